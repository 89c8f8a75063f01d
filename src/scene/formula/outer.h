/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds of expressions on intervals with a pole (Kahan 1968): all numbers except a gap, as 1/x has
 * for x from -1 to 1. They show that an expression is not 0 there. */
#pragma once

#include "scene/formula/jet.h"

/* A set of numbers: those of an interval, or, if has_gap, all numbers except those inside of it. */
struct outer {
    struct interval interval;
    bool has_gap;
};

/* Returns the set of the numbers of an interval. */
struct outer outer_interval(struct interval interval);
/* Returns bounds of all sums of a number in a and one in b. */
struct outer outer_add(struct outer a, struct outer b);
/* Returns true if 0 is not in the set. */
bool outer_excludes_zero(struct outer a);
/* Returns bounds of the expression, given those of its names, jet [slot]. Only + - * / and small
 * whole powers have gaps; other functions bound a gap by everything. */
struct outer expr_outer(const struct expr *expr, const struct jet *jet);
