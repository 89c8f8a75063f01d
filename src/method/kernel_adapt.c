/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Single steps of explicit Runge-Kutta methods with their error estimate: rk_step() again for each row and shape, those
 * of typed scenes too, and for any forces on two or four variables. Adaptive runs spend their time here.
 */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-vectorize") /* pairs of numbers: packing and unpacking them takes longer than it saves   \
                                           */
#endif
#define UNROLL _Pragma("GCC unroll 32")
#include "kernel.h"
#include "kernel_typed.h"
#include "step_body.h"

/* ---- shapes, and any equations of motion ---- */

INLINE void any_slope(const struct system *system, int half, double t, const double *y, double *dydt)
{
    for (int i = 0; i < half; i++) {
        dydt[i] = y[half + i];
        dydt[half + i] = -0.0;
    }
    for (int i = 0; i < system->terms; i++)
        system->term[i].row->add(system->term[i].c, t, y, dydt + half);
}

INLINE void line_slope(const void *system, double t, const double *y, double *dydt)
{
    any_slope(system, 1, t, y, dydt);
}

INLINE void plane_slope(const void *system, double t, const double *y, double *dydt)
{
    any_slope(system, 2, t, y, dydt);
}

#define RK_ROW JOIN(rk_, __LINE__)
#define STEP_NAME(shape) JOIN(shape##_step_, __LINE__)
#define SHAPE_STEP(shape)                                                                                              \
    static enum step_status STEP_NAME(shape)(const struct method *method, struct step *step)                           \
    {                                                                                                                  \
        struct forces forces;                                                                                          \
        (void)method;                                                                                                  \
        forces_take(&forces, step->system);                                                                            \
        return one_step(&RK_ROW, SIZE_##shape, shape##_slope, &forces, step);                                          \
    }
#define ANY_STEP(name, n)                                                                                              \
    static enum step_status STEP_NAME(name)(const struct method *method, struct step *step)                            \
    {                                                                                                                  \
        (void)method;                                                                                                  \
        return one_step(&RK_ROW, n, name##_slope, step->system, step);                                                 \
    }
#define TYPED_STEP(name, n, ...)                                                                                       \
    static enum step_status STEP_NAME(name)(const struct method *method, struct step *step)                            \
    {                                                                                                                  \
        struct known known;                                                                                            \
        (void)method;                                                                                                  \
        known_take(&known, step->system);                                                                              \
        return one_step(&RK_ROW, n, name##_slope, &known, step);                                                       \
    }
#define RUNGE_KUTTA(...)                                                                                               \
    static const struct method RK_ROW = {__VA_ARGS__};                                                                 \
    ALL_SHAPES(SHAPE_STEP)                                                                                             \
    TYPED_MOTIONS(TYPED_STEP)                                                                                          \
    TYPED_FLOWS(TYPED_STEP)                                                                                            \
    ANY_STEP(line, 2)                                                                                                  \
    ANY_STEP(plane, 4)
#include "rk.def"
#undef RUNGE_KUTTA

/* ---- the table ---- */

enum { SHAPE_LINE = SHAPE_COUNT, SHAPE_PLANE, SHAPE_TYPED };
enum { STEP_COUNT = SHAPE_TYPED + TYPED_COUNT };

#define STEP_ENTRY(shape) STEP_NAME(shape),
#define TYPED_ENTRY(name, ...) STEP_NAME(name),

static const struct {
    const struct method *method;
    step_function *step[STEP_COUNT];
} steps[] = {
#define RUNGE_KUTTA(...)                                                                                               \
    {&RK_ROW,                                                                                                          \
     {ALL_SHAPES(STEP_ENTRY) STEP_NAME(line), STEP_NAME(plane),                                                        \
      TYPED_MOTIONS(TYPED_ENTRY) TYPED_FLOWS(TYPED_ENTRY)}},
#include "rk.def"
};

step_function *method_step_kernel(const struct method *method, const struct system *system)
{
    int shape = system->n == 4 ? SHAPE_PLANE : SHAPE_LINE;
    if (method->rosenbrock)
        return rosenbrock_step_kernel(method, system);
    if (method->step != rk_step)
        return NULL;
    const int typed = typed_shape(system, false);
    if (typed >= 0)
        shape = SHAPE_TYPED + typed;
    else if (system->order != 2 || system->n > 4)
        return system->typed.row ? any_step_kernel(method) : NULL;
    else if (shape_of(system) >= 0)
        shape = shape_of(system);
    for (size_t i = 0; i < COUNT_OF(steps); i++)
        if (strcmp(steps[i].method->row.name, method->row.name) == 0)
            return steps[i].step[shape];
    return NULL;
}
