/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Decimation of a full trace. Steps are grouped in buckets of 2^k steps; each keeps its first row
 * and those of smallest and largest position (of equals the earliest), so that no peak is lost.
 * Merging two buckets gives the rows that one bucket of twice the size would have kept, so the
 * trace depends on the number of steps only, not on when it was decimated. */
#include "run/private.h"

/* Returns the address of the step of row i. */
static inline int64_t *row_step_address(const struct trace *trace, size_t i)
{
    return &trace->index[i >> CHUNK_SHIFT][i & (CHUNK_ROWS - 1)];
}

/* ---- one step ---- */

/* Adds a row at the end. Returns false if out of memory. */
static bool bucket_row_append(struct trace *trace, int64_t step, double t, const double *y)
{
    if (!trace_reserve_rows(trace, 1))
        return false;
    trace_write_row(trace, trace->count++, step, t, y, &unknown_tally);
    return true;
}

/* Records the state if it begins a bucket or is a new extreme of the last one; then the old extreme
 * is dropped unless it is the bucket's first row. */
bool trace_keep(struct trace *trace, int64_t step, double t, const double *y)
{
    if (step >= trace->tail_end) {
        if (!bucket_row_append(trace, step, t, y))
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
        if (!bucket_row_append(trace, step, t, y))
            return false;
    } else { /* the old extreme is dropped; at most the other extreme is behind it */
        if (*other > *extreme) {
            const double *row = trace_row(trace, *other);
            const struct energy_tally mark = trace_mark(trace, *other);
            trace_write_row(trace, *extreme, *row_step_address(trace, *other),
                            row[trace->width - 1], row, &mark);
            *other = *extreme;
        }
        trace_write_row(trace, trace->count - 1, step, t, y, &unknown_tally);
    }
    *extreme = trace->count - 1;
    return true;
}

/* Finds the first row of the last bucket, which begins at step `begin`, and its extremes. */
void trace_find_tail(struct trace *trace, int64_t begin)
{
    trace->tail_end = begin + trace->bucket;
    trace->tail = trace->count - 1;
    while (trace->tail > 0 && *row_step_address(trace, trace->tail - 1) >= begin)
        trace->tail--;
    trace->low = trace->high = trace->tail;
    for (size_t k = trace->tail + 1; k < trace->count; k++) {
        if (trace_row(trace, k)[0] < trace_row(trace, trace->low)[0])
            trace->low = k;
        if (trace_row(trace, k)[0] > trace_row(trace, trace->high)[0])
            trace->high = k;
    }
}

/* ---- many steps ---- */

/* Replaces each of the four numbers by that of *replacement where a is less than b. */
ALWAYS_INLINE void replace_where_less(const four *a, const four *b, const four *replacement,
                                      four *numbers)
{
    const four old = *numbers, new = *replacement;
    for (int i = 0; i < VECTOR_LANES; i++)
        (*numbers)[i] = (*a)[i] < (*b)[i] ? new[i] : old[i];
}

/* Finds the rows with the smallest and the largest position (the first number of a row) in each of
 * VECTOR_LANES consecutive parts of `count` rows, n numbers each. Sets low and high [VECTOR_LANES]
 * to their indices within each part, the first one of equals. Indices are counted in doubles, so
 * that they are vectors like positions. */
ALWAYS_INLINE void extreme_rows_of_parts(const double *row, int64_t count, int n, int64_t *low,
                                         int64_t *high)
{
    const int64_t next = count * n;
    four min = {row[0], row[next], row[2 * next], row[3 * next]}, max = min;
    four at_min = {0}, at_max = {0}, place = {0};
    for (const double *end = row + next; (row += n) != end;) {
        const four x = {row[0], row[next], row[2 * next], row[3 * next]};
        place += 1;
        replace_where_less(&x, &min, &place, &at_min);
        replace_where_less(&max, &x, &place, &at_max);
        replace_where_less(&x, &min, &x, &min);
        replace_where_less(&max, &x, &x, &max);
    }
    double places[2][VECTOR_LANES];
    memcpy(places[0], &at_min, sizeof at_min);
    memcpy(places[1], &at_max, sizeof at_max);
    for (int i = 0; i < VECTOR_LANES; i++) {
        low[i] = (int64_t)places[0][i];
        high[i] = (int64_t)places[1][i];
    }
}

/* Does the same for all of the rows, at least one: sets *low and *high to the indices of the first
 * rows with the smallest and the largest position. */
CLONES static void extreme_rows_find(const double *row, int64_t count, int n, int64_t *low,
                                     int64_t *high)
{
    const int64_t part = count / VECTOR_LANES;
    int64_t lows[VECTOR_LANES] = {0}, highs[VECTOR_LANES] = {0}, i = 1;
    *low = *high = 0;
    if (part > 1) {
        extreme_rows_of_parts(row, part, n, lows, highs);
        for (int k = 0; k < VECTOR_LANES; k++) {
            const int64_t least = k * part + lows[k], most = k * part + highs[k];
            *low = row[least * n] < row[*low * n] ? least : *low;
            *high = row[most * n] > row[*high * n] ? most : *high;
        }
        i = VECTOR_LANES * part;
    }
    for (; i < count; i++) {
        *low = row[i * n] < row[*low * n] ? i : *low;
        *high = row[i * n] > row[*high * n] ? i : *high;
    }
}

/* Sets place[] to the indices of the rows that a bucket keeps, in order: row `first`, with which
 * the bucket begins, and those of its extremes, first + low and first + high. Returns how many
 * different rows they are, 1 to 3. */
static inline size_t bucket_rows(int64_t first, int64_t low, int64_t high, int64_t place[3])
{
    const int64_t earlier = low < high ? low : high;
    const int64_t later = low < high ? high : low;
    size_t rows = 1;
    place[0] = first;
    place[rows] = first + earlier;
    rows += earlier > 0;
    place[rows] = first + later;
    return rows + (later > earlier);
}

/* Largest number of buckets whose rows are chosen in one call. */
enum { BUCKETS_MAX = 256 };

/* Chooses the rows that stay of `count` rows, the first of which begins a bucket of `bucket` rows.
 * Sets place to their indices, in order, and returns how many they are. */
CLONES static size_t bucket_rows_choose(const double *row, int64_t count, int64_t bucket, int n,
                                        int64_t place[3 * BUCKETS_MAX])
{
    int64_t low[VECTOR_LANES], high[VECTOR_LANES], i = 0;
    size_t rows = 0;
    for (; i + VECTOR_LANES * bucket <= count; i += VECTOR_LANES * bucket) {
        extreme_rows_of_parts(row + i * n, bucket, n, low, high);
        for (int k = 0; k < VECTOR_LANES; k++)
            rows += bucket_rows(i + k * bucket, low[k], high[k], place + rows);
    }
    for (; i < count; i += bucket) {
        extreme_rows_find(row + i * n, count - i < bucket ? count - i : bucket, n, low, high);
        rows += bucket_rows(i, low[0], high[0], place + rows);
    }
    return rows;
}

/* Place in the trace at which rows are written one after the other. */
struct row_writer {
    double *row; /* memory of the next row and of its step */
    int64_t *step;
    size_t next;  /* index of the next row */
    size_t width; /* numbers of a row */
    bool marked;  /* rows have marks */
};

/* Returns a writer that begins at row `next`, for rows of `width` numbers. */
ALWAYS_INLINE struct row_writer write_from(const struct trace *trace, size_t next, size_t width)
{
    return (struct row_writer){.row = trace_row(trace, next),
                               .step = row_step_address(trace, next),
                               .next = next,
                               .width = width,
                               .marked = trace_marked(trace)};
}

/* Writes a row and its step at the writer's place, which moves on; the mark is not changed. */
ALWAYS_INLINE void write_next(const struct trace *trace, struct row_writer *writer, int64_t step,
                              const double *y)
{
    if ((writer->next & (CHUNK_ROWS - 1)) == 0) {
        writer->row = trace_row(trace, writer->next);
        writer->step = row_step_address(trace, writer->next);
    }
    copy_state(writer->row, y, (int)writer->width);
    writer->row += writer->width;
    *writer->step++ = step;
    writer->next++;
}

/* Moves row source_row, with its mark, to the writer's place. */
ALWAYS_INLINE void move_next(struct trace *trace, struct row_writer *writer, int64_t step,
                             size_t source_row)
{
    if (writer->marked) {
        const struct energy_tally mark = trace_mark(trace, source_row);
        trace_set_mark(trace, writer->next, &mark);
    }
    write_next(trace, writer, step,
               trace->chunk[source_row >> CHUNK_SHIFT] +
                   (source_row & (CHUNK_ROWS - 1)) * writer->width);
}

/* Writes the rows `place` [chosen] of those from `row` on, the first of which is that of `step`. */
ALWAYS_INLINE void write_chosen(const struct trace *trace, struct row_writer *writer, int64_t step,
                                const double *row, const int64_t *place, size_t chosen)
{
    for (size_t k = 0; k < chosen; k++)
        write_next(trace, writer, step + place[k], row + (size_t)place[k] * writer->width);
}

/* ---- from each step to buckets ---- */

/* Decimates a trace that has each step in buckets of four steps. (In buckets of two both rows would
 * stay, unless they are alike.) Sets trace->index and trace->count to the rows that stay, and moves
 * these rows to the front if `moves`. Returns false if out of memory. */
static bool trace_steps_thin(struct trace *trace, bool moves)
{
    static const int64_t bucket = 4;
    int64_t place[3 * BUCKETS_MAX];
    size_t rows;
    trace_touch(trace, 0);
    if (!trace_grow_index(trace))
        return false;
    struct row_writer writer = write_from(trace, 0, trace->width);
    for (size_t first = 0; first < trace->count; first += rows) {
        const double *row = trace_rows(trace, first, trace->count, &rows);
        rows = rows < (size_t)(BUCKETS_MAX * bucket) ? rows : (size_t)(BUCKETS_MAX * bucket);
        const size_t chosen =
            bucket_rows_choose(row, (int64_t)rows, bucket, (int)trace->width, place);
        for (size_t k = 0; k < chosen; k++) {
            const int64_t step = (int64_t)first + place[k];
            if (moves)
                move_next(trace, &writer, step, (size_t)step);
            else
                *row_step_address(trace, writer.next++) = step;
        }
    }
    trace->bucket = bucket;
    trace->count = writer.next;
    return true;
}

bool trace_thin(struct trace *trace)
{
    return trace_steps_thin(trace, false);
}

/* ---- buckets of twice the size ---- */

/* Moves the rows that stay of a bucket, which may coincide, to the writer's place in order. */
ALWAYS_INLINE void move_bucket(struct trace *trace, struct row_writer *writer, size_t first,
                               size_t low, size_t high)
{
    const size_t earlier = low < high ? low : high;
    const size_t later = low < high ? high : low;
    move_next(trace, writer, *row_step_address(trace, first), first);
    if (earlier != first)
        move_next(trace, writer, *row_step_address(trace, earlier), earlier);
    if (later != earlier)
        move_next(trace, writer, *row_step_address(trace, later), later);
}

/* Merges pairs of buckets, which halves the number of rows at most. Rows move to the front, never
 * over one that is still to be read. */
static void merge_buckets(struct trace *trace)
{
    const size_t count = trace->count, width = trace->width;
    const int64_t bucket_mask = 2 * trace->bucket - 1, *step = NULL;
    const double *row = NULL;
    double min = 0, max = 0;
    struct row_writer writer = write_from(trace, 0, width);
    size_t first = 0, low = 0, high = 0;
    int64_t next = 0;
    for (size_t i = 0; i < count; i++, row += width, step++) {
        if ((i & (CHUNK_ROWS - 1)) == 0) {
            row = trace_row(trace, i);
            step = row_step_address(trace, i);
        }
        if (*step >= next) {
            if (i > 0)
                move_bucket(trace, &writer, first, low, high);
            next = (*step | bucket_mask) + 1;
            first = low = high = i;
            min = max = *row;
        } else if (*row < min) {
            min = *row;
            low = i;
        } else if (*row > max) {
            max = *row;
            high = i;
        }
    }
    move_bucket(trace, &writer, first, low, high);
    trace->count = writer.next;
    trace->bucket *= 2;
}

/* Merges buckets until at most half of the largest number of rows remain. */
static void merge_enough(struct trace *trace)
{
    trace_touch(trace, 0);
    while (trace->count > trace->cap / 2)
        merge_buckets(trace);
    trace_find_tail(trace, *row_step_address(trace, trace->count - 1) & ~(trace->bucket - 1));
}

/* Moves the rows that stay, whose steps trace_thin() has noted, to the front. */
void trace_thinned(struct trace *trace)
{
    for (size_t i = 0; i < trace->count; i++)
        copy_state(trace_row(trace, i), trace_row(trace, (size_t)*row_step_address(trace, i)),
                   (int)trace->width);
    merge_enough(trace);
}

/* Decimates the trace, in which steps are grouped in buckets from then on, or doubles its
 * buckets. */
bool trace_coarsen(struct trace *trace)
{
    if (trace->bucket == 1 && !trace_steps_thin(trace, true))
        return false;
    merge_enough(trace);
    return true;
}

/* ---- recording many steps ---- */

/* Records `count` steps that all belong to the last bucket, so that only their extremes can stay:
 * the same rows as trace_keep() for each of them. Returns false if out of memory. */
static bool bucket_extremes_record(struct trace *trace, int64_t step, const double *row,
                                   int64_t count)
{
    int64_t extreme_index[2];
    extreme_rows_find(row, count, (int)trace->width, &extreme_index[0], &extreme_index[1]);
    const bool swapped = extreme_index[0] > extreme_index[1];
    for (int i = 0; i < 2; i++) {
        const int64_t k = extreme_index[swapped ? 1 - i : i];
        const double *y = row + (size_t)k * trace->width;
        if (!trace_keep(trace, step + k, y[trace->width - 1], y))
            return false;
    }
    return true;
}

/* Records `count` steps that are whole buckets: the same rows as trace_keep() for each of them.
 * Returns false if out of memory. */
static bool whole_buckets_record(struct trace *trace, int64_t step, const double *row,
                                 int64_t count)
{
    int64_t place[3 * BUCKETS_MAX];
    const size_t rows = bucket_rows_choose(row, count, trace->bucket, (int)trace->width, place),
                 end = trace->count + rows;
    if (!trace_reserve_rows(trace, rows))
        return false;
    trace_touch(trace, trace->count);
    struct row_writer writer = write_from(trace, trace->count, trace->width);
    write_chosen(trace, &writer, step, row, place, rows);
    for (size_t i = trace->count; trace_marked(trace) && i < end; i++)
        trace_set_mark(trace, i, &unknown_tally);
    trace->count = end;
    trace->tail = trace->low = trace->high = end - 1;
    trace->tail_end = step + count;
    return true;
}

/* Returns how many of `count` steps from `step` on whole_buckets_record() can record at once: whole
 * buckets, as many as fit before the trace has to be decimated. Returns 0 if `step` begins no
 * bucket. */
static int64_t whole_bucket_steps(const struct trace *trace, int64_t step, int64_t count)
{
    int64_t buckets = count / trace->bucket;
    const int64_t room = (int64_t)(trace->cap - trace->count - 1) / 3;
    if (trace->bucket == 1 || step < trace->tail_end || step & (trace->bucket - 1))
        return 0;
    buckets = buckets < room ? buckets : room;
    return (buckets < BUCKETS_MAX ? buckets : BUCKETS_MAX) * trace->bucket;
}

/* Records the first of `count` states after `step`, `step` + 1, …: those that are passed over,
 * whole buckets, the end of a bucket, or one step. Returns how many; 0 if the trace is full or out
 * of memory. */
static int64_t steps_record(struct trace *trace, int64_t step, const double *row, int64_t count)
{
    const int64_t skipped = trace->decimates ? 0 : trace->next - step,
                  whole = whole_bucket_steps(trace, step, count),
                  in_bucket = trace->tail_end - step;
    const int64_t bucket_rows = in_bucket < count ? in_bucket : count;
    if (skipped > 0)
        return skipped < count ? skipped : count;
    if (whole > 0)
        return whole_buckets_record(trace, step, row, whole) ? whole : 0;
    if (trace->bucket > 1 && bucket_rows > 1 && trace->count + 3 < trace->cap)
        return bucket_extremes_record(trace, step, row, bucket_rows) ? bucket_rows : 0;
    return trace_record(trace, step, row[trace->width - 1], row);
}

/* Offers `count` states after `step`, …, and returns how many were taken. */
int64_t trace_record_many(struct trace *trace, int64_t step, const double *row, int64_t count)
{
    if (trace->interval > 0)
        return trace_record_even(trace, step, row, count);
    int64_t done = 0;
    for (int64_t more = 1; more > 0 && done < count; done += more)
        more = steps_record(trace, step + done, row + (size_t)done * trace->width, count - done);
    return done;
}
