/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The trace: memory of rows in chunks, marks, which are the energy balance at each row, and
 * recording of steps by the rule. trace_read.c reads it, decimation.c thins it. */
#include "run/private.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

/* ---- rows ---- */

static void free_marks(struct trace *trace);

/* Frees the trace with all rows. */
void trace_destroy(struct trace *trace)
{
    if (!trace)
        return;
    pool_release(&trace->pool);
    free_marks(trace);
    free(trace->chunk);
    free(trace->index);
    free(trace->grid);
    free(trace);
}

/* A chunk of steps for each chunk of rows. */
bool trace_grow_index(struct trace *trace)
{
    int64_t **index = realloc(trace->index, trace->capacity * sizeof *index);
    if (!index)
        return false;
    trace->index = index;
    for (; trace->indices < trace->chunks; trace->indices++)
        if (!(index[trace->indices] = pool_take(&trace->pool, CHUNK_ROWS * sizeof **index)))
            return false;
    return true;
}

/* ---- marks: the first numbers of a tally ---- */

#define MARK_EXTREMES 2 /* numbers of a mark without work: max and scale */
#define MARK_WORK 6     /* numbers of a mark with work */
_Static_assert(sizeof(struct energy_tally) == MARK_WORK * sizeof(double),
               "a mark is the beginning of a ledger");

bool trace_marked(const struct trace *trace)
{
    return trace->mark_width > 0;
}

/* Returns the numbers of the mark of row i, trace->mark_width of them. */
static double *mark_at(const struct trace *trace, size_t i)
{
    assert(trace->mark);
    return trace->mark[i >> CHUNK_SHIFT] + (i & (CHUNK_ROWS - 1)) * trace->mark_width;
}

/* Returns the mark of row i as a tally, all 0 if rows have none. */
struct energy_tally trace_mark(const struct trace *trace, size_t i)
{
    struct energy_tally tally = {0};
    if (trace->mark_width == MARK_WORK)
        memcpy(&tally, mark_at(trace, i), MARK_WORK * sizeof(double));
    else if (trace_marked(trace))
        memcpy(&tally, mark_at(trace, i), MARK_EXTREMES * sizeof(double));
    return tally;
}

/* Writes as much of the tally as marks have. */
void trace_set_mark(struct trace *trace, size_t i, const struct energy_tally *tally)
{
    trace_touch(trace, i);
    if (trace->mark_width == MARK_WORK)
        memcpy(mark_at(trace, i), tally, MARK_WORK * sizeof(double));
    else
        memcpy(mark_at(trace, i), tally, MARK_EXTREMES * sizeof(double));
}

/* Makes room for the marks of the rows in all chunks. Returns false if out of memory. */
static bool marks_grow(struct trace *trace)
{
    const size_t bytes = CHUNK_ROWS * trace->mark_width * sizeof(double);
    double **mark = realloc(trace->mark, trace->capacity * sizeof *mark);
    if (!mark)
        return false;
    trace->mark = mark;
    for (; trace->marks < trace->chunks; trace->marks++)
        if (!(mark[trace->marks] = pool_take(&trace->mark_pool, bytes)))
            return false;
    return true;
}

/* Frees the marks; the caller sets trace->mark. */
static void free_marks(struct trace *trace)
{
    pool_release(&trace->mark_pool);
    free(trace->mark);
}

void trace_forget_marks(struct trace *trace)
{
    free_marks(trace);
    trace->mark = NULL;
    trace->marks = trace->mark_width = 0;
    trace_touch(trace, 0);
}

/* Makes marks of a larger width and copies those that there are. */
bool trace_mark_rows(struct trace *trace, bool work)
{
    struct trace made = *trace;
    if (trace->mark_width >= (work ? MARK_WORK : MARK_EXTREMES))
        return true;
    made.mark = NULL;
    made.mark_pool = (struct pool){0};
    made.marks = 0;
    made.mark_width = work ? MARK_WORK : MARK_EXTREMES;
    if (made.chunks > 0 && !marks_grow(&made)) {
        free_marks(&made);
        return false;
    }
    for (size_t i = 0; i < trace->count; i++) {
        const struct energy_tally mark = trace_marked(trace) ? trace_mark(trace, i) : unknown_tally;
        trace_set_mark(&made, i, &mark);
    }
    free_marks(trace);
    *trace = made;
    trace_touch(trace, 0);
    return true;
}

/* Adds a chunk of rows. Returns false if out of memory. */
static bool trace_chunks_grow(struct trace *trace)
{
    if (trace->chunks == trace->capacity) {
        size_t capacity = trace->capacity ? trace->capacity * 2 : 16;
        double **chunk = realloc(trace->chunk, capacity * sizeof *chunk);
        if (!chunk)
            return false;
        trace->chunk = chunk;
        trace->capacity = capacity;
    }
    double *rows = pool_take(&trace->pool, CHUNK_ROWS * trace->width * sizeof *rows);
    if (!rows)
        return false;
    trace->chunk[trace->chunks++] = rows;
    return true;
}

/* Adds a chunk of rows, of marks and of steps if the next rows need them. */
bool trace_reserve_rows(struct trace *trace, size_t rows)
{
    const size_t needed = ((trace->count + rows - 1) >> CHUNK_SHIFT) + 1;
    return (needed <= trace->chunks || trace_chunks_grow(trace)) &&
           (!trace_marked(trace) || needed <= trace->marks || marks_grow(trace)) &&
           (!trace_indexed(trace) || needed <= trace->indices || trace_grow_index(trace));
}

/* Writes state, step, time and mark of row i, as far as rows have them. */
void trace_write_row(struct trace *trace, size_t i, int64_t step, double t, const double *y,
                     const struct energy_tally *mark)
{
    double *row = trace_row(trace, i);
    trace_touch(trace, i);
    copy_state(row, y, trace->n);
    if (trace_indexed(trace))
        trace->index[i >> CHUNK_SHIFT][i & (CHUNK_ROWS - 1)] = step;
    if (trace->timed)
        row[trace->n] = t;
    if (trace_marked(trace))
        trace_set_mark(trace, i, mark);
}

/* Adds a row at the end. Returns false if out of memory. */
static bool row_append(struct trace *trace, int64_t step, double t, const double *y,
                       const struct energy_tally *mark)
{
    if (!trace_reserve_rows(trace, 1))
        return false;
    trace_write_row(trace, trace->count++, step, t, y, mark);
    return true;
}

void trace_clear_rows(struct trace *trace)
{
    pool_release(&trace->pool);
    pool_release(&trace->mark_pool);
    trace->chunks = trace->indices = trace->marks = trace->count = trace->stored = 0;
}

bool trace_put_row(struct trace *trace, int64_t step, const double *row,
                   const struct energy_tally *mark)
{
    return row_append(trace, step, row[trace->width - 1], row, mark);
}

/* ---- recording ---- */

bool trace_append(struct trace *trace, int64_t step, double t, const double *y)
{
    return trace->count < trace->cap && row_append(trace, step, t, y, &unknown_tally);
}

/* Records the state if the rule asks for it, and decimates the trace if it is full. */
bool trace_record(struct trace *trace, int64_t step, double t, const double *y)
{
    /* even_record() records rows at even times, but for the first one. */
    if (trace->interval > 0 && trace->count > 0)
        return true;
    if (trace->count == 0)
        trace->origin = t;
    if (!trace->decimates && step != trace->next)
        return true;
    if (trace->count == trace->cap && !(trace->decimates && trace_coarsen(trace)))
        return false;
    if (!(trace->bucket > 1 ? trace_keep(trace, step, t, y)
                            : row_append(trace, step, t, y, &unknown_tally)))
        return false;
    trace->next = step + trace->every;
    return true;
}

/* Returns the next rows of the present chunk, if a kernel can write them directly. */
double *trace_open(struct trace *trace, size_t width, size_t *rows)
{
    if (trace->bucket > 1 || trace->every > 1 || trace->width != width || trace_marked(trace) ||
        trace->count >= trace->cap || !trace_reserve_rows(trace, 1))
        return NULL;
    size_t in_chunk = CHUNK_ROWS - (trace->count & (CHUNK_ROWS - 1)),
           to_cap = trace->cap - trace->count;
    *rows = in_chunk < to_cap ? in_chunk : to_cap;
    return trace_row(trace, trace->count);
}

void trace_close(struct trace *trace, size_t rows)
{
    trace->count += rows;
    trace->next = (int64_t)trace->count;
}

/* Drops the rows after row i, and the grids and buckets that began after it. */
void trace_truncate(struct trace *trace, size_t i)
{
    if (i < trace->count) {
        trace->now_t = trace_time(trace, i);
        trace->now_step = trace_row_step(trace, i);
        memcpy(trace->now, trace_row(trace, i), (size_t)trace->n * sizeof(double));
        trace->count = i + 1;
        trace_touch(trace, trace->count);
        trace->next = (int64_t)trace->count * trace->every;
    }
    /* A trace with only its first row is not decimated. */
    if (i == 0)
        trace->bucket = 1;
    while (trace->grids > 1 && trace_grid(trace)->first > trace->now_step)
        trace->grids--;
    if (trace->bucket > 1)
        trace_find_tail(trace, trace->now_step & ~(trace->bucket - 1));
}
