/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Shapes of scenes, shared by kernels. A shape is a list of terms (forces) in the order in which
 * their model adds them; its functions force, drag and slope inline those of the terms. To add a
 * shape, add a line TERMS_OF_name below and its name to SHAPES or MODEL_SHAPES. Lists are macros
 * that apply their argument to each member.
 */
#pragma once

#include "scene/model/forces.h"
#include "scene/model/params.h"
#define FORCE_TERMS "scene/model/terms.def"
/* Variables of one coordinate; most variables and terms of a shape; bits of a term's number. */
enum { N = 2, MOST = 4, SHAPE_TERMS = 4, FORCE_BITS = 8 };
#include "method/control/march_body.h"
#include "method/rows/rows.h"

/* Coefficients of the terms, in order; a local copy, which compilers can keep in registers. */
struct shape_forces {
    double c[SHAPE_TERMS][TERM_COEFFICIENTS];
};

/* Copies the coefficients of the first `terms` terms of the system. */
INLINE void forces_take(struct shape_forces *forces, const struct system *system, int terms)
{
    UNROLL for (int i = 0; i < terms; i++)
        memcpy(forces->c[i], system->term[i].c, sizeof forces->c[i]);
}

/* Flags of the terms as constants (name_flags). */
enum {
#define CONSERVATIVE_TERM(name, flags, ...) name##_flags = (flags),
#define POWERED_TERM(name, flags, ...) name##_flags = (flags),
#include FORCE_TERMS
    weight_flags = 0,
    attraction_flags = 0,
    well_flags = 0,
};

/* ---- shapes ---- */

#define SHAPES(S) S(drag) S(damped_drag) S(driven) S(duffing) S(driven_duffing) S(vanderpol)
#define MODEL_SHAPES(S) S(pendulum) S(driven_pendulum) S(kepler) S(henon_heiles)
/* Linear shapes, which only studies step by these kernels; runs use the propagator. */
#define LINEAR_SHAPES(S) S(spring) S(damped)
#define ALL_SHAPES(S) SHAPES(S) LINEAR_SHAPES(S) MODEL_SHAPES(S)
/* Shapes of one coordinate whose implicit stages are solved in closed form, and by iteration. */
#define CLOSED_SHAPES(S) S(spring) S(damped) S(drag) S(damped_drag) S(driven)
#define MOTION_SHAPES(S) S(duffing) S(driven_duffing) S(vanderpol) S(pendulum) S(driven_pendulum)
/* Most stages of an implicit method. */
enum { IMPLICIT_STAGES = 3 };

#define TERMS_OF_spring(T) T(0, spring)
#define TERMS_OF_damped(T) T(0, spring) T(1, damping)

#define TERMS_OF_drag(T) T(0, spring) T(1, drag)
#define TERMS_OF_damped_drag(T) T(0, spring) T(1, damping) T(2, drag)
#define TERMS_OF_driven(T) T(0, spring) T(1, damping) T(2, drive)
#define TERMS_OF_duffing(T) T(0, spring) T(1, cubic)
#define TERMS_OF_driven_duffing(T) T(0, spring) T(1, damping) T(2, drive) T(3, cubic)
#define TERMS_OF_vanderpol(T) T(0, spring) T(1, vanderpol)
/* Damping and drive of the pendulum have the code of those of the oscillator. */
#define TERMS_OF_pendulum(T) T(0, weight)
#define TERMS_OF_driven_pendulum(T) T(0, weight) T(1, damping) T(2, drive)
#define TERMS_OF_kepler(T) T(0, attraction)
#define TERMS_OF_henon_heiles(T) T(0, well)

/* Number of variables of each shape (SIZE_name). */
#define SHAPE_SIZE(shape) SIZE_##shape = 2,
enum {
    SHAPES(SHAPE_SIZE) LINEAR_SHAPES(SHAPE_SIZE) SIZE_pendulum = 2,
    SIZE_driven_pendulum = 2,
    SIZE_kepler = 4,
    SIZE_henon_heiles = 4
};

/* Statements that add a term to the acceleration a: always, or only if it is (not) drag. */
#define TERM_ALWAYS(i, name) name##_add(forces->c[i], t, y, a);
#define TERM_IF_FORCE(i, name)                                                                     \
    if (!(name##_flags & TERM_VELOCITY))                                                           \
        name##_add(forces->c[i], t, y, a);
#define TERM_IF_DRAG(i, name)                                                                      \
    if (name##_flags & TERM_VELOCITY)                                                              \
        name##_add(forces->c[i], t, y, a);

/* Parts of constant expressions over the terms of a shape. */
#define ONE_MORE(i, name) +1
#define HAS_VELOCITY(i, name) | (name##_flags & TERM_VELOCITY)

/* Defines the force, drag and slope functions of a shape. */
#define SHAPE_FUNCTIONS(shape)                                                                     \
    INLINE void shape##_force(const void *known, double t, const double *y, double *a)             \
    {                                                                                              \
        const struct shape_forces *forces = known;                                                 \
        sum_begin(SIZE_##shape / 2, a);                                                            \
        TERMS_OF_##shape(TERM_IF_FORCE)                                                            \
    }                                                                                              \
    INLINE void shape##_drag(const void *known, double t, const double *y, double *a)              \
    {                                                                                              \
        const struct shape_forces *forces = known;                                                 \
        sum_begin(SIZE_##shape / 2, a);                                                            \
        TERMS_OF_##shape(TERM_IF_DRAG)                                                             \
    }                                                                                              \
    INLINE void shape##_slope(const void *known, double t, const double *y, double *dydt)          \
    {                                                                                              \
        const struct shape_forces *forces = known;                                                 \
        double *a = dydt + SIZE_##shape / 2;                                                       \
        copy_numbers(SIZE_##shape / 2, y + SIZE_##shape / 2, dydt);                                \
        sum_begin(SIZE_##shape / 2, a);                                                            \
        TERMS_OF_##shape(TERM_ALWAYS)                                                              \
    }
ALL_SHAPES(SHAPE_FUNCTIONS)

#define SHAPE_PLACE(shape) SHAPE_##shape,
/* Numbers of the shapes (SHAPE_name). */
enum { ALL_SHAPES(SHAPE_PLACE) SHAPE_COUNT };

/* Returns the numbers of a system's terms, in their order, packed into one word, or 0 if they are
 * too many or not built in. */
static inline unsigned forces_of(const struct system *system)
{
    unsigned forces = 0;
    if (!system->model || system->model->typed || system->terms > SHAPE_TERMS)
        return 0;
    for (int i = 0; i < system->terms; i++) {
        if (!system->term[i].row->force)
            return 0;
        forces |= (unsigned)system->term[i].row->force << FORCE_BITS * i;
    }
    return forces;
}

#define FORCE_AT(i, name) | ((unsigned)FORCE_##name << FORCE_BITS * (i))
#define SHAPE_CASE(shape)                                                                          \
    case 0u TERMS_OF_##shape(FORCE_AT):                                                            \
        return SHAPE_##shape;

/* Returns the shape (SHAPE_name) whose terms the system has, or -1 if there is none. */
static inline int shape_of(const struct system *system)
{
    switch (forces_of(system)) {
        ALL_SHAPES(SHAPE_CASE)
    default:
        return -1;
    }
}
