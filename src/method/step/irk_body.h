/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The stages of implicit Runge-Kutta methods that are solved one by one. irk.c compiles this for
 * any method, kernel/implicit.c where the compiler knows method and forces; both give the same
 * bits.
 */
#pragma once

#include "method/step/newton.h"

#ifndef INLINE
#define INLINE static inline __attribute__((always_inline))
#endif

/* Solves z = h f(t, y + z) and sets sum = y + z; forces is data of the function, work memory of the
 * solver. */
typedef enum step_status stage_function(const void *forces, struct step *step, double t, double h,
                                        const double *y, double *z, double *sum, double *work);

/* Returns true if the last stage is the new state. */
INLINE bool stiffly_accurate(const struct implicit_tableau *tableau)
{
    int s = tableau->stages;
    for (int i = 0; i < s; i++)
        if (tableau->a[(s - 1) * s + i] != tableau->b[i])
            return false;
    return true;
}

/*
 * Computes the stages of a step from step->t, step->y over step->h. k [stages][n] receives the
 * slopes, z and sum [n] the last stage's increment and state; base [n] is scratch. With `warm`, k
 * holds the slopes of the step before.
 */
INLINE enum step_status diagonal_stages(const struct implicit_tableau *tableau, int n,
                                        stage_function *stage, slope_function *slope,
                                        const void *forces, struct step *step, bool warm, double *k,
                                        double *z, double *sum, double *base, double *work)
{
    const int stages = tableau->stages;
    const double t = step->t, h = step->h, part = tableau->diagonal * h, *y = step->y;
    for (int s = 0; s < stages; s++) {
        const double *row = tableau->a + s * stages;
        if (row[s] == 0) { /* the first, at y */
            if (tableau->fsal && warm) {
                memcpy(k + s * n, k + (stages - 1) * n, (size_t)n * sizeof *k);
            } else {
                slope(forces, t, y, k + s * n);
                step->cost.evals++;
            }
            continue;
        }
        for (int i = 0; i < n; i++)
            base[i] = s > 0 ? y[i] + h * weighted_sum(row, s, k, n, i) : y[i];
        const enum step_status status =
            stage(forces, step, t + tableau->c[s] * h, part, base, z, sum, work);
        if (status != STEP_OK)
            return status;
        for (int i = 0; i < n; i++)
            k[s * n + i] = z[i] / part;
    }
    return STEP_OK;
}

/* Replaces z, the last stage's increment, by the increment of the whole step. */
INLINE void diagonal_increment(const struct implicit_tableau *tableau, int n, double h,
                               const double *k, double *z)
{
    for (int i = 0; i < n; i++)
        z[i] = tableau->stages == 1 ? tableau->b[0] / tableau->diagonal * z[i]
                                    : h * weighted_sum(tableau->b, tableau->stages, k, n, i);
}
