/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Powers for the choice of a step size, which needs few digits, often, and the same ones
 * everywhere: a library's pow() takes as long as a step of a small system.
 */
#pragma once

#include <stdint.h>
#include <string.h>

/* Returns log2(x) for a normal x > 0, with an error of at most 2e-9. With x = 2^e m, 0.7 < m < 1.42
 * and s = (m - 1)/(m + 1): log2 m = 2/ln 2 (s + s^3/3 + s^5/5 + ...) (Abramowitz, Stegun 1964, eq.
 * 4.1.27). */
static inline double factor_log2(double x)
{
    const uint64_t half = 0x3fe6a09e667f3bcd; /* sqrt(1/2) */
    uint64_t bits;
    double m;
    memcpy(&bits, &x, sizeof bits);
    const int64_t whole = (int64_t)(bits - half) >> 52;
    bits -= (uint64_t)whole << 52;
    memcpy(&m, &bits, sizeof m);
    const double s = (m - 1) / (m + 1), u = s * s;
    const double series = (0.961796693925976 + u * 0.577078016355585) +
                          u * u * (0.412198583111132 + u * 0.320598897975325);
    return (double)whole + s * (2.885390081777927 + u * series);
}

/* Returns 2^x, for |x| <= 1000, with a relative error of at most 1e-9: the nearest whole number
 * goes into the exponent, and the series of exp(f ln 2), |f| <= 1/2, gives the factor for the
 * rest. */
static inline double factor_exp2(double x)
{
    const double floored = x < -1000 ? -1000 : x;
    const double clamped = floored > 1000 ? 1000 : floored;
    /* adding shift rounds to a whole number, which is then in the lowest bits */
    const double shift = 0x1.8p52, rounded = clamped + shift;
    const double f = clamped - (rounded - shift), g = f * f;
    uint64_t bits;
    double power;
    memcpy(&bits, &rounded, sizeof bits);
    bits = (bits << 52) + 0x3ff0000000000000;
    memcpy(&power, &bits, sizeof power);
    const double low =
        (1 + f * 0.693147180559945) + g * (0.240226506959101 + f * 0.0555041086648216);
    const double high = (0.00961812910762848 + f * 0.00133335581464284) +
                        g * (0.000154035303933816 + f * 1.52527338040598e-5) +
                        g * g * 1.32154867901443e-6;
    return power * (low + g * g * high);
}

/* Returns atan(x) with an error of 1e-5 (Abramowitz, Stegun 1964, eq. 4.4.49); exact at 0. */
static inline double factor_atan(double x)
{
    const double size = x < 0 ? -x : x;
    const double z = size > 1 ? 1 / x : x, u = z * z;
    const double angle =
        z * (0.9998660 + u * (-0.3302995 + u * (0.1801410 + u * (-0.0851330 + u * 0.0208351))));
    return size <= 1 ? angle : (x < 0 ? -1.5707963267948966 : 1.5707963267948966) - angle;
}

/* Returns the limiter 1 + atan(2^x - 1) of a change by 2^x (Soderlind, Wang 2006), exact at 0. For
 * |x| <= 1/2 a polynomial with an error of 2e-7, because the next step waits for it; beyond that
 * the error is 1.2e-5. */
static inline double factor_limited(double x)
{
    if (!(x >= -0.5 && x <= 0.5))
        return 1 + factor_atan(factor_exp2(x) - 1);
    const double u = x * x;
    const double low =
        (1 + 0.6931488410800936 * x) + u * (0.240226502974211 - 0.0555933829372098 * x);
    const double high = (-0.1058275956503550 - 0.0320318947604718 * x) +
                        u * (0.0284870670868496 + 0.0239926464967005 * x);
    return low + u * u * high;
}
