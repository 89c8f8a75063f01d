/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Boxes of state space (an interval for each variable) that wait to be searched for zeros, the
 * widest first, and the operator that proves that a box has exactly one zero or none. */
#pragma once

#include <hooke/scene/interval.h>
#include <hooke/scene/typed.h>

#include "modules/dynamics/orbits/field.h"

/* One box. */
struct state_box {
    struct interval side[FIELD_VARIABLES];
    bool is_singular; /* the equations or their derivatives have no bounds in it */
    bool is_smallest; /* cutting would not help: rounding dominates, or a side is one number wide */
};

/* A queue, first in, first out: halves wait behind all boxes of their parents' size. Zero at the
 * start; the owner frees `box`. */
struct box_queue {
    struct state_box *box;   /* [first] to [end - 1] wait */
    size_t first, end, room; /* room is the capacity */
};

/* Appends a copy of a box. Returns false if out of memory. */
bool box_queue_add(struct box_queue *queue, const struct state_box *box);
/* Removes the first box and copies it to *box. Returns false if none waits. */
bool box_queue_take(struct box_queue *queue, struct state_box *box);
/* Returns the number of boxes that wait. */
static inline size_t box_queue_count(const struct box_queue *queue)
{
    return queue->end - queue->first;
}

/* Returns true if the box [n] lies in another. */
bool box_lies_in(int n, const struct interval *box, const struct interval *other);
/* Returns true if two boxes have a point in common. */
bool boxes_meet(int n, const struct interval *box, const struct interval *other);

/* Verdict on the zeros of a box. */
enum verdict { NONE, ONE, UNKNOWN };

/* Applies the operator of Krawczyk (Neumaier 1990, 5.1), K(X) = m - C f(m) + (1 - C J(X)) (X - m),
 * to the box [n], and intersects the box with the result and a margin around it. jacobian [n][n]
 * are the bounds J(X) of the Jacobian on the box. Returns NONE if the box has no zero, ONE if the
 * box had exactly one before, which lies in the intersection. rounding [n], unless NULL, becomes
 * what the rounding of f(m) adds to each side of K. */
enum verdict krawczyk_verdict(const struct system *bounded, struct interval *box,
                              const struct interval *jacobian, double *rounding);
