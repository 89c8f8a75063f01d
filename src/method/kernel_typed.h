/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Typed forces for kernels: their programs, ready to be called, and shapes by the number of variables. What a program
 * takes and returns in registers stays there: a force of one coordinate needs no memory.
 */
#ifndef HOOKE_METHOD_KERNEL_TYPED_H
#define HOOKE_METHOD_KERNEL_TYPED_H

#include "march_body.h"

enum { FRAME = 512 };

/* A term: a program, or what the scene below has. */
struct part {
    program_function *run; /* NULL: the latter */
    const struct program *program;
    const struct bound_term *term;
    double *frame;
};

struct sum {
    struct part part[TERM_MAX];
    int parts;
};

struct known {
    struct sum whole, force, drag;
    double frame[FRAME];
};

static inline bool sum_take(struct sum *sum, struct known *known, int *room, const struct bound_term *term)
{
    int values;
    const struct program *const program = term_program(term, &values);
    const int places = program ? (int)program_frame(program) : 0;
    if (places > *room)
        return false;
    *room -= places;
    sum->part[sum->parts++] =
        (struct part){program ? program_code(program) : NULL, program, term, known->frame + *room};
    if (program)
        program_prepare(program, known->frame + *room);
    return true;
}

/* False: the system is not typed, or too large. */
static inline bool known_take(struct known *known, const struct system *system)
{
    const struct bound_term *const whole = system_whole(system);
    int room = FRAME;
    known->whole.parts = known->force.parts = known->drag.parts = 0;
    if (!system->typed.row || (whole && !sum_take(&known->whole, known, &room, whole)))
        return false;
    for (int i = 0; i < system->terms; i++) {
        const struct bound_term *const term = &system->term[i];
        if (!sum_take(term->row->flags & TERM_VELOCITY ? &known->drag : &known->force, known, &room, term) ||
            (!whole && !sum_take(&known->whole, known, &room, term)))
            return false;
    }
    return true;
}

/* out [rows], of n state variables */
INLINE void part_evaluate(const struct part *part, int n, int rows, double t, const double *y, double *out)
{
    const struct leading leading = part->run(part->program, t, y[0], y[1], n > 2 ? y : NULL, part->term->c + 1,
                                             rows > 2 ? out : NULL, part->frame);
    out[0] = leading.first;
    if (rows > 1)
        out[1] = leading.second;
}

/* The sum of one program. */
INLINE void one_evaluate(const struct sum *sum, int n, int rows, double t, const double *y, double *out)
{
    part_evaluate(sum->part, n, rows, t, y, out);
}

/* Copies, so that nobody has the address of y and out, and they stay in registers. */
INLINE void sum_evaluate(const struct sum *sum, int n, int rows, double t, const double *y, double *out)
{
    double state[MOST], value[MOST];
    sum_begin(rows, out);
    copy_numbers(n, y, state);
    for (const struct part *part = sum->part; part < sum->part + sum->parts; part++) {
        if (part->run) {
            part_evaluate(part, n, rows, t, state, value);
            for (int i = 0; i < rows; i++)
                value[i] = out[i] + value[i];
        } else {
            copy_numbers(rows, out, value);
            part->term->row->add(part->term->c, t, state, value);
        }
        copy_numbers(rows, value, out);
    }
}

#define TYPED_MOTIONS(S) S(typed_line, 2, one) S(typed_plane, 4, one) S(typed_on_line, 2, sum)
#define TYPED_FLOWS(S) S(typed_two, 2, one) S(typed_three, 3, one)

#define KNOWN(known) ((const struct known *)(known))
#define MOTION_FUNCTIONS(name, n, terms)                                                                               \
    INLINE void name##_slope(const void *known, double t, const double *y, double *dydt)                               \
    {                                                                                                                  \
        copy_numbers((n) / 2, y + (n) / 2, dydt);                                                                      \
        terms##_evaluate(&KNOWN(known)->whole, n, (n) / 2, t, y, dydt + (n) / 2);                                      \
    }
#define FLOW_FUNCTIONS(name, n, terms)                                                                                 \
    INLINE void name##_slope(const void *known, double t, const double *y, double *dydt)                               \
    {                                                                                                                  \
        terms##_evaluate(&KNOWN(known)->whole, n, n, t, y, dydt);                                                      \
    }
#define SPLIT_FUNCTIONS(name, n, terms)                                                                                \
    INLINE void name##_force(const void *known, double t, const double *y, double *a)                                  \
    {                                                                                                                  \
        terms##_evaluate(&KNOWN(known)->force, n, (n) / 2, t, y, a);                                                   \
    }                                                                                                                  \
    INLINE void name##_drag(const void *known, double t, const double *y, double *a)                                   \
    {                                                                                                                  \
        terms##_evaluate(&KNOWN(known)->drag, n, (n) / 2, t, y, a);                                                    \
    }
TYPED_MOTIONS(MOTION_FUNCTIONS)
TYPED_FLOWS(FLOW_FUNCTIONS)

#define TYPED_PLACE(name, ...) PLACE_##name,
enum { TYPED_MOTIONS(TYPED_PLACE) TYPED_FLOWS(TYPED_PLACE) TYPED_COUNT };

static inline bool sum_is_one(const struct sum *sum)
{
    return sum->parts == 1 && sum->part->run;
}

/* -1: none. splits: force and drag apart. */
static inline int typed_shape(const struct system *system, bool splits)
{
#define MOTION_SIZE(name, size, terms) {2, size, (#terms)[0] == 'o'},
#define FLOW_SIZE(name, size, terms) {1, size, (#terms)[0] == 'o'},
    static const struct {
        int order, n;
        bool one;
    } rows[TYPED_COUNT] = {TYPED_MOTIONS(MOTION_SIZE) TYPED_FLOWS(FLOW_SIZE)};
    struct known known;
    if (!known_take(&known, system))
        return -1;
    const bool one = splits ? sum_is_one(&known.force) && (known.drag.parts == 0 || sum_is_one(&known.drag))
                            : sum_is_one(&known.whole);
    for (int shape = 0; shape < TYPED_COUNT; shape++)
        if (system->order == rows[shape].order && system->n == rows[shape].n && (one || !rows[shape].one))
            return shape;
    return -1;
}

#endif
