/* SPDX-License-Identifier: GPL-3.0-or-later */
/* log, log10 and pow, with the same bits on every machine; they use fused multiply-add where the
 * processor has it, which gives the same results faster. */
#include <hooke/base/text.h>
#include "base/elementary/logarithm.h"

/* Returns the logarithm of numbers without a finite one: -infinity for 0, NaN for negative ones. */
static double no_logarithm(double x)
{
    if (x == 0)
        return -HUGE_VAL;
    return x < 0 ? (double)NAN : x;
}

#ifdef FUSED_CLONE
FUSED_CLONE static double log_fused(double x)
{
    return log_in(x, true);
}

FUSED_CLONE static double log10_fused(double x)
{
    return log10_in(x, true);
}

FUSED_CLONE static double power_fused(double x, double y)
{
    return power_in(x, y, true);
}
#else
#define fused_here() false
#define log_fused(x) log_in(x, true)
#define log10_fused(x) log10_in(x, true)
#define power_fused(x, y) power_in(x, y, true)
#endif

/* Returns log x, by fused multiply-add if the processor has it. */
double fixed_log(double x)
{
    if (!(x > 0 && x < HUGE_VAL))
        return no_logarithm(x);
    return fused_here() ? log_fused(x) : log_in(x, HAS_FUSED_MULTIPLY);
}

/* Returns log10 x, by fused multiply-add if the processor has it. */
double fixed_log10(double x)
{
    if (!(x > 0 && x < HUGE_VAL))
        return no_logarithm(x);
    return fused_here() ? log10_fused(x) : log10_in(x, HAS_FUSED_MULTIPLY);
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

/* Returns x^y if one of them is 0, infinite or not a number, or x is 1. */
static double special_power(double x, double y)
{
    if (y == 0 || x == 1)
        return 1;
    if (x != x || y != y)
        return x + y;
    const bool grows = (fabs(x) > 1) == (y > 0);
    const double size = grows ? HUGE_VAL : 0;
    if (fabs(y) == HUGE_VAL)
        return x == -1 ? 1 : size;
    return signbit(x) && is_odd(y) ? -size : size;
}

/* Returns x^y, as C's pow() does: |x|^y, with a minus sign for a negative x and odd y; NaN for a
 * negative x and a y that is not whole. */
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
    return sign * (fused_here() ? power_fused(size, y) : power_in(size, y, HAS_FUSED_MULTIPLY));
}
