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
#include "kernel_typed.h"
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

/* A whole typed scene in one program: prepared once a march, not at each evaluation. */
struct whole {
    const struct system *system;
    int positions; /* variables whose slopes are others; -1: not in one program */
    bool force;    /* what does not depend on velocity is in one */
    struct known known;
};

static void whole_take(struct whole *whole, const struct system *system)
{
    const int n = system->n, rows = system->order == 2 ? n / 2 : n;
    whole->system = system;
    const bool taken = n > 2 && known_take(&whole->known, system);
    whole->positions = taken && sum_is_one(&whole->known.whole) ? n - rows : -1;
    whole->force = taken && sum_is_one(&whole->known.force);
}

static void whole_slope(const void *of, double t, const double *y, double *dydt)
{
    const struct whole *whole = of;
    const int n = whole->system->n, positions = whole->positions;
    if (positions < 0) {
        system_derivative(whole->system, t, y, dydt);
        return;
    }
    memcpy(dydt, y + n - positions, (size_t)positions * sizeof *y);
    one_evaluate(&whole->known.whole, n, n - positions, t, y, dydt + positions);
}

static void whole_force(const void *of, double t, const double *y, double *a)
{
    const struct whole *whole = of;
    const int n = whole->system->n;
    if (whole->force)
        one_evaluate(&whole->known.force, n, n / 2, t, y, a);
    else
        system_force(whole->system, t, y, a);
}

static void whole_drag(const void *of, double t, const double *y, double *a)
{
    const struct whole *whole = of;
    system_drag(whole->system, t, y, a);
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
        struct whole whole;                                                                                            \
        whole_take(&whole, system);                                                                                    \
        return rk_march(&RK_ROW, size_of(system), whole_slope, &whole, march);                                         \
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
        struct whole whole;                                                                                            \
        whole_take(&whole, system);                                                                                    \
        return split_march(&SPLIT_ROW, system->n, drag, whole_force, whole_drag, &whole, march);                       \
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
