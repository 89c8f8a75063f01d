/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One solution for a reference: steps end at each grid time, and at the bursts (short changes) of
 * the forces that the first solution finds on its way. */
#include "modules/comparison/compute/reference.h"
#include <hooke/base/cancel.h>

#include <stdlib.h>
#include <string.h>

/* distance of two solutions with different steps, relative to their size, that counts as
 * unchanged */
#define SOLUTIONS_DISTANCE_MAX 1e-9
/* number of parts of a burst at which steps end, as its bounds may be wider than it is */
#define PARTS_OF_BURST 16
/* Number of times an interval is solved again with the bursts that were found in it. */
#define BURST_ROUNDS 12

/* Returns the time [s] by which the adaptive step from t must end: the next boundary of one of the
 * PARTS_OF_BURST parts of a burst, or t_end. *index is the number of the first burst that has not
 * ended at t, and advances. `shift` [s] is the true time minus that of the clock. */
static double next_stop(const struct reference_search *search, int *index, double t, double t_end,
                        double shift)
{
    const double way = t_end > t ? 1 : -1;
    while (*index < search->bursts && way * (search->burst[*index].t_end - shift - t) <= 0)
        ++*index;
    if (*index == search->bursts)
        return t_end;
    const struct burst *burst = &search->burst[*index];
    for (int k = 0; k <= PARTS_OF_BURST; k++) {
        const double stop =
            burst->t_begin + (burst->t_end - burst->t_begin) * k / PARTS_OF_BURST - shift;
        if (way * (stop - t) > 0 && way * (t_end - stop) > 0)
            return stop;
    }
    return t_end;
}

/* Stores the state at time t among the nodes between which bursts are searched for; without room it
 * is left out. */
static void add_node(struct reference_search *search, double t, const double *y)
{
    if (search->nodes == BURST_NODES_MAX - 1) /* the last one is that of the end */
        return;
    search->node[search->nodes].t = t;
    memcpy(search->node[search->nodes++].y, y, (size_t)search->system->n * sizeof *y);
}

/* An interval of the grid in time of the clock [s]; `shift` is the true time minus that of the
 * clock. */
struct interval_of_grid {
    double t_begin, t_end, shift;
};

/* Crosses an interval in `steps` equal steps. Returns STOP_END, or why it stopped. */
static enum stop cross_fixed(const struct reference_search *search, struct solver *s,
                             const struct interval_of_grid *interval, int64_t steps)
{
    for (int64_t i = 0; i < steps; i++) {
        const double h = (interval->t_end - interval->t_begin) / (double)steps;
        s->step.t = interval->t_begin + h * (double)i;
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

/* Crosses an interval in adaptive steps, which end at the ends of search->parts equal parts and at
 * those of bursts. Stores the states where bursts begin and end as nodes. Returns STOP_END, or why
 * it stopped. */
static enum stop cross_adaptive(struct reference_search *search, struct solver *s,
                                struct controller *controller,
                                const struct interval_of_grid *interval)
{
    const int parts = search->parts;
    const double t_begin = interval->t_begin, t_end = interval->t_end;
    int part = 1, burst_index = 0;
    search->nodes = 0;
    add_node(search, t_begin + interval->shift, s->y);
    for (int64_t i = 0; s->step.t != t_end; i++) {
        const double next = part < parts ? t_begin + (t_end - t_begin) * part / parts : t_end;
        const double stop = next_stop(search, &burst_index, s->step.t, next, interval->shift);
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
    search->node[search->nodes].t = t_end + interval->shift;
    memcpy(search->node[search->nodes++].y, s->y, (size_t)search->system->n * sizeof *s->y);
    return STOP_END;
}

/* Orders bursts for qsort() by their begin. */
static int by_time(const void *a, const void *b)
{
    const double x = ((const struct burst *)a)->t_begin, y = ((const struct burst *)b)->t_begin;
    return (x > y) - (x < y);
}

/* Orders bursts for qsort() by their begin, latest first. */
static int by_time_back(const void *a, const void *b)
{
    return by_time(b, a);
}

/* Finds the bursts of the interval that was just crossed, which replace those from old_count on.
 * Returns false if it has none. */
static bool find_bursts(struct reference_search *search, int old_count)
{
    const bool forward = search->reference->span > 0;
    const int count = search->bursts;
    for (int i = 0; i + 1 < search->nodes; i++) {
        const struct reference_node *node = &search->node[i];
        const double t[2] = {node[0].t, node[1].t};
        if (t[0] != t[1])
            search->bursts =
                old_count + system_bursts(search->system, t, node[0].y, node[1].y, false,
                                          search->burst + old_count, search->bursts - old_count,
                                          BURSTS_MAX - old_count);
    }
    qsort(search->burst + old_count, (size_t)(search->bursts - old_count), sizeof *search->burst,
          forward ? by_time : by_time_back);
    return search->bursts > count || search->bursts > old_count;
}

/* Returns the largest relative difference between two states. */
static double state_change(const struct system *system, const double *a, const double *b)
{
    double max = 0;
    for (int i = 0; i < system->n; i++)
        max = fmax(max, fabs(a[i] - b[i]) / fmax(system->scale[i], fmax(fabs(a[i]), fabs(b[i]))));
    return max;
}

/* Crosses an interval, looks for bursts, and crosses it again from its begin with steps that end at
 * them, until that changes the state no more: a burst may lead to a state with other bursts. If the
 * first repetition changes nothing, the bursts had been resolved without help and are dropped.
 * Returns STOP_END, or why it stopped. */
static enum stop cross_bursts(struct reference_search *search, struct solver *s,
                              struct controller *controller,
                              const struct interval_of_grid *interval)
{
    const size_t size = (size_t)search->system->n * sizeof(double);
    const struct controller at_first = *controller;
    const int old_count = search->bursts;
    double y[LIMIT_VARIABLES], low[LIMIT_VARIABLES], last[LIMIT_VARIABLES];
    memcpy(y, s->y, size);
    memcpy(low, s->low, size);
    enum stop stop = cross_adaptive(search, s, controller, interval);
    for (int round = 0; round < BURST_ROUNDS && stop == STOP_END && find_bursts(search, old_count);
         round++) {
        memcpy(last, s->y, size);
        memcpy(s->y, y, size);
        memcpy(s->low, low, size);
        *controller = at_first;
        s->step.t = interval->t_begin;
        s->step.warm = s->step.again = false;
        stop = cross_adaptive(search, s, controller, interval);
        if (stop != STOP_END || state_change(search->system, s->y, last) >= SOLUTIONS_DISTANCE_MAX)
            continue;
        search->bursts = round == 0 ? old_count : search->bursts;
        break;
    }
    return stop;
}

/* Solves the system from its start and stores the state at each of the STUDY_TIMES grid times in
 * `grid` [STUDY_TIMES x n]; steps end exactly at these times. `steps` is the number of steps in an
 * interval, or 0 for adaptive steps. If the laws do not depend on time, the clock starts at 0 in
 * each interval, so that rounding of the time does not add up. The first adaptive solution of a
 * search also looks for bursts (search->bursts). Returns STOP_END, or the reason for an early stop.
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
        struct interval_of_grid interval = {begin, end, 0};
        if (anew)
            interval = (struct interval_of_grid){0, s->span / (STUDY_TIMES - 1), begin};
        s->step.t = interval.t_begin;
        s->step.warm = s->step.again = false;
        enum stop stop;
        if (steps > 0)
            stop = cross_fixed(search, s, &interval, steps);
        else if (looking)
            stop = cross_bursts(search, s, &controller, &interval);
        else
            stop = cross_adaptive(search, s, &controller, &interval);
        if (stop != STOP_END)
            return stop;
        if (cancelled(search->cancel))
            return STOP_CANCELLED;
        memcpy(grid + k * n, s->y, (size_t)n * sizeof *grid);
    }
    search->looked |= looking;
    return STOP_END;
}

/* Solves from start to end and stores the states at all grid times in grid [STUDY_TIMES][n]. */
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
