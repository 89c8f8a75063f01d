/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The error estimate of an explicit Runge-Kutta step, in one text like its stages. */
#pragma once

#include "method/step/rk_body.h"

/* Stage by stage where the number of variables is not known, so that they are in vectors; the same
 * bits. */
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

/*
 * The difference from the embedded weights; with a rough one too, that of DOP853 (II.10,
 * eq. 10.17). Returns the sum of its squares by scaled_square(): the next step waits for that, not
 * for the root.
 */
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

INLINE double rk_estimate(const struct tableau *tableau, int n, const double *scale, double h,
                          const double *k, const double *y, const double *z, double *error)
{
    double rough[LIMIT_VARIABLES];
    rk_difference(n, h, tableau->b, tableau->b_hat, tableau->stages, k, error);
    if (tableau->rough)
        rk_difference(n, h, tableau->b, tableau->rough, tableau->stages, k, rough);
    return rk_square(tableau, n, scale, y, z, rough, error);
}
