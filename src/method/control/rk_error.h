/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The error estimate of an explicit Runge-Kutta step; kernels and the general step compile this
 * code, so both give the same bits. */
#pragma once

#include "method/step/rk_body.h"

/* Computes error_i = h sum_j (w_j - u_j) k_ji. If n is not a constant, it sums stage by stage, so
 * that compilers make vectors; both orders give the same bits. */
INLINE void rk_difference(int n, double h, const double *w, const double *u, int count,
                          const double *k, double *error)
{
    if (!__builtin_constant_p(n)) {
        double sum[LIMIT_VARIABLES];
        for (int i = 0; i < n; i++)
            sum[i] = -0.0;
        for (int j = 0; j < count; j++)
            for (int i = 0; i < n && w[j] != u[j]; i++)
                sum[i] += (w[j] - u[j]) * k[j * n + i];
        for (int i = 0; i < n; i++)
            error[i] = h * sum[i];
        return;
    }
    for (int i = 0; i < n; i++) {
        double sum = -0.0;
        UNROLL for (int j = 0; j < count; j++) if (w[j] != u[j]) sum +=
            (w[j] - u[j]) * k[j * n + i];
        error[i] = h * sum;
    }
}

/* Combines the difference from the embedded method with that from the rough one, as DOP853 does
 * (II.10, eq. 10.17), if the method has a rough one. Returns the sum of squares by scaled_square(),
 * because the next step waits for that and not for the root. */
INLINE double rk_square(const struct tableau *tableau, int n, const double *scale, const double *y,
                        const double *z, const double *rough, double *error)
{
    const double square = scaled_square(n, scale, error, y, z);
    if (!tableau->rough)
        return square;
    const double part = square / (square + 0.01 * scaled_square(n, scale, rough, y, z));
    const double fraction = square > 0 ? part : 0, root = sqrt(fraction);
    for (int i = 0; i < n; i++)
        error[i] *= root;
    return square * fraction;
}

/* Fills error [n] with the estimated error of the step from y to z. Returns its squared size as
 * rk_square() does. */
INLINE double rk_estimate(const struct tableau *tableau, int n, const double *scale, double h,
                          const double *k, const double *y, const double *z, double *error)
{
    double rough[LIMIT_VARIABLES];
    rk_difference(n, h, tableau->b, tableau->b_hat, tableau->stages, k, error);
    if (tableau->rough)
        rk_difference(n, h, tableau->b, tableau->rough, tableau->stages, k, rough);
    return rk_square(tableau, n, scale, y, z, rough, error);
}
