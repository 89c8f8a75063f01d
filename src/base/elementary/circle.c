/* SPDX-License-Identifier: GPL-3.0-or-later */
/* sin, cos and tan of any double, with the same bits on every machine; and of arrays, in loops that
 * compilers turn into vectors. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O3") /* vectors */
#endif
#include <hooke/base/numeric.h>

#include "base/elementary/circle.h"
#include "base/elementary/tables.h"

/* ---- large arguments (Payne & Hanek 1983) ---- */

/* Bits of 2/pi behind the binary point, 64 in a word. */
static const uint64_t two_over_pi[] = {
    0xa2f9836e4e441529, 0xfc2757d1f534ddc0, 0xdb6295993c439041, 0xfe5163abdebbc561,
    0xb7246e3a424dd2e0, 0x06492eea09d1921c, 0xfe1deb1cb129a73e, 0xe88235f52ebb4484,
    0xe99c7026b45f7e41, 0x3991d639835339f4, 0x9c845f8bbdf9283b, 0x1ff897ffde05980f,
    0xef2f118b5a0a6d1f, 0x6d367ecf27cb09b7, 0x4f463f669e5fea2d, 0x7527bac7ebe5f17b,
    0x3d0739f78a5292ea, 0x6bfb5fb11f8d5d08, 0x56033046fc7b6bab, 0xf0cfbc209af4361d,
};

/* Returns 64 bits of 2/pi from a position on; bits before the binary point (position < 0) are 0. */
static uint64_t bits_from(int position)
{
    const int words = (int)COUNT_OF(two_over_pi), word = (position + 1024) / 64 - 16,
              shift = (position + 1024) % 64;
    const uint64_t first = word >= 0 && word < words ? two_over_pi[word] : 0;
    const uint64_t second = word >= -1 && word < words - 1 ? two_over_pi[word + 1] : 0;
    return shift > 0 ? first << shift | second >> (64 - shift) : first;
}

/* Returns the upper 64 bits of the product a b. */
static uint64_t upper_product(uint64_t a, uint64_t b)
{
    const uint64_t mask = 0xFFFFFFFF, a1 = a >> 32, a0 = a & mask, b1 = b >> 32, b0 = b & mask;
    const uint64_t middle = a1 * b0 + (a0 * b0 >> 32), other = (middle & mask) + a0 * b1;
    return a1 * b1 + (middle >> 32) + (other >> 32);
}

/* Reduces a finite x >= 2^-20 to *r + *low, |*r| <= pi/4, and returns the number of quarter turns,
 * of which the lowest two bits are right. With x = m 2^e it multiplies m by the bits of 2/pi from
 * 2^(1 - e) on, without those of weight 4 and above. Two bits of the product count quarters, the
 * following ones are the fraction. */
static uint64_t quarters_far(double x, double *r, double *low)
{
    const int e = (int)(to_bits(x) >> EXPONENT_SHIFT) - 1075;
    const uint64_t one = UINT64_C(1) << EXPONENT_SHIFT, m = (to_bits(x) & (one - 1)) | one;
    const uint64_t w2 = bits_from(e - 2), w1 = bits_from(e + 62), w0 = bits_from(e + 126);
    const uint64_t a0 = m * w0, b1 = m * w1, a1 = b1 + upper_product(m, w0),
                   a2 = m * w2 + upper_product(m, w1) + (a1 < b1);
    uint64_t quarters = a2 >> 62, f1 = a2 << 2 | a1 >> 62, f0 = a1 << 2 | a0 >> 62;
    const bool is_negative = f1 >> 63;
    if (is_negative) {
        quarters++;
        f0 = ~f0;
        f1 = ~f1;
    }
    int zeros = 0;
    for (; zeros < 64 && !(f1 >> 63); zeros++) {
        f1 = f1 << 1 | f0 >> 63;
        f0 <<= 1;
    }
    const double high = (double)(f1 >> 11) * 0x1p-53,
                 rest = (double)((f1 << 53 | f0 >> 11) >> 11) * 0x1p-106;
    const struct wide quarter = {0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54},
                      fraction = {high, rest}, turn = wide_times(fraction, quarter);
    const double size = power_of_two(-zeros) * (is_negative ? -1 : 1);
    *r = turn.high * size;
    *low = turn.low * size;
    return quarters;
}

/* Reduces a finite x >= 0 to *r + *low; returns the number of quarter turns, in its lowest two
 * bits. */
static uint64_t quarters_of(double x, double *r, double *low)
{
    uint64_t fine;
    const uint64_t quarters = quarters_near(x, r, low, &fine);
    return fine ? quarters : quarters_far(x, r, low);
}

/* ---- one argument ---- */

/* Returns sin x. An odd number of quarter turns exchanges sine and cosine; two change the sign. */
double fixed_sin(double x)
{
    const double size = fabs(x);
    double r, low;
    if (size <= CIRCLE_NEAR)
        return copysign(sine_near(size, 0), x);
    if (!(size < HUGE_VAL))
        return x != x ? x : (double)NAN;
    const uint64_t quarters = quarters_of(size, &r, &low);
    const double value = quarters & 1 ? cosine_near(r, low) : sine_near(r, low);
    return (x < 0) != ((quarters & 2) != 0) ? -value : value;
}

/* Returns cos x, as the sine of one more quarter turn. */
double fixed_cos(double x)
{
    const double size = fabs(x);
    double r, low;
    if (size <= CIRCLE_NEAR)
        return cosine_near(size, 0);
    if (!(size < HUGE_VAL))
        return x != x ? x : (double)NAN;
    const uint64_t quarters = quarters_of(size, &r, &low) + 1;
    const double value = quarters & 1 ? cosine_near(r, low) : sine_near(r, low);
    return quarters & 2 ? -value : value;
}

#define TANGENT_SERIES 0.125 /* a series is used up to this |x|, for cot one of 1/x */

/* Returns tan(r + low) for 0 <= r < TANGENT_SERIES, with a relative error of 2^-60.9. */
INLINE double tangent_small(double r, double low)
{
    const double s = r * r, q = s * s;
    const double sum = (0x1.5555555555553p-2 + s * 0x1.1111111112e12p-3) +
                       q * ((0x1.ba1ba1ae03cacp-5 + s * 0x1.664f5ad4ec377p-6) +
                            q * (0x1.22604617f9c4dp-7 + s * 0x1.e1319c5aa6e9ep-9));
    return r + (r * s * sum + (low + low * s));
}

/* Returns cot(r + low) for 0 < r < TANGENT_SERIES, with a relative error of 2^-62.5. */
INLINE double cotangent_small(double r, double low)
{
    const double s = r * r;
    const double sum =
        (0x1.5555555555556p-2 + s * 0x1.6c16c16c13badp-6) +
        s * s *
            ((0x1.1566abdc8a718p-9 + s * 0x1.bbd69154682eap-13) + s * s * 0x1.6853706f40314p-16);
    const struct wide one = {1, 0}, arc = {r, low}, inverse = wide_quotient(one, arc);
    return inverse.high + (inverse.low - r * sum);
}

/* Returns tan(r + low), or cot(r + low) if odd, for r from TANGENT_SERIES to pi/4. With T =
 * tan(j/32) of the table and t = tan(r + low - j/32) it is T + (1 + T^2) t/(1 - T t); cot has the
 * same form with other signs. */
INLINE double tangent_rows(uint64_t odd, double r, double low)
{
    const double j = (r * 32 + ROUND_TO_INTEGER) - ROUND_TO_INTEGER,
                 arc = (r - j * (1. / 32)) + low, s = arc * arc;
    const double t = arc + arc * s *
                               ((0x1.5555555555951p-2 + s * 0x1.111110dfe8db2p-3) +
                                s * s * 0x1.ba31059ee0839p-5);
    const struct wide row = elementary_tangents[odd][(int)j];
    const double signed_t = odd ? -t : t,
                 value = row.high + (row.low + (signed_t + row.high * row.high * signed_t) /
                                                   (1 - row.high * signed_t));
    return odd ? -value : value;
}

/* Returns tan x. An odd number of quarter turns makes it the cotangent with changed sign. */
double fixed_tan(double x)
{
    const double size = fabs(x);
    double r = size, low = 0;
    uint64_t quarters = 0;
    if (!(size <= CIRCLE_NEAR)) {
        if (!(size < HUGE_VAL))
            return x != x ? x : (double)NAN;
        quarters = quarters_of(size, &r, &low);
    } else if (size < 0x1p-27) {
        return x;
    }
    const uint64_t odd = quarters & 1;
    const double sign = r < 0 ? -1 : 1, arc = fabs(r), rest = sign * low;
    double value;
    if (arc > TANGENT_SERIES)
        value = tangent_rows(odd, arc, rest);
    else
        value = odd ? -cotangent_small(arc, rest) : tangent_small(arc, rest);
    return (x < 0) != (r < 0) ? -value : value;
}

/* ---- arrays, in blocks of 64: if an argument of a block is too large for the loop, the block is
 * computed again one by one ---- */

/* Sets results [n] to the sines of x [n]. */
CLONES void fixed_sines(int n, const double *x, double *results)
{
    for (; n > 0; n -= 64, x += 64, results += 64) {
        uint64_t doubt = 0;
        double value[64];
        const int count = n < 64 ? n : 64;
        for (int i = 0; i < count; i++)
            value[i] = sine_in_loop(x[i], &doubt);
        for (int i = 0; doubt & 1 && i < count; i++)
            value[i] = fixed_sin(x[i]);
        memcpy(results, value, (size_t)count * sizeof *results);
    }
}

/* Sets results [n] to the cosines of x [n]. */
CLONES void fixed_cosines(int n, const double *x, double *results)
{
    for (; n > 0; n -= 64, x += 64, results += 64) {
        uint64_t doubt = 0;
        double value[64];
        const int count = n < 64 ? n : 64;
        for (int i = 0; i < count; i++)
            value[i] = cosine_in_loop(x[i], &doubt);
        for (int i = 0; doubt & 1 && i < count; i++)
            value[i] = fixed_cos(x[i]);
        memcpy(results, value, (size_t)count * sizeof *results);
    }
}
