/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/scene/interval.h>

#include <float.h>

#define LEAST 0x1p-1070 /* more than what the smallest results are rounded by */

struct interval interval_wide(double lo, double hi, double units)
{
    if (lo != lo || hi != hi)
        return interval_none;
    const double a = lo - (fabs(lo) * (units * DBL_EPSILON) + LEAST);
    const double b = hi + (fabs(hi) * (units * DBL_EPSILON) + LEAST);
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

/* Infinite bounds are no numbers: what has them is unbounded. */
static struct interval bounded(double lo, double hi)
{
    return interval_wide(lo == lo ? lo : -HUGE_VAL, hi == hi ? hi : HUGE_VAL, 1);
}

static bool exact(struct interval a)
{
    return a.lo == 0 && a.hi == 0;
}

struct interval interval_add(struct interval a, struct interval b)
{
    if (interval_empty(a) || interval_empty(b))
        return interval_none;
    return exact(a) ? b : exact(b) ? a : bounded(a.lo + b.lo, a.hi + b.hi);
}

struct interval interval_sub(struct interval a, struct interval b)
{
    return interval_add(a, interval_neg(b));
}

static double times(double a, double b)
{
    return a == 0 || b == 0 ? 0 : a * b;
}

struct interval interval_mul(struct interval a, struct interval b)
{
    if (interval_empty(a) || interval_empty(b))
        return interval_none;
    if (exact(a) || exact(b))
        return interval_point(0);
    const double p = times(a.lo, b.lo), q = times(a.lo, b.hi), r = times(a.hi, b.lo),
                 s = times(a.hi, b.hi);
    const double pq = p < q ? p : q, rs = r < s ? r : s, max_pq = p < q ? q : p,
                 max_rs = r < s ? s : r;
    return interval_wide(pq < rs ? pq : rs, max_pq < max_rs ? max_rs : max_pq, 1);
}

struct interval interval_div(struct interval a, struct interval b)
{
    if (interval_empty(a) || interval_empty(b))
        return interval_none;
    if (interval_has(b, 0))
        return interval_all;
    return interval_mul(a, interval_wide(1 / b.hi, 1 / b.lo, 1));
}

struct interval interval_square(struct interval a)
{
    return interval_power(a, 2);
}

static double power(double x, int n)
{
    double out = 1;
    for (; n > 0; n /= 2, x *= x)
        if (n & 1)
            out *= x;
    return out;
}

struct interval interval_power(struct interval a, int n)
{
    if (interval_empty(a) || n == 0)
        return n == 0 ? interval_point(1) : a;
    if (n < 0)
        return interval_div(interval_point(1), interval_power(a, -n));
    const double p = power(a.lo, n), q = power(a.hi, n), units = 2 * n;
    if (n % 2 == 1)
        return interval_wide(p, q, units);
    if (interval_has(a, 0))
        return interval_wide(0, p > q ? p : q, units);
    return a.lo > 0 ? interval_wide(p, q, units) : interval_wide(q, p, units);
}
