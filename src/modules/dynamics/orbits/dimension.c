/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The dimension of Kaplan and Yorke with its derivatives. */
#include "modules/dynamics/orbits/dimension.h"

#include <math.h>

/* Number of standard errors within which a sum counts as 0. */
static const double standard_errors = 2;
/* An exponent is taken for 0 only if its error is below this part of the largest one: a larger
 * error tells nothing. */
static const double zero_error_max = 1e-3;

/* Returns the number of leading exponents that are 0: one for a cycle, several for a torus. Each
 * counts as a whole dimension, whatever the sign of its rounding. */
static int count_zeros(const struct exponent *e, int count, double scale)
{
    int zeros = 0;
    while (zeros < count && fabs(e[zeros].value) <= standard_errors * e[zeros].error &&
           e[zeros].error <= zero_error_max * scale)
        zeros++;
    return zeros;
}

/* Returns the sum of the first `count` exponents. */
static double sum_of(const struct exponent *e, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++)
        sum += e[i].value;
    return sum;
}

/* Computes slope [count], the derivatives of i + (L1 + ... + Li)/|L(i+1)|. */
static void find_slopes(const struct exponent *e, int i, int count, double *slope)
{
    const double next = -e[i].value;
    for (int k = 0; k < count; k++)
        slope[k] = k < i ? 1 / next : 0;
    slope[i] = sum_of(e, i) / (next * next);
}

/* Skips leading zeros, sums exponents while the sum is not negative, and divides the rest by the
 * next one. */
double kaplan_yorke(const struct exponent *e, int count, int n, double scale, double *slope)
{
    int j = count_zeros(e, count, scale);
    double error = 0;
    for (int k = 0; k < count; k++)
        slope[k] = 0;
    while (j < count && sum_of(e, j) + e[j].value >= 0)
        j++;
    if (j == count)
        return count == n ? n : NAN;
    for (int k = 0; k < j; k++)
        error = hypot(error, e[k].error);
    const double sum = sum_of(e, j);
    if (j == 0)
        return 0;
    const bool may_be_less =
        sum <= standard_errors * error && e[j - 1].value < 0 && count_zeros(e, count, scale) < j;
    find_slopes(e, may_be_less ? j - 1 : j, count, slope);
    return j + sum / -e[j].value;
}
