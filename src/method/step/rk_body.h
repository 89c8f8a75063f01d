/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The stages of an explicit Runge-Kutta step. rk.c compiles them for any tableau and system, the
 * kernels where the compiler knows both; both give the same bits.
 */
#pragma once

#include "method/step/step.h"

#ifndef UNROLL
#define UNROLL
#endif
#define INLINE static inline __attribute__((always_inline))

/* Computes z = y + sum_j (h w_j) k_j. low is as in struct step, or NULL. */
INLINE void rk_combine(int n, double h, const double *w, int count, const double *k,
                       const double *y, double *z, double *low)
{
    for (int i = 0; i < n; i++) {
        double sum = -0.0;
        UNROLL for (int j = 0; j < count; j++) if (w[j] != 0) sum += h * w[j] * k[j * n + i];
        z[i] = y[i];
        step_add(&z[i], low ? &low[i] : NULL, sum);
    }
}

/* Computes the stages k [stages][n] and the new state z. `known` means that k_1 has been
 * computed. */
INLINE void rk_stages(const struct tableau *tableau, int n, slope_function *slope,
                      const void *forces, double t, double h, const double *y, double *k, double *z,
                      double *low, bool known)
{
    const int stages = tableau->stages;
    if (!known)
        slope(forces, t, y, k);
    UNROLL for (int s = 1; s < stages; s++)
    {
        rk_combine(n, h, tableau_row(tableau, s), s, k, y, z,
                   tableau->fsal && s == stages - 1 ? low : NULL);
        slope(forces, t + tableau->c[s] * h, z, k + s * n);
    }
    if (!tableau->fsal) /* else z is already there: the last row of a equals b */
        rk_combine(n, h, tableau->b, stages, k, y, z, low);
}
