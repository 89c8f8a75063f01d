/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rows at even times, origin + k interval (RECORD_TIMES). A row in the middle of a step lies on its
 * dense output; where a step ends at such a time but for rounding, the row is the state that was
 * computed. even_record() records step by step, trace_record_even() many steps that end at rows. */
#include "run/private.h"

#include <float.h>
#include <math.h>

/* Returns the difference [s] up to which two times near t count as equal: both the grid of steps
 * and that of rows are sums of rounded numbers. */
static double time_tolerance(const struct trace *trace, double t)
{
    return 8 * DBL_EPSILON * fmax(fabs(t), fabs(trace->origin));
}

/* Returns the time [s] of the next row. */
static double due_time(const struct trace *trace)
{
    return trace->origin + trace->due * trace->interval;
}

/* Sets the next row to the first one after t in the direction of h. */
void trace_aim(struct trace *trace, double t, double h)
{
    trace->ahead = h < 0 ? -1 : 1;
    trace->due = trace->ahead * (floor(trace->ahead * ((t - trace->origin) / trace->interval)) - 1);
    /* The quotient is rounded, so that `due` may be a few rows too early. The number of corrections
     * is limited because they would never end if the interval is below the rounding of t. */
    for (int i = 0; i < 4 && (due_time(trace) - t) * trace->ahead <= time_tolerance(trace, t); i++)
        trace->due += trace->ahead;
}

/* Returns true if the interval of rows is a whole number of steps and rows are at ends of steps. */
bool trace_in_step(struct trace *trace)
{
    const struct time_grid *grid = trace_grid(trace);
    const double every = nearbyint(trace->interval / fabs(grid->h)), due = due_time(trace),
                 steps = nearbyint((due - grid->origin) / grid->h);
    if (!(every >= 1 && every < LIMIT_STEPS && steps < LIMIT_STEPS) ||
        fabs(every * fabs(grid->h) - trace->interval) > 2 * DBL_EPSILON * trace->interval)
        return false;
    trace->every = (int64_t)every;
    trace->next = grid->first + (int64_t)steps;
    return fabs(grid_time(grid, trace->next) - due) <= time_tolerance(trace, due);
}

/* Records y as the row that is due and moves on to the next one. Returns false if the trace is full
 * or out of memory. */
static bool due_row_append(struct trace *trace, int64_t step, const double *y)
{
    if (!trace_append(trace, step, due_time(trace), y))
        return false;
    trace->due += trace->ahead;
    trace->next += trace->every;
    return true;
}

/* Records those of `count` steps that are due; returns how many steps were passed. */
int64_t trace_record_even(struct trace *trace, int64_t step, const double *row, int64_t count)
{
    while (trace->next < step + count)
        if (!due_row_append(trace, trace->next, row + (trace->next - step) * trace->n))
            return trace->next - step;
    return count;
}

/* Records all rows that are due in the last step, each by the state inside of the step. */
enum stop even_record(struct run *run, bool cold, double t, double h)
{
    struct trace *trace = run->trace;
    const double t_tolerance = time_tolerance(trace, run->t);
    for (double due; due = due_time(trace), (due - run->t) * trace->ahead <= t_tolerance;) {
        double inside[LIMIT_VARIABLES];
        const bool end = fabs(due - run->t) <= t_tolerance;
        if (!end) {
            const struct inside step = inside_of(run, cold, t, h);
            inside_state(&step, (due - t) / h, inside);
            if (!run_in_bounds(run, inside))
                return STOP_DIVERGED;
        }
        if (!due_row_append(trace, run->steps, end ? run->y : inside))
            return STOP_FULL;
        if (!end)
            ledger_inside(run, due, inside);
    }
    return STOP_NONE;
}

/* Drops the rows after time t, and makes them due again. */
void even_drop(struct trace *trace, double t)
{
    for (; trace->count > 1; trace->count--) {
        const double last = trace_time(trace, trace->count - 1);
        if ((last - t) * trace->ahead <= time_tolerance(trace, t))
            return;
        trace->due -= trace->ahead;
        trace->next -= trace->every;
        trace->stored = trace->count - 1 < trace->stored ? trace->count - 1 : trace->stored;
    }
}

bool even_present(const struct trace *trace, double row_time)
{
    return fabs(row_time - trace->now_t) <= time_tolerance(trace, trace->now_t);
}
