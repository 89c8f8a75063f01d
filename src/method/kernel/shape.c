/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Code that each shape of scene has for all methods: its forces as one function, which typed.c and
 * adapt.c call, and marches of any splitting, which wait for the forces rather than for the
 * weights. METHOD_UNROLLED rows have kernels of their own (kernel.c).
 */
#include "method/kernel/kernel.h"
#include "method/kernel/typed.h"

/* ---- forces as functions with arguments in registers ---- */

/* Head of a program_function: time, position q and velocity v of a single coordinate or else all
 * variables in `state`; returns two accelerations. Built-in terms use frame for their
 * coefficients. */
#define PROGRAM_FUNCTION(name)                                                                     \
    static struct leading name(const struct program *program, double t, double q, double v,        \
                               const double *state, const double *args, double *output,            \
                               double *frame)

/* Defines the program_function of a shape. */
#define SHAPE_RUN(shape)                                                                           \
    PROGRAM_FUNCTION(shape##_run)                                                                  \
    {                                                                                              \
        const struct shape_forces *forces = (const struct shape_forces *)(const void *)frame;      \
        const double line[N] = {q, v}, *const y = (int)SIZE_##shape == (int)N ? line : state;      \
        double a[2] = {-0.0, -0.0};                                                                \
        (void)program, (void)args, (void)output;                                                   \
        TERMS_OF_##shape(TERM_ALWAYS);                                                             \
        return (struct leading){a[0], a[1]};                                                       \
    }
ALL_SHAPES(SHAPE_RUN)

/* Adds any built-in terms; frame holds a pointer to the system. */
PROGRAM_FUNCTION(terms_run)
{
    const struct system *const *const system_pointer =
        (const struct system *const *)(const void *)frame;
    const struct system *const system = *system_pointer;
    const double line[N] = {q, v}, *const y = system->n == N ? line : state;
    double a[2] = {-0.0, -0.0};
    (void)program, (void)args, (void)output;
    for (int i = 0; i < system->terms; i++)
        system->term[i].row->add(system->term[i].c, t, y, a);
    return (struct leading){a[0], a[1]};
}

/* Makes *part evaluate the system's built-in terms: by a function specialized for their combination
 * if there is one, else term by term. `frame` is memory for that function, which *part refers to.
 * Returns false, with nothing changed, unless the system is of second order with at most MOST state
 * variables. */
static bool built_in_take(const struct system *system, struct typed_addend *part, double *frame)
{
#define RUN_ENTRY(shape) shape##_run,
    static program_function *const runs[] = {ALL_SHAPES(RUN_ENTRY)};
    const int shape = shape_of(system);
    if (system->order != 2 || system->n > MOST)
        return false;
    *part = (struct typed_addend){shape < 0 ? terms_run : runs[shape], NULL, system->term, frame};
    if (shape < 0)
        memcpy(frame, &system, sizeof(const struct system *));
    else
        forces_take((struct shape_forces *)(void *)frame, system, SHAPE_TERMS);
    return true;
}

/* ---- typed terms ---- */

/* Adds a term to the sum; a program gets its part of the frame, of which *left doubles remain.
 * Returns false if they do not suffice. */
static bool sum_take(struct typed_sum *sum, struct typed_forces *known, int *left,
                     const struct bound_term *term)
{
    int values;
    const struct program *const program = term_program(term, &values);
    const int size = program ? (int)program_frame(program) : 0;
    if (size > *left)
        return false;
    *left -= size;
    sum->part[sum->parts++] = (struct typed_addend){program ? program_code(program) : NULL, program,
                                                    term, known->frame + *left};
    if (program)
        program_prepare(program, known->frame + *left);
    return true;
}

/* Computes the acceleration of one coordinate as the sum of parts: a part with its own function
 * calls it, others add a built-in term. Has the signature of a program_function; `frame` points to
 * a struct typed_sum, q and v are position and velocity, and the other arguments are unused. */
static struct leading sum_run(const struct program *program, double t, double q, double v,
                              const double *state, const double *args, double *output,
                              double *frame)
{
    const struct typed_sum *sum = (const struct typed_sum *)(const void *)frame;
    const double y[2] = {q, v};
    double a = -0.0;
    (void)program, (void)state, (void)args, (void)output;
    for (const struct typed_addend *part = sum->part; part < sum->part + sum->parts; part++) {
        if (part->run)
            a +=
                part->run(part->program, t, q, v, NULL, part->term->c + 1, NULL, part->frame).first;
        else
            part->term->row->add(part->term->c, t, y, &a);
    }
    return (struct leading){a, 0};
}

bool sum_is_one(const struct typed_sum *sum)
{
    return sum->parts == 1 && sum->part->run;
}

/* Sets sum->all: the only part, or the function that adds all parts. */
static void sum_close(struct typed_sum *sum, const struct system *system)
{
    sum->all = sum_is_one(sum)
                   ? sum->part[0]
                   : (struct typed_addend){sum_run, NULL, system->term, (double *)(void *)sum};
}

/* Prepares the forces of a system as functions: the program of the whole right-hand side if there
 * is one, else the sum of the terms. Returns false if they do not fit. */
bool known_take(struct typed_forces *known, const struct system *system)
{
    const struct bound_term *const whole = system_whole(system);
    int left = FRAME;
    known->whole.parts = known->force.parts = known->drag.parts = 0;
    if (!system->typed.row)
        return built_in_take(system, &known->whole.all, known->frame);
    if (whole && !sum_take(&known->whole, known, &left, whole))
        return false;
    for (int i = 0; i < system->terms; i++) {
        const struct bound_term *const term = &system->term[i];
        if (!sum_take(term->row->flags & TERM_VELOCITY ? &known->drag : &known->force, known, &left,
                      term) ||
            (!whole && !sum_take(&known->whole, known, &left, term)))
            return false;
    }
    sum_close(&known->whole, system);
    sum_close(&known->force, system);
    sum_close(&known->drag, system);
    return true;
}

/* Returns the shape of a typed system, or -1. Shapes of more than one coordinate need all forces in
 * one program. */
int typed_shape(const struct system *system, bool splits)
{
    struct typed_forces known;
    if (!known_take(&known, system))
        return -1;
    const bool one =
        !system->typed.row ||
        (splits ? sum_is_one(&known.force) && (known.drag.parts == 0 || sum_is_one(&known.drag))
                : sum_is_one(&known.whole));
    const bool motion = system->order == 2;
    switch (system->n) {
    case 1:
        return !motion && one ? PLACE_typed_one : -1;
    case 2:
        if (motion)
            return PLACE_typed_line;
        return one ? PLACE_typed_two : -1;
    case 3:
        return !motion && one ? PLACE_typed_three : -1;
    case 4:
        return motion && one ? PLACE_typed_plane : -1;
    default:
        return -1;
    }
}

/* ---- splittings ---- */

/* Defines the march of splittings for a shape. */
#define SHAPE_SPLIT(shape)                                                                         \
    static int64_t shape##_split(const struct method *method, const struct march *march)           \
    {                                                                                              \
        const bool velocity = (0 TERMS_OF_##shape(HAS_VELOCITY)) != 0;                             \
        const enum drag drag = velocity ? march->step->drag : DRAG_DEFAULT;                        \
        struct shape_forces forces;                                                                \
        forces_take(&forces, march->step->system, 0 TERMS_OF_##shape(ONE_MORE));                   \
        return split_march(method, SIZE_##shape, drag, shape##_force, shape##_drag, &forces,       \
                           march);                                                                 \
    }
ALL_SHAPES(SHAPE_SPLIT)

/* Defines the march of splittings for typed forces of n variables. */
TYPED_MOTIONS(SPLIT_FUNCTIONS)
#define TYPED_SPLIT(name, n)                                                                       \
    static int64_t name##_split(const struct method *method, const struct march *march)            \
    {                                                                                              \
        const bool velocity = march->step->system->velocity;                                       \
        const enum drag drag = velocity ? DRAG_EXPLICIT : DRAG_DEFAULT;                            \
        struct typed_forces known;                                                                 \
        known_take(&known, march->step->system);                                                   \
        return split_march(method, n, drag, name##_force, name##_drag, &known, march);             \
    }
TYPED_MOTIONS(TYPED_SPLIT)

march_function *shape_split(int shape)
{
#define SPLIT_ENTRY(shape) shape##_split,
    static march_function *const splits[SHAPE_COUNT] = {ALL_SHAPES(SPLIT_ENTRY)};
    return splits[shape];
}

march_function *typed_split(int shape)
{
#define TYPED_SPLIT_ENTRY(name, n) name##_split,
    static march_function *const splits[] = {TYPED_MOTIONS(TYPED_SPLIT_ENTRY)};
    return shape < (int)COUNT_OF(splits) ? splits[shape] : NULL;
}
