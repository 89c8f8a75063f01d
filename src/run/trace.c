/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The trace: rows in chunks, decimation that keeps every peak, times from grids. */
#include "run/private.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

/* ---- rows ---- */

static void free_marks(struct trace *trace);

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

/* A chunk of steps for each chunk of rows: only a decimated trace needs them. */
static bool grow_index(struct trace *trace)
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

#define MARK_EXTREMES 2
#define MARK_WORK 6
_Static_assert(sizeof(struct energy_tally) == MARK_WORK * sizeof(double),
               "a mark is the beginning of a tally");

bool trace_marked(const struct trace *trace)
{
    return trace->mark_width > 0;
}

static double *mark_at(const struct trace *trace, size_t i)
{
    assert(trace->mark);
    return trace->mark[i >> CHUNK_SHIFT] + (i & (CHUNK_ROWS - 1)) * trace->mark_width;
}

struct energy_tally trace_mark(const struct trace *trace, size_t i)
{
    struct energy_tally tally = {0};
    if (trace->mark_width == MARK_WORK)
        memcpy(&tally, mark_at(trace, i), MARK_WORK * sizeof(double));
    else if (trace_marked(trace))
        memcpy(&tally, mark_at(trace, i), MARK_EXTREMES * sizeof(double));
    return tally;
}

/* Row i changes. */
static inline void touch(struct trace *trace, size_t i)
{
    trace->stored = i < trace->stored ? i : trace->stored;
}

void trace_set_mark(struct trace *trace, size_t i, const struct energy_tally *tally)
{
    touch(trace, i);
    if (trace->mark_width == MARK_WORK)
        memcpy(mark_at(trace, i), tally, MARK_WORK * sizeof(double));
    else
        memcpy(mark_at(trace, i), tally, MARK_EXTREMES * sizeof(double));
}

static bool grow_marks(struct trace *trace)
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

static const struct energy_tally unknown = {.scale = -1};

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
    touch(trace, 0);
}

bool trace_mark_rows(struct trace *trace, bool work)
{
    struct trace made = *trace;
    if (trace->mark_width >= (work ? MARK_WORK : MARK_EXTREMES))
        return true;
    made.mark = NULL;
    made.mark_pool = (struct pool){0};
    made.marks = 0;
    made.mark_width = work ? MARK_WORK : MARK_EXTREMES;
    if (made.chunks > 0 && !grow_marks(&made)) {
        free_marks(&made);
        return false;
    }
    for (size_t i = 0; i < trace->count; i++) {
        const struct energy_tally mark = trace_marked(trace) ? trace_mark(trace, i) : unknown;
        trace_set_mark(&made, i, &mark);
    }
    free_marks(trace);
    *trace = made;
    touch(trace, 0);
    return true;
}

static bool grow(struct trace *trace)
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

/* Makes room for a few more rows. */
static bool reserve_rows(struct trace *trace, size_t rows)
{
    const size_t needed = ((trace->count + rows - 1) >> CHUNK_SHIFT) + 1;
    return (needed <= trace->chunks || grow(trace)) &&
           (!trace_marked(trace) || needed <= trace->marks || grow_marks(trace)) &&
           (!trace_indexed(trace) || needed <= trace->indices || grow_index(trace));
}

static void write_row(struct trace *trace, size_t i, int64_t step, double t, const double *y,
                      const struct energy_tally *mark)
{
    double *row = trace_row(trace, i);
    touch(trace, i);
    copy_state(row, y, trace->n);
    if (trace_indexed(trace))
        trace->index[i >> CHUNK_SHIFT][i & (CHUNK_ROWS - 1)] = step;
    if (trace->timed)
        row[trace->n] = t;
    if (trace_marked(trace))
        trace_set_mark(trace, i, mark);
}

static bool append(struct trace *trace, int64_t step, double t, const double *y,
                   const struct energy_tally *mark)
{
    if (!reserve_rows(trace, 1))
        return false;
    write_row(trace, trace->count++, step, t, y, mark);
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
    return append(trace, step, row[trace->width - 1], row, mark);
}

/* ---- decimation ----
 *
 * A bucket of 2^k steps keeps its first row and those of smallest and largest position (of equals
 * the earliest). Merging two buckets gives the rows that one bucket of twice the size would have
 * kept, so the trace depends on the step count only.
 */

static bool keep(struct trace *trace, int64_t step, double t, const double *y,
                 const struct energy_tally *mark)
{
    if (step >= trace->tail_end) {
        if (!append(trace, step, t, y, mark))
            return false;
        trace->tail = trace->low = trace->high = trace->count - 1;
        trace->tail_end = (step | (trace->bucket - 1)) + 1;
        return true;
    }
    size_t *extreme, *other = &trace->low;
    if (y[0] < trace_row(trace, trace->low)[0]) {
        extreme = &trace->low;
        other = &trace->high;
    } else if (y[0] > trace_row(trace, trace->high)[0]) {
        extreme = &trace->high;
    } else {
        return true;
    }
    if (*extreme == trace->tail) {
        if (!append(trace, step, t, y, mark))
            return false;
    } else { /* its row goes; at most the other extreme stands after it */
        if (*other > *extreme) {
            const double *row = trace_row(trace, *other);
            const struct energy_tally mark_of_other = trace_mark(trace, *other);
            write_row(trace, *extreme, trace_row_step(trace, *other), row[trace->width - 1], row,
                      &mark_of_other);
            *other = *extreme;
        }
        write_row(trace, trace->count - 1, step, t, y, mark);
    }
    *extreme = trace->count - 1;
    return true;
}

static inline int64_t *step_at(const struct trace *trace, size_t i)
{
    return &trace->index[i >> CHUNK_SHIFT][i & (CHUNK_ROWS - 1)];
}

/* The rows that stay of those of one bucket, in order; before they have moved, row i is where step
 * i was recorded. Returns how many; *end: the first row of the next bucket. */
static int stay(const struct trace *trace, size_t first, size_t count, int64_t bucket, bool moved,
                size_t *end, size_t *row)
{
    const int64_t next = (*step_at(trace, first) | (bucket - 1)) + 1;
    size_t low = first, high = first, i = first + 1;
    double min = trace_row(trace, moved ? first : (size_t)*step_at(trace, first))[0], max = min;
    for (; i < count && *step_at(trace, i) < next; i++) {
        const double y = trace_row(trace, moved ? i : (size_t)*step_at(trace, i))[0];
        if (y < min) {
            min = y;
            low = i;
        } else if (y > max) {
            max = y;
            high = i;
        }
    }
    int rows = 1;
    row[0] = first;
    for (int k = 0; k < 2; k++) {
        const size_t extreme = (k == 0) == (low < high) ? low : high;
        if (extreme != first)
            row[rows++] = extreme;
    }
    *end = i;
    return rows;
}

/* Finds the rows of the last bucket again. */
static void find_tail(struct trace *trace, int64_t begin)
{
    trace->tail_end = begin + trace->bucket;
    trace->tail = trace->count - 1;
    while (trace->tail > 0 && trace_row_step(trace, trace->tail - 1) >= begin)
        trace->tail--;
    trace->low = trace->high = trace->tail;
    for (size_t k = trace->tail + 1; k < trace->count; k++) {
        if (trace_row(trace, k)[0] < trace_row(trace, trace->low)[0])
            trace->low = k;
        if (trace_row(trace, k)[0] > trace_row(trace, trace->high)[0])
            trace->high = k;
    }
}

/* Of rows one after the other, a bucket each step of which is there: the first, and those of
 * smallest and largest position, in order. Returns how many. */
static int bucket_rows(const double *row, int64_t count, int stride, int64_t *index)
{
    int64_t low, high;
    int rows = 1;
    rows_extremes(row, count, stride, &low, &high);
    const int64_t earlier = low < high ? low : high;
    index[0] = 0;
    if (earlier > 0)
        index[rows++] = earlier;
    if (low != high)
        index[rows++] = low < high ? high : low;
    return rows;
}

/*
 * A trace with each step gets buckets. First only the steps of the rows that stay are noted, for
 * whoever wants to see the others once more; trace_thinned() then moves the rows. A bucket of two
 * keeps both, unless they are alike.
 */
bool trace_thin(struct trace *trace)
{
    const size_t count = trace->count;
    size_t staying = 0, row[3], end;
    int64_t bucket = 4, index[3];
    touch(trace, 0);
    if (!grow_index(trace))
        return false;
    for (size_t first = 0; first < count; first += (size_t)bucket) {
        const int64_t left = (int64_t)(count - first);
        const int rows = bucket_rows(trace_row(trace, first), left < bucket ? left : bucket,
                                     (int)trace->width, index);
        for (int k = 0; k < rows; k++)
            *step_at(trace, staying++) = (int64_t)first + index[k];
    }
    while (staying > trace->cap / 2) {
        const size_t stayed = staying;
        bucket *= 2;
        staying = 0;
        for (size_t first = 0; first < stayed; first = end) {
            const int rows = stay(trace, first, stayed, bucket, false, &end, row);
            for (int k = 0; k < rows; k++)
                *step_at(trace, staying++) = *step_at(trace, row[k]);
        }
    }
    trace->bucket = bucket;
    trace->count = staying;
    return true;
}

void trace_thinned(struct trace *trace)
{
    for (size_t i = 0; i < trace->count; i++)
        copy_state(trace_row(trace, i), trace_row(trace, (size_t)trace_row_step(trace, i)),
                   (int)trace->width);
    find_tail(trace, trace_row_step(trace, trace->count - 1) & ~(trace->bucket - 1));
}

static void move_row(struct trace *trace, size_t to, size_t from)
{
    copy_state(trace_row(trace, to), trace_row(trace, from), (int)trace->width);
    trace->index[to >> CHUNK_SHIFT][to & (CHUNK_ROWS - 1)] = trace_row_step(trace, from);
    if (trace_marked(trace))
        memcpy(mark_at(trace, to), mark_at(trace, from), trace->mark_width * sizeof(double));
}

/* Buckets become twice as long: rows move to the front, never over one that is still to be read. */
static bool coarsen(struct trace *trace)
{
    if (trace->bucket == 1) {
        if (!trace_thin(trace))
            return false;
        trace_thinned(trace);
        return true;
    }
    touch(trace, 0);
    do {
        const size_t count = trace->count;
        size_t row[3], end;
        trace->bucket *= 2;
        trace->count = 0;
        for (size_t first = 0; first < count; first = end) {
            const int rows = stay(trace, first, count, trace->bucket, true, &end, row);
            for (int k = 0; k < rows; k++)
                move_row(trace, trace->count++, row[k]);
        }
    } while (trace->count > trace->cap / 2);
    find_tail(trace, trace_row_step(trace, trace->count - 1) & ~(trace->bucket - 1));
    return true;
}

bool trace_append(struct trace *trace, int64_t step, double t, const double *y)
{
    return trace->count < trace->cap && append(trace, step, t, y, &unknown);
}

bool trace_record(struct trace *trace, int64_t step, double t, const double *y)
{
    /* by even_record() */
    if (trace->interval > 0 && trace->count > 0)
        return true;
    if (trace->count == 0)
        trace->origin = t;
    if (!trace->decimates && step != trace->next)
        return true;
    if (trace->count == trace->cap && !(trace->decimates && coarsen(trace)))
        return false;
    if (!(trace->bucket > 1 ? keep(trace, step, t, y, &unknown)
                            : append(trace, step, t, y, &unknown)))
        return false;
    trace->next = step + trace->every;
    return true;
}

/* As keep() for each of the rows, none of which begins a bucket: only their extremes can stay.
 * False: no memory. */
static bool keep_within(struct trace *trace, int64_t step, const double *row, int64_t count)
{
    int64_t at[2];
    rows_extremes(row, count, trace->n, &at[0], &at[1]);
    const bool swapped = at[0] > at[1];
    for (int i = 0; i < 2; i++) {
        const int64_t k = at[swapped ? 1 - i : i];
        if (!keep(trace, step + k, 0, row + k * trace->n, &unknown))
            return false;
    }
    return true;
}

/* As keep() for each of the rows, which are a bucket, or its first ones. False: no memory. */
static bool keep_bucket(struct trace *trace, int64_t step, const double *row, int64_t count)
{
    int64_t index[3];
    if (!reserve_rows(trace, COUNT_OF(index)))
        return false;
    const int rows = bucket_rows(row, count, trace->n, index);
    trace->tail = trace->low = trace->high = trace->count;
    trace->tail_end = (step | (trace->bucket - 1)) + 1;
    for (int k = 0; k < rows; k++) {
        const double *y = row + index[k] * trace->n;
        write_row(trace, trace->count, step + index[k], 0, y, &unknown);
        if (y[0] < trace_row(trace, trace->low)[0])
            trace->low = trace->count;
        if (y[0] > trace_row(trace, trace->high)[0])
            trace->high = trace->count;
        trace->count++;
    }
    return true;
}

int64_t trace_record_many(struct trace *trace, int64_t step, const double *row, int64_t count)
{
    if (trace->interval > 0)
        return trace_record_even(trace, step, row, count);
    for (int64_t i = 0; i < count; i++) {
        const bool begins = step + i >= trace->tail_end;
        const int64_t end = begins ? ((step + i) | (trace->bucket - 1)) + 1 : trace->tail_end,
                      within = end - step - i < count - i ? end - step - i : count - i;
        if (trace->bucket > 1 && within > 1 && trace->count + 3 < trace->cap) {
            const double *rows = row + i * trace->n;
            if (!(begins ? keep_bucket : keep_within)(trace, step + i, rows, within))
                return i;
            i += within - 1;
            trace->next = step + i + 1;
        } else if (!trace->decimates && step + i < trace->next)
            i = (trace->next - step < count ? trace->next - step : count) - 1;
        else if (!trace_record(trace, step + i, 0, row + i * trace->n))
            return i;
    }
    return count;
}

double *trace_open(struct trace *trace, size_t *rows)
{
    if (trace->bucket > 1 || trace->every > 1 || trace->timed || trace_marked(trace) ||
        trace->count >= trace->cap || !reserve_rows(trace, 1))
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

void trace_truncate(struct trace *trace, size_t i)
{
    if (i < trace->count) {
        trace->now_t = trace_time(trace, i);
        trace->now_step = trace_row_step(trace, i);
        memcpy(trace->now, trace_row(trace, i), (size_t)trace->n * sizeof(double));
        trace->count = i + 1;
        touch(trace, trace->count);
        trace->next = (int64_t)trace->count * trace->every;
    }
    /* as it began */
    if (i == 0)
        trace->bucket = 1;
    while (trace->grids > 1 && trace_grid(trace)->first > trace->now_step)
        trace->grids--;
    if (trace->bucket > 1)
        find_tail(trace, trace->now_step & ~(trace->bucket - 1));
}
