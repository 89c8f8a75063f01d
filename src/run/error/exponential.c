/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Exponentials of matrices, with their size kept as a logarithm. */
#include "run/error/exponential.h"

#include <hooke/base/elementary.h>
#include <hooke/base/limit.h>

#include <math.h>
#include <string.h>

enum { TERMS = 10, SQUARINGS_MAX = 200, NORMALISED_EACH = 3 }; /* 0.5^11 / 11! is 1e-11 */

double matrix_norm(int n, const double *a)
{
    double max = 0;
    for (int i = 0; i < n; i++) {
        double sum = 0;
        for (int j = 0; j < n; j++)
            sum += fabs(a[i * n + j]);
        max = fmax(max, sum);
    }
    return max;
}

static void multiply(int n, const double *a, const double *b, double *product)
{
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            double sum = 0;
            for (int k = 0; k < n; k++)
                sum += a[i * n + k] * b[k * n + j];
            product[i * n + j] = sum;
        }
}

/* Divides a by a power of two, so that its norm is near 1. Returns that power. */
static int normalise(int n, double *a)
{
    int exponent = 0;
    frexp(matrix_norm(n, a), &exponent);
    const double factor = ldexp(1, -exponent);
    for (int i = 0; i < n * n; i++)
        a[i] *= factor;
    return exponent;
}

/* Fills sum [n][n] with the series of exp(a), |a| <= 0.5, by Horner's rule. */
static void exponential_series(int n, const double *a, double *sum, double *product)
{
    memset(sum, 0, (size_t)n * (size_t)n * sizeof *sum);
    for (int i = 0; i < n; i++)
        sum[i * n + i] = 1;
    for (int k = TERMS; k > 0; k--) {
        multiply(n, a, sum, product);
        for (int i = 0; i < n * n; i++)
            sum[i] = product[i] / k;
        for (int i = 0; i < n; i++)
            sum[i * n + i]++;
    }
}

double exponential_apply(int n, double *a, double *v, double *work)
{
    double result[LIMIT_VARIABLES], *sum = work, *product = work + n * n;
    double norm = matrix_norm(n, a), part = 1, size = 0, before = 0;
    int squarings = 0;
    for (; norm * part > 0.5 && squarings < SQUARINGS_MAX; squarings++)
        part /= 2;
    for (int i = 0; i < n * n; i++)
        a[i] *= part;
    exponential_series(n, a, sum, product);
    double log2_size = 0;
    for (int k = 0; k < squarings; k++) {
        double *square = product;
        multiply(n, sum, sum, square);
        product = sum;
        sum = square;
        log2_size *= 2;
        if (k % NORMALISED_EACH == 0)
            log2_size += normalise(n, sum);
    }
    for (int i = 0; i < n; i++) {
        result[i] = 0;
        for (int j = 0; j < n; j++)
            result[i] += sum[i * n + j] * v[j];
        before = fmax(before, fabs(v[i]));
        size = fmax(size, fabs(result[i]));
    }
    for (int i = 0; i < n && size > 0; i++)
        v[i] = result[i] / size;
    return size > 0 ? log2_size * fixed_log(2) + fixed_log(size / before) : -HUGE_VAL;
}
