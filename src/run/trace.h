/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The rows that a run has recorded: their times, the energy balance at each, their memory, and
 * which of them stay when there are too many. trace_create(), then trace_regrid() and
 * trace_record() for each step; trace_present() after each call of run_advance(). */
#pragma once

#include <hooke/run.h>

/* ---- the grid of times: t = origin + (step - first) h, never accumulated ---- */

/* Times of the steps from `first` to the next grid. A new grid begins where the step changes. */
struct time_grid {
    int64_t first; /* step index at the origin */
    double origin; /* [s]; for adaptive steps, whose times are in their rows, the target's time */
    double h;      /* [s] signed */
};

/* Returns the time [s] of a step on the grid. */
double grid_time(const struct time_grid *grid, int64_t step);

/* Interval from one time to another in steps of dt. */
struct stretch {
    double ratio;   /* |t_end - t_begin| / dt */
    int64_t whole;  /* full steps, at most LIMIT_STEPS */
    double partial; /* [s] signed remaining time after them; 0 if there is none */
    bool exact;     /* a whole number of steps, up to rounding */
};

/* Measures the interval in steps of dt > 0; t_end may be infinite. */
struct stretch stretch_measure(double t_begin, double t_end, double dt);

/* ---- the energy balance after a state ---- */

/* A sum that does not lose small addends (Neumaier 1974). */
struct compensated_sum {
    double high, low;
};

/* Sums since the start of the run, in units of factor^2 J (see run_private). */
struct energy_tally {
    double max;   /* largest |E - E0 - work| after a step so far */
    double scale; /* |E0|, or the largest |E| so far if E0 is 0; negative if not yet computed */
    struct compensated_sum work; /* work of drag, drive, jumps and changes of parameters */
    struct compensated_sum drag; /* work of drag alone */
};

/* ---- memory that is released all at once (pool.c) ---- */

struct pool {
    struct pool_block *blocks; /* list of all blocks, the last one first */
    char *free;                /* `left` free bytes in the last block */
    size_t left, bytes;        /* `bytes` is the total size of the blocks */
};

/* Makes room for one more than `count` elements of `bytes` each in an array; `array` is the address
 * of its pointer. Returns false if out of memory. Two arrays that share a capacity are called with
 * copies of the same old one. */
bool array_reserve(void *array, size_t bytes, size_t count, size_t *capacity);
/* Allocates a multiple of 16 bytes, not cleared; returns NULL if out of memory. */
void *pool_take(struct pool *pool, size_t size);
/* Frees everything that was taken from the pool, which is empty afterwards. */
void pool_release(struct pool *pool);

/* ---- trace ----
 *
 * A row has n state values, then the time if the trace is `timed` (adaptive, or rows at even
 * times). Row i is that of step i * every, unless rows have their steps in `index`: those of a
 * decimated trace, and those at even times, of which a step may have none or many. The present
 * state is shown as a last row if it was not recorded itself.
 */

#define CHUNK_SHIFT 12 /* 4096 rows in a chunk */
#define CHUNK_ROWS ((size_t)1 << CHUNK_SHIFT)

struct trace {
    int n;           /* numbers of a state */
    bool decimates;  /* leaves rows out when it is full (RECORD_AUTO) */
    bool timed;      /* rows have their time */
    int64_t every;   /* steps from one recorded row to the next; 1 if it decimates */
    int64_t next;    /* next step to record; unused if it decimates */
    size_t width;    /* numbers of a row */
    size_t cap;      /* largest number of rows; then the trace is decimated or full */
    double **chunk;  /* [chunks] rows, CHUNK_ROWS in each */
    int64_t **index; /* [indices] steps of the rows in each chunk, if trace_indexed() */
    size_t chunks, indices;
    size_t capacity; /* size of the arrays chunk, index and mark */
    size_t count;    /* recorded rows */
    size_t stored;   /* rows before this one have not changed since the run was last stored */
    double **mark;   /* [marks] energy balance at the rows of each chunk; NULL if not kept */
    size_t marks;
    size_t mark_width;           /* numbers of a mark; 0 if rows have none */
    struct pool pool, mark_pool; /* memory of rows and their steps; of marks */

    /* number of steps that share at most three rows; 1 if the trace is not decimated */
    int64_t bucket;
    int64_t tail_end;       /* step at which the last bucket ends */
    size_t tail, low, high; /* its rows: first, smallest, largest position */

    double interval; /* [s] rows are at origin + k interval; 0 if rows are at ends of steps */
    double origin;   /* [s] */
    double due;      /* the k of the next row */
    int ahead;       /* 1 if times increase, else -1 */

    struct time_grid *grid; /* [grids] in order of steps; the last one is in use */
    size_t grids, grid_capacity;

    double now[LIMIT_VARIABLES]; /* present state of the run */
    double now_t;                /* [s] */
    int64_t now_step;
};

/* Returns the numbers of a recorded row: the state, then the time if the trace is timed. */
static inline double *trace_row(const struct trace *trace, size_t i)
{
    return trace->chunk[i >> CHUNK_SHIFT] + (i & (CHUNK_ROWS - 1)) * trace->width;
}

/* Returns true if each row has its step in trace->index, because steps do not follow from row
 * numbers. */
static inline bool trace_indexed(const struct trace *trace)
{
    return trace->bucket > 1 || trace->interval > 0;
}

/* Returns the step of recorded row i. */
static inline int64_t trace_row_step(const struct trace *trace, size_t i)
{
    return trace_indexed(trace) ? trace->index[i >> CHUNK_SHIFT][i & (CHUNK_ROWS - 1)]
                                : (int64_t)i * trace->every;
}

/* Drops all recorded rows. trace_put_row() adds them again, when a stored run is read. */
void trace_clear_rows(struct trace *trace);
/* Adds a row that was recorded earlier, with its mark, whatever the recording rule. Returns false
 * if out of memory. */
bool trace_put_row(struct trace *trace, int64_t step, const double *row,
                   const struct energy_tally *mark);
/* Adds a row without asking the recording rule; returns false if the trace is full or out of
 * memory. */
bool trace_append(struct trace *trace, int64_t step, double t, const double *y);
/* Creates an empty trace for states of n numbers. Rows have times if `timed`; together they take at
 * most `memory` bytes, where 0 stands for MEMORY_DEFAULT. Returns NULL if out of memory. */
struct trace *trace_create(int n, bool timed, struct recording_rule rule, size_t memory);
void trace_destroy(struct trace *trace);
/* Offers the state after `step`, which the recording rule takes or passes over. Returns false, with
 * nothing recorded, if the trace is full or out of memory. Steps come in order, each once. */
bool trace_record(struct trace *trace, int64_t step, double t, const double *y);
/* Does the same for `count` states after `step`, `step` + 1, …, rows as the trace has them. Returns
 * how many were offered before the trace was full or out of memory. */
int64_t trace_record_many(struct trace *trace, int64_t step, const double *row, int64_t count);
/* Returns the recorded state after `step`, or NULL if it was not recorded or the trace is
 * decimated. */
const double *trace_state_after(const struct trace *trace, int64_t step);
/* Returns the memory of the next rows of `width` numbers, to write *rows of them one after the
 * other and then call trace_close(). Returns NULL if out of memory, or unless the trace keeps every
 * step in rows of that width. */
double *trace_open(struct trace *trace, size_t width, size_t *rows);
/* Counts `rows` rows, which were written after trace_open(), as recorded. */
void trace_close(struct trace *trace, size_t rows);
/* Returns the grid that gives this step its time. */
const struct time_grid *trace_grid_of(const struct trace *trace, int64_t step);
/* Sets the present state of the run, which is shown as the last row. */
void trace_present(struct trace *trace, int64_t step, double t, const double *y);
/* Drops everything after row i, which becomes the present state. */
void trace_truncate(struct trace *trace, size_t i);
/* Makes room for `more` calls of trace_regrid(); returns false if out of memory. */
bool trace_reserve_grids(struct trace *trace, size_t more);
/* Begins a new grid at the step grid.first; room for it was reserved before. */
void trace_regrid(struct trace *trace, struct time_grid grid);
/* Returns the grid in use, the last one. */
const struct time_grid *trace_grid(const struct trace *trace);
/* Returns the memory [byte] of a row, with its time and its step if it has them. */
size_t trace_row_bytes(int n, bool timed, bool indexed);
/* Gives each row a mark, the energy balance at the row; it contains the work only if `work`. Rows
 * that were recorded before get unknown_tally, or keep what their marks had. Returns false if out
 * of memory. */
bool trace_mark_rows(struct trace *trace, bool work);
/* Returns true if rows have marks. */
bool trace_marked(const struct trace *trace);
void trace_forget_marks(struct trace *trace);
/* Returns the mark of row i; its scale is negative if the balance there is not yet known. */
struct energy_tally trace_mark(const struct trace *trace, size_t i);
void trace_set_mark(struct trace *trace, size_t i, const struct energy_tally *tally);
/* Returns the first recorded row of this step or a later one; trace->count if there is none. */
size_t trace_row_from(const struct trace *trace, int64_t step);
/* Returns recorded row i, and sets *count to the number of rows, this one included, that follow
 * each other in memory before row `end`. */
const double *trace_rows(const struct trace *trace, size_t i, size_t end, size_t *count);
/* Notes that row i changes, so that it will be stored again. */
static inline void trace_touch(struct trace *trace, size_t i)
{
    trace->stored = i < trace->stored ? i : trace->stored;
}

/* The mark of a row whose balance has not been computed. */
static const struct energy_tally unknown_tally = {.scale = -1};

/* Makes room for `rows` more rows, at most CHUNK_ROWS; returns false if out of memory. */
bool trace_reserve_rows(struct trace *trace, size_t rows);
/* Makes room for the steps of the rows in all chunks; returns false if out of memory. */
bool trace_grow_index(struct trace *trace);
/* Sets row i, for which there is room. */
void trace_write_row(struct trace *trace, size_t i, int64_t step, double t, const double *y,
                     const struct energy_tally *mark);

/* ---- decimation.c ---- */

/* Records the state after a step in a decimated trace, if its bucket needs it. Returns false if out
 * of memory. */
bool trace_keep(struct trace *trace, int64_t step, double t, const double *y);
/* Doubles the length of buckets until at most half of trace->cap rows remain. Returns false if out
 * of memory. */
bool trace_coarsen(struct trace *trace);
/* Sets tail, low and high, the rows of the last bucket, which begins at step `begin`. */
void trace_find_tail(struct trace *trace, int64_t begin);
/*
 * Decimate a trace that has each step, in two parts, between which the marks of the rows that stay
 * can be computed. trace_thin() sets `index` and `count` to the rows that stay, but leaves all rows
 * where they are; it returns false if out of memory. trace_thinned() moves the rows that stay to
 * the front.
 */
bool trace_thin(struct trace *trace);
void trace_thinned(struct trace *trace);
