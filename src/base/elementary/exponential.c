/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * exp and what is made of it. x = n ln 2 + r, |r| <= ln 2/2, ln 2 in two parts,
 * of which n times the first is exact; polynomials by Remez exchange in 400
 * bits.
 */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("O3") /* vectors */
#endif
#include <hooke/base/numeric.h>

#include "base/elementary/wide.h"

#define LN_2_1 0x1.62e42fee00000p-1 /* 32 bits */
#define LN_2_2 0x1.a39ef35793c76p-33
#define PER_LN_2 0x1.71547652b82fep+0
#define EXP_SAFE 708 /* |x| up to which the result is normal */
#define LOST 40      /* x where 1 beside e^x is less than its last place */

/* 2^n x, rounded once, x about 1 */
static double scaled(double x, int64_t n)
{
    if (n > 1023)
        return x * 0x1p1023 * power_of_two(n < 2046 ? n - 1023 : 1023);
    if (n < -1022) /* rounded once: the first product is exact */
        return x * 0x1p-969 * power_of_two(n + 969 > -1022 ? n + 969 : -1022);
    return x * power_of_two(n);
}

/* x = n ln 2 + r + low; n in the lowest bits of what is returned */
INLINE uint64_t reduce(double x, double *r, double *low)
{
    const double turned = x * PER_LN_2 + WHOLE, n = turned - WHOLE;
    const double near = x - n * LN_2_1, step = n * LN_2_2;
    *r = near - step;
    *low = (near - *r) - step;
    return to_bits(turned);
}

/* e^(r + low): 1 + r + r^2 E(r), to 2^-57.6 */
INLINE double exp_near(double r, double low)
{
    const double s = r * r, q = s * s;
    const double sum = ((0x1.0000000000008p-1 + r * 0x1.5555555555500p-3) +
                        s * (0x1.5555555550fb7p-5 + r * 0x1.111111112709ep-7)) +
                       q * ((0x1.6c16c182d1c5bp-10 + r * 0x1.a01a012b5af8dp-13) +
                            s * (0x1.a0199d402d75fp-16 + r * 0x1.71df27ab2d38ap-19)) +
                       q * q * (0x1.28aacbb4e0eabp-22 + r * 0x1.ad762522c667dp-26);
    const struct wide most = ordered_sum(1, r);
    return most.high + (s * sum + (most.low + low));
}

/* Where |x| <= EXP_SAFE: else *doubt has its lowest bit set. */
INLINE double exp_in_loop(double x, uint64_t *doubt)
{
    double r, low;
    const uint64_t n = reduce(x, &r, &low);
    *doubt |= (uint64_t) !(fabs(x) <= EXP_SAFE);
    return from_bits(to_bits(exp_near(r, low)) + (n << EXPONENT_SHIFT));
}

/* 2^shift e^x, |shift| <= 1 */
static double exp_shifted(double x, int shift)
{
    double r, low;
    if (!(fabs(x) <= 750))
        return x > 0 ? HUGE_VAL : x < 0 ? 0 : x + x;
    const uint64_t turned = reduce(x, &r, &low);
    const int64_t n = (int64_t)(turned - to_bits(WHOLE));
    return scaled(exp_near(r, low), n + shift);
}

double fixed_exp(double x)
{
    uint64_t doubt = 0;
    const double value = exp_in_loop(x, &doubt);
    return doubt ? exp_shifted(x, 0) : value;
}

CLONES void fixed_exponentials(int n, const double *x, double *out)
{
    for (; n > 0; n -= 64, x += 64, out += 64) {
        uint64_t doubt = 0;
        double value[64];
        const int count = n < 64 ? n : 64;
        for (int i = 0; i < count; i++)
            value[i] = exp_in_loop(x[i], &doubt);
        for (int i = 0; doubt && i < count; i++)
            value[i] = fixed_exp(x[i]);
        memcpy(out, value, (size_t)count * sizeof *out);
    }
}

/* e^(x + low), |x| < 1000 */
double exponential_of(double x, double low)
{
    double r, rest;
    const int64_t n = (int64_t)(reduce(x, &r, &rest) - to_bits(WHOLE));
    const struct wide reduced = wide_sum(r, rest + low);
    return scaled(exp_near(reduced.high, reduced.low), n);
}

/* ---- with more digits ---- */

/* e^x as 2^n (1 + what is returned): e^r - 1 = r + r^2/2 + r^3 E(r), to 2^-61 */
static struct wide exponential_part(double x, int64_t *n)
{
    double r, low;
    *n = (int64_t)(reduce(x, &r, &low) - to_bits(WHOLE));
    const struct wide square = wide_product(r, r);
    const double s = square.high, q = s * s;
    const double sum = ((0x1.5555555555558p-3 + r * 0x1.5555555555558p-5) +
                        s * (0x1.111111110f971p-7 + r * 0x1.6c16c16c14c89p-10)) +
                       q * (((0x1.a01a01aee72d7p-13 + r * 0x1.a01a01aecef5ap-16) +
                             s * (0x1.71ddfaa276d93p-19 + r * 0x1.27e4c8e5df96bp-22)) +
                            q * (0x1.af5afc6677e1bp-26 + r * 0x1.1f91292fb3953p-29));
    const struct wide most = ordered_sum(r, s * 0.5);
    return ordered_sum(most.high, most.low + (square.low * 0.5 + (r * s * sum + (low + low * r))));
}

/* e^x - 1, |x| <= 2 LOST */
static struct wide less_one(double x)
{
    int64_t n;
    const struct wide part = exponential_part(x, &n), one = {-1, 0};
    if (n == 0)
        return part;
    const struct wide sum = wide_sum(1, part.high);
    const double size = power_of_two(n);
    return wide_add((struct wide){sum.high * size, (sum.low + part.low) * size}, one);
}

double fixed_expm1(double x)
{
    if (!(x <= LOST))
        return fixed_exp(x);
    if (x < -LOST)
        return -1;
    return fabs(x) < 0x1p-54 ? x : less_one(x).high;
}

double fixed_sinh(double x)
{
    const double size = fabs(x);
    if (size < 0x1p-28 || x != x)
        return x;
    if (size > LOST)
        return copysign(exp_shifted(size, -1), x);
    const struct wide t = less_one(size), one = {1, 0};
    return copysign(wide_add(t, wide_quotient(t, wide_add(t, one))).high * 0.5, x);
}

double fixed_cosh(double x)
{
    const double size = fabs(x);
    if (!(size <= LOST))
        return exp_shifted(size, -1);
    const struct wide one = {1, 0}, e = wide_add(less_one(size), one);
    return wide_add(e, wide_quotient(one, e)).high * 0.5;
}

double fixed_tanh(double x)
{
    const double size = fabs(x);
    if (size < 0x1p-28 || x != x)
        return x;
    if (size > LOST / 2)
        return copysign(1, x);
    const struct wide t = less_one(2 * size), two = {2, 0};
    return copysign(wide_quotient(t, wide_add(t, two)).high, x);
}
