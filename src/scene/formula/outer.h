/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bounds of expressions on stretches with a pole (Kahan 1968): all numbers but a gap. */
#pragma once

#include "scene/formula/jet.h"

/* The numbers of an interval; or, if has_gap, all up to its lower end and all from its upper end
 * on. */
struct outer {
    struct interval interval;
    bool has_gap;
};

struct outer outer_interval(struct interval interval);
struct outer outer_add(struct outer a, struct outer b);
/* Returns true if 0 is none of the numbers. */
bool outer_excludes_zero(struct outer a);
/* Bounds that follow from those of the names, jet [slot]; functions that are not rational lose the
 * gap. */
struct outer expr_outer(const struct expr *expr, const struct jet *jet);
