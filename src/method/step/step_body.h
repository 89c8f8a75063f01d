/* SPDX-License-Identifier: GPL-3.0-or-later */
/* rk_step() for kernels: the compiler knows the method and the function that evaluates the slope.
 * Needs MOST, the largest number of variables. */
#pragma once

#include "method/control/march_body.h"
#include "method/control/rk_error.h"

/* Takes a step as rk_step() does. */
INLINE enum step_status one_step(const struct method *method, int n, slope_function *slope,
                                 const void *forces, struct step *step)
{
    const struct tableau *tableau = method->tableau;
    const int stages = tableau->stages;
    double k[STAGES_MAX * MOST], z[MOST], y[MOST];
    /* keeps gcc from warning that y may be uninitialised */
    if (n < 1)
        __builtin_unreachable();
    if (step->low)
        return rk_step(method, step);
    for (int i = 0; i < n; i++)
        y[i] = step->y[i];
    const bool known = (tableau->fsal && step->warm) || step->again;
    const double *first = step->work + (tableau->fsal && step->warm ? (stages - 1) * n : 0);
    for (int i = 0; i < n; i++)
        k[i] = first[i];
    rk_stages(tableau, n, slope, forces, step->t, step->h, y, k, z, NULL, known);
    step->cost.evals += stages - known;
    for (int i = 0; i < stages * n; i++)
        step->work[i] = k[i];
    /* the interpolant's stages are not there */
    step->work[(stages + tableau->extra + 1) * n] = false;
    if (step->error && tableau->b_hat)
        step->square = rk_estimate(tableau, n, step_scale(step), step->h, k, y, z, step->error);
    bool finite = true;
    for (int i = 0; i < n; i++)
        finite = finite && isfinite(z[i]);
    if (!finite)
        return STEP_NONFINITE;
    for (int i = 0; i < n; i++)
        step->y[i] = z[i];
    return STEP_OK;
}

/* Does the same as one_step(), for methods that the compiler does not know, with the stride of
 * picked_march(). */
INLINE enum step_status picked_step(const struct method *method, int n, int stride,
                                    combine_function *combine, slope_function *slope,
                                    const void *forces, struct step *step)
{
    const struct tableau *tableau = method->tableau;
    const int stages = tableau->stages;
    struct weights weights[STAGES_MAX];
    double k[STAGES_MAX * MOST], z[MOST], y[MOST];
    if (step->low)
        return rk_step(method, step);
    stages_take(weights, tableau, step->h);
    blocks_begin(stages, n, stride, k, y);
    copy_numbers(n, step->y, y);
    const bool known = (tableau->fsal && step->warm) || step->again;
    copy_numbers(n, step->work + (tableau->fsal && step->warm ? (stages - 1) * n : 0), k);
    picked_stages(tableau, weights, n, stride, combine, slope, forces, step->t, step->h, y, k, z,
                  known);
    step->cost.evals += stages - known;
    for (int s = 0; s < stages; s++)
        copy_numbers(n, k + s * stride, step->work + s * n);
    step->work[(stages + tableau->extra + 1) * n] = false;
    if (step->error && tableau->b_hat)
        step->square =
            rk_estimate(tableau, n, step_scale(step), step->h, step->work, y, z, step->error);
    return step_finish(step, z);
}
