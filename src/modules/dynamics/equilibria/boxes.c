/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The queue of boxes, and the Krawczyk operator. */
#include "modules/dynamics/equilibria/boxes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const size_t first_room = 256; /* number of boxes for which memory is allocated first */
/* Margin around the result of the operator, relative to a side. A side that shrank to rounding at
 * once could not shrink again, as a proof needs all sides to do. */
static const double margin_share = 1e-6;

/* If the memory is full, reuses the room of boxes that have been taken if that is more than half of
 * it, else doubles the memory. */
bool box_queue_add(struct box_queue *queue, const struct state_box *box)
{
    if (queue->end == queue->room && queue->first > queue->room / 2) {
        queue->end -= queue->first;
        memmove(queue->box, queue->box + queue->first, queue->end * sizeof *queue->box);
        queue->first = 0;
    }
    if (queue->end == queue->room) {
        const size_t room = queue->room > 0 ? 2 * queue->room : first_room;
        struct state_box *more = realloc(queue->box, room * sizeof *more);
        if (!more)
            return false;
        queue->box = more;
        queue->room = room;
    }
    queue->box[queue->end++] = *box;
    return true;
}

bool box_queue_take(struct box_queue *queue, struct state_box *box)
{
    if (queue->first == queue->end)
        return false;
    *box = queue->box[queue->first++];
    return true;
}

bool box_lies_in(int n, const struct interval *box, const struct interval *other)
{
    bool inside = true;
    for (int i = 0; i < n; i++)
        inside = inside && box[i].lo >= other[i].lo && box[i].hi <= other[i].hi;
    return inside;
}

bool boxes_meet(int n, const struct interval *box, const struct interval *other)
{
    bool meet = true;
    for (int i = 0; i < n; i++)
        meet = meet && box[i].lo <= other[i].hi && box[i].hi >= other[i].lo;
    return meet;
}

/* ---- the operator of Krawczyk ---- */

/* Computes an approximate inverse of the middle of the bounds. Returns false if it is singular. */
static bool invert_middle(int n, const struct interval *jacobian, double *inverse)
{
    for (int column = 0; column < n; column++) {
        double a[FIELD_VARIABLES * FIELD_VARIABLES], unit[FIELD_VARIABLES] = {0};
        for (int i = 0; i < n * n; i++)
            a[i] = interval_middle(jacobian[i]);
        unit[column] = 1;
        if (!matrix_solve(n, a, unit))
            return false;
        for (int i = 0; i < n; i++)
            inverse[i * n + column] = unit[i];
    }
    return true;
}

/* Returns half of the width that the rounding of f(m) alone gives the operator in direction i. */
static double operator_rounding(int n, const double *inverse, const struct interval *rate, int i)
{
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += fabs(inverse[i * n + j]) * (rate[j].hi - rate[j].lo) / 2;
    return sum;
}

/* Applies the Krawczyk operator K = m - C f(m) + (1 - C J) (box - m), where m is the middle of the
 * box, C an approximate inverse of the middle of J, and J the interval matrix `jacobian` [n x n].
 * Returns ONE if K is inside of the box, NONE if they do not meet, else UNKNOWN; box [n] shrinks to
 * its intersection with K, with a small margin. `rounding` [n] may be NULL, or receives the part of
 * K's width that is due to rounding. */
enum verdict krawczyk_verdict(const struct system *bounded, struct interval *box,
                              const struct interval *jacobian, double *rounding)
{
    const int n = bounded->n;
    double inverse[FIELD_VARIABLES * FIELD_VARIABLES];
    struct interval centre[FIELD_VARIABLES] = {{0}}, rate[FIELD_VARIABLES], k[FIELD_VARIABLES];
    for (int i = 0; rounding && i < n; i++)
        rounding[i] = 0;
    if (!invert_middle(n, jacobian, inverse))
        return UNKNOWN;
    for (int i = 0; i < n; i++)
        centre[i] = interval_point(interval_middle(box[i]));
    system_bounds(bounded, centre, rate, NULL);
    bool inside = true;
    for (int i = 0; i < n; i++) {
        if (rounding)
            rounding[i] = operator_rounding(n, inverse, rate, i);
        k[i] = centre[i];
        for (int j = 0; j < n; j++)
            k[i] = interval_sub(k[i], interval_mul(interval_point(inverse[i * n + j]), rate[j]));
        for (int j = 0; j < n; j++) {
            struct interval rest = interval_point(i == j);
            for (int l = 0; l < n; l++)
                rest = interval_sub(
                    rest, interval_mul(interval_point(inverse[i * n + l]), jacobian[l * n + j]));
            k[i] = interval_add(k[i], interval_mul(rest, interval_sub(box[j], centre[j])));
        }
        if (!(k[i].lo <= k[i].hi) || !isfinite(k[i].lo) || !isfinite(k[i].hi))
            return UNKNOWN;
        if (k[i].lo > box[i].hi || k[i].hi < box[i].lo)
            return NONE;
        inside = inside && k[i].lo > box[i].lo && k[i].hi < box[i].hi;
    }
    for (int i = 0; i < n; i++) {
        const double width = box[i].hi - box[i].lo, margin = margin_share * width;
        box[i].lo = fmax(box[i].lo, k[i].lo - margin);
        box[i].hi = fmin(box[i].hi, k[i].hi + margin);
    }
    return inside ? ONE : UNKNOWN;
}
