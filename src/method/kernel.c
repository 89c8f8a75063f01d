/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Kernels: the step bodies again, each row of explicit Runge-Kutta methods and splittings with each shape that is not
 * linear (those have the propagator). The compiler knows coefficients and forces, so loops unroll, zeros
 * vanish and the state stays in registers.
 */
#define UNROLL _Pragma("GCC unroll 32")
#include "kernel.h"

/* ---- explicit Runge-Kutta ---- */

INLINE void rk_march(const struct method *method, int n, slope_function *slope, const struct march *march)
{
    const struct tableau *tableau = method->tableau;
    struct step *step = march->step;
    const int stages = tableau->stages;
    double k[STAGES_MAX * MOST], z[MOST], y[MOST];
    double *const last = k + (stages - 1) * n, *const kept = step->work + (stages - 1) * n;
    struct forces forces;
    forces_take(&forces, step->system);
    copy_numbers(n, step->y, y);
    const bool known = tableau->fsal && step->warm;
    if (known)
        copy_numbers(n, kept, last);
    else if (tableau->fsal)
        slope(&forces, march->origin + (double)march->first * step->h, y, last);

    double *row = march->row;
    for (int64_t i = 0; i < march->count; i++, row += n) {
        if (tableau->fsal)
            copy_numbers(n, last, k);
        rk_stages(tableau, n, slope, &forces, march->origin + (double)(march->first + i) * step->h, step->h, y, k, z,
                  NULL, tableau->fsal);
        copy_numbers(n, z, y);
        copy_numbers(n, z, row);
    }
    if (tableau->fsal)
        copy_numbers(n, last, kept);
    copy_numbers(n, y, step->y);
    step->warm = true;
    step->cost.evals += march->count * (stages - tableau->fsal) + (tableau->fsal && !known);
}

/* ---- splittings, with the drag that they have by default ---- */

INLINE void split_march(const struct method *method, int n, enum drag drag, force_function *force,
                        force_function *velocity, const struct march *march)
{
    struct step *step = march->step;
    const double h = step->h;
    double z[MOST], pull[MOST / 2];
    struct forces known;
    forces_take(&known, step->system);
    const struct oscillator oscillator = step->system->oscillator;
    const struct split_forces forces = {force, velocity, &known, &oscillator};
    struct split_way way;
    split_choose(&way, method, drag);

    const struct drag_flow half = way.around ? oscillator_drag_flow(&oscillator, h / 2) : (struct drag_flow){0};
    struct frozen frozen[WEIGHTS_MAX];
    const bool freezes = drag == DRAG_EXACT && !way.around;
    for (int i = 0; freezes && i < way.splitting->count; i++)
        frozen[i] = frozen_over(&oscillator, splitting_weight(way.splitting, i) * h);
    copy_numbers(n, step->y, z);
    if (split_known(&way, step))
        copy_numbers(n / 2, step->work + n, pull);
    else if (way.continues)
        force(&known, march->origin + (double)march->first * h, z, pull);
    else
        sum_begin(n / 2, pull);
    double *row = march->row;
    for (int64_t i = 0; i < march->count; i++, row += n) {
        split_stages(&way, n, &forces, &half, freezes ? frozen : NULL, march->origin + (double)(march->first + i) * h,
                     h, z, pull, NULL, way.continues);
        copy_numbers(n, z, row);
    }
    step->cost.evals += march->count * (way.kicks - way.continues) + (way.continues && !step->warm);
    copy_numbers(n / 2, pull, step->work + n);
    copy_numbers(n, z, step->y);
    step->warm = true;
}

/* A row is known by the line where it ends. */
#define RK_ROW JOIN(rk_, __LINE__)
#define RK_NAME(shape) JOIN(shape##_rk_, __LINE__)
#define SPLIT_ROW JOIN(split_, __LINE__)
#define SPLIT_NAME(shape) JOIN(shape##_split_, __LINE__)

#define RK_KERNEL(shape)                                                                                               \
    static void RK_NAME(shape)(const struct march *march)                                                              \
    {                                                                                                                  \
        rk_march(&RK_ROW, SIZE_##shape, shape##_slope, march);                                                         \
    }
#define RUNGE_KUTTA(...)                                                                                               \
    static const struct method RK_ROW = {.step = rk_step, __VA_ARGS__};                                                \
    ALL_SHAPES(RK_KERNEL)
#include "rk.def"
#undef RUNGE_KUTTA

#define HAS_VELOCITY(i, name) | (name##_flags & TERM_VELOCITY)
#define SPLIT_KERNEL(shape)                                                                                            \
    static void SPLIT_NAME(shape)(const struct march *march)                                                           \
    {                                                                                                                  \
        const enum drag drag = (0 TERMS_OF_##shape(HAS_VELOCITY)) ? SPLIT_ROW.drag : DRAG_DEFAULT;                     \
        split_march(&SPLIT_ROW, SIZE_##shape, drag, shape##_force, shape##_drag, march);                               \
    }
#define SPLITTING(...)                                                                                                 \
    static const struct method SPLIT_ROW = {.step = split_step, __VA_ARGS__};                                          \
    ALL_SHAPES(SPLIT_KERNEL)
#include "split.def"
#undef SPLITTING

/* ---- the table ---- */

struct kernels {
    const struct method *method;
    march_function *march[SHAPE_COUNT];
};

#define RK_ENTRY(shape) RK_NAME(shape),
#define SPLIT_ENTRY(shape) SPLIT_NAME(shape),

static const struct kernels kernels[] = {
#define RUNGE_KUTTA(...) {&RK_ROW, {ALL_SHAPES(RK_ENTRY)}},
#include "rk.def"
#define SPLITTING(...) {&SPLIT_ROW, {ALL_SHAPES(SPLIT_ENTRY)}},
#include "split.def"
};

march_function *method_kernel(const struct method *method, const struct system *system, enum drag drag)
{
    const int shape = shape_of(system);
    if (system->model && system->model->typed)
        return typed_kernel(method, system);
    if (shape < 0 || (method->splitting && system->velocity && drag != method->drag))
        return NULL;
    for (size_t i = 0; i < COUNT_OF(kernels); i++)
        if (method->step == kernels[i].method->step && strcmp(kernels[i].method->row.name, method->row.name) == 0)
            return kernels[i].march[shape];
    return NULL;
}
