/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * sin and cos of what is not too large, without a branch: in loops it becomes
 * vectors, and both forms are one text.
 */
#pragma once

#include "base/elementary/wide.h"

#define OF_SINE(sine, cosine) (sine)
#define OF_COSINE(sine, cosine) (cosine)

/* sin(r + low) - r */
INLINE double sine_rest(double r, double low)
{
    const double s = r * r, q = s * s;
    const double sum = CIRCLE_SERIES(OF_SINE, s, q);
    return r * s * sum + low * (1 - s * (0.5 - s * (1. / 24)));
}

/* cos(r + low) - *most, the larger part */
INLINE double cosine_rest(double r, double low, double *most)
{
    const double s = r * r, q = s * s, half = s * 0.5;
    const double sum = CIRCLE_SERIES(OF_COSINE, s, q);
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
    const double turned = x * TWO_OVER_PI + ROUND_TO_INTEGER, n = turned - ROUND_TO_INTEGER;
    const double reduced = x - n * HALF_PI_1, step = n * HALF_PI_2;
    *r = reduced - step;
    *low = ((reduced - *r) - step) - n * HALF_PI_3;
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
