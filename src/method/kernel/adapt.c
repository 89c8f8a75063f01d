/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Single steps of explicit Runge-Kutta methods with their error estimate, for adaptive runs:
 * rk_step() compiled for each row and each small number of variables, with forces called through a
 * pointer. Sums over the stages hide the time of the call; steps with the forces of one scene
 * inlined were not faster.
 */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize(                                                                              \
    "no-tree-vectorize",                                                                           \
    "no-tree-loop-distribute-patterns") /* pairs of numbers: packing and unpacking them takes      \
                                         * longer than it saves                                    \
                                         */
#endif
#define UNROLL _Pragma("GCC unroll 32")
/* Largest number of variables, for march_body.h. */
enum { MOST = 4 };
#include "method/kernel/typed.h"
#include "method/rows/rows.h"
#include "method/step/step_body.h"

/* Names of the row and of the step kernel, made unique by the line at which a row ends. */
#define RK_ROW JOIN(rk_, __LINE__)
#define STEP_NAME(shape) JOIN(shape##_step_, __LINE__)
#define TYPED_STEP(name, n)                                                                        \
    static enum step_status STEP_NAME(name)(const struct method *method, struct step *step)        \
    {                                                                                              \
        struct typed_forces known;                                                                 \
        (void)method;                                                                              \
        known_take(&known, step->system);                                                          \
        return one_step(&RK_ROW, n, name##_slope, &known, step);                                   \
    }
#define RUNGE_KUTTA(id, ...)                                                                       \
    static const struct method RK_ROW = {__VA_ARGS__};                                             \
    TYPED_MOTIONS(TYPED_STEP)                                                                      \
    TYPED_FLOWS(TYPED_STEP)
#include "method/rows/rk.def"
#undef RUNGE_KUTTA

/* ---- the table ---- */

#define TYPED_ENTRY(name, n) STEP_NAME(name),

/* Returns the step compiled for the method and the size of the system, or NULL for the general
 * one. */
step_function *method_step_kernel(const struct method *method, const struct system *system)
{
    static step_function *const steps[][TYPED_COUNT] = {
        {NULL},
#define RUNGE_KUTTA(...) {TYPED_MOTIONS(TYPED_ENTRY) TYPED_FLOWS(TYPED_ENTRY)},
#include "method/rows/rk.def"
    };
    if (method->rosenbrock)
        return rosenbrock_step_kernel(method, system);
    if (method->step != rk_step)
        return NULL;
    const int typed = typed_shape(system, false);
    if (typed < 0)
        return system->typed.row || system->n > MOST ? any_step_kernel(method) : NULL;
    return steps[method->index][typed];
}
