/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The parts of e^x, after Tang (1989, ACM Trans. Math. Softw. 15:144): x = n ln 2/128 + r, ln 2/128
 * in two parts, of which n times the first is exact; 2^(n/128) by a table, e^r by a polynomial
 * (Remez exchange, to 2^-65).
 */
#pragma once

#include "base/elementary/tables.h"
#include "base/elementary/wide.h"

#define LN_2_1 0x1.62e42fef80000p-8 /* the first 34 bits of (ln 2)/128, and the remainder */
#define LN_2_2 0x1.1cf79abc9e3b4p-43
#define ROWS_PER_LN_2 0x1.71547652b82fep+7 /* 128/ln 2 */

/* Returns n, which may be negative (as two's complement), and sets *r so that x = n ln 2/128 + r
 * with |r| <= ln 2/256, for |x| < 1000. */
INLINE uint64_t exp_reduced(double x, double *r)
{
    const double turned = x * ROWS_PER_LN_2 + ROUND_TO_INTEGER, n = turned - ROUND_TO_INTEGER;
    *r = (x - n * LN_2_1) - n * LN_2_2;
    return to_bits(turned) - to_bits(ROUND_TO_INTEGER);
}

/* Sets *most to the power of two of the table without its tail, and returns 2^(n/128) e^r - *most;
 * for 2^(n/128) from 2^-1021 to 2^1023. */
INLINE double exp_rest(uint64_t n, double r, double *most)
{
    const uint64_t row = powers_of_two[n % TABLE_ROWS],
                   less = row & ((UINT64_C(1) << TAIL_SHIFT) - 1);
    const double scale = from_bits(to_bits(1) + (n << ROW_SHIFT) - less);
    const double tail = from_bits(to_bits(TAIL_ONE) + (row >> TAIL_SHIFT)) - TAIL_ZERO;
    const double s = r * r, curved = scale * s;
    const double sum = curved * (0x1.ffffffffffdc7p-2 + r * 0x1.555555555543cp-3);
    const double next = (curved * s) * (0x1.55555ce5531c9p-5 + r * 0x1.1111167a7d07bp-7);
    *most = scale;
    return (scale * (tail + r) + sum) + next;
}

/* Returns 2^(n/128) e^r, in the range of exp_rest(). */
INLINE double exp_sum(uint64_t n, double r)
{
    double most;
    const double rest = exp_rest(n, r, &most);
    return most + rest;
}

/* Returns 2^n x, rounded once, for an x near 1 and any n. */
INLINE double scaled(double x, int64_t n)
{
    if (n > 1023)
        return x * 0x1p1023 * power_of_two(n < 2046 ? n - 1023 : 1023);
    if (n < -1022) /* rounded once: the first product is exact */
        return x * 0x1p-969 * power_of_two(n + 969 > -1022 ? n + 969 : -1022);
    return x * power_of_two(n);
}

/* Returns 2^(n/128 + shift) e^r, |shift| <= 1, also if it overflows or underflows. */
INLINE double exp_scaled(uint64_t n, double r, int shift)
{
    const uint64_t row = n % TABLE_ROWS;
    return scaled(exp_sum(row, r), (int64_t)(n - row) / TABLE_ROWS + shift);
}
