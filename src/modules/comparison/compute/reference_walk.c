/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One solution on the grid of a reference, and the bursts of the forces on its way. */
#include "modules/comparison/compute/reference.h"
#include <hooke/base/cancel.h>

#include <stdlib.h>
#include <string.h>

#define SOLUTIONS_DISTANCE_MAX 1e-9 /* Solutions by different steps may differ by this. */
#define PARTS_OF_BURST 16           /* bounds are wider than the truth */
/* Number of times an interval is solved again with the bursts that were found in it. */
#define BURST_ROUNDS 12

/* Where the next adaptive step ends at the latest, on the way from t to `to`; shift: of the clock;
 * *at: the burst that is ahead. */
static double next_stop(const struct reference_search *search, int *at, double t, double to,
                        double shift)
{
    const double way = to > t ? 1 : -1;
    while (*at < search->bursts && way * (search->burst[*at].to - shift - t) <= 0)
        ++*at;
    if (*at == search->bursts)
        return to;
    const struct burst *burst = &search->burst[*at];
    for (int k = 0; k <= PARTS_OF_BURST; k++) {
        const double stop = burst->from + (burst->to - burst->from) * k / PARTS_OF_BURST - shift;
        if (way * (stop - t) > 0 && way * (to - stop) > 0)
            return stop;
    }
    return to;
}

static void add_node(struct reference_search *search, double t, const double *y)
{
    if (search->nodes == BURST_NODES_MAX - 1) /* the last one is that of the end */
        return;
    search->node[search->nodes].t = t;
    memcpy(search->node[search->nodes++].y, y, (size_t)search->system->n * sizeof *y);
}

/* An interval of the grid, and its clock. */
struct interval_of_grid {
    double from, to, shift;
};

static enum stop cross_fixed(const struct reference_search *search, struct solver *s,
                             const struct interval_of_grid *interval, int64_t steps)
{
    for (int64_t i = 0; i < steps; i++) {
        const double h = (interval->to - interval->from) / (double)steps;
        s->step.t = interval->from + h * (double)i;
        s->step.h = h;
        const enum step_status status = method_turning_step(s->method, &s->step);
        if (status != STEP_OK)
            return solver_stop(status);
        if (solver_cost(s) > s->max)
            return STOP_FULL;
        if ((i & 63) == 63 && cancelled(search->cancel))
            return STOP_CANCELLED;
    }
    return STOP_END;
}

/* No step across the ends of `parts` equal parts of it, nor across a burst. */
static enum stop cross_adaptive(struct reference_search *search, struct solver *s,
                                struct controller *controller,
                                const struct interval_of_grid *interval)
{
    const int parts = search->parts;
    const double from = interval->from, to = interval->to;
    int part = 1, at = 0;
    search->nodes = 0;
    add_node(search, from + interval->shift, s->y);
    for (int64_t i = 0; s->step.t != to; i++) {
        const double next = part < parts ? from + (to - from) * part / parts : to;
        const double stop = next_stop(search, &at, s->step.t, next, interval->shift);
        const enum step_status status = method_adapt(s->method, &s->step, controller, stop);
        part += s->step.t == next;
        if (status != STEP_OK)
            return solver_stop(status);
        if (s->step.t == stop && stop != next)
            add_node(search, stop + interval->shift, s->y);
        if (solver_cost(s) > s->max)
            return STOP_FULL;
        if ((i & 63) == 63 && cancelled(search->cancel))
            return STOP_CANCELLED;
    }
    search->node[search->nodes].t = to + interval->shift;
    memcpy(search->node[search->nodes++].y, s->y, (size_t)search->system->n * sizeof *s->y);
    return STOP_END;
}

static int by_time(const void *a, const void *b)
{
    const double x = ((const struct burst *)a)->from, y = ((const struct burst *)b)->from;
    return (x > y) - (x < y);
}

static int by_time_back(const void *a, const void *b)
{
    return by_time(b, a);
}

/* Bursts of the interval that was just crossed, from those before it on; false: none that are new.
 */
static bool look_for_bursts(struct reference_search *search, int before)
{
    const bool forward = search->reference->span > 0;
    const int count = search->bursts;
    for (int i = 0; i + 1 < search->nodes; i++) {
        const struct reference_node *node = &search->node[i];
        const double t[2] = {node[0].t, node[1].t};
        if (t[0] != t[1])
            search->bursts = before + system_bursts(search->system, t, node[0].y, node[1].y, false,
                                                    search->burst + before, search->bursts - before,
                                                    BURSTS_MAX - before);
    }
    qsort(search->burst + before, (size_t)(search->bursts - before), sizeof *search->burst,
          forward ? by_time : by_time_back);
    return search->bursts > count || search->bursts > before;
}

static double moved_by(const struct system *system, const double *a, const double *b)
{
    double max = 0;
    for (int i = 0; i < system->n; i++)
        max = fmax(max, fabs(a[i] - b[i]) / fmax(system->scale[i], fmax(fabs(a[i]), fabs(b[i]))));
    return max;
}

/*
 * The interval again, with steps that end at what was found along the way through it, until that
 * changes nothing: what happens there may lead elsewhere. Where the first round changes nothing it
 * had been seen, and is forgotten.
 */
static enum stop cross_bursts(struct reference_search *search, struct solver *s,
                              struct controller *controller,
                              const struct interval_of_grid *interval)
{
    const size_t size = (size_t)search->system->n * sizeof(double);
    const struct controller at_first = *controller;
    const int before = search->bursts;
    double y[LIMIT_VARIABLES], low[LIMIT_VARIABLES], last[LIMIT_VARIABLES];
    memcpy(y, s->y, size);
    memcpy(low, s->low, size);
    enum stop stop = cross_adaptive(search, s, controller, interval);
    for (int round = 0; round < BURST_ROUNDS && stop == STOP_END && look_for_bursts(search, before);
         round++) {
        memcpy(last, s->y, size);
        memcpy(s->y, y, size);
        memcpy(s->low, low, size);
        *controller = at_first;
        s->step.t = interval->from;
        s->step.warm = s->step.again = false;
        stop = cross_adaptive(search, s, controller, interval);
        if (stop != STOP_END || moved_by(search->system, s->y, last) >= SOLUTIONS_DISTANCE_MAX)
            continue;
        search->bursts = round == 0 ? before : search->bursts;
        break;
    }
    return stop;
}

/*
 * Every grid time is hit. Where the laws do not depend on time the clock starts anew at each of
 * them, so that rounding of the time does not add up. steps: in an interval, 0: adaptive.
 */
static enum stop walk_grid(struct reference_search *search, struct solver *s, int64_t steps,
                           double *grid)
{
    const int n = s->system->n;
    const bool anew = s->system->autonomous, looking = steps == 0 && !search->looked;
    struct controller controller = {.tol = s->tol};
    solver_start(s);
    s->step.y = s->y;
    s->step.low = s->low;
    search->bursts = looking ? 0 : search->bursts;
    memcpy(grid, s->y, (size_t)n * sizeof *grid);
    for (int k = 1; k < STUDY_TIMES; k++) {
        const double begin = s->system->t0 + s->span * (k - 1) / (STUDY_TIMES - 1);
        const double end = s->system->t0 + s->span * k / (STUDY_TIMES - 1);
        const struct interval_of_grid interval = {
            anew ? 0 : begin, anew ? s->span / (STUDY_TIMES - 1) : end, anew ? begin : 0};
        s->step.t = interval.from;
        s->step.warm = s->step.again = false;
        const enum stop stop = steps > 0 ? cross_fixed(search, s, &interval, steps)
                               : looking ? cross_bursts(search, s, &controller, &interval)
                                         : cross_adaptive(search, s, &controller, &interval);
        if (stop != STOP_END)
            return stop;
        if (cancelled(search->cancel))
            return STOP_CANCELLED;
        memcpy(grid + k * n, s->y, (size_t)n * sizeof *grid);
    }
    search->looked |= looking;
    return STOP_END;
}

/* Within what is left of the cost of all of them. */
enum stop reference_walk(struct reference_search *search, struct solver *s, int64_t steps,
                         double *grid)
{
    const int64_t max = s->max;
    s->max = search->left < max ? search->left : max;
    const enum stop stop = walk_grid(search, s, steps, grid);
    search->left -= solver_cost(s);
    s->max = max;
    return stop;
}
