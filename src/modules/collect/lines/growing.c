/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A recording that grows while lines are collected. Every second row is dropped when it becomes
 * long, so that drawing it costs the same. */
#include "modules/collect/lines.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Returns true if two parts of a file were read in the same way: same columns, times and clock. */
static bool same_columns(const struct recording *a, const struct recording *b)
{
    if (a->columns != b->columns || a->time != b->time || a->value != b->value ||
        a->source != b->source || a->collected->clock != b->collected->clock)
        return false;
    for (int i = 0; i < a->columns; i++)
        if (a->column[i].quantity != b->column[i].quantity ||
            a->column[i].factor != b->column[i].factor ||
            strcmp(a->column[i].name, b->column[i].name) != 0)
            return false;
    return true;
}

/* Makes room for `rows` rows in all arrays of the recording. Returns false if out of memory. */
static bool rows_reserve(struct lengthening *growth, struct recording *recording, size_t rows)
{
    if (rows <= growth->capacity)
        return true;
    const size_t capacity = rows + rows / 2;
    struct {
        void **array;
        size_t size;
    } arrays[3] = {{(void **)&recording->t, sizeof *recording->t},
                   {(void **)&recording->y, sizeof *recording->y},
                   {(void **)&recording->line, sizeof *recording->line}};
    for (int i = 0; i < recording->columns + 3; i++) {
        void **array = i < 3 ? arrays[i].array : (void **)&recording->column[i - 3].value;
        void *larger = realloc(*array, capacity * (i < 3 ? arrays[i].size : sizeof(double)));
        if (!larger)
            return false;
        *array = larger;
    }
    growth->capacity = capacity;
    return true;
}

/* Appends a row of source to target. */
static void move_row(struct recording *target, const struct recording *source, size_t row)
{
    const size_t target_row = target->rows++;
    for (int i = 0; i < target->columns; i++)
        target->column[i].value[target_row] = source->column[i].value[row];
    target->t[target_row] = source->t[row];
    target->y[target_row] = source->y[row];
    target->line[target_row] = source->line[row];
}

/* Drops every second row if there are too many, so that the rows kept are multiples of the doubled
 * stride. */
static void rows_thin(struct lengthening *growth, struct recording *recording)
{
    if (recording->rows <= GROWING_ROWS)
        return;
    const size_t rows = recording->rows;
    const bool odd = growth->last_row / growth->stride % 2 == rows % 2;
    growth->stride *= 2;
    recording->rows = 0;
    for (size_t i = odd; i < rows; i += 2)
        move_row(recording, recording, i);
}

/* Returns the row of `more` that was read from that line, or `more->rows` if there is none. */
static size_t row_of_line(const struct recording *more, uint32_t line)
{
    size_t i = more->rows;
    while (i > 0 && more->line[i - 1] > line)
        i--;
    return i > 0 && more->line[i - 1] == line ? i - 1 : more->rows;
}

/* Shifts the times of `more` so that the given line is at t [s], if it has a clock of the device.
 */
void recording_join_clock(struct recording *more, uint32_t line, double t)
{
    const size_t row = row_of_line(more, line);
    const double shift = row < more->rows ? t - more->t[row] : 0;
    if (shift == 0 || more->collected->clock != CLOCK_DEVICE)
        return;
    for (size_t i = 0; i < more->rows; i++) {
        more->t[i] += shift;
        if (more->source == TIME_COLUMN)
            more->column[more->time].value[i] += shift / more->column[more->time].factor;
    }
}

/* Copies the facts about lines and clock of `more`, the newest part, to the growing recording, and
 * updates its rate. `end` [s] is the time of its last row before it grew: a window that ended there
 * follows the new end. */
static void update_known_times(struct lengthening *growth, struct recording *recording,
                               const struct recording *more, double end)
{
    const struct text statement = growth->known->statement;
    *growth->known = *more->collected;
    growth->known->statement = statement;
    recording_set_step(recording);
    recording->rate = 1 / recording->dt;
    if (recording->window[1] == end) /* the user has not set another window */
        recording->window[1] = recording->t[recording->rows - 1];
    recording->findings = NULL; /* the findings refer to other rows */
    recording->cleaned = false;
}

/* Begins the growth of a recording that was read completely: sets *growth to the line and time of
 * its last row, and gives the recording its own copy of the facts about its lines. Returns false if
 * out of memory. */
bool growth_begin(struct lengthening *growth, struct recording *recording)
{
    const size_t last = recording->rows - 1;
    struct collected *known = arena_alloc(&recording->arena, sizeof *known);
    if (!known)
        return false;
    *known = *recording->collected;
    recording->collected = known;
    *growth = (struct lengthening){.stride = 1,
                                   .capacity = recording->rows,
                                   .last_row = last,
                                   .line = recording->line[last],
                                   .t = recording->t[last],
                                   .known = known};
    return true;
}

/* Appends the rows of `more`, which was read from the last lines of the same file, unless the
 * recording has them: growth->line is the last line that it has, and `overlaps` is true if `more`
 * contains it. If times are computed from the arrivals of lines, new lines change the times of
 * earlier ones, so that all rows of `more` replace those of the same lines. Of the rows that came,
 * each growth->stride-th is kept. Sets *other to true, and appends nothing, if `more` has other
 * columns. Returns false if out of memory. */
bool recording_grow(struct recording *recording, struct lengthening *growth, struct recording *more,
                    bool *other)
{
    const size_t newest = row_of_line(more, growth->line);
    const bool overlaps = newest < more->rows,
               times_from_arrivals = more->collected->clock != CLOCK_DEVICE;
    *other = !same_columns(recording, more);
    if (*other)
        return true;
    if (!rows_reserve(growth, recording, recording->rows + more->rows))
        return false;
    recording_join_clock(more, growth->line, growth->t);
    const double end = recording->t[recording->rows - 1];
    size_t first = overlaps ? newest + 1 : 0, row = growth->last_row + 1;
    /* the straight line fitted to the arrivals has changed */
    if (times_from_arrivals && overlaps) {
        first = 0;
        row = growth->last_row - newest;
        while (recording->rows > 1 && recording->line[recording->rows - 1] >= more->line[0])
            recording->rows--;
    }
    for (size_t i = first; i < more->rows; i++, row++)
        if (row % growth->stride == 0 && more->t[i] > recording->t[recording->rows - 1])
            move_row(recording, more, i);
    growth->last_row = row - 1;
    growth->line = more->line[more->rows - 1];
    growth->t = more->t[more->rows - 1];
    update_known_times(growth, recording, more, end);
    rows_thin(growth, recording);
    return true;
}
