/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Batches of steps, fixed or adaptive: a kernel writes the states, directly into the trace if every
 * step is recorded, else into memory from which rows are chosen. advance_many() is the entry; what
 * it does is the same, to the bit, as single steps by advance_step(). */
#include "run/private.h"

#include <math.h>
#include <stdlib.h>

/* Returns true if the magnitudes of all 4 fours numbers are within the bound, which is repeated
 * VECTOR_LANES times. Magnitudes of doubles are ordered like their bits as integers, NaN above all:
 * where one is too large, the difference from the bound is negative, and its sign survives in an OR
 * of all differences. */
CLONES static bool all_within(const double *number, int64_t fours, const double *bound)
{
    const four_bits limit = *(const four_bits *)(const void *)bound;
    four_bits exceeded = {0};
    for (int64_t i = 0; i < fours; i++)
        exceeded |=
            limit - (*(const four_bits *)(const void *)(number + i * VECTOR_LANES) & INT64_MAX);
    uint64_t any = 0;
    for (int k = 0; k < VECTOR_LANES; k++)
        any |= exceeded[k];
    return (int64_t)any >= 0;
}

/* Returns the number of rows within bounds, counted from the first. Nearly always all of them are
 * within the smallest bound, which is checked first because it is fast. */
static int64_t rows_within(const double *row, int64_t count, int n, const double *bound)
{
    double least = bound[0], smallest[VECTOR_LANES];
    for (int i = 1; i < n; i++)
        least = bound[i] < least ? bound[i] : least;
    for (int i = 0; i < VECTOR_LANES; i++)
        smallest[i] = least;
    const int64_t fours = count * n / VECTOR_LANES;
    int64_t accepted = all_within(row, fours, smallest) ? fours * VECTOR_LANES / n : 0;
    for (; accepted < count; accepted++)
        for (int k = 0; k < n; k++)
            if (!(fabs(row[accepted * n + k]) <= bound[k]))
                return accepted;
    return count;
}

/* Largest number of rows in a batch by a kernel: rows of two numbers fill half of the fastest
 * cache. */
#define HOT_ROWS 1024

static int64_t min_steps(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* Returns the propagator for steps of h, which is made if there is none for this step; NULL if the
 * scene has none or out of memory. */
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

/* Gives the propagator the state at the beginning of the block that contains `step`, if the
 * propagator lacks it and the trace has it: after run_back() the run may be in the middle of a
 * block. The state must belong to the present epoch, because earlier ones had another scene or
 * step. */
static void propagator_block_find(struct run *run, const struct segment *segment, int64_t step)
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

/* Copies states that run_give() has provided into march->row, instead of computing them. Returns
 * how many. */
static int64_t given_steps_copy(struct run *run, const struct march *march)
{
    struct run_private *p = run->private_state;
    const size_t n = (size_t)run->system.n, size = n * sizeof(double);
    const int64_t taken = min_steps(march->count, p->given_end - run->steps);
    memcpy(march->row, p->given + (size_t)(run->steps - p->given_first) * n, (size_t)taken * size);
    memcpy(run->y, march->row + (size_t)(taken - 1) * n, size);
    p->step.warm = false;
    return taken;
}

/* Takes up to march->count fixed steps. If a state diverges before the last step, the march is
 * repeated up to that state, so that the cost of a run depends neither on the kernel nor on the
 * size of batches. Sets *status to that of the last step and *good to the number of steps before
 * the diverging state; returns the number of steps taken. */
static int64_t march_within(struct run *run, struct march *march, enum step_status *status,
                            int64_t *good)
{
    struct run_private *p = run->private_state;
    const int n = run->system.n;
    const bool restores = !(run->method->flags & METHOD_EXTERNAL);
    const size_t size = method_work_size(run->method, n) * sizeof *p->work;
    const struct step saved_step = p->step;
    const struct switches_state switches = run->controller.switches;
    int64_t taken = method_turning_march(run->method, p->kernel, march, status);
    *good = rows_within(march->row, taken, n, p->bound);
    if (restores && *good + 1 < taken + (*status != STEP_OK)) {
        p->step = saved_step;
        run->controller.switches = switches;
        copy_state(run->y, p->previous_state, n);
        memcpy(p->work, p->work_before, size);
        march->count = *good + 1;
        taken = method_turning_march(run->method, p->kernel, march, status);
    }
    return taken;
}

/* Copies the working memory of the method to p->work_before, so that a batch can be taken back.
 * Returns false if out of memory. */
static bool method_work_save(struct run *run)
{
    struct run_private *p = run->private_state;
    const size_t size = method_work_size(run->method, run->system.n) * sizeof *p->work;
    if (!p->work_before)
        p->work_before = malloc(size + 1);
    if (p->work_before)
        memcpy(p->work_before, p->work, size);
    return p->work_before;
}

/* Returns memory for *capacity rows of `width` numbers: in the trace, and sets *in_trace, if it
 * keeps every step unchanged, else p->scratch, which is used again. Returns NULL if out of
 * memory. */
static double *batch_rows_open(struct run *run, size_t width, size_t *capacity, bool *in_trace)
{
    struct run_private *p = run->private_state;
    double *row = trace_open(run->trace, width, capacity);
    *in_trace = row;
    if (row)
        return row;
    *capacity = CHUNK_ROWS;
    if (!p->scratch)
        p->scratch = malloc(CHUNK_ROWS * width * sizeof *p->scratch);
    return p->scratch;
}

/* State of the solver before a batch of adaptive steps, beside run_private's previous_state and
 * work_before. */
struct adapted_from {
    struct step step;
    struct controller controller;
};

/* Takes a batch of adaptive steps back to `saved`, and makes only the first `count` of its steps
 * again. */
static void adaptive_batch_repeat(struct run *run, const struct adapted_from *saved, double end,
                                  int64_t count, double *row)
{
    struct run_private *p = run->private_state;
    enum step_status status;
    p->step = saved->step;
    copy_state(run->y, p->previous_state, run->system.n);
    memcpy(p->work, p->work_before, method_work_size(run->method, run->system.n) * sizeof *p->work);
    controller_copy(&run->controller, &saved->controller, &run->system);
    if (count > 0)
        method_adapt_many(&p->step, &run->controller, end, count, row, &status);
}

/* Takes up to `count` adaptive steps towards time `end`, writes their states and times to row
 * [count][n + 1] and records them; in_trace tells that row is memory of the trace. Ends before the
 * first step that is out of bounds or has no room, and sets *stop if the run has to stop. Returns
 * the number of steps; the run's state is then that after the last of them. */
static int64_t adapt_within(struct run *run, double end, int64_t count, double *row, bool in_trace,
                            enum stop *stop)
{
    struct run_private *p = run->private_state;
    const int n = run->system.n;
    struct adapted_from saved = {.step = p->step};
    enum step_status status = STEP_OK;
    double bound[LIMIT_VARIABLES + 1];
    copy_state(bound, p->bound, n);
    bound[n] = HUGE_VAL; /* bound of the time */
    controller_copy(&saved.controller, &run->controller, &run->system);
    copy_state(p->previous_state, run->y, n);
    const int64_t taken = method_adapt_many(&p->step, &run->controller, end, count, row, &status);
    int64_t good = rows_within(row, taken, n + 1, bound);
    /* All states are within bounds, so the status of the last step is the reason to stop. */
    if (good == taken && good > 0)
        *stop = stop_of_step(status);
    if (good > 0)
        row[good * (n + 1) - 1] = run_arrival(row[good * (n + 1) - 1], end);
    if (in_trace) {
        trace_close(run->trace, (size_t)good);
    } else {
        const int64_t recorded = trace_record_many(run->trace, run->steps + 1, row, good);
        *stop = recorded < good ? STOP_FULL : *stop;
        good = recorded;
    }
    if (good < taken || good == 0)
        adaptive_batch_repeat(run, &saved, end, good, row);
    return good;
}

/* Takes a batch of adaptive steps in one call, not beyond the segment's limit or the next check for
 * a singularity. *stop receives the reason if the run stops, else is unchanged. Returns false if no
 * step was taken, so that the next one has to be taken alone. */
static bool adapt_many(struct run *run, const struct segment *segment, enum stop *stop)
{
    struct run_private *p = run->private_state;
    const int n = run->system.n;
    const size_t width = (size_t)n + 1;
    const double end = segment->target->t;
    const int64_t left = min_steps(segment->limit, p->look) - run->steps;
    size_t capacity = 0;
    bool in_trace;
    if (!method_adapts_many(&p->step, &run->controller) || run->t == end || left <= 0)
        return false;
    double *row = batch_rows_open(run, width, &capacity, &in_trace);
    if (!row || !method_work_save(run))
        return false;
    p->step.t = run->t;
    const int64_t count = min_steps(min_steps(left, p->batch), (int64_t)capacity),
                  good = adapt_within(run, end, count, row, in_trace, stop);
    if (good == 0)
        return false; /* the single step that follows finds the reason */
    const double *last = row + (size_t)(good - 1) * width;
    p->gap_known = false;
    if (good > 1)
        copy_state(p->previous_state, last - width, n);
    if (!in_trace)
        ledger_take(run, row, row + n, width, good);
    run->steps += good;
    run->t = last[n];
    if (*stop != STOP_NONE)
        copy_state(p->previous_state, run->y, n);
    else if (run_creeps(run))
        *stop = STOP_SINGULAR;
    return true;
}

/* Makes a batch by the propagator, by states that were given, or by the method's kernel; then
 * checks bounds, records the rows, and takes back what diverged or had no room. */
bool advance_many(struct run *run, const struct segment *segment, enum stop *stop)
{
    struct run_private *p = run->private_state;
    const int n = run->system.n;
    const int64_t left = min_steps(segment->limit, segment->last) - run->steps;
    if (segment->target->condition || segment->target->events > 0 || segment->rows_between_steps ||
        ledger_is_due(run))
        return false;
    if (run->plan.adaptive)
        return adapt_many(run, segment, stop);
    if (p->step.low || left <= 0 || !method_work_save(run))
        return false;
    size_t capacity = 0;
    bool in_trace;
    double *row = batch_rows_open(run, (size_t)n, &capacity, &in_trace);
    if (!row)
        return false;
    copy_state(p->previous_state, run->y, n);
    p->step.h = segment->grid.h;
    struct march march = {.step = &p->step,
                          .origin = segment->grid.origin,
                          .first = run->steps - segment->grid.first,
                          .count = min_steps(min_steps(left, p->batch), (int64_t)capacity),
                          .row = row};
    enum step_status status = STEP_OK;
    struct propagator *propagator = propagator_for(run, segment->grid.h);
    if (!propagator)
        march.count = min_steps(march.count, HOT_ROWS);
    if (propagator)
        propagator_block_find(run, segment, march.first);
    int64_t taken = propagator
                        ? propagator_advance(propagator, march.first, march.count, run->y, row)
                        : 0,
            good = -1;
    const bool propagated = taken > 0;
    if (propagated) {
        p->step.warm = false;
    } else if (run->steps < p->given_end) {
        taken = given_steps_copy(run, &march);
    } else {
        /* The propagator does not know this block: the method makes its steps, but only to the end
         * of the block, so that the states do not depend on how the run is cut into calls. */
        if (propagator)
            march.count = min_steps(march.count, propagator_rest(march.first));
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
        ledger_take(run, row, NULL, (size_t)n, good);
    }
    if (good < march.count && *stop != STOP_NONE) { /* back to the last good state */
        copy_state(run->y, good > 0 ? row + (good - 1) * n : p->previous_state, n);
        p->step.warm = false;
    }
    run->steps += good;
    if (good > 0)
        run->t = segment->exact && run->steps == segment->last
                     ? segment->target->t
                     : grid_time(&segment->grid, run->steps);
    return true;
}
