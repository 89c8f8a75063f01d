/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Small dense matrices: determinants that do not overflow, sums and products of eigenvalues. */
#include "study/dynamics/field.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <math.h>

/* Gaussian elimination with partial pivoting, GSL's; false: not finite, no memory. */
static bool factor(int n, double *a, gsl_permutation *order, int *sign)
{
    gsl_matrix_view view = gsl_matrix_view_array(a, (size_t)n, (size_t)n);
    for (int i = 0; i < n * n; i++)
        if (!isfinite(a[i]))
            return false;
    return gsl_linalg_LU_decomp(&view.matrix, order, sign) == GSL_SUCCESS;
}

static double diagonal_product(int n, const double *a, int sign, int *exponent)
{
    double product = sign;
    *exponent = 0;
    /* what lies behind a pivot that is 0 has been divided by it */
    for (int i = 0; i < n && product != 0; i++) {
        int more;
        product = frexp(product * a[i * n + i], &more);
        *exponent += more;
    }
    return product;
}

bool matrix_solve(int n, double *a, double *b)
{
    size_t place[MATRIX_MAX];
    gsl_permutation order = {(size_t)n, place};
    int sign, exponent;
    gsl_set_error_handler_off(); /* GSL's default ends the program; statuses are checked here */
    if (n > MATRIX_MAX || !factor(n, a, &order, &sign))
        return false;
    gsl_matrix_view view = gsl_matrix_view_array(a, (size_t)n, (size_t)n);
    gsl_vector_view right = gsl_vector_view_array(b, (size_t)n);
    if (diagonal_product(n, a, sign, &exponent) == 0 ||
        gsl_linalg_LU_svx(&view.matrix, &order, &right.vector) != GSL_SUCCESS)
        return false;
    for (int i = 0; i < n; i++)
        if (!isfinite(b[i]))
            return false;
    return true;
}

double matrix_determinant(int n, double *a, int *exponent)
{
    size_t place[MATRIX_MAX];
    gsl_permutation order = {(size_t)n, place};
    int sign;
    *exponent = 0;
    if (n == 0)
        return 1;
    gsl_set_error_handler_off();
    return n <= MATRIX_MAX && factor(n, a, &order, &sign) ? diagonal_product(n, a, sign, exponent)
                                                          : NAN;
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
