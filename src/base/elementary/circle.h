/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * sin and cos of what is not too large, without a branch: in loops it becomes
 * vectors, and both forms are one text.
 *
 * x = n pi/2 + r (Cody & Waite 1980), pi/2 in three parts, of which n of at
 * most 19 bits times the first two is exact. Polynomials for |r| <= pi/4 (Remez
 * exchange in 400 bits, weights of the relative error, coefficients rounded one
 * after another, the others found again each time): sin r = r + r^3 S(r^2) to
 * 2^-57.9, cos r = 1 - r^2/2 + r^4 C(r^2) to 2^-64.
 */
#ifndef HOOKE_BASE_ELEMENTARY_CIRCLE_H
#define HOOKE_BASE_ELEMENTARY_CIRCLE_H

#include "base/elementary/wide.h"

#define HALF_PI_1 0x1.921fb54400000p+0 /* 33 bits each, and what follows */
#define HALF_PI_2 0x1.0b4611a600000p-34
#define HALF_PI_3 0x1.3198a2e037073p-69
#define TWO_OVER_PI 0x1.45f306dc9c883p-1
#define CIRCLE_FAR 0x1p19 /* |x| beyond takes all of pi's digits */
#define CIRCLE_CLOSE                                                                               \
    0x1p-40               /* and so does what is left of n pi/2 where it is less than this n       \
                           */
#define CIRCLE_NEAR 0.785 /* nothing to reduce below */

/* sin(r + low) - r */
INLINE double sine_rest(double r, double low)
{
    const double s = r * r, q = s * s;
    const double sum = (-0x1.5555555555548p-3 + s * 0x1.111111110f730p-7) +
                       q * ((-0x1.a01a019be9212p-13 + s * 0x1.71de35552aaacp-19) +
                            q * (-0x1.ae5e4b830f1f3p-26 + s * 0x1.5d8b553fce991p-33));
    return r * s * sum + low * (1 - s * (0.5 - s * (1. / 24)));
}

/* cos(r + low) - *most, the larger part */
INLINE double cosine_rest(double r, double low, double *most)
{
    const double s = r * r, q = s * s, half = s * 0.5;
    const double sum = (0x1.555555555554bp-5 + s * -0x1.6c16c16c15013p-10) +
                       q * ((0x1.a01a019c8ed07p-16 + s * -0x1.27e4f7f141083p-22) +
                            q * (0x1.1ee9db8e24ed5p-29 + s * -0x1.8fa65e88311bfp-37));
    *most = 1 - half;
    return q * sum + (((1 - *most) - half) - low * (r - r * s * (1. / 6)));
}

INLINE double sine_near(double r, double low)
{
    return r + sine_rest(r, low);
}

INLINE double cosine_near(double r, double low)
{
    double most;
    const double rest = cosine_rest(r, low, &most);
    return most + rest;
}

/* |x|, 0 <= x <= CIRCLE_FAR, as quarters pi/2 + r + low; quarters in the lowest
 * bits of what is returned. *fine: all of these digits are right */
INLINE uint64_t quarters_near(double x, double *r, double *low, uint64_t *fine)
{
    const double turned = x * TWO_OVER_PI + WHOLE, n = turned - WHOLE;
    const double near = x - n * HALF_PI_1, step = n * HALF_PI_2;
    *r = near - step;
    *low = ((near - *r) - step) - n * HALF_PI_3;
    *fine = (uint64_t)(x <= CIRCLE_FAR) & (uint64_t)(fabs(*r) >= n * CIRCLE_CLOSE);
    return to_bits(turned);
}

/* sin(r + low + quarters pi/2) */
INLINE double circle_turned(uint64_t quarters, double r, double low)
{
    const uint64_t odd = -(quarters & 1);
    return from_bits(((to_bits(sine_near(r, low)) & ~odd) | (to_bits(cosine_near(r, low)) & odd)) ^
                     (quarters & 2) << 62);
}

/* sin x; *doubt: what is not to be used has its lowest bit set */
INLINE double sine_in_loop(double x, uint64_t *doubt)
{
    double r, low;
    uint64_t fine;
    const uint64_t quarters = quarters_near(fabs(x), &r, &low, &fine);
    *doubt |= fine ^ 1;
    return from_bits(to_bits(circle_turned(quarters, r, low)) ^ (to_bits(x) & SIGN_BIT));
}

INLINE double cosine_in_loop(double x, uint64_t *doubt)
{
    double r, low;
    uint64_t fine;
    const uint64_t quarters = quarters_near(fabs(x), &r, &low, &fine) + 1;
    *doubt |= fine ^ 1;
    return circle_turned(quarters, r, low);
}

#endif
