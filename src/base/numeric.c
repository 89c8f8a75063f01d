/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Numerical tools that every layer may use: quantiles, sorting, random numbers, Cholesky factors,
 * products and exponentials of small matrices. */
#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_sort_double.h>
#include <gsl/gsl_statistics_double.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Keeps GSL from ending the program, as its default error handler does even if memory runs out. Its
 * functions then return a status, NULL or NaN, which callers check. */
__attribute__((constructor)) static void gsl_errors_return(void)
{
    gsl_set_error_handler_off();
}

double values_quantile(double *values, size_t n, double share)
{
    return n ? gsl_stats_select(values, 1, n, (size_t)(share * (double)(n - 1) + 0.5)) : NAN;
}

/* Maps doubles to integers of the same order: those of negative numbers are reversed. */
static uint64_t sort_key(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits >> 63 ? ~bits : bits | (uint64_t)1 << 63;
}

/* Six digits of 11 bits make the 64 bits of a key. */
enum { RADIX_BITS = 11, RADIX_SIZE = 1 << RADIX_BITS, RADIX_PASSES = 6 };

static size_t radix_digit(double value, int pass)
{
    return (sort_key(value) >> (pass * RADIX_BITS)) & (RADIX_SIZE - 1);
}

/* Turns the counts of one digit into the first index of each. Returns false if all values have the
 * same digit. */
static bool radix_offsets(uint32_t count[RADIX_SIZE], size_t n)
{
    uint32_t sum = 0;
    for (size_t k = 0; k < RADIX_SIZE; k++) {
        const uint32_t here = count[k];
        if (here == n)
            return false;
        count[k] = sum;
        sum += here;
    }
    return true;
}

/* Sorts by one digit after the other, from the lowest up (least significant digit radix sort). */
bool sort_values(double *values, size_t n, double *scratch, const struct cancel *cancel)
{
    uint32_t count[RADIX_PASSES][RADIX_SIZE];
    double *source = values, *target = scratch;
    if (cancelled(cancel))
        return false;
    if (n <= RADIX_SIZE || n > UINT32_MAX) {
        gsl_sort(values, 1, n);
        return true;
    }
    memset(count, 0, sizeof count);
    for (size_t i = 0; i < n && !cancelled_at(cancel, i); i++)
        for (int pass = 0; pass < RADIX_PASSES; pass++)
            count[pass][radix_digit(values[i], pass)]++;
    for (int pass = 0; pass < RADIX_PASSES; pass++) {
        if (cancelled(cancel))
            return false;
        if (!radix_offsets(count[pass], n))
            continue;
        for (size_t i = 0; i < n; i++)
            target[count[pass][radix_digit(source[i], pass)]++] = source[i];
        double *const sorted = target;
        target = source;
        source = sorted;
    }
    if (source != values)
        memcpy(values, source, n * sizeof *values);
    return true;
}

/* Returns the index of the first of the ascending values that is >= x, or n. */
size_t first_from(const double *ascending, size_t n, double x)
{
    size_t low = 0, high = n;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (ascending[middle] < x)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Computes splitmix64 (Steele, Lea, Flood 2014). */
double random_fraction(uint64_t *state)
{
    uint64_t z = (*state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/* Computes l with a = l l^T for the first n rows and columns of matrices with rows of length width.
 * Returns false if a pivot is not above independent times its diagonal element. */
bool matrix_cholesky(int n, int width, const double *a, double independent, double *l)
{
    for (int i = 0; i < n; i++) {
        const double min = independent * a[i * width + i];
        for (int j = 0; j <= i; j++) {
            double sum = a[i * width + j];
            for (int k = 0; k < j; k++)
                sum -= l[i * width + k] * l[j * width + k];
            if (i == j && !(sum > min))
                return false;
            l[i * width + j] = i == j ? sqrt(sum) : sum / l[j * width + j];
        }
    }
    return true;
}

/* Replaces x by the solution of l x' = x. */
void cholesky_forward(int n, int width, const double *l, double *x)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= l[i * width + k] * x[k];
        x[i] /= l[i * width + i];
    }
}

/* Replaces x by the solution of l^T x' = x. */
void cholesky_backward(int n, int width, const double *l, double *x)
{
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            x[i] -= l[k * width + i] * x[k];
        x[i] /= l[i * width + i];
    }
}

/* ---- square matrices ---- */

/* Multiplies square matrices; inlined, so that loops for a constant n are unrolled. */
static inline __attribute__((always_inline)) void
multiply_inline(int n, const double *restrict a, const double *restrict b, double *restrict product)
{
#pragma GCC unroll 4
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++)
            product[i * n + j] = 0;
#pragma GCC unroll 4
        for (int k = 0; k < n; k++) {
            const double factor = a[i * n + k];
            if (factor == 0)
                continue;
#pragma GCC unroll 4
            for (int j = 0; j < n; j++)
                product[i * n + j] += factor * b[k * n + j];
        }
    }
}

/* Computes the product of square matrices [n][n], with loops of constant length for n = 2 and 3. */
void matrix_multiply(int n, const double *a, const double *b, double *product)
{
    if (n == 2)
        multiply_inline(2, a, b, product);
    else if (n == 3)
        multiply_inline(3, a, b, product);
    else
        multiply_inline(n, a, b, product);
}

/* Returns the largest sum of absolute values in a row. */
double matrix_norm(int n, const double *a)
{
    double max = 0;
    for (int i = 0; i < n; i++) {
        double sum = 0;
        for (int j = 0; j < n; j++)
            sum += fabs(a[i * n + j]);
        max = sum > max ? sum : max;
    }
    return max;
}

/* Divides a by a power of two if its norm is far from 1. Returns the exponent of that power. */
static int matrix_normalise(int n, double *a)
{
    /* Powers of two up to this one do not overflow when they are squared four times. */
    enum { FAR_FROM_ONE = 60 };
    int power = 0;
    frexp(matrix_norm(n, a), &power);
    if (abs(power) < FAR_FROM_ONE)
        return 0;
    for (int i = 0; i < n * n; i++)
        a[i] = ldexp(a[i], -power);
    return power;
}

/* Fills sum with the series of exp(a) by Horner's rule: 1 + a (1 + a/2 (1 + a/3 (...))). product is
 * scratch memory [n n]. */
static void exponential_series(int n, const double *a, double *sum, double *product)
{
    enum { TERMS = 14 };
    memset(sum, 0, (size_t)(n * n) * sizeof *sum);
    for (int i = 0; i < n; i++)
        sum[i * n + i] = 1;
    for (int term = TERMS; term > 0; term--) {
        matrix_multiply(n, a, sum, product);
        for (int i = 0; i < n * n; i++)
            sum[i] = product[i] / term;
        for (int i = 0; i < n; i++)
            sum[i * n + i] += 1;
    }
}

/* Replaces a [n][n] by its exponential divided by 2^k and returns k: scales a down until its norm
 * is small, sums the series, and squares the result as often as a was halved. */
double matrix_exponential(int n, double *a, double *work)
{
    /* The 14 terms of the series are exact up to a norm of 2^QUARTER. */
    enum { HALVINGS_MAX = 200, QUARTER = -2 };
    double *sum = work, *product = work + n * n, power = 0;
    int exponent;
    if (frexp(matrix_norm(n, a), &exponent) == 0.5)
        exponent--;
    const int wanted = exponent > QUARTER ? exponent - QUARTER : 0;
    const int halvings = wanted < HALVINGS_MAX ? wanted : HALVINGS_MAX;
    const double part = ldexp(1, -halvings);
    for (int i = 0; i < n * n; i++)
        a[i] *= part;
    exponential_series(n, a, sum, product);
    for (int k = 0; k < halvings; k++) {
        matrix_multiply(n, sum, sum, product);
        double *square = product;
        product = sum;
        sum = square;
        power = 2 * power + (k % 4 == 3 ? matrix_normalise(n, sum) : 0);
    }
    memcpy(a, sum, (size_t)(n * n) * sizeof *a);
    return power;
}
