/* SPDX-License-Identifier: GPL-3.0-or-later */
/* log and pow. x = 2^k m, sqrt(1/2) <= m < sqrt 2. Polynomials by Remez exchange in 400 bits. */
#include <stdbool.h>

#include "base/elementary/wide.h"

#define LN_2_1 0x1.62e42fee00000p-1 /* 32 bits */
#define LN_2_2 0x1.a39ef35793c76p-33

/* ln(j/32) for j from 22 on, the first part a multiple of 2^-42 */
#define CENTRES 32
#define FIRST_CENTRE 22
static const struct wide centre_log[] = {
    {-0x1.7fafa3bd81000p-2, -0x1.46fb79bf6d4cbp-44},
    {-0x1.522ae0738a000p-2, -0x1.ebe708164c759p-45},
    {-0x1.269621134e000p-2, 0x1.1b61f10522625p-44},
    {-0x1.f991c6cb3c000p-3, 0x1.90d04cd7cc834p-44},
    {-0x1.a93ed3c8ae000p-3, 0x1.8724350562169p-45},
    {-0x1.5bf406b544000p-3, 0x1.27023eb68981cp-46},
    {-0x1.1178e8227e000p-3, -0x1.1ef78ce2d07f2p-45},
    {-0x1.9335e5d594000p-4, -0x1.3115c3abd47dap-45},
    {-0x1.08598b59e4000p-4, 0x1.7e5dd7009902cp-46},
    {-0x1.0415d89e78000p-5, 0x1.dddc7f461c516p-44},
    {0, 0},
    {0x1.f829b0e780000p-6, 0x1.980267c7e09e4p-45},
    {0x1.f0a30c0118000p-5, -0x1.d599e83368e91p-45},
    {0x1.6f0d28ae58000p-4, -0x1.4b4641b664613p-44},
    {0x1.e27076e2b0000p-4, -0x1.a342c2af0003cp-45},
    {0x1.29552f8200000p-3, -0x1.5b967f4471dfcp-44},
    {0x1.5ff3070a7a000p-3, -0x1.8586f183bebf2p-44},
    {0x1.9525a9cf46000p-3, -0x1.297137d9f158fp-44},
    {0x1.c8ff7c79aa000p-3, -0x1.7794f689f8434p-45},
    {0x1.fb9186d5e4000p-3, -0x1.d572aab993c87p-47},
    {0x1.1675cababa000p-2, 0x1.8380e731f55c4p-44},
    {0x1.2e8e2bae12000p-2, -0x1.67b1e99b72bd8p-45},
    {0x1.4618bc21c6000p-2, -0x1.3d82f484c84ccp-46},
    {0x1.5d1bdbf581000p-2, -0x1.8d6bdc9c7c238p-44},
    {0x1.739d7f6bbd000p-2, 0x1.a7389314feb50p-52},
};

/* x > 0, finite: its m */
static double mantissa(double x, double *k)
{
    const uint64_t root = to_bits(0x1.6a09e667f3bcdp-1);
    double less = 0;
    if (x < 0x1p-1022) {
        x *= 0x1p54;
        less = 54;
    }
    const uint64_t from_root = to_bits(x) - root;
    const int64_t whole = (int64_t)(from_root >> EXPONENT_SHIFT) - (from_root >> 63 ? 4096 : 0);
    *k = (double)whole - less;
    return from_bits(to_bits(x) - ((uint64_t)whole << EXPONENT_SHIFT));
}

/* Of what has no finite logarithm. */
static double no_logarithm(double x)
{
    return x == 0 ? -HUGE_VAL : x < 0 ? (double)NAN : x;
}

/*
 * With f = m - 1 and s = f/(2 + f): log m = 2 s + s^3 L(s^2) to 2^-59.5 (the form f - (f^2/2 -
 * s (f^2/2 + s^2 L)), in which f^2/2 is the only rounding that counts, is that of Ng's logarithm in
 * fdlibm, 1993).
 */
double fixed_log(double x)
{
    if (!(x > 0 && x < HUGE_VAL))
        return no_logarithm(x);
    double k;
    const double f = mantissa(x, &k) - 1, half = f * f * 0.5, s = f / (2 + f);
    const double z = s * s, q = z * z;
    const double sum =
        z *
        ((0x1.5555555555592p-1 + z * 0x1.999999997ff38p-2) +
         q * ((0x1.24924941df283p-2 + z * 0x1.c71c52160dc3bp-3) +
              q * ((0x1.74663c9e00762p-3 + z * 0x1.39a1ef13645e1p-3) + q * 0x1.2f038edb4a26ap-3)));
    return k * LN_2_1 - ((half - (s * (half + sum) + k * LN_2_2)) - f);
}

/* With c = j/32 next to m and s = (m - c)/(m + c): log m = log c + 2 s + 2/3 s^3 + 2/5 s^5 …, to
 * 2^-66 of it. */
static struct wide wide_log(double x)
{
    double k;
    const double m = mantissa(x, &k), j = (m * CENTRES + WHOLE) - WHOLE, c = j / CENTRES;
    const struct wide centre = centre_log[(int)j - FIRST_CENTRE], difference = {m - c, 0};
    const struct wide s = wide_quotient(difference, wide_sum(m, c));
    const double z = s.high * s.high;
    const double sum = 2. / 3 + z * (2. / 5 + z * (2. / 7 + z * (2. / 9 + z * (2. / 11))));
    const struct wide most =
        wide_sum(k * 0x1.62e42fefa2000p-1 + centre.high, 2 * s.high); /* the first is exact */
    const double rest = 2 * s.low + s.high * z * sum + (centre.low + k * 0x1.9ef35793c7673p-41);
    return ordered_sum(most.high, most.low + rest);
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
    const struct wide log = wide_log(size);
    const double about = y * log.high;
    if (!(fabs(about) < 800))
        return sign * (about > 0 ? HUGE_VAL : 0);
    const struct wide product = wide_product(y, log.high);
    const struct wide exponent = ordered_sum(product.high, product.low + y * log.low);
    int64_t n;
    const struct wide part = exponential_part(exponent.high, exponent.low, &n);
    const struct wide sum = ordered_sum(1, part.high);
    return sign * scaled(sum.high + (sum.low + part.low), n);
}
