/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Clocks that are set back while a recording continues evenly, as when a computer synchronises its
 * time, or that restart from 0 because their counter is full. */
#include "modules/recording/table/table.h"

#include <hooke/base/numeric.h>

#include <math.h>
#include <stdio.h>

/* Number of rows on each side of a jump whose steps must be even. */
enum { EVEN_ROWS = 8 };
/* Largest difference of an even step from the usual one, in usual steps; rounded stamps need
 * some. */
static const double even_distance = 0.25;

/* Returns true if all steps between rows begin and end - 1 are near `step`. */
static bool steps_are_even(const double *t, size_t begin, size_t end, double step)
{
    for (size_t i = begin + 1; i < end; i++)
        if (!(fabs(t[i] - t[i - 1] - step) <= even_distance * step))
            return false;
    return true;
}

/* Returns true if two rows have the same value in every column. */
static bool rows_agree(const struct recording *recording, size_t a, size_t b)
{
    for (int i = 0; i < recording->columns; i++)
        if (recording->column[i].value[a] != recording->column[i].value[b])
            return false;
    return true;
}

/* Returns true if most rows after the jump at row i repeat rows from `begin` on that have the same
 * times. */
static bool is_repetition(const struct recording *recording, size_t begin, size_t i)
{
    size_t repeated = 0, rows = 0;
    for (size_t k = i, j = begin; k < recording->rows && recording->t[k] <= recording->t[i - 1];
         k++) {
        while (j < i && recording->t[j] < recording->t[k])
            j++;
        repeated += j < i && rows_agree(recording, j, k);
        rows++;
    }
    return 2 * repeated > rows;
}

/* Returns the longest time step, or 0 if a time is not a number. */
static double longest_step(const struct recording *recording)
{
    double longest = 0;
    for (size_t i = 1; i < recording->rows; i++) {
        const double step = recording->t[i] - recording->t[i - 1];
        if (!isfinite(step))
            return 0;
        longest = fmax(longest, step);
    }
    return longest;
}

/* Returns true if nearly all steps except those back are even. If there are gaps, it is unknown by
 * how much the clock was set. */
static bool is_even_elsewhere(const struct recording *recording, double step)
{
    static const double even_share = 0.99;
    size_t even = 0;
    for (size_t i = 1; i < recording->rows; i++) {
        const double here = recording->t[i] - recording->t[i - 1];
        even += here < 0 || fabs(here - step) <= even_distance * step;
    }
    return (double)even >= even_share * (double)(recording->rows - 1);
}

/* Returns true if every step back is that of a clock that was set. A clock that also jumps ahead
 * (longest) may belong to rows in another order. */
static bool only_jumps(const struct recording *recording, double longest, double step)
{
    const double *t = recording->t;
    size_t begin = 0;
    for (size_t i = 1; i < recording->rows; i++) {
        if (!(t[i] < t[i - 1]))
            continue;
        if (i < begin + EVEN_ROWS || i + EVEN_ROWS > recording->rows ||
            !steps_are_even(t, i - EVEN_ROWS, i, step) ||
            !steps_are_even(t, i, i + EVEN_ROWS, step) ||
            longest - step >= 0.5 * (t[i - 1] - t[i]) || is_repetition(recording, begin, i))
            return false;
        begin = i;
    }
    return begin > 0 && is_even_elsewhere(recording, step);
}

/* Adds the lost time after each step back of the clock, with a warning, if all of them look like a
 * clock that was set: between evenly spaced rows. */
void mend_clock_jumps(struct recording *recording)
{
    if (recording->source != TIME_COLUMN || recording->collected || recording->rows < 2 * EVEN_ROWS)
        return;
    const double step_max = longest_step(recording);
    const double step = step_max > 0 ? recording_median_step(recording) : 0;
    if (!(step > 0) || !only_jumps(recording, step_max, step))
        return;
    double *t = recording->t, moved = 0, previous = t[0], longest = 0;
    size_t jumps = 0, first = 0;
    for (size_t i = 1; i < recording->rows; i++) {
        const double now = t[i];
        if (now < previous) {
            moved += previous + step - now;
            longest = fmax(longest, previous + step - now);
            first = first ? first : i;
            jumps++;
        }
        previous = now;
        t[i] = now + moved;
    }
    char more[40] = "";
    if (jumps > 1)
        snprintf(more, sizeof more, " and %zu more times", jumps - 1);
    recording_warn(recording,
                   "the clock jumps back by %s%.4g s (line %u)%s although the rows are even; the "
                   "later times are shifted by the same amount",
                   jumps > 1 ? "up to " : "", longest, recording->line[first], more);
}

/* Returns the count at which a counter is full that makes every step back an ordinary one, and sets
 * *wraps to the number of these steps; returns 0 if there is none. `usual` is the usual step. */
static double full_count(const double *value, size_t rows, double usual, size_t *wraps)
{
    /* 16 and 32 bits; microseconds of 32 bits, written as ms and as s */
    static const double full[] = {65536, 4294967296, 4294967.296, 4294.967296};
    static const double longest = 3, steps_min = 64; /* usual steps */
    for (size_t k = 0; k < COUNT_OF(full); k++) {
        bool fits = full[k] >= steps_min * usual;
        *wraps = 0;
        for (size_t i = 0; i < rows && fits; i++) {
            fits = value[i] >= 0 && value[i] < full[k];
            if (i == 0 || !fits || value[i] >= value[i - 1])
                continue;
            fits = value[i] + full[k] - value[i - 1] <= longest * usual;
            ++*wraps;
        }
        if (fits && *wraps > 0)
            return full[k];
    }
    return 0;
}

/* Adds the size of an overflowing counter in a column (none if negative) at each overflow, with a
 * warning, if one of the usual sizes explains all steps back. */
void unwrap_clock(struct recording *recording, int column)
{
    if (column < 0 || recording->collected)
        return;
    double *value = recording->column[column].value, moved = 0, previous = value[0];
    size_t rising = 0, wraps;
    bool falls = false;
    for (size_t i = 1; i < recording->rows && !falls; i++)
        falls = value[i] < value[i - 1];
    double *rise = falls ? arena_array(&recording->arena, recording->rows, sizeof *rise) : NULL;
    for (size_t i = 1; rise && i < recording->rows; i++)
        if (value[i] > value[i - 1])
            rise[rising++] = value[i] - value[i - 1];
    if (rising == 0)
        return;
    const double full =
        full_count(value, recording->rows, values_quantile(rise, rising, 0.5), &wraps);
    if (full == 0)
        return;
    for (size_t i = 1; i < recording->rows; i++) {
        moved += value[i] < previous ? full : 0;
        previous = value[i];
        value[i] += moved;
    }
    recording_warn(recording,
                   "the clock in %s overflowed %zu %s, at %.10g; the times are continued",
                   recording->column[column].name, wraps, wraps == 1 ? "time" : "times", full);
}
