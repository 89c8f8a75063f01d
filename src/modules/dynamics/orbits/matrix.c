/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Small dense matrices: determinants that do not overflow, sums and products of eigenvalues. */
#include "modules/dynamics/orbits/field.h"

#include <math.h>

static void swap_rows(int n, double *a, int i, int j)
{
    for (int k = 0; k < n; k++) {
        const double kept = a[i * n + k];
        a[i * n + k] = a[j * n + k];
        a[j * n + k] = kept;
    }
}

/*
 * Gaussian elimination with partial pivoting (Golub, Van Loan 1996, Matrix Computations, 3.4): a
 * [n][n] becomes upper triangular, and the same is done to the column b [n] unless it is NULL.
 * Stops at a pivot that is 0. Returns the sign of the row exchanges, or 0 if `a` is not finite.
 */
static int eliminate(int n, double *a, double *b)
{
    int sign = 1;
    for (int i = 0; i < n * n; i++)
        if (!isfinite(a[i]))
            return 0;
    for (int p = 0; p < n; p++) {
        int best = p;
        for (int i = p + 1; i < n; i++)
            if (fabs(a[i * n + p]) > fabs(a[best * n + p]))
                best = i;
        if (best != p) {
            sign = -sign;
            swap_rows(n, a, p, best);
            if (b)
                swap_rows(1, b, p, best);
        }
        if (a[p * n + p] == 0)
            break;
        for (int i = p + 1; i < n; i++) {
            const double factor = a[i * n + p] / a[p * n + p];
            for (int j = p + 1; j < n; j++)
                a[i * n + j] -= factor * a[p * n + j];
            if (b)
                b[i] -= factor * b[p];
        }
    }
    return sign;
}

static double diagonal_product(int n, const double *a, int sign, int *exponent)
{
    double product = sign;
    *exponent = 0;
    for (int i = 0; i < n && product != 0; i++) {
        int more;
        product = frexp(product * a[i * n + i], &more);
        *exponent += more;
    }
    return product;
}

bool matrix_solve(int n, double *a, double *b)
{
    int exponent;
    if (diagonal_product(n, a, eliminate(n, a, b), &exponent) == 0)
        return false;
    for (int i = n; i-- > 0;) {
        for (int j = i + 1; j < n; j++)
            b[i] -= a[i * n + j] * b[j];
        b[i] /= a[i * n + i];
        if (!isfinite(b[i]))
            return false;
    }
    return true;
}

double matrix_determinant(int n, double *a, int *exponent)
{
    const int sign = eliminate(n, a, NULL);
    const double product = diagonal_product(n, a, sign, exponent);
    return sign != 0 ? product : NAN;
}

static double entry(int n, const double *a, int i, int j)
{
    return a[i * n + j];
}

/* Of the row of the pair p > q, the column of r > s. */
static double pair_sum(int n, const double *a, int p, int q, int r, int s)
{
    return r == q             ? -entry(n, a, p, s)
           : r != p && s == q ? entry(n, a, p, r)
           : r == p && s == q ? entry(n, a, p, p) + entry(n, a, q, q)
           : r == p           ? entry(n, a, q, s)
           : s == p           ? -entry(n, a, q, r)
                              : 0;
}

void matrix_pair_sums(int n, const double *jacobian, double *pairs)
{
    for (int p = 1; p < n; p++)
        for (int q = 0; q < p; q++)
            for (int r = 1; r < n; r++)
                for (int s = 0; s < r; s++)
                    *pairs++ = pair_sum(n, jacobian, p, q, r, s);
}
