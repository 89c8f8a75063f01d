/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Forces of built-in terms, written once, for models and for kernels that compile them in again, so
 * that both give the same bits. A FORCE of one coordinate is an expression of t, the coordinate q,
 * its velocity v and the coefficients c0, c1, c2; terms_program() also makes programs of its text,
 * as lanes evaluate them, and their derivatives. SLOPES have the operations of that derivative in
 * their order, for the same bits. */
#pragma once

#include "scene/model/model.h"

/* ---- programs of built-in terms of one coordinate ---- */

/* Returns true if the system has one coordinate, and each built-in term has the text of its
 * force. */
bool terms_have_text(const struct system *system);
/*
 * Makes a program of the sum of the built-in terms whose flags under `mask` are `wanted`, or, with
 * `slopes`, of its derivatives by position and velocity. It gives the same bits as the terms'
 * functions. Names are t, q and v; the coefficients of term i are the names from `first` +
 * TERM_COEFFICIENTS i on. Returns NULL if there is no such term, or, with an error, if out of
 * memory. The caller destroys the program.
 */
struct program *terms_program(const struct system *system, unsigned mask, unsigned wanted,
                              int first, bool slopes, struct error *error);

/* ---- forces ---- */

/* Number of the force of each term; 0 for one that no kernel knows. */
enum force {
    FORCE_OTHER,
#define CONSERVATIVE_TERM(name, ...) FORCE_##name,
#define POWERED_TERM(name, ...) FORCE_##name,
#include "scene/model/terms.def"
    FORCE_TERMS_END, /* end of the terms of the oscillator */
    FORCE_weight,
    FORCE_attraction,
    FORCE_well,
    FORCE_reaction,
};

/* Heads of the functions of a term's row: the acceleration and its Jacobian are added to a and jac.
 * FORCE, SLOPES and POTENTIAL make functions of expressions. */
#define MODEL_FORCE(name)                                                                          \
    static inline void name##_add(UNUSED const double *c, UNUSED double t, UNUSED const double *y, \
                                  double *a)
#define MODEL_SLOPES(name)                                                                         \
    static inline void name##_jacobian(UNUSED const double *c, UNUSED double t,                    \
                                       UNUSED const double *y, double *jac)
#define FORCE_NAMES UNUSED const double q = y[0], v = y[1], c0 = c[0], c1 = c[1], c2 = c[2]
#define FORCE(name, expression)                                                                    \
    UNUSED static const char name##_text[] = #expression;                                          \
    MODEL_FORCE(name)                                                                              \
    {                                                                                              \
        FORCE_NAMES;                                                                               \
        a[0] += (expression);                                                                      \
    }
#define SLOPES(name, by_q, by_v)                                                                   \
    MODEL_SLOPES(name)                                                                             \
    {                                                                                              \
        FORCE_NAMES;                                                                               \
        jac[0] += (by_q);                                                                          \
        jac[1] += (by_v);                                                                          \
    }
#define POTENTIAL(name, expression)                                                                \
    static inline double name##_potential(const double *c, const double *y)                        \
    {                                                                                              \
        UNUSED const double q = y[0], c0 = c[0], c1 = c[1], c2 = c[2];                             \
        return (expression);                                                                       \
    }

/* Functions as expressions call them. */
#define abs(x) fabs(x)
#define sin(x) fixed_sin(x)
#define cos(x) fixed_cos(x)

/* ---- pendulum: damping and drive are those of the oscillator ---- */

FORCE(weight, -c0 *sin(q))
SLOPES(weight, -c0 *cos(q), 0)
/* 0 at the bottom, and without cancellation near it */
POTENTIAL(weight, 2 * c1 * sin(q / 2) * sin(q / 2))

/* ---- oscillator ---- */

#include "scene/model/terms.def"

/* Computes the acceleration with dry friction c0 [m/s^2], given that by all other forces. At rest
 * friction cancels as much as there is, up to c0. */
MODEL_FORCE(friction)
{
    if (y[1] != 0)
        a[0] -= copysign(c[0], y[1]);
    else
        a[0] = fabs(a[0]) <= c[0] ? 0 : a[0] - copysign(c[0], a[0]);
}

/* ---- kepler ---- */

MODEL_FORCE(attraction)
{
    const double square = y[0] * y[0] + y[1] * y[1], pull = c[0] / (square * sqrt(square));
    a[0] -= pull * y[0];
    a[1] -= pull * y[1];
}

/* ---- henon-heiles ---- */

MODEL_FORCE(well)
{
    a[0] -= y[0] + 2 * y[0] * y[1];
    a[1] -= y[1] + (y[0] * y[0] - y[1] * y[1]);
}

/* ---- robertson ---- */

MODEL_FORCE(reaction)
{
    const double forth = c[0] * y[0], burn = c[1] * y[1] * y[1], back = c[2] * y[1] * y[2];
    a[0] += back - forth;
    a[1] += forth - back - burn;
    a[2] += burn;
}

MODEL_SLOPES(reaction)
{
    const double burn = 2 * c[1] * y[1], by_b = c[2] * y[2], by_c = c[2] * y[1];
    const double change[9] = {-c[0], by_b, by_c, c[0], -by_b - burn, -by_c, 0, burn, 0};
    for (int i = 0; i < 9; i++)
        jac[i] += change[i];
}

#undef abs
#undef sin
#undef cos
