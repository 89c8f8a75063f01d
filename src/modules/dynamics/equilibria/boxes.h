/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Boxes of states that wait to be searched for zeros, the widest first, and what proves that one
 * has a zero, or none. */
#pragma once

#include <hooke/scene/interval.h>
#include <hooke/scene/typed.h>

#include "modules/dynamics/orbits/field.h"

struct state_box {
    struct interval side[FIELD_VARIABLES];
    bool is_singular; /* the equations or their derivatives have no bounds in it */
    bool is_smallest; /* cutting it would not help: rounding decides, or it is one number wide */
};

/* First in, first out: halves wait behind all boxes of their parents' size. */
struct box_queue {
    struct state_box *box; /* [first], ..., [end - 1] wait */
    size_t first, end, room;
};

/* Appends a box; false if out of memory. */
bool box_queue_add(struct box_queue *queue, const struct state_box *box);
/* Takes the first box; false if none waits. */
bool box_queue_take(struct box_queue *queue, struct state_box *box);
static inline size_t box_queue_count(const struct box_queue *queue)
{
    return queue->end - queue->first;
}

/* Returns true if the box [n] lies in another. */
bool box_lies_in(int n, const struct interval *box, const struct interval *other);
/* Returns true if two boxes have a point in common. */
bool boxes_meet(int n, const struct interval *box, const struct interval *other);

enum verdict { NONE, ONE, UNKNOWN };

/*
 * Applies the operator of Krawczyk (Neumaier 1990, 5.1), K(X) = m - C f(m) + (1 - C J(X)) (X - m),
 * to the box [n] and intersects the box with the result, and a margin around it. by [n][n] are
 * bounds of the Jacobian on the box. NONE means that the box has no zero, ONE that the box before
 * had exactly one, which lies in the intersection. rounding [n], or NULL, becomes what rounding of
 * f(m) adds to each side of K.
 */
enum verdict krawczyk_verdict(const struct system *bounded, struct interval *box,
                              const struct interval *jacobian, double *rounding);
