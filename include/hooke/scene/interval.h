/* SPDX-License-Identifier: GPL-3.0-or-later */
/* interval: interval arithmetic, rounded outwards (Moore 1966, Interval Analysis). The result
 * contains every value that the operation has for operands in the given intervals. An empty
 * interval (NAN) as an operand gives an empty result. */
#pragma once

#include <hooke/scene/formula.h>

#include <math.h>

/* All real numbers; and the empty interval. */
static const struct interval interval_all = {-HUGE_VAL, HUGE_VAL}, interval_none = {NAN, NAN};

/* Returns true for the empty interval. */
static inline bool interval_empty(struct interval a)
{
    return a.lo != a.lo;
}

/* Returns true if x is in the interval. */
static inline bool interval_has(struct interval a, double x)
{
    return a.lo <= x && x <= a.hi;
}

/* Returns [x, x]. */
static inline struct interval interval_point(double x)
{
    return (struct interval){x, x};
}

/* Returns the midpoint. */
static inline double interval_middle(struct interval a)
{
    return a.lo + (a.hi - a.lo) / 2;
}

/* Returns [lo, hi], widened on both sides by about `units` units in the last place, which covers
 * rounding errors; the empty interval if lo or hi is NAN. */
struct interval interval_wide(double lo, double hi, double units);
/* Returns the smallest interval that contains both; an empty one is ignored. */
struct interval interval_hull(struct interval a, struct interval b);
/* Returns -a. */
struct interval interval_neg(struct interval a);
/* Returns a + b. */
struct interval interval_add(struct interval a, struct interval b);
/* Returns a - b. */
struct interval interval_sub(struct interval a, struct interval b);
/* Returns a b; an operand [0, 0] gives [0, 0], even if the other is unbounded. */
struct interval interval_mul(struct interval a, struct interval b);
/* Returns a / b, or interval_all if b contains 0. */
struct interval interval_div(struct interval a, struct interval b);
/* Returns a^2, which is never negative. */
struct interval interval_square(struct interval a);
struct interval interval_power(struct interval a, int n); /* Returns a^n, n of any sign. */
