/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The trace: its creation, and reading it by row number, step and time. The last row is the present
 * state of the run. */
#include "run/private.h"

#include <stdlib.h>

size_t trace_row_bytes(int n, bool timed, bool indexed)
{
    return ((size_t)n + timed + indexed) * sizeof(double);
}

/* Sets the rule and the largest number of rows; memory of rows is allocated as they come. */
struct trace *trace_create(int n, bool timed, struct recording_rule rule, size_t memory)
{
    struct trace *trace = calloc(1, sizeof *trace);
    if (!trace)
        return NULL;
    trace->n = n;
    trace->interval = rule.rule == RECORD_TIMES ? rule.interval : 0;
    trace->timed = timed = timed || trace->interval > 0;
    trace->decimates = rule.rule == RECORD_AUTO;
    trace->every = rule.rule == RECORD_EVERY ? rule.every : 1;
    trace->width = (size_t)n + timed;
    trace->cap = (memory ? memory : MEMORY_DEFAULT) /
                 trace_row_bytes(n, timed, trace->decimates || rule.rule == RECORD_TIMES);
    if (trace->decimates) {
        /* Three rows a bucket must always fit into half of the cap, or decimating would not end. */
        if (trace->cap > LIMIT_SAMPLES)
            trace->cap = LIMIT_SAMPLES;
        else
            trace->cap = trace->cap < 64 ? 64 : trace->cap;
    }
    trace->bucket = 1;
    return trace;
}

void trace_present(struct trace *trace, int64_t step, double t, const double *y)
{
    trace->now_step = step;
    trace->now_t = t;
    memcpy(trace->now, y, (size_t)trace->n * sizeof *y);
}

/* Counts the present state, too, if it is not recorded. */
size_t trace_count(const struct trace *trace)
{
    const size_t last = trace->count - 1;
    const bool present = trace_row_step(trace, last) == trace->now_step &&
                         (trace->interval == 0 || even_present(trace, trace_time(trace, last)));
    return trace->count + !present;
}

int64_t trace_step(const struct trace *trace, size_t i)
{
    return i < trace->count ? trace_row_step(trace, i) : trace->now_step;
}

/* Returns the time of a row: stored, or computed from the grid. */
double trace_time(const struct trace *trace, size_t i)
{
    int64_t step = trace_step(trace, i);
    /* The present time is exact, which the time of the grid need not be. */
    if (trace->interval > 0 ? i >= trace->count : step == trace->now_step)
        return trace->now_t;
    if (trace->timed)
        return trace_row(trace, i)[trace->width - 1];
    return grid_time(trace_grid_of(trace, step), step);
}

const double *trace_state(const struct trace *trace, size_t i)
{
    return i < trace->count ? trace_row(trace, i) : trace->now;
}

const double *trace_state_after(const struct trace *trace, int64_t step)
{
    const bool recorded = !trace_indexed(trace) && step % trace->every == 0 &&
                          step / trace->every < (int64_t)trace->count;
    return recorded ? trace_row(trace, (size_t)(step / trace->every)) : NULL;
}

bool trace_decimated(const struct trace *trace)
{
    return trace->bucket > 1;
}

size_t trace_bytes(const struct trace *trace)
{
    return sizeof *trace + trace->capacity * sizeof *trace->chunk +
           trace->grid_capacity * sizeof *trace->grid + trace->pool.bytes + trace->mark_pool.bytes +
           (trace->mark ? trace->capacity * sizeof *trace->mark : 0) +
           (trace->index ? trace->capacity * sizeof *trace->index : 0);
}

/* Finds the first row of the step or a later one, by bisection. */
size_t trace_row_from(const struct trace *trace, int64_t step)
{
    size_t low = 0, high = trace->count;
    if (high > 0 && trace_row_step(trace, high - 1) < step)
        return high;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (trace_row_step(trace, middle) < step)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Finds the first row at or after time t in the run's direction, by bisection. */
size_t trace_row_at(const struct trace *trace, double t)
{
    const size_t n = trace_count(trace);
    const double way = n > 0 && trace_time(trace, n - 1) < trace_time(trace, 0) ? -1 : 1;
    size_t low = 0, high = n;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (way * trace_time(trace, middle) < way * t)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

const double *trace_rows(const struct trace *trace, size_t i, size_t end, size_t *count)
{
    const size_t in_chunk = CHUNK_ROWS - (i & (CHUNK_ROWS - 1));
    *count = end - i < in_chunk ? end - i : in_chunk;
    return trace_row(trace, i);
}
