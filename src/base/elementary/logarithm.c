/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * log and pow, after Tang (1990, ACM Trans. Math. Softw. 16:378): x = 2^k m,
 * 0.71 <= m < 1.42, and m c = 1 + r with a c of 8 bits near 1/m, so that r is
 * known exactly in two parts without a division, |r| < 0.019; log x = k ln 2 -
 * log c + log(1 + r). The polynomial is by Remez exchange in 400 bits, to
 * 2^-69.
 */
#include <stdbool.h>

#include "base/elementary/wide.h"

#define LN_2_1 0x1.62e42fefa2000p-1 /* 41 bits, and what follows */
#define LN_2_2 0x1.9ef35793c7673p-41
#define FIRST_M 0x3FE6C00000000000 /* the bits of the smallest m */
#define ROW_SHIFT 47               /* 32 rows, 1 in the middle of one */

static const struct {
    double c, high, low; /* -log c, the first part a multiple of 2^-42 */
} rows[] = {
    {0x1.64p+0, -0x1.51aad872e0000p-2, 0x1.f4bd8db0a7cc1p-44},
    {0x1.5cp+0, -0x1.3a64c55694000p-2, -0x1.7a71cbcd735d0p-44},
    {0x1.56p+0, -0x1.2895a13de8000p-2, -0x1.a8d7ad24c13f0p-44},
    {0x1.4ep+0, -0x1.1058bf9ae5000p-2, 0x1.4ab9d817d52cdp-44},
    {0x1.48p+0, -0x1.fb9186d5e4000p-3, 0x1.d572aab993c87p-47},
    {0x1.42p+0, -0x1.d5c216b4fc000p-3, 0x1.1ba91bbca681bp-45},
    {0x1.3cp+0, -0x1.af3c94e80c000p-3, 0x1.a4e633fcd9066p-52},
    {0x1.36p+0, -0x1.87fa06520c000p-3, -0x1.22120401202fcp-44},
    {0x1.30p+0, -0x1.5ff3070a7a000p-3, 0x1.8586f183bebf2p-44},
    {0x1.2ap+0, -0x1.371fc201e8000p-3, -0x1.ee8779b2d8abcp-44},
    {0x1.24p+0, -0x1.0d77e7cd08000p-3, -0x1.cb2cd2ee2f482p-44},
    {0x1.20p+0, -0x1.e27076e2b0000p-4, 0x1.a342c2af0003cp-45},
    {0x1.1ap+0, -0x1.8c345d6318000p-4, -0x1.b20f5acb42a66p-44},
    {0x1.16p+0, -0x1.51b073f060000p-4, -0x1.83f69278e686ap-44},
    {0x1.12p+0, -0x1.16536eea38000p-4, 0x1.47c5e768fa309p-46},
    {0x1.0cp+0, -0x1.77458f6330000p-5, 0x1.181dce586af09p-44},
    {0x1.08p+0, -0x1.f829b0e780000p-6, -0x1.980267c7e09e4p-45},
    {0x1.04p+0, -0x1.fc0a8b0fc0000p-7, -0x1.f1e7cf6d3a69cp-50},
    {1, 0, 0},
    {0x1.f0p-1, 0x1.0415d89e78000p-5, -0x1.dddc7f461c516p-44},
    {0x1.e0p-1, 0x1.08598b59e4000p-4, -0x1.7e5dd7009902cp-46},
    {0x1.d4p-1, 0x1.700d30aeac000p-4, 0x1.c1e8da99ded32p-49},
    {0x1.c8p-1, 0x1.da72763844000p-4, 0x1.a89401fa71733p-46},
    {0x1.bcp-1, 0x1.23d712a49c000p-3, 0x1.00d238fd3df5cp-46},
    {0x1.b0p-1, 0x1.5bf406b544000p-3, -0x1.27023eb68981cp-46},
    {0x1.a4p-1, 0x1.95a5adcf70000p-3, 0x1.7f22858a0ff6fp-47},
    {0x1.98p-1, 0x1.d1037f2656000p-3, -0x1.84a7e75b6f6e4p-47},
    {0x1.90p-1, 0x1.f991c6cb3c000p-3, -0x1.90d04cd7cc834p-44},
    {0x1.88p-1, 0x1.1178e8227e000p-2, 0x1.1ef78ce2d07f2p-44},
    {0x1.7cp-1, 0x1.314f1e1d36000p-2, -0x1.8e27ad3213cb8p-45},
    {0x1.74p-1, 0x1.4718dc271c000p-2, 0x1.06c18fb4c14c5p-44},
    {0x1.6cp-1, 0x1.5d5bddf596000p-2, -0x1.a0b2a08a465dcp-47},
};

/* What log x is the sum of: `whole`, exact, and log(1 + r.high + r.low), and
 * `rest`. */
struct parts {
    double whole, rest;
    struct wide r, square; /* r^2, of 52 bits and what follows */
};

/* x > 0, finite */
INLINE struct parts parts_of(double x)
{
    const bool tiny = x < 0x1p-1022;
    const uint64_t bits = to_bits(tiny ? x * 0x1p54 : x), from = bits - FIRST_M;
    const int64_t whole = (int64_t)(from >> EXPONENT_SHIFT) - (from >> 63 ? 4096 : 0);
    const uint64_t m = bits - ((uint64_t)whole << EXPONENT_SHIFT);
    const int row = (int)(from >> ROW_SHIFT & 31);
    const double k = (double)(tiny ? whole - 54 : whole), c = rows[row].c,
                 upper = from_bits(m & ~UINT64_C(0x1FFFFFFF)), lower = from_bits(m) - upper;
    const double most = upper * c - 1, rest = lower * c;
    return (struct parts){k * LN_2_1 + rows[row].high,
                          rows[row].low + k * LN_2_2,
                          wide_sum(most, rest),
                          {most * most, (2 * most + rest) * rest}};
}

/* Of what has no finite logarithm. */
static double no_logarithm(double x)
{
    return x == 0 ? -HUGE_VAL : x < 0 ? (double)NAN : x;
}

/* log(1 + r) = r - r^2/2 + r^3 of this */
INLINE double cubic_part(double r)
{
    const double s = r * r;
    return ((0x1.5555555555554p-2 - r * 0x1.ffffffffffff8p-3) +
            s * (0x1.99999999ae5d9p-3 - r * 0x1.555555557a65bp-3)) +
           s * s *
               ((0x1.2492464642ed8p-3 - r * 0x1.fffff846da6ebp-4) +
                s * (0x1.c76b6ebfdd701p-4 - r * 0x1.99ef7a2d41ec2p-4));
}

double fixed_log(double x)
{
    if (!(x > 0 && x < HUGE_VAL))
        return no_logarithm(x);
    const struct parts parts = parts_of(x);
    const double r = parts.r.high, s = r * r;
    const struct wide most = wide_sum(parts.whole, r);
    return most.high +
           ((r * s * cubic_part(r) - s * 0.5) + (most.low + (parts.rest + parts.r.low)));
}

/* To 2^-64 of it. */
static struct wide wide_log(double x)
{
    const struct parts parts = parts_of(x);
    const double r = parts.r.high;
    const struct wide square = parts.square, most = wide_sum(parts.whole, r),
                      next = ordered_sum(most.high, -0.5 * square.high);
    const double rest = (parts.rest + (parts.r.low - r * parts.r.low)) +
                        (r * (r * r) * cubic_part(r) - 0.5 * square.low);
    return ordered_sum(next.high, (most.low + next.low) + rest);
}

double fixed_log10(double x)
{
    const struct wide per_ln_10 = {0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57};
    if (!(x > 0 && x < HUGE_VAL))
        return no_logarithm(x);
    return wide_times(wide_log(x), per_ln_10).high;
}

/* ---- powers ---- */

static bool is_whole(double y)
{
    return y == floor(y);
}

static bool is_odd(double y)
{
    return is_whole(y) && !is_whole(y / 2);
}

/* x^y where one of them is 0, 1, infinite or not a number. */
static double special_power(double x, double y)
{
    if (y == 0 || x == 1)
        return 1;
    if (x != x || y != y)
        return x + y;
    const bool grows = (fabs(x) > 1) == (y > 0);
    if (fabs(y) == HUGE_VAL)
        return x == -1 ? 1 : grows ? HUGE_VAL : 0;
    const double size = grows ? HUGE_VAL : 0;
    return signbit(x) && is_odd(y) ? -size : size;
}

/* e^(y log |x|), the logarithm and the product in two parts. */
double fixed_pow(double x, double y)
{
    const double size = fabs(x);
    if (y == 0 || x == 1 || !(size > 0 && size < HUGE_VAL) || !(fabs(y) < HUGE_VAL))
        return special_power(x, y);
    if (x < 0 && !is_whole(y))
        return (double)NAN;
    const double sign = x < 0 && is_odd(y) ? -1 : 1;
    if (size == 1)
        return sign;
    const struct wide log = wide_log(size);
    const double about = y * log.high;
    if (!(fabs(about) < 800))
        return sign * (about > 0 ? HUGE_VAL : 0);
    const struct wide product = wide_product(y, log.high);
    return sign * exponential_of(product.high, product.low + y * log.low);
}
