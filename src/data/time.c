/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * From the chosen columns to time [s] that rises and value [SI]. What is odd about the times is counted and said.
 */
#include "table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MEDIAN_SAMPLE 4096 /* steps looked at for the median */
#define UNEVEN 0.1         /* of the median step: beyond it the sampling is called uneven */
#define GAP 1.5            /* median steps */

/* As unit_convert: by division where the factor is 1/n, so that decimal fractions are rounded once. */
static void to_si(const double *number, size_t n, double factor, double *si)
{
    const double inverse = nearbyint(1 / factor);
    const bool divide = factor < 1 && inverse * factor == 1;
    for (size_t i = 0; i < n; i++)
        si[i] = divide ? number[i] / inverse : number[i] * factor;
}

static bool set_time_unit(struct recording *recording, const struct load_options *options, struct error *error)
{
    const struct unit *unit = options->time_unit;
    if (recording->source != TIME_COLUMN)
        return !unit || error_set(error, ERROR_COMMAND, "tunit= has no meaning together with rate=");
    struct column *time = &recording->column[recording->time];
    if (unit && unit->quantity != QUANTITY_TIME)
        return error_set(error, ERROR_COMMAND, "tunit= needs a time (s, ms, min), got '%s' (%s)", unit->row.name,
                         quantity_name(unit->quantity));
    if (unit) {
        snprintf(time->unit, sizeof time->unit, "%s", unit->row.name);
        time->quantity = QUANTITY_TIME;
        time->factor = unit->factor;
    } else if (time->quantity != QUANTITY_TIME && time->unit[0]) {
        error_set(error, options->time.len > 0 ? ERROR_COMMAND : ERROR_IO,
                  "the unit of '%s' is '%s', which is no known time", time->name, time->unit);
        return error_hint(error, "tunit=s takes its numbers as seconds");
    } else if (time->quantity != QUANTITY_TIME) {
        bool whole = true;
        for (size_t i = 0; i < recording->rows && whole; i++)
            whole = !(fabs(time->value[i]) < HUGE_VAL) || time->value[i] == floor(time->value[i]);
        recording_warn(recording, "%s has no unit: %s; tunit= says otherwise", time->name,
                       whole ? "seconds assumed, but whole numbers are often milliseconds (tunit=ms)"
                             : "seconds assumed");
    }
    return true;
}

static void set_value_unit(struct recording *recording, const struct unit *unit)
{
    struct column *value = &recording->column[recording->value];
    if (unit) {
        snprintf(value->unit, sizeof value->unit, "%s", unit->row.name);
        value->quantity = unit->quantity;
        value->factor = unit->factor;
    } else if (value->unit[0] && value->quantity == QUANTITY_OTHER) {
        recording_warn(recording,
                       "the unit '%s' of %s is not converted: its numbers are taken as they are; unit=cm (or another) "
                       "says otherwise",
                       value->unit, value->name);
    } else if (!value->unit[0]) {
        recording_warn(
            recording,
            "%s has no unit: its numbers are taken as they are; unit=cm (or m, mm, deg …) says what they are",
            value->name);
    }
}

struct dropped {
    size_t count, line; /* how many, line of the first */
};

static void drop(struct dropped *dropped, size_t line)
{
    if (dropped->count++ == 0)
        dropped->line = line;
}

static void warn_dropped(struct recording *recording, const struct dropped *dropped, const char *one, const char *many)
{
    if (dropped->count > 0)
        recording_warn(recording, "%zu %s: dropped (first: line %zu)", dropped->count, dropped->count == 1 ? one : many,
                       dropped->line);
    recording->dropped += dropped->count;
}

static void keep(struct recording *recording, size_t to, size_t from)
{
    for (int i = 0; to != from && i < recording->columns; i++)
        recording->column[i].value[to] = recording->column[i].value[from];
    recording->line[to] = recording->line[from];
    recording->t[to] = recording->t[from];
}

/*
 * Keeps the rows whose time rises. A single time that is ahead of its successor, where the one before is not, is itself
 * wrong; after any other step back the rows are dropped until the clock has caught up.
 */
static void drop_rows(struct recording *recording)
{
    struct dropped missing = {0}, same = {0}, back = {0};
    size_t kept = 0, rising = 0;
    double last = -HUGE_VAL;
    for (; rising < recording->rows && recording->t[rising] > last; rising++)
        last = recording->t[rising];
    if (rising == recording->rows && last < HUGE_VAL) /* as it should be */
        return;
    for (size_t i = 0; i < recording->rows; i++)
        if (isfinite(recording->t[i]))
            keep(recording, kept++, i);
        else
            drop(&missing, recording->line[i]);
    recording->rows = kept;
    kept = 0;
    for (size_t i = 0; i < recording->rows; i++) {
        const double before = kept > 0 ? recording->t[kept - 1] : -HUGE_VAL, now = recording->t[i];
        const bool ahead = i + 1 < recording->rows && recording->t[i + 1] < now && recording->t[i + 1] > before;
        if (now > before && !ahead)
            keep(recording, kept++, i);
        else
            drop(now == before ? &same : &back, recording->line[i]);
    }
    recording->rows = kept;
    recording->repeated = same.count;
    recording->backward = back.count;
    warn_dropped(recording, &missing, "row has no time", "rows have no time");
    warn_dropped(recording, &same, "row repeats the time before", "rows repeat the time before");
    warn_dropped(recording, &back, "row goes back in time", "rows go back in time");
}

static int compare_reals(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median_step(const struct recording *recording)
{
    double step[MEDIAN_SAMPLE];
    const size_t steps = recording->rows - 1, stride = steps / MEDIAN_SAMPLE + 1;
    size_t count = 0;
    for (size_t i = 0; i < steps; i += stride)
        step[count++] = recording->t[i + 1] - recording->t[i];
    qsort(step, count, sizeof *step, compare_reals);
    return step[count / 2];
}

static void warn_steps(struct recording *recording)
{
    const double median = median_step(recording);
    double least = HUGE_VAL, most = 0, longest = 0;
    size_t uneven = 0, gaps = 0, first = 0;
    for (size_t i = 0; i + 1 < recording->rows; i++) {
        const double step = recording->t[i + 1] - recording->t[i];
        longest = step > longest ? step : longest;
        if (step > GAP * median) {
            first = gaps++ == 0 ? recording->line[i] : first;
            continue;
        }
        least = step < least ? step : least;
        most = step > most ? step : most;
        uneven += fabs(step - median) > UNEVEN * median;
    }
    if (gaps > 0)
        recording_warn(recording,
                       "%zu %s between samples, the longest %.4g s where %.4g s is usual (first: after line %zu)", gaps,
                       gaps == 1 ? "gap" : "gaps", longest, median, first);
    if (uneven > 0)
        recording_warn(
            recording,
            "the sampling is uneven: %zu of %zu steps differ by more than %.0f %% from %.4g s (%.4g to %.4g s)", uneven,
            recording->rows - 1, 100 * UNEVEN, median, least, most);
}

/* Values in SI; what is missing inside is said. */
static bool fill_values(struct recording *recording)
{
    const struct column *column = &recording->column[recording->value];
    struct dropped missing = {0};
    if (!(recording->y = malloc(recording->rows * sizeof *recording->y)))
        return false;
    to_si(column->value, recording->rows, column->factor, recording->y);
    for (size_t i = 0; i < recording->rows; i++)
        if (!isfinite(recording->y[i])) {
            recording->y[i] = NAN;
            drop(&missing, recording->line[i]);
        }
    if (missing.count > 0)
        recording_warn(recording, "%s: %zu %s missing (first: line %zu)", column->name, missing.count,
                       missing.count == 1 ? "value is" : "values are", missing.line);
    return true;
}

bool enough_rows(const struct recording *recording, struct error *error)
{
    return recording->rows >= 2 || error_set(error, ERROR_IO, "only %zu usable %s of data; at least 2 are needed",
                                             recording->rows, recording->rows == 1 ? "row" : "rows");
}

bool recording_time(struct recording *recording, const struct load_options *options, struct error *error)
{
    if (!set_time_unit(recording, options, error))
        return false;
    set_value_unit(recording, options->unit);
    const struct column *time = recording->time >= 0 ? &recording->column[recording->time] : NULL;
    if (recording->source == TIME_COLUMN)
        to_si(time->value, recording->rows, time->factor, recording->t);
    else
        for (size_t i = 0; i < recording->rows; i++)
            recording->t[i] = (time ? time->value[i] : recording->t[i]) / options->rate;
    drop_rows(recording);
    if (!enough_rows(recording, error))
        return false;
    recording->dt = (recording->t[recording->rows - 1] - recording->t[0]) / (double)(recording->rows - 1);
    recording->rate = options->rate > 0 ? options->rate : 1 / recording->dt;
    warn_steps(recording);
    if (!fill_values(recording))
        return error_memory(error);
    recording_restore(recording);
    return true;
}
