/* SPDX-License-Identifier: GPL-3.0-or-later */
/* exp, expm1, sinh, cosh and tanh, with the same bits on every machine. Polynomials are computed by
 * scripts/elementary. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O3") /* vectors */
#endif
#include <hooke/base/numeric.h>

#include "base/elementary/exponential.h"

#define EXP_SAFE 690     /* |x| up to which the result and its parts are normal */
#define EXP_ALONE_MIN 40 /* smallest x at which 1 is less than the last place of e^x */

/* Returns 2^shift e^x for any x, |shift| <= 1, also if e^x alone would overflow or underflow. */
static double exp_shifted(double x, int shift)
{
    double r;
    if (x > 750)
        return HUGE_VAL;
    if (!(x >= -750))
        return x < 0 ? 0 : x + x;
    const uint64_t n = exp_reduced(x, &r);
    return exp_scaled(n, r, shift);
}

/* Returns e^x; exp_sum() suffices while the result and its parts are normal numbers. */
double fixed_exp(double x)
{
    double r;
    if (!(fabs(x) <= EXP_SAFE))
        return exp_shifted(x, 0);
    const uint64_t n = exp_reduced(x, &r);
    return exp_sum(n, r);
}

/* Sets results [n] to e^x [n], in blocks of 64. If an argument of a block is too large for the
 * loop, the block is computed again one by one. */
CLONES void fixed_exponentials(int n, const double *x, double *results)
{
    for (; n > 0; n -= 64, x += 64, results += 64) {
        uint64_t doubt = 0;
        double value[64];
        const int count = n < 64 ? n : 64;
        for (int i = 0; i < count; i++) {
            double r;
            const uint64_t turns = exp_reduced(x[i], &r);
            doubt |= (uint64_t) !(fabs(x[i]) <= EXP_SAFE);
            value[i] = exp_sum(turns, r);
        }
        for (int i = 0; doubt && i < count; i++)
            value[i] = fixed_exp(x[i]);
        memcpy(results, value, (size_t)count * sizeof *results);
    }
}

/* ---- differences from 1 and hyperbolic functions ---- */

/* Smaller arguments have series of their own, in which nothing cancels. */
#define SERIES_X_MAX 0.125

/* Returns e^x - 1: by a series for small |x|, beyond it by subtracting 1 from the larger part of
 * e^x, which is exact in two parts. */
double fixed_expm1(double x)
{
    if (!(fabs(x) <= EXP_ALONE_MIN))
        return x < 0 ? -1 : fixed_exp(x);
    if (fabs(x) < 0x1p-54)
        return x;
    if (fabs(x) < SERIES_X_MAX) { /* relative error 2^-56.4 */
        const double s = x * x, q = s * s;
        const double low = (0x1.ffffffffffff7p-2 + x * 0x1.555555555554fp-3) +
                           s * (0x1.555555556570cp-5 + x * 0x1.111111111e1e7p-7);
        const double high = (0x1.6c16bf8a311ffp-10 + x * 0x1.a019ff7cb8cabp-13) +
                            s * (0x1.a0430adca07e8p-16 + x * 0x1.720271f051b96p-19);
        return x + s * (low + q * high);
    }
    double r, most;
    const uint64_t n = exp_reduced(x, &r);
    const double rest = exp_rest(n, r, &most);
    const struct wide sum = wide_sum(most, -1);
    return sum.high + (sum.low + rest);
}

/* Returns e^x + sign e^-x, for SERIES_X_MAX <= x <= EXP_ALONE_MIN, or any smaller x >= 0 if sign >
 * 0. */
INLINE double both_signs(double x, double sign)
{
    double r, growing, decaying;
    const uint64_t n = exp_reduced(x, &r);
    const double rest = exp_rest(n, r, &growing) + sign * exp_rest(-n, -r, &decaying);
    const struct wide sum = ordered_sum(growing, sign * decaying);
    return sum.high + (sum.low + rest);
}

/* Returns sinh x: by a series for small |x|, in which nothing cancels, beyond it as (e^x -
 * e^-x)/2. */
double fixed_sinh(double x)
{
    const double size = fabs(x);
    if (size < SERIES_X_MAX) { /* relative error 2^-62.7 */
        const double s = x * x;
        const double sum = (0x1.5555555555552p-3 + s * 0x1.1111111119e9cp-7) +
                           s * s * (0x1.a019ffee3c99fp-13 + s * 0x1.71fecdd56609dp-19);
        return size < 0x1p-28 ? x : x + x * s * sum;
    }
    return copysign(size <= EXP_ALONE_MIN ? both_signs(size, -1) * 0.5 : exp_shifted(size, -1), x);
}

double fixed_cosh(double x)
{
    const double size = fabs(x);
    return size <= EXP_ALONE_MIN ? both_signs(size, 1) * 0.5 : exp_shifted(size, -1);
}

#define TANH_SERIES 0.25 /* largest |x| for tanh_rest() */

/* Returns tanh x - x for |x| < TANH_SERIES, with an error of 2^-57.6 of tanh x. */
INLINE double tanh_rest(double x)
{
    const double s = x * x, q = s * s;
    const double low = (-0x1.5555555555507p-2 + s * 0x1.11111111001dep-3) +
                       q * (-0x1.ba1ba193d35b3p-5 + s * 0x1.664f345118e0cp-6);
    const double high =
        (-0x1.22688c3862785p-7 + s * 0x1.d515c3a1ba173p-9) - q * 0x1.59d20ef416414p-10;
    return x * s * (low + q * q * high);
}

/* Returns tanh x: as x plus a polynomial for small |x|, beyond it as 1 - 2/(e^2x + 1), with the
 * quotient in two parts. */
double fixed_tanh(double x)
{
    const double size = fabs(x);
    if (size < TANH_SERIES)
        return size < 0x1p-28 ? x : x + tanh_rest(x);
    if (!(size <= EXP_ALONE_MIN / 2))
        return x != x ? x : copysign(1, x);
    double r, most;
    const uint64_t n = exp_reduced(2 * size, &r);
    const double rest = exp_rest(n, r, &most);
    const struct wide more = ordered_sum(most, 1), sum = ordered_sum(more.high, rest), two = {2, 0},
                      denominator = {sum.high, more.low + sum.low},
                      part = wide_quotient(two, denominator), less = ordered_sum(1, -part.high);
    return copysign(less.high + (less.low - part.low), x);
}
