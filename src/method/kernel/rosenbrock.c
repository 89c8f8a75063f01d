/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Single steps of Rosenbrock methods: rosenbrock_body.h compiled for each row and the shapes that
 * are not linear, with slope and Jacobian inlined.
 */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-vectorize") /* the code has vectors of two already */
#endif
#define UNROLL _Pragma("GCC unroll 32")
#include "method/kernel/kernel.h"
#include "method/step/rosenbrock_body.h"

/* ---- slopes and Jacobians of the shapes ---- */

/* Equations of motion, and systems of first order with their number of variables. */
#define MOTIONS(S) S(duffing) S(vanderpol) S(pendulum)
#define FLOWS(S) S(robertson, 3)

#define TERM_SLOPES(i, name) name##_jacobian(forces->c[i], t, y, jac + N);
/* Defines the Jacobian of an equation of motion. */
#define MOTION_JACOBIAN(shape)                                                                     \
    INLINE void shape##_jac(const void *known, double t, const double *y, double *jac)             \
    {                                                                                              \
        const struct shape_forces *forces = known;                                                 \
        jac[0] = jac[2] = jac[3] = 0;                                                              \
        jac[1] = 1;                                                                                \
        TERMS_OF_##shape(TERM_SLOPES)                                                              \
    }
MOTIONS(MOTION_JACOBIAN)

#define TERMS_OF_robertson(T) T(0, reaction)

#define TERM_JACOBIANS(i, name) name##_jacobian(forces->c[i], t, y, jac);
/* Defines slope and Jacobian of a system of first order. */
#define FLOW_FUNCTIONS(shape, n)                                                                   \
    INLINE void shape##_slope(const void *known, double t, const double *y, double *dydt)          \
    {                                                                                              \
        const struct shape_forces *forces = known;                                                 \
        sum_begin(n, dydt);                                                                        \
        double *const a = dydt;                                                                    \
        TERMS_OF_##shape(TERM_ALWAYS)                                                              \
    }                                                                                              \
    INLINE void shape##_jac(const void *known, double t, const double *y, double *jac)             \
    {                                                                                              \
        const struct shape_forces *forces = known;                                                 \
        for (int i = 0; i < (n) * (n); i++)                                                        \
            jac[i] = 0;                                                                            \
        TERMS_OF_##shape(TERM_JACOBIANS)                                                           \
    }
FLOWS(FLOW_FUNCTIONS)

/* ---- steps ---- */

/* Names of rows and kernels, made unique by the line at which a row ends. */
#define ROSENBROCK_ROW JOIN(rosenbrock_, __LINE__)
#define NAME(shape) JOIN(shape##_rosenbrock_, __LINE__)
/* Defines the step kernel of ROSENBROCK_ROW for a shape of n variables. */
#define STEP(shape, n)                                                                             \
    static enum step_status NAME(shape)(const struct method *method, struct step *step)            \
    {                                                                                              \
        struct shape_forces forces;                                                                \
        const struct rosenbrock_forces of = {shape##_slope, shape##_jac, &forces, false};          \
        (void)method;                                                                              \
        for (int i = 0; i < (0 TERMS_OF_##shape(ONE_MORE)); i++)                                   \
            memcpy(forces.c[i], step->system->term[i].c, sizeof forces.c[i]);                      \
        return rosenbrock_small_step(n, ROSENBROCK_ROW.rosenbrock, &of, step);                     \
    }
#define MOTION_STEP(shape) STEP(shape, N)
#define ROSENBROCK(id, ...)                                                                        \
    static const struct method ROSENBROCK_ROW = {__VA_ARGS__};                                     \
    MOTIONS(MOTION_STEP) FLOWS(STEP)
#include "method/rows/rosenbrock.def"
#undef ROSENBROCK

/* ---- the table ---- */

#define FLOW_PLACE(shape, n) SHAPE_##shape,
/* Numbers of the systems of first order, behind those of the shapes of kernel.h. */
enum { LAST_MOTION = SHAPE_COUNT - 1, FLOWS(FLOW_PLACE) PLACES };

#define FLOW_CASE(name, n)                                                                         \
    case 0u TERMS_OF_##name(FORCE_AT):                                                             \
        shape = SHAPE_##name;                                                                      \
        break;
#define MOTION_ENTRY(shape) [SHAPE_##shape] = NAME(shape),
#define FLOW_ENTRY(shape, n) [SHAPE_##shape] = NAME(shape),
/* Step kernels by method and shape; NULL for four variables and for linear systems. */
static step_function *const steps[][PLACES] = {
    {NULL},
#define ROSENBROCK(...) {MOTIONS(MOTION_ENTRY) FLOWS(FLOW_ENTRY)},
#include "method/rows/rosenbrock.def"
};

/* Returns the kernel for a method and shape, or NULL if there is none. */
step_function *rosenbrock_step_kernel(const struct method *method, const struct system *system)
{
    int shape = shape_of(system);
    switch (forces_of(system)) {
        FLOWS(FLOW_CASE)
    default:
        break;
    }
    return shape >= 0 ? steps[method->index][shape] : NULL;
}
