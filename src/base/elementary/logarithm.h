/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The parts of log and pow, after Tang (1990, ACM Trans. Math. Softw. 16:378): x = 2^k m, 0.697 <=
 * m < 1.395, and m c = 1 + r with a short c near 1/m, so that r is a double, |r| < 0.00528; log x =
 * k ln 2 - log c + log(1 + r). The table and the polynomial, accurate to 2^-70, come from
 * scripts/elementary. `fused` selects multiply-add in one operation (wide.h).
 */
#pragma once

#include "base/elementary/exponential.h"

#define LN_2_HIGH 0x1.62e42fefa2000p-1 /* the first 41 bits of ln 2, and the remainder */
#define LN_2_LOW 0x1.9ef35793c7673p-41

/* Summands of log x = whole + log(1 + r) + rest: whole is exact, and 0 or larger than r. */
struct log_parts {
    double whole, r, rest;
};

/* Splits the logarithm of a finite x > 0, which may be subnormal. */
INLINE struct log_parts parts_of(double x, bool fused)
{
    const bool tiny = x < 0x1p-1022;
    const uint64_t bits = to_bits(tiny ? x * 0x1p54 : x), offset_bits = bits - FIRST_M;
    const int64_t power = (int64_t)offset_bits >> EXPONENT_SHIFT;
    const uint64_t m = bits - ((uint64_t)power << EXPONENT_SHIFT);
    const struct reciprocal *row =
        &elementary_reciprocals[offset_bits >> ROW_SHIFT & (TABLE_ROWS - 1)];
    const double k = (double)(tiny ? power - 54 : power), value = from_bits(m);
    const double upper = fused ? 0 : from_bits(m & ~UINT64_C(0x1FFFFFFF)), lower = value - upper;
    return (struct log_parts){k * LN_2_HIGH + row->high,
                              fused ? fma(value, row->c, -1)
                                    : (upper * row->c - 1) + lower * row->c,
                              row->low + k * LN_2_LOW};
}

/* Returns log(1 + r) - r + r^2/2. */
INLINE double cubic_part(double r)
{
    const double s = r * r, cube = r * s;
    return cube * (0x1.555555555555dp-2 - r * 0x1.0000000000010p-2) +
           cube * s *
               ((0x1.999999965f971p-3 - r * 0x1.55555550c2215p-3) +
                s * (0x1.24956082fa00ep-3 - r * 0x1.0003627cfacfbp-3));
}

/* Returns log x for a finite x > 0. */
INLINE double log_in(double x, bool fused)
{
    const struct log_parts parts = parts_of(x, fused);
    const struct wide most = ordered_sum(parts.whole, parts.r);
    return most.high + ((most.low + (parts.rest - parts.r * parts.r * 0.5)) + cubic_part(parts.r));
}

/* Returns log x with a relative error of 2^-67. */
INLINE struct wide wide_log(double x, bool fused)
{
    const struct log_parts parts = parts_of(x, fused);
    const struct wide square = exact_product(parts.r, parts.r, fused),
                      most = ordered_sum(parts.whole, parts.r),
                      next = ordered_sum(most.high, -0.5 * square.high);
    return ordered_sum(next.high, (most.low + next.low) +
                                      ((parts.rest - 0.5 * square.low) + cubic_part(parts.r)));
}

#define PER_LN_10_1 0x1.bcb7b10000000p-2 /* the first 25 bits of 1/ln 10, and the remainder */
#define PER_LN_10_2 0x1.49b9438ca9aaep-28

/* Returns log10 x for a finite x > 0. */
INLINE double log10_in(double x, bool fused)
{
    const struct wide log = wide_log(x, fused);
    const double upper = upper_part(log.high), lower = log.high - upper;
    return upper * PER_LN_10_1 +
           (lower * PER_LN_10_1 + (log.high * PER_LN_10_2 + log.low * PER_LN_10_1));
}

/* Returns x^y = e^(y log x) for a finite x > 0, with logarithm and product in two parts. */
INLINE double power_in(double x, double y, bool fused)
{
    const struct wide log = wide_log(x, fused);
    const double exponent = y * log.high;
    if (!(fabs(exponent) < 800))
        return exponent > 0 ? HUGE_VAL : 0;
    const struct wide product = exact_product(y, log.high, fused);
    double r;
    const uint64_t n = exp_reduced(product.high, &r);
    r += product.low + y * log.low;
    return fabs(exponent) < 690 ? exp_sum(n, r) : exp_scaled(n, r, 0);
}
