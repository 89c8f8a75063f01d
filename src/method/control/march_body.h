/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Marches (many steps of one size) of explicit Runge-Kutta methods and splittings, for kernels: the
 * compiler knows the method and the function that evaluates the forces. A file that includes this
 * defines MOST, the largest number of variables, before.
 */
#pragma once

#include "method/step/rk_body.h"
#include "method/step/split_body.h"
#include "method/step/weights.h"

/* Most stages of a Runge-Kutta method, and most weights of a splitting. */
enum { STAGES_MAX = 16, WEIGHTS_MAX = 40 };

INLINE void copy_numbers(int count, const double *source, double *target)
{
    for (int i = 0; i < count; i++)
        target[i] = source[i];
}

/* Sets sums to -0.0, which is neutral in additions. */
INLINE void sum_begin(int count, double *sum)
{
    for (int i = 0; i < count; i++)
        sum[i] = -0.0;
}

/* Takes all steps of the march with an explicit Runge-Kutta method. Returns their number. */
INLINE int64_t rk_march(const struct method *method, int n, slope_function *slope,
                        const void *forces, const struct march *march)
{
    const struct tableau *tableau = method->tableau;
    struct step *step = march->step;
    const int stages = tableau->stages;
    double k[STAGES_MAX * MOST], z[MOST], y[MOST];
    double *const last = k + (stages - 1) * n, *const kept = step->work + (stages - 1) * n;
    copy_numbers(n, step->y, y);
    const bool known = tableau->fsal && step->warm;
    if (known)
        copy_numbers(n, kept, last);
    else if (tableau->fsal)
        slope(forces, march->origin + (double)march->first * step->h, y, last);

    double *row = march->row;
    for (int64_t i = 0; i < march->count; i++, row += n) {
        if (tableau->fsal)
            copy_numbers(n, last, k);
        rk_stages(tableau, n, slope, forces, march->origin + (double)(march->first + i) * step->h,
                  step->h, y, k, z, NULL, tableau->fsal);
        copy_numbers(n, z, y);
        copy_numbers(n, z, row);
    }
    if (tableau->fsal)
        copy_numbers(n, last, kept);
    copy_numbers(n, y, step->y);
    step->warm = true;
    step->cost.evals += march->count * (stages - tableau->fsal) + (tableau->fsal && !known);
    return march->count;
}

/* Computes z = y + sum_j weight_j k_j; k is [stages][stride]. */
typedef void combine_function(int n, int stride, const struct weights *weights, const double *k,
                              const double *y, double *z);

/* Does the same as rk_stages(), with weights that were picked before (weights.h). */
INLINE void picked_stages(const struct tableau *tableau, const struct weights *weights, int n,
                          int stride, combine_function *combine, slope_function *slope,
                          const void *forces, double t, double h, const double *y, double *k,
                          double *z, bool known)
{
    const int stages = tableau->stages;
    if (!known)
        slope(forces, t, y, k);
    for (int s = 1; s < stages; s++) {
        combine(n, stride, &weights[s], k, y, z);
        slope(forces, t + tableau->c[s] * h, z, k + s * stride);
    }
    if (!tableau->fsal)
        combine(n, stride, &weights[0], k, y, z);
}

/* Clears the numbers between the n variables and the next stage's, because sums in whole blocks
 * include them. */
INLINE void blocks_begin(int stages, int n, int stride, double *k, double *y)
{
    for (int i = n; i < stride; i++) {
        y[i] = 0;
        for (int s = 0; s < stages; s++)
            k[s * stride + i] = 0;
    }
}

/* Does the same as rk_march(), for methods that the compiler does not know. stride, at least n,
 * separates the slopes of one stage from those of the next. */
INLINE int64_t picked_march(const struct method *method, int n, int stride,
                            combine_function *combine, slope_function *slope, const void *forces,
                            const struct march *march)
{
    const struct tableau *tableau = method->tableau;
    struct step *step = march->step;
    const int stages = tableau->stages;
    const double h = step->h;
    struct weights weights[STAGES_MAX];
    double k[STAGES_MAX * MOST], state[2][MOST], *y = state[0], *z = state[1];
    double *const last = k + (stages - 1) * stride, *const kept = step->work + (stages - 1) * n;
    stages_take(weights, tableau, h);
    blocks_begin(stages, n, stride, k, y);
    copy_numbers(n, step->y, y);
    const bool known = tableau->fsal && step->warm;
    if (known)
        copy_numbers(n, kept, last);
    else if (tableau->fsal)
        slope(forces, march->origin + (double)march->first * h, y, last);
    double *row = march->row;
    for (int64_t i = 0; i < march->count; i++, row += n) {
        if (tableau->fsal)
            copy_numbers(n, last, k);
        picked_stages(tableau, weights, n, stride, combine, slope, forces,
                      march->origin + (double)(march->first + i) * h, h, y, k, z, tableau->fsal);
        double *const previous = y;
        y = z;
        z = previous;
        copy_numbers(n, y, row);
    }
    if (tableau->fsal)
        copy_numbers(n, last, kept);
    copy_numbers(n, y, step->y);
    step->warm = true;
    step->cost.evals += march->count * (stages - tableau->fsal) + (tableau->fsal && !known);
    return march->count;
}

/* Takes all steps of the march with a splitting; known holds the data of the force functions.
 * Returns their number. */
INLINE int64_t split_march(const struct method *method, int n, enum drag drag,
                           force_function *force, force_function *velocity, const void *known,
                           const struct march *march)
{
    struct step *step = march->step;
    const double h = step->h;
    double z[MOST], pull[MOST / 2];
    const struct oscillator oscillator = step->system->oscillator;
    const struct split_forces forces = {force, velocity, known, &oscillator};
    struct split_way way;
    split_choose(&way, method, drag);

    const struct drag_flow half =
        way.drag_at_ends ? oscillator_drag_flow(&oscillator, h / 2) : (struct drag_flow){0};
    struct frozen frozen[WEIGHTS_MAX];
    const bool freezes = drag == DRAG_EXACT && !way.drag_at_ends;
    for (int i = 0; freezes && i < way.splitting->count; i++)
        frozen[i] = frozen_over(&oscillator, splitting_weight(way.splitting, i) * h);
    copy_numbers(n, step->y, z);
    if (split_known(&way, step))
        copy_numbers(n / 2, step->work + n, pull);
    else if (way.continues)
        force(known, march->origin + (double)march->first * h, z, pull);
    else
        sum_begin(n / 2, pull);
    double *row = march->row;
    for (int64_t i = 0; i < march->count; i++, row += n) {
        split_stages(&way, n, &forces, &half, freezes ? frozen : NULL,
                     march->origin + (double)(march->first + i) * h, h, z, pull, NULL,
                     way.continues);
        copy_numbers(n, z, row);
    }
    step->cost.evals += march->count * (way.kicks - way.continues) + (way.continues && !step->warm);
    copy_numbers(n / 2, pull, step->work + n);
    copy_numbers(n, z, step->y);
    step->warm = true;
    return march->count;
}
