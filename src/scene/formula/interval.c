/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Interval arithmetic: bounds of sums, products, quotients and powers that contain the exact
 * result, rounded outwards. */
#include <hooke/scene/interval.h>

#include <float.h>

/* A number above the rounding error of the smallest results. */
static const double tiny = 0x1p-1070;
/* Rounding to nearest, in units of the last place. */
static const double rounding = 0.5;

/* A little more than the distance of two numbers at 1: its half leads to the next. */
static const double last_place = DBL_EPSILON * (1 + DBL_EPSILON);

/* Returns a bound below x, `units` units in the last place away. With units = 0.5, lower() and
 * upper() give the next numbers below and above x (Rump, Zimmermann, Boldo, Melquiond 2009). */
static double lower(double x, double units)
{
    return x - (fabs(x) * (units * last_place) + tiny);
}

static double upper(double x, double units)
{
    return x + (fabs(x) * (units * last_place) + tiny);
}

/* Infinite results of finite numbers are no bounds: the largest number is one. */
struct interval interval_wide(double lo, double hi, double units)
{
    if (lo != lo || hi != hi)
        return interval_none;
    const double a = lower(lo, units), b = upper(hi, units);
    return (struct interval){a == a ? a : DBL_MAX, b == b ? b : -DBL_MAX};
}

struct interval interval_hull(struct interval a, struct interval b)
{
    if (interval_empty(a) || interval_empty(b))
        return interval_empty(a) ? b : a;
    return (struct interval){fmin(a.lo, b.lo), fmax(a.hi, b.hi)};
}

struct interval interval_neg(struct interval a)
{
    return (struct interval){-a.hi, -a.lo};
}

/* Returns the bound, unless it is NaN: then `largest` if the result itself is infinite, or an
 * infinite bound on that side if the result is NaN, too, as a difference of infinities. */
static double finite_bound(double bound, double result, double largest)
{
    if (bound == bound)
        return bound;
    return result == result ? largest : -copysign(HUGE_VAL, largest);
}

/* Returns the bounds of results that were rounded to nearest; 0 is exact. */
static struct interval rounded(double lo, double hi)
{
    const double lo_rounded = lo == 0 ? 0 : lower(lo, rounding),
                 hi_rounded = hi == 0 ? 0 : upper(hi, rounding);
    return (struct interval){finite_bound(lo_rounded, lo, DBL_MAX),
                             finite_bound(hi_rounded, hi, -DBL_MAX)};
}

/* Returns true if the interval is exactly 0. */
static bool is_exactly_zero(struct interval a)
{
    return a.lo == 0 && a.hi == 0;
}

struct interval interval_add(struct interval a, struct interval b)
{
    if (interval_empty(a) || interval_empty(b))
        return interval_none;
    return is_exactly_zero(a) ? b : is_exactly_zero(b) ? a : rounded(a.lo + b.lo, a.hi + b.hi);
}

struct interval interval_sub(struct interval a, struct interval b)
{
    return interval_add(a, interval_neg(b));
}

/* Returns a product or quotient of nonzero numbers, replaced by `tiny` with its sign if it
 * underflowed to 0. */
static double nonzero(double value)
{
    return value == 0 ? copysign(tiny, value) : value;
}

/* Returns the product of two bounds. 0 times infinity is 0, because an infinite bound stands for
 * numbers that are finite. */
static double bound_product(double a, double b)
{
    return a == 0 || b == 0 ? 0 : nonzero(a * b);
}

/* Returns the range of the four products of bounds, rounded outwards. */
struct interval interval_mul(struct interval a, struct interval b)
{
    if (interval_empty(a) || interval_empty(b))
        return interval_none;
    if (is_exactly_zero(a) || is_exactly_zero(b))
        return interval_point(0);
    const double p = bound_product(a.lo, b.lo), q = bound_product(a.lo, b.hi),
                 r = bound_product(a.hi, b.lo), s = bound_product(a.hi, b.hi);
    const double pq = p < q ? p : q, rs = r < s ? r : s, max_pq = p < q ? q : p,
                 max_rs = r < s ? s : r;
    return rounded(pq < rs ? pq : rs, max_pq < max_rs ? max_rs : max_pq);
}

/* Returns the quotient of two bounds, b not 0. */
static double quotient(double a, double b)
{
    return a == 0 ? 0 : nonzero(a / b);
}

/* Returns everything if b contains 0. */
struct interval interval_div(struct interval a, struct interval b)
{
    if (interval_empty(a) || interval_empty(b))
        return interval_none;
    if (interval_has(b, 0))
        return interval_all;
    if (b.hi < 0)
        return interval_div(interval_neg(a), interval_neg(b));
    return rounded(quotient(a.lo, a.lo < 0 ? b.lo : b.hi), quotient(a.hi, a.hi < 0 ? b.hi : b.lo));
}

struct interval interval_square(struct interval a)
{
    return interval_power(a, 2);
}

/* Returns x^n for n >= 0 by repeated squaring. */
static double power(double x, int n)
{
    double product = 1;
    for (; n > 0; n /= 2, x *= x)
        if (n & 1)
            product *= x;
    return product;
}

/* Returns a^n for a whole n; even powers are not negative. */
struct interval interval_power(struct interval a, int n)
{
    if (interval_empty(a) || n == 0)
        return n == 0 ? interval_point(1) : a;
    if (n < 0)
        return interval_div(interval_point(1), interval_power(a, -n));
    if (n == 1)
        return a;
    /* a square is rounded once; others up to n - 1 times, here and where formulas are evaluated */
    const double p = power(a.lo, n), q = power(a.hi, n), units = n == 2 ? rounding : n;
    if (n % 2 == 1)
        return interval_wide(p, q, units);
    const struct interval bounds = interval_wide(fmin(p, q), fmax(p, q), units);
    return (struct interval){interval_has(a, 0) ? 0 : fmax(bounds.lo, 0), bounds.hi};
}
