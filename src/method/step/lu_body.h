/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Elimination for one size, compiled in lu.c and in kernels, so that both give the same bits. The
 * diagonal of the factors holds reciprocals. Source: Golub, Van Loan 1996,
 * Matrix Computations, 3.4.
 */
#pragma once

#include "method/step/lu.h"

#include <math.h>

#define LU_FUNCTION static inline __attribute__((always_inline))

LU_FUNCTION void doubles_swap(double *a, double *b)
{
    double c = *a;
    *a = *b;
    *b = c;
}

/* Replaces a [n][n] by its factors; pivot [n] receives the row that was swapped with each. Returns
 * false if a is singular or not finite. */
LU_FUNCTION bool lu_factor_size(int n, double *a, double *pivot)
{
    for (int p = 0; p < n; p++) {
        int best = p;
        for (int i = p + 1; i < n; i++)
            if (fabs(a[i * n + p]) > fabs(a[best * n + p]))
                best = i;
        double inverse = 1 / a[best * n + p];
        if (inverse == 0 || !isfinite(inverse))
            return false;
        pivot[p] = best;
        /* tests each i, so that indices are constants and small matrices stay in registers */
        for (int i = p + 1; i < n; i++)
            for (int j = p; j < n && i == best; j++)
                doubles_swap(&a[p * n + j], &a[i * n + j]);
        a[p * n + p] = inverse;
        for (int i = p + 1; i < n; i++) {
            double factor = a[i * n + p] *= inverse;
            for (int j = p + 1; j < n; j++)
                a[i * n + j] -= factor * a[p * n + j];
        }
    }
    return true;
}

/* Replaces b [n] by the solution of a x = b, by the factors of lu_factor_size(). */
LU_FUNCTION void lu_solve_size(int n, const double *a, const double *pivot, double *b)
{
    for (int p = 0; p < n; p++) {
        int best = (int)pivot[p];
        for (int i = p + 1; i < n; i++)
            if (i == best)
                doubles_swap(&b[p], &b[i]);
        for (int i = p + 1; i < n; i++)
            b[i] -= a[i * n + p] * b[p];
    }
    for (int i = n; i-- > 0;) {
        for (int j = i + 1; j < n; j++)
            b[i] -= a[i * n + j] * b[j];
        b[i] *= a[i * n + i];
    }
}

/* Returns true if the determinant of the factored matrix is negative. The diagonal holds the
 * reciprocals of the pivots. */
LU_FUNCTION bool lu_negative(int n, const double *a)
{
    bool negative = false;
    for (int p = 0; p < n; p++)
        negative ^= (a[p * n + p] < 0) != ((int)a[n * n + p] != p);
    return negative;
}
