/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Kernels of typed scenes of any size, and of what was typed on top of built-in ones: the step bodies of explicit
 * Runge-Kutta methods and splittings, with sums over the state in vectors.
 */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O3") /* vectors */
#endif
#define UNROLL _Pragma("GCC unroll 32")
#include <hooke/base.h>
enum { MOST = LIMIT_VARIABLES };
#include "rows.h"
#include "step_body.h"

/* The compiler need not think of nothing at all. */
static inline int size_of(const struct system *system)
{
    if (system->n < 1)
        __builtin_unreachable();
    return system->n;
}

static void any_slope(const void *system, double t, const double *y, double *dydt)
{
    system_derivative(system, t, y, dydt);
}

static void any_force(const void *system, double t, const double *y, double *a)
{
    system_force(system, t, y, a);
}

static void any_drag(const void *system, double t, const double *y, double *a)
{
    system_drag(system, t, y, a);
}

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define RK_ROW JOIN(rk_, __LINE__)
#define RK_NAME JOIN(any_rk_, __LINE__)
#define STEP_NAME JOIN(any_step_, __LINE__)
#define SPLIT_ROW JOIN(split_, __LINE__)
#define SPLIT_NAME JOIN(any_split_, __LINE__)

#define RUNGE_KUTTA(...)                                                                                               \
    static const struct method RK_ROW = {.step = rk_step, __VA_ARGS__};                                                \
    static int64_t RK_NAME(const struct march *march)                                                                  \
    {                                                                                                                  \
        const struct system *system = march->step->system;                                                             \
        return rk_march(&RK_ROW, size_of(system), any_slope, system, march);                                           \
    }                                                                                                                  \
    static enum step_status STEP_NAME(const struct method *method, struct step *step)                                  \
    {                                                                                                                  \
        (void)method;                                                                                                  \
        return one_step(&RK_ROW, size_of(step->system), any_slope, step->system, step);                                \
    }
#include "rk.def"
#undef RUNGE_KUTTA

#define SPLITTING(...)                                                                                                 \
    static const struct method SPLIT_ROW = {.step = split_step, __VA_ARGS__};                                          \
    static int64_t SPLIT_NAME(const struct march *march)                                                               \
    {                                                                                                                  \
        const struct system *system = march->step->system;                                                             \
        const enum drag drag = system->velocity ? march->step->drag : DRAG_DEFAULT;                                    \
        return split_march(&SPLIT_ROW, system->n, drag, any_force, any_drag, system, march);                           \
    }
#include "split.def"
#undef SPLITTING

static const struct kernels {
    const struct method *method;
    march_function *march;
    step_function *step;
} kernels[] = {
#define RUNGE_KUTTA(...) {&RK_ROW, RK_NAME, STEP_NAME},
#include "rk.def"
#define SPLITTING(...) {&SPLIT_ROW, SPLIT_NAME, NULL},
#include "split.def"
};

static const struct kernels *kernels_of(const struct method *method)
{
    for (size_t i = 0; i < COUNT_OF(kernels); i++)
        if (method->step == kernels[i].method->step && strcmp(kernels[i].method->row.name, method->row.name) == 0)
            return &kernels[i];
    return NULL;
}

march_function *any_kernel(const struct method *method)
{
    const struct kernels *kernel = kernels_of(method);
    return kernel ? kernel->march : NULL;
}

step_function *any_step_kernel(const struct method *method)
{
    const struct kernels *kernel = kernels_of(method);
    return kernel ? kernel->step : NULL;
}
