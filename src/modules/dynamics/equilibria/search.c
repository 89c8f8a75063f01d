/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Branch and prune. A box in which the bounds of a rate exclude 0 is dropped; the Krawczyk operator
 * proves that a box has exactly one zero or none, or makes it smaller; otherwise it is cut in two
 * (Neumaier 1990, Interval Methods for Systems of Equations, chapter 5). Boxes in which the
 * equations are unbounded (poles) wait until all others are decided. What cannot be decided is left
 * to the caller. */
#include "modules/dynamics/equilibria/search.h"

#include <float.h>
#include <hooke/scene/poles.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BOXES_PER_REPORT = 64, BOXES_MAX = 200000, SINGULAR_CUTS_MAX = 10000 };
enum { NEWTON_STEPS_MAX = 100, TIGHTEN_STEPS_MAX = 60 };

/* Boxes are not cut below this width, relative to the range. */
static const double box_side_min = 1e-15;
/* A box that has shrunk to less than this part of its widest side is examined once more before it
 * is halved. */
static const double shrunk_share = 0.7;
/* Boxes are not cut in the middle, since zeros often lie on symmetry axes. */
static const double cut_share = 0.4837;
/* Largest width, relative to the range, of the regions around a box that are tried for one zero
 * (epsilon inflation, Rump 1983). */
static const double inflation_max = 1e-3;
/* Largest number of comparisons of undecided boxes with zeros. */
static const double comparisons_max = 2e7;
/* Distance from the edge, relative to the range, within which a zero is on it. */
static const double edge_rounding = 1e-12;

bool zeros_in_range(const struct zero_search *s, const double *y)
{
    bool inside = true;
    for (int i = 0; i < s->n; i++)
        inside = inside && y[i] >= s->request->box[i][0] - edge_rounding * s->width[i] &&
                 y[i] <= s->request->box[i][1] + edge_rounding * s->width[i];
    return inside;
}

/* Applies Newton's method to the field, averaged over the drive's period. */
void zeros_correct(const struct zero_search *s, double *y)
{
    const int n = s->n;
    for (int k = 0; k < NEWTON_STEPS_MAX; k++) {
        double jacobian[FIELD_VARIABLES * FIELD_VARIABLES], step[FIELD_VARIABLES], longest = 0;
        mean_field(&s->bounded, y, step, jacobian);
        if (!matrix_solve(n, jacobian, step))
            return;
        for (int i = 0; i < n; i++) {
            y[i] -= step[i];
            longest = fmax(longest, fabs(step[i]) / s->width[i]);
        }
        if (longest < 1e-16)
            return;
    }
}

/* ---- zeros that are proven ---- */

/* Shrinks a box with exactly one zero as far as the operator can. */
static void tighten_box(const struct zero_search *s, struct interval *box)
{
    struct interval rate[FIELD_VARIABLES], jacobian[FIELD_VARIABLES * FIELD_VARIABLES],
        previous[FIELD_VARIABLES];
    bool shrinks = true;
    for (int k = 0; k < TIGHTEN_STEPS_MAX && shrinks; k++) {
        memcpy(previous, box, sizeof previous);
        system_bounds(&s->bounded, box, rate, jacobian);
        krawczyk_verdict(&s->bounded, box, jacobian, NULL);
        shrinks = false;
        for (int i = 0; i < s->n; i++)
            shrinks = shrinks || box[i].hi - box[i].lo < 0.9 * (previous[i].hi - previous[i].lo);
    }
}

/* Moves a zero at the lower end of a full turn to the upper end, which is the same place. */
static void move_to_upper_end(const struct zero_search *s, double *y, struct zero_proof *proof)
{
    for (int i = 0; i < s->n; i++) {
        if (!(s->turn[i] > 0) || y[i] > s->request->box[i][0] + edge_rounding * s->width[i])
            continue;
        y[i] += s->turn[i];
        proof->tight[i] = interval_add(proof->tight[i], interval_point(s->turn[i]));
        proof->unique[i] = interval_add(proof->unique[i], interval_point(s->turn[i]));
    }
}

/* Grows the arrays of solutions and proofs together. */
bool zeros_append(struct zero_search *s, const double *y, const struct zero_proof *proof)
{
    struct equilibria *found = s->found;
    if (found->count == s->capacity) {
        const int capacity = s->capacity > 0 ? 2 * s->capacity : 16;
        struct solution *more = realloc(found->solution, (size_t)capacity * sizeof *more);
        if (more)
            found->solution = more;
        struct zero_proof *proofs = realloc(s->proof, (size_t)capacity * sizeof *proofs);
        if (proofs)
            s->proof = proofs;
        if (!more || !proofs)
            return false;
        s->capacity = capacity;
    }
    struct solution *solution = &found->solution[found->count];
    *solution = (struct solution){.kind = SOLUTION_EQUILIBRIUM, .n = s->n, .multiple = !proof};
    memcpy(solution->state, y, (size_t)s->n * sizeof *y);
    if (proof)
        s->proof[found->count] = *proof;
    found->count++;
    return true;
}

/* Adds a box to the undecided ones. Returns false if out of memory. */
static bool leave_undecided(struct zero_search *s, const struct interval *side, bool singular,
                            bool smallest)
{
    struct state_box box = {.is_singular = singular, .is_smallest = smallest};
    memcpy(box.side, side, sizeof box.side);
    return box_queue_add(&s->undecided, &box);
}

/* Appends the only zero of a region, unless it is known already or lies outside of the range. Two
 * zeros are the same only if that follows from their proofs; otherwise the box becomes undecided.
 * Returns false if out of memory. */
static bool keep_zero(struct zero_search *s, const struct interval *region)
{
    struct zero_proof proof;
    double y[FIELD_VARIABLES];
    memcpy(proof.unique, region, sizeof proof.unique);
    memcpy(proof.tight, region, sizeof proof.tight);
    tighten_box(s, proof.tight);
    for (int i = 0; i < s->n; i++)
        y[i] = interval_middle(proof.tight[i]);
    zeros_correct(s, y);
    for (int i = 0; i < s->n; i++) {
        const struct interval tight = proof.tight[i];
        const bool has_zero = tight.lo <= 0 && tight.hi >= 0;
        y[i] = has_zero ? 0 : fmin(fmax(y[i], tight.lo), tight.hi);
        if (isnan(y[i]))
            y[i] = interval_middle(tight);
    }
    if (!zeros_in_range(s, y))
        return true;
    move_to_upper_end(s, y, &proof);
    for (int k = 0; k < s->found->count; k++) {
        const struct zero_proof *known = &s->proof[k];
        if (box_lies_in(s->n, proof.tight, known->unique) ||
            box_lies_in(s->n, known->tight, proof.unique))
            return true;
        if (boxes_meet(s->n, proof.tight, known->tight))
            return leave_undecided(s, proof.tight, false, true);
    }
    return zeros_append(s, y, &proof);
}

/* Finds a region [n] around a box [n] and the zero near it in which that zero is proven to be the
 * only one. Tries regions with growing margins. Returns false if no region proves it before the
 * margin exceeds inflation_max of the search region. */
static bool find_region(const struct zero_search *s, const struct interval *box,
                        struct interval *region)
{
    double y[FIELD_VARIABLES];
    for (int i = 0; i < s->n; i++)
        y[i] = interval_middle(box[i]);
    zeros_correct(s, y);
    for (double growth = 1;; growth *= 10) {
        struct interval cut[FIELD_VARIABLES], rate[FIELD_VARIABLES],
            jacobian[FIELD_VARIABLES * FIELD_VARIABLES];
        for (int i = 0; i < s->n; i++) {
            const double lo = fmin(box[i].lo, y[i]), hi = fmax(box[i].hi, y[i]),
                         margin = growth * (hi - lo + 4 * DBL_EPSILON * fabs(y[i]) +
                                            box_side_min * s->width[i]);
            if (!(margin <= inflation_max * s->width[i]))
                return false;
            region[i] = (struct interval){lo - margin, hi + margin};
        }
        memcpy(cut, region, sizeof cut);
        system_bounds(&s->bounded, region, rate, jacobian);
        if (krawczyk_verdict(&s->bounded, cut, jacobian, NULL) == ONE)
            return true;
    }
}

/* Finds a zero by Newton's method, then a region in which it is the only one. */
bool zeros_prove_from(struct zero_search *s, const double *start)
{
    double y[FIELD_VARIABLES];
    struct interval point[FIELD_VARIABLES], region[FIELD_VARIABLES];
    memcpy(y, start, (size_t)s->n * sizeof *y);
    zeros_correct(s, y);
    for (int i = 0; i < s->n; i++)
        point[i] = (struct interval){y[i], y[i]};
    return !zeros_in_range(s, y) || !find_region(s, point, region) || keep_zero(s, region);
}

/* Drops undecided boxes inside of a region whose only zero is known. */
void zeros_drop_decided(struct zero_search *s)
{
    struct box_queue *left = &s->undecided;
    if ((double)box_queue_count(left) * s->found->count > comparisons_max)
        return;
    size_t remaining = left->first;
    for (size_t b = left->first; b < left->end; b++) {
        bool decided = false;
        for (int k = 0; k < s->found->count && !decided; k++)
            decided = box_lies_in(s->n, left->box[b].side, s->proof[k].unique);
        if (!decided)
            left->box[remaining++] = left->box[b];
    }
    left->end = remaining;
}

/* ---- boxes ---- */

/* Returns the volume of a box as a fraction of that of the range. */
static double volume_share(const struct zero_search *s, const struct interval *box)
{
    double part = 1;
    for (int i = 0; i < s->n; i++)
        part *= (box[i].hi - box[i].lo) / s->width[i];
    return part;
}

/* Returns the index of the side that is widest relative to the range. */
static int widest_side(const struct zero_search *s, const struct interval *box)
{
    int widest = 0;
    for (int i = 1; i < s->n; i++)
        if ((box[i].hi - box[i].lo) / s->width[i] >
            (box[widest].hi - box[widest].lo) / s->width[widest])
            widest = i;
    return widest;
}

/* Returns where a side is cut. */
static double cut_place(struct interval side)
{
    return side.lo + cut_share * (side.hi - side.lo);
}

/* Cuts a box at its widest side and appends both parts. Returns false if out of memory. */
static bool add_halves(struct zero_search *s, const struct state_box *box)
{
    const int widest = widest_side(s, box->side);
    const double cut = cut_place(box->side[widest]);
    struct state_box lower = *box, upper = *box;
    lower.side[widest].hi = upper.side[widest].lo = cut;
    return box_queue_add(&s->waiting, &lower) && box_queue_add(&s->waiting, &upper);
}

/* Handles a box for which interval bounds prove neither one zero nor none. A box that can be cut is
 * cut in two along its widest side or, if it is singular, queued for later. One that is too small
 * to be cut is searched for a provable zero around it, else added to the undecided ones. rounding
 * [n] is the error of the bounds from krawczyk_verdict(); a side that it dominates is not cut.
 * Returns false if out of memory. */
static bool split_box(struct zero_search *s, struct state_box *box, const double *rounding)
{
    const int widest = widest_side(s, box->side);
    const struct interval side = box->side[widest];
    const double length = side.hi - side.lo, cut = cut_place(side);
    struct interval region[FIELD_VARIABLES];
    if (length >= box_side_min * s->width[widest] && cut > side.lo && cut < side.hi &&
        !(rounding[widest] >= length / 4))
        return box->is_singular ? box_queue_add(&s->singular, box) : add_halves(s, box);
    s->done += volume_share(s, box->side);
    if (!box->is_singular && find_region(s, box->side, region))
        return keep_zero(s, region);
    return leave_undecided(s, box->side, box->is_singular, true);
}

/* Returns true if the interval does not contain 0 (or is empty, NAN). */
static bool excludes_zero(struct interval a)
{
    return a.lo > 0 || a.hi < 0 || isnan(a.lo);
}

bool zeros_are_bounded(int n, const struct interval *bounds)
{
    bool bounded = true;
    for (int i = 0; i < n; i++)
        bounded = bounded && isfinite(bounds[i].lo) && isfinite(bounds[i].hi);
    return bounded;
}

/* Returns true if the box has a point in common with the requested range. */
static bool meets_range(const struct zero_search *s, const struct interval *box)
{
    bool meets = true;
    for (int i = 0; i < s->n; i++)
        meets = meets && box[i].hi >= s->request->box[i][0] - edge_rounding * s->width[i] &&
                box[i].lo <= s->request->box[i][1] + edge_rounding * s->width[i];
    return meets;
}

/* Examines one box, again as long as the operator shrinks it: to shrunk_share of its widest side or
 * less each time. Then the box is dropped (no zero), its zero is kept (exactly one), or it is
 * split. s->done increases by the share of the volume that is settled. Returns false if out of
 * memory. */
static bool examine_box(struct zero_search *s, struct state_box *box)
{
    const double part = volume_share(s, box->side);
    for (;;) {
        struct interval rate[FIELD_VARIABLES], jacobian[FIELD_VARIABLES * FIELD_VARIABLES],
            saved[FIELD_VARIABLES];
        double rounding[FIELD_VARIABLES] = {0};
        enum verdict verdict = UNKNOWN;
        s->boxes++;
        memcpy(saved, box->side, sizeof saved);
        system_bounds(&s->bounded, box->side, rate, jacobian);
        bool empty = !meets_range(s, box->side);
        for (int i = 0; i < s->n; i++)
            empty = empty || excludes_zero(rate[i]);
        box->is_singular =
            !zeros_are_bounded(s->n, rate) || !zeros_are_bounded(s->n * s->n, jacobian);
        empty = empty || (box->is_singular && system_excludes_zero(&s->bounded, box->side));
        if (!empty && !box->is_singular)
            verdict = krawczyk_verdict(&s->bounded, box->side, jacobian, rounding);
        if (empty || verdict == NONE || verdict == ONE) {
            s->done += part;
            return empty || verdict == NONE || keep_zero(s, saved);
        }
        const int widest = widest_side(s, saved);
        if (!(box->side[widest].hi - box->side[widest].lo <
              shrunk_share * (saved[widest].hi - saved[widest].lo))) {
            s->done += part - volume_share(s, box->side);
            return split_box(s, box, rounding);
        }
    }
}

/* Reports the finished fraction of the volume from time to time. */
static void report_search(const struct zero_search *s)
{
    if (s->boxes % BOXES_PER_REPORT == 0 && s->request->progress)
        s->request->progress(s->request->context, fmin(fmax(s->done, 0), 1));
}

/* Moves all boxes of a queue to the undecided ones. Returns false if out of memory. */
static bool leave_queue_undecided(struct zero_search *s, struct box_queue *queue)
{
    struct state_box box;
    while (box_queue_take(queue, &box))
        if (!box_queue_add(&s->undecided, &box))
            return false;
    return true;
}

/* Takes waiting boxes first; singular ones are cut when none waits. */
bool zeros_search(struct zero_search *s)
{
    struct state_box box;
    int cuts = 0;
    while (s->boxes < BOXES_MAX && s->found->count < ZEROS_MAX && !cancelled(s->request->cancel)) {
        if (box_queue_take(&s->waiting, &box)) {
            if (!examine_box(s, &box))
                return false;
        } else if (cuts < SINGULAR_CUTS_MAX && box_queue_take(&s->singular, &box)) {
            cuts++;
            if (!add_halves(s, &box))
                return false;
        } else {
            break;
        }
        report_search(s);
    }
    return leave_queue_undecided(s, &s->waiting) && leave_queue_undecided(s, &s->singular);
}
