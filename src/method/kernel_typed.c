/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Kernels of typed scenes: the step bodies of explicit Runge-Kutta methods with a program for the right-hand side,
 * whose parameters and numbers are laid out once for many steps.
 */
#define UNROLL _Pragma("GCC unroll 32")
#include "rk_body.h"
#include "rows.h"

#include <string.h>

enum { FRAME = 256, STAGES_MAX = 16, MOST = 4 };

struct known {
    const struct program *program;
    double *frame; /* t, y, then what stays */
};

INLINE void evaluate(const struct known *known, int n, double t, const double *y, double *out)
{
    known->frame[0] = t;
    for (int i = 0; i < n; i++)
        known->frame[1 + i] = y[i];
    program_eval(known->program, known->frame, out, known->frame);
}

INLINE void motion_slope(int n, const struct known *known, double t, const double *y, double *dydt)
{
    for (int i = 0; i < n / 2; i++)
        dydt[i] = y[n / 2 + i];
    evaluate(known, n, t, y, dydt + n / 2);
}

#define SHAPES(S) S(line, 2, motion_slope) S(plane, 4, motion_slope) S(two, 2, flow_slope) S(three, 3, flow_slope)

INLINE void flow_slope(int n, const struct known *known, double t, const double *y, double *dydt)
{
    evaluate(known, n, t, y, dydt);
}

#define SHAPE_SLOPE(name, n, slope)                                                                                    \
    INLINE void name##_slope(const void *known, double t, const double *y, double *dydt)                               \
    {                                                                                                                  \
        slope(n, known, t, y, dydt);                                                                                   \
    }
SHAPES(SHAPE_SLOPE)

INLINE void rk_march(const struct method *method, int n, slope_function *slope, const struct march *march)
{
    const struct tableau *tableau = method->tableau;
    struct step *step = march->step;
    const int stages = tableau->stages;
    double frame[FRAME], k[STAGES_MAX * MOST], z[MOST], y[MOST];
    double *const last = k + (stages - 1) * n, *const kept = step->work + (stages - 1) * n;
    const struct known known = {system_program(step->system, frame, FRAME), frame};
    memcpy(y, step->y, (size_t)n * sizeof *y);
    const bool warm = tableau->fsal && step->warm;
    if (warm)
        memcpy(last, kept, (size_t)n * sizeof *last);
    else if (tableau->fsal)
        slope(&known, march->origin + (double)march->first * step->h, y, last);
    double *row = march->row;
    for (int64_t i = 0; i < march->count; i++, row += n) {
        if (tableau->fsal)
            memcpy(k, last, (size_t)n * sizeof *k);
        rk_stages(tableau, n, slope, &known, march->origin + (double)(march->first + i) * step->h, step->h, y, k, z,
                  NULL, tableau->fsal);
        memcpy(y, z, (size_t)n * sizeof *y);
        memcpy(row, z, (size_t)n * sizeof *row);
    }
    if (tableau->fsal)
        memcpy(kept, last, (size_t)n * sizeof *kept);
    memcpy(step->y, y, (size_t)n * sizeof *y);
    step->warm = true;
    step->cost.evals += march->count * (stages - tableau->fsal) + (tableau->fsal && !warm);
}

#define RK_ROW JOIN(rk_, __LINE__)
#define RK_NAME(shape) JOIN(shape##_rk_, __LINE__)
#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)

#define RK_KERNEL(name, n, slope)                                                                                      \
    static void RK_NAME(name)(const struct march *march)                                                               \
    {                                                                                                                  \
        rk_march(&RK_ROW, n, name##_slope, march);                                                                     \
    }
#define RUNGE_KUTTA(...)                                                                                               \
    static const struct method RK_ROW = {.step = rk_step, __VA_ARGS__};                                                \
    SHAPES(RK_KERNEL)
#include "rk.def"
#undef RUNGE_KUTTA

#define SHAPE_PLACE(name, n, slope) SHAPE_##name,
enum { SHAPES(SHAPE_PLACE) SHAPE_COUNT };

#define RK_ENTRY(name, n, slope) RK_NAME(name),
static const struct {
    const struct method *method;
    march_function *march[SHAPE_COUNT];
} kernels[] = {
#define RUNGE_KUTTA(...) {&RK_ROW, {SHAPES(RK_ENTRY)}},
#include "rk.def"
};

march_function *typed_kernel(const struct method *method, const struct system *system)
{
    double frame[FRAME];
    const int n = system->n;
    const int shape = system->order == 2 ? (n == 2 ? SHAPE_line : n == 4 ? SHAPE_plane : -1)
                                         : (n == 2 ? SHAPE_two : n == 3 ? SHAPE_three : -1);
    if (shape < 0 || method->step != rk_step || !system_program(system, frame, FRAME))
        return NULL;
    for (size_t i = 0; i < COUNT_OF(kernels); i++)
        if (strcmp(kernels[i].method->row.name, method->row.name) == 0)
            return kernels[i].march[shape];
    return NULL;
}
