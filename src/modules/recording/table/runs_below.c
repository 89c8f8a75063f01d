/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Several recordings below each other in one table: each begins where the clock goes back to the
 * start. */
#include "modules/recording/table/table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define RUNS_BELOW_MAX 64
/* Smallest number of rows of a run. */
#define ROWS_MIN 8
/* Share of the elapsed time by which the clock goes back at the start of a run; less is a faulty
 * stamp. */
#define BACK_MIN 0.5

/* Sets start to the first row of each run, and after the last to the number of rows. Returns the
 * number of runs, which is 1 for an ordinary table. */
static int find_starts(const struct recording *recording, size_t start[RUNS_BELOW_MAX + 1])
{
    const double *t = recording->t;
    int runs = 1;
    start[0] = 0;
    for (size_t i = 1; i < recording->rows; i++) {
        const double begin = t[start[runs - 1]], passed = t[i - 1] - begin, back = t[i - 1] - t[i];
        if (!(back > BACK_MIN * passed) || !(passed > 0) || i - start[runs - 1] < ROWS_MIN)
            continue;
        /* The clock does not continue from the new time if a single stamp is wrong. */
        bool is_start = i + ROWS_MIN <= recording->rows;
        for (size_t k = i + 1; is_start && k < i + ROWS_MIN; k++)
            is_start = t[k] >= t[k - 1] && t[k] < t[i - 1];
        if (is_start && runs < RUNS_BELOW_MAX)
            start[runs++] = i;
    }
    start[runs] = recording->rows;
    return runs;
}

/* Keeps rows begin to end - 1 and drops the others. */
static void keep_rows(struct recording *recording, size_t begin, size_t end)
{
    const size_t n = end - begin;
    for (int i = 0; i < recording->columns; i++)
        memmove(recording->column[i].value, recording->column[i].value + begin, n * sizeof(double));
    memmove(recording->t, recording->t + begin, n * sizeof(double));
    memmove(recording->line, recording->line + begin, n * sizeof *recording->line);
    recording->rows = n;
}

/* Reduces the recording to one run, the requested or the first, if its clock restarts, so that runs
 * are below each other; names the runs and warns. Returns false with the error. */
bool take_run_below(struct recording *recording, const struct load_options *options,
                    struct error *error)
{
    size_t start[RUNS_BELOW_MAX + 1];
    if (recording->runs > 0)
        return true;
    const bool could = recording->source == TIME_COLUMN && recording->rows >= 2 * ROWS_MIN;
    const int runs = could ? find_starts(recording, start) : 1;
    if (runs == 1)
        return options->run.len == 0 || run_find(recording, options->run, &recording->taken, error);
    recording->run = arena_array(&recording->arena, (size_t)runs, sizeof *recording->run);
    if (!recording->run)
        return error_memory(error);
    for (int i = 0; i < runs; i++)
        snprintf(recording->run[i].name, sizeof recording->run[i].name, "Run %d", i + 1);
    recording->runs = runs;
    recording->taken = 0;
    if (options->run.len > 0 && !run_find(recording, options->run, &recording->taken, error))
        return false;
    recording_warn(recording, "the clock restarts %d %s, so the file has %d runs; run=%d is read",
                   runs - 1, runs == 2 ? "time" : "times", runs, recording->taken + 1);
    keep_rows(recording, start[recording->taken], start[recording->taken + 1]);
    return true;
}
