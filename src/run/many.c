/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Whole steps of a fixed size in bulk: a kernel writes the states, where possible straight into the
 * trace. */
#include "run/private.h"

#include <math.h>
#include <stdlib.h>

/*
 * Are all numbers within the bound, which is repeated FOUR times? Magnitudes of doubles are ordered
 * like their bits, NaN above all: where one is too large, the difference to the bound is negative,
 * and that survives in a sum of bits.
 */
CLONES static bool all_within(const double *number, int64_t fours, const double *bound)
{
    const four_bits limit = *(const four_bits *)(const void *)bound;
    four_bits beyond = {0};
    for (int64_t i = 0; i < fours; i++)
        beyond |= limit - (*(const four_bits *)(const void *)(number + i * FOUR) & INT64_MAX);
    uint64_t any = 0;
    for (int k = 0; k < FOUR; k++)
        any |= beyond[k];
    return (int64_t)any >= 0;
}

/* How many of the rows are within bounds, counted from the first: nearly always all of them are
 * within the smallest bound. */
static int64_t rows_within(const double *row, int64_t count, int n, const double *bound)
{
    double least = bound[0], smallest[FOUR];
    for (int i = 1; i < n; i++)
        least = bound[i] < least ? bound[i] : least;
    for (int i = 0; i < FOUR; i++)
        smallest[i] = least;
    const int64_t fours = count * n / FOUR;
    int64_t within = all_within(row, fours, smallest) ? fours * FOUR / n : 0;
    for (; within < count; within++)
        for (int k = 0; k < n; k++)
            if (!(fabs(row[within * n + k]) <= bound[k]))
                return within;
    return count;
}

#define HOT_ROWS 1024 /* of two numbers: half of the fastest cache */

static int64_t min(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* The propagator for this step, made when it is first needed. */
static struct propagator *propagator_for(struct run *run, double h)
{
    struct run_private *p = run->private_state;
    if (p->propagator && propagator_step(p->propagator) != h) {
        free(p->propagator);
        p->propagator = NULL;
    }
    if (!p->propagator && run->plan.propagates)
        p->propagator = propagator_create(run, h);
    return p->propagator;
}

/* After going back in the middle of a block: where it began was recorded, and belongs to the same
 * scene. */
static void find_block(struct run *run, const struct segment *segment, int64_t step)
{
    struct propagator *propagator = run->private_state->propagator;
    const int64_t begin = segment->grid.first + propagator_block(step);
    const double *state = trace_state_after(run->trace, begin);
    if (!propagator_knows(propagator, step) && state &&
        run->private_state->epoch[run->private_state->epochs - 1].first <= begin)
        propagator_anchor(propagator, propagator_block(step), state);
}

void run_give(struct run *run, const double *row, int64_t count)
{
    run->private_state->given = row;
    run->private_state->given_first = run->steps;
    run->private_state->given_end = run->steps + count;
}

/* Steps that are given instead of taken. */
static int64_t take_given(struct run *run, const struct march *march)
{
    struct run_private *p = run->private_state;
    const size_t n = (size_t)run->system.n, size = n * sizeof(double);
    const int64_t taken = min(march->count, p->given_end - run->steps);
    memcpy(march->row, p->given + (size_t)(run->steps - p->given_first) * n, (size_t)taken * size);
    memcpy(run->y, march->row + (size_t)(taken - 1) * n, size);
    p->step.warm = false;
    return taken;
}

/* Steps by the method, those beyond a state that has diverged as if they had not been taken: what a
 * run costs depends on neither the kernel nor on how many steps are taken at once. *good: those
 * before it. */
static int64_t march_within(struct run *run, struct march *march, enum step_status *status,
                            int64_t *good)
{
    struct run_private *p = run->private_state;
    const int n = run->system.n;
    const bool restores = !(run->method->flags & METHOD_EXTERNAL);
    const size_t size = method_work_size(run->method, n) * sizeof *p->work;
    const struct step was = p->step;
    const struct switches_state switches = run->controller.switches;
    if (restores)
        memcpy(p->work_before, p->work, size);
    int64_t taken = method_turning_march(run->method, p->kernel, march, status);
    *good = rows_within(march->row, taken, n, p->bound);
    if (restores && *good + 1 < taken + (*status != STEP_OK)) {
        p->step = was;
        run->controller.switches = switches;
        copy_state(run->y, p->before, n);
        memcpy(p->work, p->work_before, size);
        march->count = *good + 1;
        taken = method_turning_march(run->method, p->kernel, march, status);
    }
    return taken;
}

bool advance_many(struct run *run, const struct segment *segment, enum stop *stop)
{
    struct run_private *p = run->private_state;
    const int n = run->system.n;
    const int64_t left = min(segment->limit, segment->last) - run->steps;
    if (run->plan.adaptive || segment->target->condition || segment->target->events > 0 ||
        p->step.low || left <= 0 || segment->between || ledger_is_due(run))
        return false;

    if (!p->work_before &&
        !(p->work_before = malloc(method_work_size(run->method, n) * sizeof *p->work + 1)))
        return false;
    size_t capacity = CHUNK_ROWS;
    double *in_trace = trace_open(run->trace, &capacity), *row = in_trace;
    if (!row) {
        if (!p->scratch && !(p->scratch = malloc(CHUNK_ROWS * (size_t)n * sizeof *p->scratch)))
            return false;
        row = p->scratch;
    }
    copy_state(p->before, run->y, n);
    p->step.h = segment->grid.h;
    struct march march = {.step = &p->step,
                          .origin = segment->grid.origin,
                          .first = run->steps - segment->grid.first,
                          .count = min(min(left, p->batch), (int64_t)capacity),
                          .row = row};
    enum step_status status = STEP_OK;
    struct propagator *propagator = propagator_for(run, segment->grid.h);
    if (!propagator)
        march.count = min(march.count, HOT_ROWS);
    if (propagator)
        find_block(run, segment, march.first);
    int64_t taken = propagator ? propagate(propagator, march.first, march.count, run->y, row) : 0,
            good = -1;
    const bool propagated = taken > 0;
    if (propagated) {
        p->step.warm = false;
    } else if (run->steps < p->given_end) {
        taken = take_given(run, &march);
    } else {
        /* In a block that is not known: by steps, but only to its end, however the calls are cut.
         */
        if (propagator)
            march.count = min(march.count, propagator_rest(march.first));
        taken = march_within(run, &march, &status, &good);
    }
    if (good < 0)
        good = propagated && propagator_within(propagator, p->bound)
                   ? taken
                   : rows_within(row, taken, n, p->bound);
    *stop = good < taken ? STOP_DIVERGED : stop_of_step(status);
    if (in_trace) {
        trace_close(run->trace, (size_t)good);
    } else {
        const int64_t recorded = trace_record_many(run->trace, run->steps + 1, row, good);
        if (recorded < good)
            *stop = STOP_FULL;
        good = recorded;
        ledger_take(run, row, good);
    }
    if (good < march.count && *stop != STOP_NONE) { /* back to the last good state */
        copy_state(run->y, good > 0 ? row + (good - 1) * n : p->before, n);
        p->step.warm = false;
    }
    run->steps += good;
    if (good > 0)
        run->t = segment->exact && run->steps == segment->last
                     ? segment->target->t
                     : grid_time(&segment->grid, run->steps);
    return true;
}
