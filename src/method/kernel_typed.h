/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Typed forces for kernels: their programs, ready to be called, and shapes by the number of variables. What a program
 * takes and returns in registers stays there: a force of one coordinate needs no memory.
 */
#ifndef HOOKE_METHOD_KERNEL_TYPED_H
#define HOOKE_METHOD_KERNEL_TYPED_H

#include "../scene/typed.h"
#include "march_body.h"

enum { FRAME = 512 };

struct evaluated {
    program_function *run;
    const struct program *program;
    const double *given;
    double *frame;
};

/* Their sum. */
struct evaluated_sum {
    struct evaluated part[GROUPS];
    int parts;
};

struct known {
    struct evaluated whole;
    struct evaluated_sum force, drag;
    double frame[FRAME];
};

static inline bool known_add(struct known *known, int *room, const struct bound_term *term, struct evaluated *part)
{
    const struct program *program = typed_term_of(term->c)->add;
    const int places = (int)program_frame(program);
    if (places > *room)
        return false;
    *room -= places;
    *part = (struct evaluated){program->run, program, term->c + 1, known->frame + *room};
    program_prepare(program, part->frame);
    return true;
}

/* False: no such kernel has this system. */
static inline bool known_take(struct known *known, const struct system *system)
{
    int room = FRAME;
    const struct bound_term *const whole = typed_whole(system);
    if (!whole || !known_add(known, &room, whole, &known->whole))
        return false;
    known->force.parts = known->drag.parts = 0;
    for (int i = 0; i < system->terms; i++) {
        const struct bound_term *term = &system->term[i];
        struct evaluated_sum *sum = term->row->flags & TERM_VELOCITY ? &known->drag : &known->force;
        if (system->terms == 1)
            sum->part[sum->parts++] = known->whole;
        else if (!known_add(known, &room, term, &sum->part[sum->parts++]))
            return false;
    }
    return true;
}

/* out [rows] of n state variables; a loop over the rest. */
INLINE void evaluate(const struct evaluated *e, int n, int rows, double t, const double *y, double *out)
{
    const struct leading leading =
        e->run(e->program, t, y[0], y[1], n > 2 ? y : NULL, e->given, rows > 2 ? out : NULL, e->frame);
    out[0] = leading.first;
    if (rows > 1)
        out[1] = leading.second;
}

INLINE void evaluate_sum(const struct evaluated_sum *sum, int n, double t, const double *y, double *out)
{
    double more[MOST / 2];
    sum_begin(n / 2, out);
    for (int part = 0; part < sum->parts; part++) {
        evaluate(&sum->part[part], n, n / 2, t, y, more);
        for (int i = 0; i < n / 2; i++)
            out[i] += more[i];
    }
}

#define TYPED_MOTIONS(S) S(typed_line, 2) S(typed_plane, 4)
#define TYPED_FLOWS(S) S(typed_two, 2) S(typed_three, 3)

#define MOTION_FUNCTIONS(name, n)                                                                                      \
    INLINE void name##_slope(const void *known, double t, const double *y, double *dydt)                               \
    {                                                                                                                  \
        copy_numbers((n) / 2, y + (n) / 2, dydt);                                                                      \
        evaluate(&((const struct known *)known)->whole, n, (n) / 2, t, y, dydt + (n) / 2);                             \
    }
#define FLOW_FUNCTIONS(name, n)                                                                                        \
    INLINE void name##_slope(const void *known, double t, const double *y, double *dydt)                               \
    {                                                                                                                  \
        evaluate(&((const struct known *)known)->whole, n, n, t, y, dydt);                                             \
    }
#define SPLIT_FUNCTIONS(name, n)                                                                                       \
    INLINE void name##_force(const void *known, double t, const double *y, double *a)                                  \
    {                                                                                                                  \
        evaluate_sum(&((const struct known *)known)->force, n, t, y, a);                                               \
    }                                                                                                                  \
    INLINE void name##_drag(const void *known, double t, const double *y, double *a)                                   \
    {                                                                                                                  \
        evaluate_sum(&((const struct known *)known)->drag, n, t, y, a);                                                \
    }
TYPED_MOTIONS(MOTION_FUNCTIONS)
TYPED_FLOWS(FLOW_FUNCTIONS)

#define TYPED_PLACE(name, n) PLACE_##name,
enum { TYPED_MOTIONS(TYPED_PLACE) TYPED_FLOWS(TYPED_PLACE) TYPED_COUNT };

/* -1: none */
static inline int typed_shape(const struct system *system)
{
#define MOTION_SIZE(name, size) {2, size},
#define FLOW_SIZE(name, size) {1, size},
    static const int size[TYPED_COUNT][2] = {TYPED_MOTIONS(MOTION_SIZE) TYPED_FLOWS(FLOW_SIZE)};
    struct known known;
    for (int shape = 0; shape < TYPED_COUNT; shape++)
        if (system->order == size[shape][0] && system->n == size[shape][1])
            return known_take(&known, system) ? shape : -1;
    return -1;
}

#endif
