/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Arithmetic of intervals, rounded outwards (Moore 1966, Interval Analysis). */
#pragma once

#include <hooke/scene/formula.h>

#include <math.h>

static const struct interval interval_all = {-HUGE_VAL, HUGE_VAL}, interval_none = {NAN, NAN};

static inline bool interval_empty(struct interval a)
{
    return a.lo != a.lo;
}

static inline bool interval_has(struct interval a, double x)
{
    return a.lo <= x && x <= a.hi;
}

static inline struct interval interval_point(double x)
{
    return (struct interval){x, x};
}

static inline double interval_middle(struct interval a)
{
    return a.lo + (a.hi - a.lo) / 2;
}

/* Returns [lo, hi], widened for rounding by at most `units` units in the last place. */
struct interval interval_wide(double lo, double hi, double units);
struct interval interval_hull(struct interval a, struct interval b);
struct interval interval_neg(struct interval a);
struct interval interval_add(struct interval a, struct interval b);
struct interval interval_sub(struct interval a, struct interval b);
struct interval interval_mul(struct interval a, struct interval b); /* 0 times anything is 0 */
struct interval interval_div(struct interval a, struct interval b); /* all, where b has 0 in it */
struct interval interval_square(struct interval a);
struct interval interval_power(struct interval a, int n); /* n of any sign */
