/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What kernels share: shapes of oscillators, each a list of terms in the order of terms.def, whose own functions are
 * used again. A shape is a line below and a line in SHAPES.
 */
#ifndef HOOKE_METHOD_KERNEL_H
#define HOOKE_METHOD_KERNEL_H

#include "../scene/params.h"
#define FORCE_TERMS "../scene/terms.def"
#include "rk_body.h"
#include "rows.h"
#include "split_body.h"

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)

enum { N = 2, STAGES_MAX = 16, WEIGHTS_MAX = 40, SHAPE_TERMS = 4 };

/* Coefficients of the terms, in order, where the compiler can keep them in registers. */
struct forces {
    double c[SHAPE_TERMS][TERM_COEFFICIENTS];
};

INLINE void forces_take(struct forces *forces, const struct system *system)
{
    for (int i = 0; i < SHAPE_TERMS; i++)
        memcpy(forces->c[i], system->term[i].c, sizeof forces->c[i]);
}

/* The terms' functions once more, and their flags as constants. */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#define TERM_BODIES
#include FORCE_TERMS
#undef TERM_BODIES
#pragma GCC diagnostic pop

enum {
#define CONSERVATIVE_TERM(name, flags, ...) name##_flags = (flags),
#define POWERED_TERM(name, flags, ...) name##_flags = (flags),
#include FORCE_TERMS
};

/* ---- shapes ---- */

#define SHAPES(S) S(drag) S(damped_drag) S(driven) S(duffing) S(driven_duffing) S(vanderpol)

#define TERMS_OF_drag(T) T(0, spring) T(1, drag)
#define TERMS_OF_damped_drag(T) T(0, spring) T(1, damping) T(2, drag)
#define TERMS_OF_driven(T) T(0, spring) T(1, damping) T(2, drive)
#define TERMS_OF_duffing(T) T(0, spring) T(1, cubic)
#define TERMS_OF_driven_duffing(T) T(0, spring) T(1, damping) T(2, drive) T(3, cubic)
#define TERMS_OF_vanderpol(T) T(0, spring) T(1, vanderpol)

#define TERM_ALWAYS(i, name) name##_add(forces->c[i], t, y, a);
#define TERM_IF_FORCE(i, name)                                                                                         \
    if (!(name##_flags & TERM_VELOCITY))                                                                               \
        name##_add(forces->c[i], t, y, a);
#define TERM_IF_DRAG(i, name)                                                                                          \
    if (name##_flags & TERM_VELOCITY)                                                                                  \
        name##_add(forces->c[i], t, y, a);
#define TERM_NAME(i, name) #name,

#define SHAPE_FUNCTIONS(shape)                                                                                         \
    INLINE void shape##_force(const void *known, double t, const double *y, double *a)                                 \
    {                                                                                                                  \
        const struct forces *forces = known;                                                                           \
        a[0] = -0.0;                                                                                                   \
        TERMS_OF_##shape(TERM_IF_FORCE)                                                                                \
    }                                                                                                                  \
    INLINE void shape##_drag(const void *known, double t, const double *y, double *a)                                  \
    {                                                                                                                  \
        const struct forces *forces = known;                                                                           \
        a[0] = -0.0;                                                                                                   \
        TERMS_OF_##shape(TERM_IF_DRAG)                                                                                 \
    }                                                                                                                  \
    INLINE void shape##_slope(const void *known, double t, const double *y, double *dydt)                              \
    {                                                                                                                  \
        const struct forces *forces = known;                                                                           \
        double *a = dydt + 1;                                                                                          \
        dydt[0] = y[1];                                                                                                \
        a[0] = -0.0;                                                                                                   \
        TERMS_OF_##shape(TERM_ALWAYS)                                                                                  \
    }
SHAPES(SHAPE_FUNCTIONS)

#define SHAPE_PLACE(shape) SHAPE_##shape,
enum { SHAPES(SHAPE_PLACE) SHAPE_COUNT };

/* The system's shape, -1: it has none of these. */
static inline int shape_of(const struct system *system)
{
#define SHAPE_TERMS_ROW(shape) {TERMS_OF_##shape(TERM_NAME)},
    static const char *const names[SHAPE_COUNT][SHAPE_TERMS + 1] = {SHAPES(SHAPE_TERMS_ROW)};
    for (int shape = 0; shape < SHAPE_COUNT; shape++) {
        int i = 0;
        while (i < system->terms && names[shape][i] && strcmp(system->term[i].row->row.name, names[shape][i]) == 0)
            i++;
        if (system->model == &oscillator_model && i == system->terms && !names[shape][i])
            return shape;
    }
    return -1;
}

#endif
