/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recorded rows: their times, the balance at each, their memory, which of them stay. */
#pragma once

#include <hooke/run.h>

/* ---- the grid of times: t = origin + (step - first) h, never accumulated ---- */

struct time_grid {
    int64_t first; /* step index at the origin */
    double origin; /* [s]; the target of adaptive steps, whose times are in their rows */
    double h;      /* [s] signed */
};

double grid_time(const struct time_grid *grid, int64_t step); /* [s] */

/* Interval from one time to another in steps of dt. */
struct stretch {
    double ratio;   /* |to - from| / dt */
    int64_t whole;  /* full steps, at most LIMIT_STEPS */
    double partial; /* [s] signed remaining time after them; 0 if there is none */
    bool exact;     /* a whole number of steps, up to rounding */
};

struct stretch stretch_measure(double t_begin, double t_end, double dt); /* `to` may be infinite */

/* ---- the energy balance after a state ---- */

/* A sum that does not lose small addends (Neumaier 1974). */
struct compensated_sum {
    double high, low;
};

/* Sums in units of factor^2 J (see run_private). */
struct energy_tally {
    double max;   /* largest |E - E0 - work| after a step so far */
    double scale; /* largest |E|, or |E0| where that is not 0 */
    /* totals since the start: work of drag, drive, jumps and changes of parameters; of drag
     * alone */
    struct compensated_sum work, drag;
};

/* ---- memory that is released all at once (pool.c) ---- */

struct pool {
    struct pool_block *blocks;
    char *free; /* `left` free bytes in the last block */
    size_t left, bytes;
};

/* Makes room for one more than `count` things in an array, whose pointer is at `array`. Returns
 * false if out of memory. Arrays that share a capacity each begin from the same one. */
bool array_reserve(void *array, size_t bytes, size_t count, size_t *capacity);
/* Allocates a multiple of 16 bytes, not cleared; returns NULL if out of memory. */
void *pool_take(struct pool *pool, size_t size);
void pool_release(struct pool *pool);

/* ---- trace ----
 *
 * Row: n state values, then the time if `timed` (adaptive). Row i is step i * every, until the
 * trace is decimated: then the steps stand in `index`, as they do where rows are at even times:
 * there may be none in a step, or many. The present state is shown as a last row when it was not
 * recorded itself.
 */

#define CHUNK_SHIFT 12
#define CHUNK_ROWS ((size_t)1 << CHUNK_SHIFT)

struct trace {
    int n;
    bool decimates, timed;
    /* unless it decimates: record each so many steps; the next one to record */
    int64_t every, next;
    size_t width; /* doubles a row */
    size_t cap;   /* largest number of rows; then the trace is decimated or full */
    double **chunk;
    int64_t **index; /* [indices] steps of the rows in each chunk, once decimated */
    size_t chunks, indices, capacity, count;
    size_t stored; /* rows before it are as they were when somebody last stored them */
    double **mark; /* [marks] the balance at each row, where there are steps between rows */
    size_t marks, mark_width;
    struct pool pool, mark_pool; /* memory of rows and their steps; of marks */

    /* number of steps that share at most three rows; 1 if the trace is not decimated */
    int64_t bucket;
    int64_t tail_end;       /* step at which the last bucket ends */
    size_t tail, low, high; /* its rows: first, smallest, largest position */

    double interval, origin; /* [s] rows at origin + k interval; interval 0: by steps */
    double due;              /* the k of the next one */
    int ahead;               /* 1 if times increase, else -1 */

    struct time_grid *grid;
    size_t grids, grid_capacity;

    double now[LIMIT_VARIABLES];
    double now_t;
    int64_t now_step;
};

/* The numbers of a recorded row: the state, its time where it is timed. */
static inline double *trace_row(const struct trace *trace, size_t i)
{
    return trace->chunk[i >> CHUNK_SHIFT] + (i & (CHUNK_ROWS - 1)) * trace->width;
}

/* Returns true if rows carry their steps. */
static inline bool trace_indexed(const struct trace *trace)
{
    return trace->bucket > 1 || trace->interval > 0;
}

static inline int64_t trace_row_step(const struct trace *trace, size_t i)
{
    return trace_indexed(trace) ? trace->index[i >> CHUNK_SHIFT][i & (CHUNK_ROWS - 1)]
                                : (int64_t)i * trace->every;
}

void trace_clear_rows(struct trace *trace);
/* Adds a row that was recorded earlier, with its mark, whatever the rule. Returns false if out of
 * memory. */
bool trace_put_row(struct trace *trace, int64_t step, const double *row,
                   const struct energy_tally *mark);
/* Adds a row that the rule has asked for; returns false if the trace is full or out of memory. */
bool trace_append(struct trace *trace, int64_t step, double t, const double *y);
/* Returns NULL if out of memory. */
struct trace *trace_create(int n, bool timed, struct recording_rule rule, size_t memory);
void trace_destroy(struct trace *trace);
/* Offers the state after `step`. Returns false, with nothing recorded, if the trace is full or out
 * of memory. Steps come in order, each once. */
bool trace_record(struct trace *trace, int64_t step, double t, const double *y);
/* The same for the states after `step`, `step` + 1, …, rows as the trace has them; returns how many
 * were taken. */
int64_t trace_record_many(struct trace *trace, int64_t step, const double *row, int64_t count);
/* Returns the recorded state after `step`, or NULL if it was not recorded or the trace is
 * decimated. */
const double *trace_state_after(const struct trace *trace, int64_t step);
/* Returns the place of the next rows of `width` numbers, with room for *rows of them one after the
 * other, or NULL unless every step is kept in rows of that width. */
double *trace_open(struct trace *trace, size_t width, size_t *rows);
/* that gives this step its time */
const struct time_grid *trace_grid_of(const struct trace *trace, int64_t step);
void trace_close(struct trace *trace, size_t rows); /* so many were written there */
void trace_present(struct trace *trace, int64_t step, double t, const double *y);
/* Drops everything after row i, which becomes the present. */
void trace_truncate(struct trace *trace, size_t i);
/* Makes room for `more` regrids; returns false if out of memory. */
bool trace_reserve_grids(struct trace *trace, size_t more);
void trace_regrid(struct trace *trace, struct time_grid grid); /* starts a new grid here */
const struct time_grid *trace_grid(const struct trace *trace); /* the present one */
size_t trace_row_bytes(int n, bool timed, bool indexed);
/* Gives rows marks, which hold the balance at each row, and its work only if `work`. Rows that were
 * recorded before have unknown marks or 0. Returns false if out of memory. */
bool trace_mark_rows(struct trace *trace, bool work);
bool trace_marked(const struct trace *trace);
void trace_forget_marks(struct trace *trace);
struct energy_tally trace_mark(const struct trace *trace, size_t i); /* scale < 0: not yet known */
void trace_set_mark(struct trace *trace, size_t i, const struct energy_tally *tally);
/* the first recorded row of this step or a later one */
size_t trace_row_from(const struct trace *trace, int64_t step);
/* Recorded row i of those before `end`, and how many follow it in memory, each trace->width on. */
const double *trace_rows(const struct trace *trace, size_t i, size_t end, size_t *count);
/* Row i changes. */
static inline void trace_touch(struct trace *trace, size_t i)
{
    trace->stored = i < trace->stored ? i : trace->stored;
}

static const struct energy_tally unknown_tally = {.scale = -1};

/* Makes room for a few more rows, and for the steps of the rows that there are. Return false if
 * there is no memory. */
bool trace_reserve_rows(struct trace *trace, size_t rows);
bool trace_grow_index(struct trace *trace);
/* Sets row i, for which there is room. */
void trace_write_row(struct trace *trace, size_t i, int64_t step, double t, const double *y,
                     const struct energy_tally *mark);

/* ---- decimation.c ---- */

/* Offers a step to a decimated trace. Returns false if there is no memory. */
bool trace_keep(struct trace *trace, int64_t step, double t, const double *y);
/* Makes buckets longer until at most half of the rows remain. Returns false if there is no memory.
 */
bool trace_coarsen(struct trace *trace);
/* Finds the rows of the last bucket, which begins at that step, again. */
void trace_find_tail(struct trace *trace, int64_t begin);
/*
 * Decimates a trace with each step in two parts: first its steps and its number of rows are those
 * that stay, while trace_rows() still finds each step's row; then rows move to their places.
 * Returns false if out of memory.
 */
bool trace_thin(struct trace *trace);
void trace_thinned(struct trace *trace);
