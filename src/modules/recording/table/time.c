/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Makes rising times [s] and values [SI] from the chosen columns. Irregular times are counted and
 * reported. */
#include "modules/recording/table/table.h"

#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>
#include <hooke/data/even_times.h>

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Steps that are examined for the median. */
#define MEDIAN_SAMPLE 4096
/* Deviation from the median step, as a fraction of it, above which the sampling is called
 * uneven. */
#define UNEVEN_STEP_FRACTION 0.1
/* Median steps above which a step is a gap. */
#define GAP_MEDIAN_STEPS 1.5

/* Converts numbers [n] to SI as unit_convert() does, but by division if the factor is 1/n, so that
 * decimal fractions are rounded once. */
static void to_si(const double *number, size_t n, double factor, double *si)
{
    const double inverse = nearbyint(1 / factor);
    const bool divide = factor < 1 && inverse * factor == 1;
    for (size_t i = 0; i < n; i++)
        si[i] = divide ? number[i] / inverse : number[i] * factor;
}

/* Returns true if the time column counts seconds, milli-, micro- or nanoseconds since 1970,
 * recognised by the size of its first value (years 1990 to 2100). Counts it from the first value
 * then, with a warning. */
static bool set_epoch(struct recording *recording, struct column *time)
{
    static const struct {
        double per_second;
        const char *unit;
    } clocks[] = {{1, "s"}, {1e3, "ms"}, {1e6, "us"}, {1e9, "ns"}};
    const double first = recording->rows > 0 ? time->value[0] : NAN;
    for (size_t i = 0; i < COUNT_OF(clocks); i++) {
        if (!(first > 631152000 * clocks[i].per_second &&
              first < 4102444800 * clocks[i].per_second))
            continue;
        for (size_t row = 0; row < recording->rows; row++)
            time->value[row] -= first;
        snprintf(time->unit, sizeof time->unit, "%s", clocks[i].unit);
        time->quantity = QUANTITY_TIME;
        time->factor = 1 / clocks[i].per_second;
        recording_warn(recording,
                       "%s counts %s since 1970; the time is counted from the first value, %.0f "
                       "(tunit= changes that)",
                       time->name, clocks[i].unit, first);
        return true;
    }
    return false;
}

/* Sets the unit of the time column: the requested one, the file's, or seconds with a warning.
 * Returns false with the error if the unit is unusable. */
static bool set_time_unit(struct recording *recording, const struct load_options *options,
                          struct error *error)
{
    const struct unit *unit = options->time_unit;
    if (recording->source != TIME_COLUMN)
        return !unit ||
               error_set(error, ERROR_COMMAND, "tunit= has no meaning together with rate=");
    struct column *time = &recording->column[recording->time];
    if (unit && unit->quantity != QUANTITY_TIME)
        return error_set(error, ERROR_COMMAND, "tunit= needs a time (s, ms, min), got '%s' (%s)",
                         unit->row.name, quantity_name(unit->quantity));
    if (unit) {
        snprintf(time->unit, sizeof time->unit, "%s", unit->row.name);
        time->quantity = QUANTITY_TIME;
        time->factor = unit->factor;
    } else if (time->quantity != QUANTITY_TIME && time->unit[0]) {
        error_set(error, options->time.len > 0 ? ERROR_COMMAND : ERROR_IO,
                  "the unit of '%s' is '%s', which is not a known unit of time", time->name,
                  time->unit);
        return error_hint(error, "tunit=s reads its numbers as seconds");
    } else if (time->quantity != QUANTITY_TIME && set_epoch(recording, time)) {
        return true;
    } else if (time->quantity != QUANTITY_TIME) {
        bool whole = true;
        for (size_t i = 0; i < recording->rows && whole; i++)
            whole = !(fabs(time->value[i]) < HUGE_VAL) || time->value[i] == floor(time->value[i]);
        recording_warn(recording, "%s has no unit: %s; tunit= sets another unit", time->name,
                       whole
                           ? "seconds assumed, but whole numbers are often milliseconds (tunit=ms)"
                           : "seconds assumed");
    }
    return true;
}

/* Sets the unit of the value column to `unit` unless NULL; warns if the unit remains unknown. */
static void set_value_unit(struct recording *recording, const struct unit *unit)
{
    struct column *value = &recording->column[recording->value];
    if (unit) {
        snprintf(value->unit, sizeof value->unit, "%s", unit->row.name);
        value->quantity = unit->quantity;
        value->factor = unit->factor;
    } else if (value->unit[0] && value->quantity == QUANTITY_OTHER) {
        recording_warn(recording,
                       "the unit '%s' of %s is unknown; the numbers are used unchanged (unit=cm or "
                       "another sets a known unit)",
                       value->unit, value->name);
    } else if (!value->unit[0]) {
        recording_warn(
            recording,
            "%s has no unit; its numbers are used unchanged (unit=cm, m, mm, deg … sets one)",
            value->name);
    }
}

/* Rows that are left out for one reason. */
struct dropped {
    size_t count, line; /* number of such rows, and line of the first */
};

static void dropped_note(struct dropped *dropped, size_t line)
{
    if (dropped->count++ == 0)
        dropped->line = line;
}

/* Warns of dropped rows in the words for one or for several, and counts them in the recording. */
static void warn_dropped(struct recording *recording, const struct dropped *dropped,
                         const char *one, const char *many)
{
    if (dropped->count > 0)
        recording_warn(recording, "%zu %s: dropped (first: line %zu)", dropped->count,
                       dropped->count == 1 ? one : many, dropped->line);
    recording->dropped += dropped->count;
}

/* Copies row `source` to row `target`. */
static void keep_time_row(struct recording *recording, size_t target, size_t source)
{
    for (int i = 0; target != source && i < recording->columns; i++)
        recording->column[i].value[target] = recording->column[i].value[source];
    recording->line[target] = recording->line[source];
    recording->t[target] = recording->t[source];
}

/* ---- rounded stamps ---- */

/* Share of rows that repeat the previous stamp, above which the clock was rounded, evenly or not.
 * Fewer repeats are faults of a logger. */
static const double repeats_of_rounded_clock = 0.2;

/* Returns the smallest step [s] between different stamps. */
static double stamp_step_min(const struct recording *recording)
{
    double smallest = HUGE_VAL;
    for (size_t i = 1; i < recording->rows; i++) {
        const double step = recording->t[i] - recording->t[i - 1];
        if (step > 0 && step < smallest)
            smallest = step;
    }
    return smallest;
}

/* Changes the times of consecutive rows with the same stamp, so that they are spread evenly from
 * that stamp to the next one. The last group is spread like the one before. */
static void spread_groups(struct recording *recording)
{
    const size_t n = recording->rows;
    double last = 0;
    for (size_t i = 0, next; i < n; i = next) {
        for (next = i + 1; next < n && recording->t[next] == recording->t[i];)
            next++;
        const double t_group = recording->t[i], count = (double)(next - i);
        last = next < n ? (recording->t[next] - t_group) / count : last;
        for (size_t k = i; k < next; k++)
            recording->t[k] = t_group + last * (double)(k - i);
    }
}

/* Corrects stamps with too few digits, which repeat, if no stamp goes back: 24 pictures a second in
 * hundredths of a second, for example. If all stamps lie within their rounding of a line through
 * the rows, the times are taken from the line; else rows that share a stamp are spread. To drop the
 * repeats would shorten some steps and not others. */
static void spread_stamps(struct recording *recording)
{
    size_t repeated = 0;
    struct even_times even;
    if (recording->source != TIME_COLUMN || recording->rows < 8 || recording->collected)
        return;
    for (size_t i = 1; i < recording->rows; i++) {
        if (!(recording->t[i] >= recording->t[i - 1]))
            return;
        repeated += recording->t[i] == recording->t[i - 1];
    }
    even_times_find(recording->t, recording->column[recording->value].value, recording->rows,
                    recording->cancel, &even);
    if (even.even && even.resolution > 0) {
        for (size_t i = 0; i < recording->rows; i++)
            recording->t[i] = even.first + even.step * (double)i;
        recording->pace = even.pace;
    } else if ((double)repeated >= repeats_of_rounded_clock * (double)recording->rows &&
               repeated + 2 <= recording->rows) {
        even.even = false;
        even.resolution = stamp_step_min(recording);
        spread_groups(recording);
    } else {
        return;
    }
    const char *times = even.even ? "at even times (a straight line through the time stamps)"
                                  : "spread between the time stamps";
    if (repeated > 0)
        recording_warn(
            recording,
            "%zu %s the previous time, which was rounded to %.3g s; all rows are kept, %s",
            repeated, repeated == 1 ? "row repeats" : "rows repeat", even.resolution, times);
}

/* Keeps the rows whose time rises. A single time that is ahead of the next row, while the previous
 * one is not, is wrong itself; after any other step back, rows are dropped until the clock has
 * caught up. */
static void drop_rows(struct recording *recording)
{
    struct dropped missing = {0}, same = {0}, back = {0};
    size_t rows_used = 0, rising = 0;
    double last = -HUGE_VAL;
    for (; rising < recording->rows && recording->t[rising] > last; rising++)
        last = recording->t[rising];
    if (rising == recording->rows && last < HUGE_VAL) /* all times rise */
        return;
    for (size_t i = 0; i < recording->rows && !cancelled_at(recording->cancel, i); i++)
        if (isfinite(recording->t[i]))
            keep_time_row(recording, rows_used++, i);
        else
            dropped_note(&missing, recording->line[i]);
    recording->rows = rows_used;
    rows_used = 0;
    for (size_t i = 0; i < recording->rows && !cancelled_at(recording->cancel, i); i++) {
        const double previous = rows_used > 0 ? recording->t[rows_used - 1] : -HUGE_VAL,
                     now = recording->t[i];
        const bool ahead =
            i + 1 < recording->rows && recording->t[i + 1] < now && recording->t[i + 1] > previous;
        if (now > previous && !ahead)
            keep_time_row(recording, rows_used++, i);
        else
            dropped_note(now == previous ? &same : &back, recording->line[i]);
    }
    recording->rows = rows_used;
    recording->repeated = same.count;
    recording->backward = back.count;
    warn_dropped(recording, &missing, "row has no time", "rows have no time");
    warn_dropped(recording, &same, "row repeats the previous time",
                 "rows repeat the previous time");
    warn_dropped(recording, &back, "row goes back in time", "rows go back in time");
}

static void values_swap(double *a, double *b)
{
    const double was = *a;
    *a = *b;
    *b = was;
}

/* Reverses every column and the line numbers, and warns. */
void recording_reverse(struct recording *recording)
{
    for (size_t i = 0, j = recording->rows; i + 1 < j && !cancelled_at(recording->cancel, i); i++) {
        j--;
        for (int k = 0; k < recording->columns; k++)
            values_swap(&recording->column[k].value[i], &recording->column[k].value[j]);
        const uint32_t line = recording->line[i];
        recording->line[i] = recording->line[j];
        recording->line[j] = line;
    }
    recording_warn(recording, "the newest row comes first, so the rows are sorted by time");
}

/* Takes at most MEDIAN_SAMPLE steps, evenly spread. */
double recording_median_step(const struct recording *recording)
{
    double step[MEDIAN_SAMPLE];
    const size_t steps = recording->rows - 1, stride = steps / MEDIAN_SAMPLE + 1;
    size_t count = 0;
    for (size_t i = 0; i < steps; i += stride)
        step[count++] = recording->t[i + 1] - recording->t[i];
    return values_quantile(step, count, 0.5);
}

/* Warns of gaps and of uneven sampling. */
static void warn_steps(struct recording *recording)
{
    const double median = recording_median_step(recording);
    double min = HUGE_VAL, max = 0, longest = 0;
    size_t uneven = 0, gaps = 0, first = 0;
    for (size_t i = 0; i + 1 < recording->rows && !cancelled_at(recording->cancel, i); i++) {
        const double step = recording->t[i + 1] - recording->t[i];
        longest = step > longest ? step : longest;
        if (step > GAP_MEDIAN_STEPS * median) {
            first = gaps++ == 0 ? recording->line[i] : first;
            continue;
        }
        min = step < min ? step : min;
        max = step > max ? step : max;
        uneven += fabs(step - median) > UNEVEN_STEP_FRACTION * median;
    }
    if (gaps > 0)
        recording_warn(recording,
                       "%zu %s between samples; the longest is %.4g s instead of %.4g s (first: "
                       "after line %zu)",
                       gaps, gaps == 1 ? "gap" : "gaps", longest, median, first);
    if (uneven > 0)
        recording_warn(recording,
                       "the sampling is uneven: %zu of %zu steps differ by more than %.0f %% from "
                       "%.4g s (they are %.4g to %.4g s)",
                       uneven, recording->rows - 1, 100 * UNEVEN_STEP_FRACTION, median, min, max);
}

/* Computes the values in SI; warns of missing ones, which become NAN. Returns false if out of
 * memory. */
static bool fill_values(struct recording *recording)
{
    const struct column *column = &recording->column[recording->value];
    struct dropped missing = {0};
    assert(recording->rows > 0);
    if (!(recording->y = malloc(recording->rows * sizeof *recording->y)))
        return false;
    to_si(column->value, recording->rows, column->factor, recording->y);
    for (size_t i = 0; i < recording->rows && !cancelled_at(recording->cancel, i); i++)
        if (!isfinite(recording->y[i])) {
            recording->y[i] = NAN;
            dropped_note(&missing, recording->line[i]);
        }
    if (missing.count > 0)
        recording_warn(recording, "%s: %zu %s missing (first: line %zu)", column->name,
                       missing.count, missing.count == 1 ? "value is" : "values are", missing.line);
    return true;
}

void recording_set_step(struct recording *recording)
{
    struct even_times even;
    even_times_find(recording->t, NULL, recording->rows, recording->cancel, &even);
    recording->dt = even.step;
}

bool enough_rows(const struct recording *recording, struct error *error)
{
    return recording->rows >= 2 ||
           error_set(error, ERROR_IO, "only %zu usable %s of data; at least 2 are needed",
                     recording->rows, recording->rows == 1 ? "row" : "rows");
}

/* Returns false with the error if reading was cancelled; called between two passes over the
 * rows. */
static bool reading_continues(const struct recording *recording, struct error *error)
{
    return !cancelled(recording->cancel) ||
           error_set(error, ERROR_CANCELLED, "reading was stopped");
}

/* Computes times from the column or the rate, corrects faulty clocks, drops rows whose time does
 * not rise, and computes the values in SI. Returns false with the error. */
bool recording_time(struct recording *recording, const struct load_options *options,
                    struct error *error)
{
    if (!set_time_unit(recording, options, error))
        return false;
    set_value_unit(recording, options->unit);
    if (options->calibration && !recording_calibrate(recording, options->calibration, error))
        return false;
    const struct column *time = recording->time >= 0 ? &recording->column[recording->time] : NULL;
    const double rate = options->rate > 0 ? options->rate : recording->header_rate;
    if (time && recording->source == TIME_COLUMN)
        to_si(time->value, recording->rows, time->factor, recording->t);
    else
        for (size_t i = 0; i < recording->rows; i++) {
            const double index = time ? time->value[i] : recording->t[i];
            recording->t[i] = (options->rate > 0 ? 0 : recording->header_start) + index / rate;
        }
    if (!reading_continues(recording, error) || !take_run_below(recording, options, error))
        return false;
    mend_clock_jumps(recording);
    spread_stamps(recording);
    if (!reading_continues(recording, error))
        return false;
    drop_rows(recording);
    if (!reading_continues(recording, error) || !enough_rows(recording, error))
        return false;
    recording_set_step(recording);
    recording->rate = recording->source != TIME_COLUMN ? rate : 1 / recording->dt;
    warn_steps(recording);
    if (!fill_values(recording))
        return error_memory(error);
    recording_restore(recording);
    return reading_continues(recording, error);
}
