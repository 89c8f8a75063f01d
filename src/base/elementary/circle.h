/* SPDX-License-Identifier: GPL-3.0-or-later */
/* sin and cos of arguments that are not too large, without branches: in loops they become vectors.
 * circle.c uses the same code for single values, so that both give the same bits. */
#pragma once

#include "base/elementary/wide.h"

/* Select one of two coefficients of CIRCLE_SERIES. */
#define OF_SINE(sine, cosine) (sine)
#define OF_COSINE(sine, cosine) (cosine)

/* Returns sin(r + low) - r, |r| <= pi/4. */
INLINE double sine_rest(double r, double low)
{
    const double s = r * r, q = s * s;
    const double sum = CIRCLE_SERIES(OF_SINE, s, q);
    return r * s * sum + low * (1 - s * (0.5 - s * (1. / 24)));
}

/* Sets *most to the larger part of cos(r + low). Returns the difference from it. */
INLINE double cosine_rest(double r, double low, double *most)
{
    const double s = r * r, q = s * s, half = s * 0.5;
    const double sum = CIRCLE_SERIES(OF_COSINE, s, q);
    *most = 1 - half;
    return q * sum + (((1 - *most) - half) - low * (r - r * s * (1. / 6)));
}

/* sin and cos of r + low, |r| <= pi/4. */
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

/* Reduces x, 0 <= x <= CIRCLE_FAR, to quarters pi/2 + *r + *low. Returns quarters, of which only
 * the lowest two bits are right. *fine becomes 1 if all digits of *r and *low are right, else 0. */
INLINE uint64_t quarters_near(double x, double *r, double *low, uint64_t *fine)
{
    const double turned = x * TWO_OVER_PI + ROUND_TO_INTEGER, n = turned - ROUND_TO_INTEGER;
    const double reduced = x - n * HALF_PI_1, step = n * HALF_PI_2;
    *r = reduced - step;
    *low = ((reduced - *r) - step) - n * HALF_PI_3;
    *fine = (uint64_t)(x <= CIRCLE_FAR) & (uint64_t)(fabs(*r) >= n * CIRCLE_CLOSE);
    return to_bits(turned);
}

/* Returns sin(r + low + quarters pi/2). */
INLINE double circle_turned(uint64_t quarters, double r, double low)
{
    const uint64_t odd = -(quarters & 1);
    return from_bits(((to_bits(sine_near(r, low)) & ~odd) | (to_bits(cosine_near(r, low)) & odd)) ^
                     (quarters & 2) << 62);
}

/* Returns sin x; sets the lowest bit of *doubt if the result must not be used. */
INLINE double sine_in_loop(double x, uint64_t *doubt)
{
    double r, low;
    uint64_t fine;
    const uint64_t quarters = quarters_near(fabs(x), &r, &low, &fine);
    *doubt |= fine ^ 1;
    return from_bits(to_bits(circle_turned(quarters, r, low)) ^ (to_bits(x) & SIGN_BIT));
}

/* Returns cos x; sets the lowest bit of *doubt if the result must not be used. */
INLINE double cosine_in_loop(double x, uint64_t *doubt)
{
    double r, low;
    uint64_t fine;
    const uint64_t quarters = quarters_near(fabs(x), &r, &low, &fine) + 1;
    *doubt |= fine ^ 1;
    return circle_turned(quarters, r, low);
}
