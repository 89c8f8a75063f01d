/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Files of collected lines: writing a line with its arrival, and reading a file as a recording. The
 * lines themselves are a table that the other formats read; the arrivals of lines without times of
 * their own are another column. */
#include "modules/collect/lines.h"

#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* mark behind a line that was cut */
#define CUT_MARK "\\..."
/* the byte order mark of UTF-8 as it is written into the file */
#define BYTE_ORDER_MARK "\\xEF\\xBB\\xBF"
/* largest relative difference by which the rate of a clock may differ from ms or us per second */
#define UNIT_NEAR 0.1

/* ---- writing ---- */

/* Returns true if the character at i is written unchanged; sets *len to its bytes. Others are
 * written as \\xHH, byte by byte. */
static bool is_plain(struct text line, size_t i, size_t *len)
{
    const unsigned char c = (unsigned char)line.data[i];
    *len = 1;
    if (c < 0x80)
        return c == '\t' || (c >= ' ' && c < 0x7F);
    const uint32_t codepoint = text_codepoint(text_after(line, i), len);
    const bool plain = codepoint != CODEPOINT_INVALID && !codepoint_hidden(codepoint);
    *len = plain ? *len : 1;
    return plain;
}

/* Appends a line with its arrival [s] to the text of the file: bytes that are no text as \xHH, what
 * exceeds COLLECTED_LINE bytes cut off with a mark. */
void collected_put(struct buffer *file, double arrival, struct text line)
{
    while (line.len > 0 && line.data[line.len - 1] == '\r')
        line.len--;
    buffer_format(file, "%.6f\t", arrival);
    const size_t end = line.len < COLLECTED_LINE ? line.len : COLLECTED_LINE;
    for (size_t i = 0, len; i < end; i += len)
        if (is_plain(line, i, &len))
            buffer_put(file, (struct text){line.data + i, len});
        else
            buffer_format(file, "\\x%02X", (unsigned char)line.data[i]);
    buffer_put(file, line.len > end ? TEXT(CUT_MARK "\n") : TEXT("\n"));
}

/* ---- reading ---- */

/* Lines of a file, without comments. */
struct collected_text {
    struct buffer lines; /* text of the lines as they came; garbled lines are empty */
    double *arrival;     /* [count] arrival of each line, NAN if unknown */
    /* [count] number of the line, counted from 0 without blank lines and remarks */
    double *order;
    bool *pause; /* [count] true if the collection was paused before the line */
    /* lines; lines without blank ones and remarks; remarks */
    size_t count, came, remarks;
};

/* Splits the text of a collected file into *result: its lines (without arrival times), the arrival
 * time and order of each, and where pauses were. Garbled lines, which contain '\', become empty.
 * Statement and calibration in the comments are stored in *collected. Returns false if out of
 * memory. */
static bool split_lines(const struct table_text *text, struct arena *arena,
                        struct collected *collected, struct collected_text *result)
{
    struct text rest = text->text, line;
    size_t max = 1;
    bool pause = false;
    for (size_t i = 0; i < rest.len; i++)
        max += rest.data[i] == '\n';
    result->arrival = arena_array(arena, max, sizeof *result->arrival);
    result->order = arena_array(arena, max, sizeof *result->order);
    result->pause = arena_array(arena, max, sizeof *result->pause);
    if (!result->arrival || !result->order || !result->pause)
        return false;
    while (rest.len > 0 && text_split(&rest, '\n', &line)) {
        const struct text mark = TEXT(COLLECTED_STATEMENT);
        size_t used = 0;
        double arrival;
        if (text_starts(line, mark)) {
            collected->statement = text_after(line, mark.len);
            continue;
        }
        if (text_starts(line, TEXT(COLLECTED_CALIBRATION))) {
            const size_t len = strlen(COLLECTED_CALIBRATION);
            calibration_take_line(text_after(line, len), &collected->calibration);
            continue;
        }
        pause |= text_is(line, COLLECTED_PAUSE);
        if (line.len == 0 || line.data[0] == '#' ||
            real_scan(line, '.', &arrival, &used) != REAL_OK || used == line.len ||
            line.data[used] != '\t' || result->count == max)
            continue;
        struct text came = {line.data + used + 1, line.len - used - 1};
        if (result->count == 0 && text_starts(came, TEXT(BYTE_ORDER_MARK)))
            came = text_after(came, strlen(BYTE_ORDER_MARK));
        const bool garbled = came.len > 0 && memchr(came.data, '\\', came.len);
        result->arrival[result->count] = arrival;
        result->pause[result->count] = pause && result->count > 0;
        pause = false;
        result->order[result->count++] = (double)result->came;
        const bool remark = !garbled && table_comment(came);
        result->remarks += remark;
        result->came += garbled || (text_trim(came).len > 0 && !remark);
        if (!garbled)
            buffer_put(&result->lines, came);
        buffer_char(&result->lines, '\n');
    }
    return !result->lines.failed;
}

/* ---- times ---- */

/* Returns ms or us if the column of times has no unit and advances by as many counts per second of
 * the arrivals, else NULL. */
static const struct unit *clock_unit(struct recording *recording, double pace)
{
    static const char *const names[] = {"ms", "us"};
    const struct column *time = &recording->column[recording->time];
    for (size_t i = 0; i < COUNT_OF(names) && !time->unit[0]; i++) {
        const struct unit *unit = NULL;
        if (unit_spelled(text_of(names[i]), &recording->arena, &unit) && unit &&
            fabs(pace * unit->factor - 1) < UNIT_NEAR)
            return unit;
    }
    return NULL;
}

/* Collects the arrivals of the lines that became rows of the recording. Returns false if out of
 * memory. */
static bool collect_arrivals(const struct recording *recording, const struct collected_text *lines,
                             struct arena *arena, struct arrivals *result)
{
    const size_t n = recording->rows;
    double *arrival = arena_array(arena, n + 1, sizeof *arrival),
           *order = arena_array(arena, n + 1, sizeof *order);
    bool *pause = arena_array(arena, n + 1, sizeof *pause);
    *result = (struct arrivals){arrival, order, n, false, pause};
    for (size_t i = 0, line = 0; arrival && order && pause && i < n; i++) {
        for (pause[i] = false; line < recording->line[i]; line++)
            pause[i] |= i > 0 && lines->pause[line];
        arrival[i] = lines->arrival[recording->line[i] - 1];
        order[i] = lines->order[recording->line[i] - 1];
    }
    return arrival && order && pause;
}

/* Takes the numbers of the lines from a counter of the device, whose gaps are lost lines. Returns
 * false if out of memory. */
static bool number_by_counter(const struct arrivals *a, const double *counter, struct arena *arena,
                              struct collected *collected, struct arrivals *counted)
{
    double *order = arena_array(arena, a->n + 1, sizeof *order);
    double previous_order = 0;
    for (size_t i = 0, previous_index = 0; order && i < a->n; i++) {
        const double came = i > 0 ? a->order[i] - a->order[previous_index] : 0;
        order[i] = previous_order + came;
        if (isfinite(counter[i])) {
            order[i] = fmax(previous_order + came, counter[i] - counter[0]);
            collected->lost += a->pause[i] ? 0 : (size_t)(order[i] - previous_order - came);
        }
        previous_order = order[i];
        previous_index = i;
    }
    collected->lost_known = true;
    *counted = (struct arrivals){a->arrival, order, a->n, true, a->pause};
    return order != NULL;
}

/* Adds a column "arrival" with the times of the samples, computed from the arrivals of their lines.
 * Returns false if out of memory. */
static bool add_arrivals(struct recording *recording, const struct arrivals *arrivals,
                         struct collected *collected, struct arena *arena)
{
    const size_t n = recording->rows;
    struct column *column =
        arena_array(&recording->arena, (size_t)recording->columns + 1, sizeof *column);
    if (!column)
        return false;
    memcpy(column, recording->column, (size_t)recording->columns * sizeof *column);
    struct column *own = &column[recording->columns];
    *own = (struct column){.quantity = QUANTITY_TIME, .factor = 1, .run = -1};
    snprintf(own->name, sizeof own->name, "arrival");
    snprintf(own->unit, sizeof own->unit, "s");
    own->value = malloc((n + 1) * sizeof *own->value);
    if (!own->value)
        return false;
    recording->column = column;
    recording->columns++;
    return arrival_times(arrivals, arena, collected, own->value);
}

/* A counter of lines is a clock if it counts ms or us to this relative accuracy; a rate within it
 * of the stated one is confirmed. */
#define CLOCK_UNIT_TOLERANCE 0.01

/* Repairs the time stamps in column column_index of a recording (nothing is done for < 0) and
 * describes the repairs in *mended. Steps back are taken as restarts of a clock if that is certain:
 * the user has named the column's unit (`said`), its quantity is a time, or its pace against the
 * arrival times is one of the usual units. Returns false if out of memory. */
static bool mend_clock(struct recording *recording, const struct arrivals *arrivals,
                       int column_index, bool said, struct arena *arena,
                       struct clock_mended *mended)
{
    static const double units[] = {1, 1e3, 1e6}; /* clock units per second: s, ms, us */
    if (column_index < 0)
        return true;
    const struct column *column = &recording->column[column_index];
    double *scratch = arena_array(arena, arrivals->n + 1, sizeof *scratch);
    if (!scratch)
        return false;
    const double pace = clock_pace(arrivals, column->value, scratch);
    for (size_t i = 0; i < COUNT_OF(units); i++)
        said = said || fabs(pace / units[i] - 1) < UNIT_NEAR;
    return clock_mend(arrivals, said || column->quantity == QUANTITY_TIME, arena, column->value,
                      mended);
}

/* Mends the column of times and, if it is the first and might be a counter, the one behind it. */
static bool mend_clocks(struct recording *recording, const struct arrivals *arrivals, bool said,
                        struct arena *arena, struct clock_mended *mended)
{
    const int clock = recording_clock(recording);
    return mend_clock(recording, arrivals, clock, said, arena, mended) &&
           (clock != 0 || recording->columns <= 2 || recording_counter(recording) != 0 ||
            mend_clock(recording, arrivals, 1, said, arena, mended));
}

/* Returns true if a counter that rises by one per line advances by 1000 or 1e6 per second, so that
 * it may be a clock. */
static bool counts_time(double pace)
{
    return fabs(pace / 1e3 - 1) < CLOCK_UNIT_TOLERANCE ||
           fabs(pace / 1e6 - 1) < CLOCK_UNIT_TOLERANCE;
}

/* Makes the column the one of times. Returns false with an error. */
static bool choose_time(struct recording *recording, struct load_options *options, int column_index,
                        struct arena *arena, struct error *error)
{
    char number[16];
    snprintf(number, sizeof number, "%d", column_index + 1);
    const char *copy = arena_text(arena, text_of(number));
    options->time = copy ? text_of(copy) : options->time;
    return copy ? recording_choose(recording, options, error) : error_memory(error);
}

/* Places samples by the stated rate= [Hz]: their numbers come from the arrivals, lost lines
 * included, if these confirm the rate. Returns false if out of memory. */
static bool place_by_rate(struct recording *recording, const struct arrivals *arrivals, double rate,
                          struct collected *collected, struct arena *arena)
{
    struct collected known = {.lost = 0};
    double *t = arena_array(arena, recording->rows + 1, sizeof *t);
    if (!t || !arrival_times(arrivals, arena, &known, t))
        return false;
    collected->by_rate = recording->source == TIME_RATE;
    if (recording->source != TIME_RATE || known.clock != CLOCK_ARRIVAL ||
        !(fabs(known.rate.value / rate - 1) < CLOCK_UNIT_TOLERANCE))
        return true;
    for (size_t i = 0; i < recording->rows; i++)
        recording->t[i] = nearbyint((t[i] - t[0]) * known.rate.value);
    collected->lost = known.lost;
    collected->lost_known = known.lost_known;
    return true;
}

/* Chooses the columns of time and value: a clock among the columns, or rate=, or else the arrivals.
 * Returns false with an error. */
static bool choose_columns(struct recording *recording, const struct collected_text *lines,
                           struct load_options *options, struct collected *collected,
                           struct clock_mended *mended, struct arena *arena, struct error *error)
{
    struct error none = {0};
    struct arrivals arrivals, counted;
    if (!collect_arrivals(recording, lines, arena, &arrivals) ||
        !mend_clocks(recording, &arrivals, options->time_unit != NULL, arena, mended))
        return error_memory(error);
    bool chosen = recording_choose(recording, options, &none);
    const int counter = chosen ? -1 : recording_counter(recording);
    const bool given = options->rate > 0 || options->time.len > 0;
    double *scratch = arena_array(arena, arrivals.n + 1, sizeof *scratch);
    if (!scratch)
        return error_memory(error);
    const int column_index = chosen ? recording->time : counter;
    const double pace = column_index < 0
                            ? NAN
                            : clock_pace(&arrivals, recording->column[column_index].value, scratch);
    if (counter >= 0 && !given && (options->time_unit || counts_time(pace)))
        chosen = choose_time(recording, options, counter, arena, &none);
    if (chosen && recording->source == TIME_COLUMN) {
        collected->clock = CLOCK_DEVICE;
        if (!options->time_unit)
            options->time_unit = clock_unit(recording, pace);
        return recording_time(recording, options, error);
    }
    if (given) {
        *error = none;
        return chosen && place_by_rate(recording, &arrivals, options->rate, collected, arena) &&
               recording_time(recording, options, error);
    }
    if ((counter >= 0 && !number_by_counter(&arrivals, recording->column[counter].value, arena,
                                            collected, &counted)) ||
        !add_arrivals(recording, counter >= 0 ? &counted : &arrivals, collected, arena))
        return error_memory(error);
    options->time_unit = NULL;
    return choose_time(recording, options, recording->columns - 1, arena, error) &&
           recording_time(recording, options, error);
}

/* ---- counts and warnings ---- */

/* Counts the lines lost between samples of a device with a clock. `line` and `rows` are those
 * before rows were dropped. Returns false if out of memory. */
static bool count_lost(const struct recording *recording, const struct collected_text *lines,
                       const struct clock_mended *mended, const uint32_t *line, size_t rows,
                       struct arena *arena, struct collected *collected)
{
    struct arrivals arrivals;
    double *scratch = arena_array(arena, recording->rows + 1, sizeof *scratch);
    bool *is_restart = arena_array(arena, recording->rows + 1, sizeof *is_restart);
    if (!scratch || !is_restart || !collect_arrivals(recording, lines, arena, &arrivals))
        return false;
    for (size_t i = 0, row = 0; mended->is_restart && i < recording->rows; i++) {
        for (; row < rows && line[row] < recording->line[i]; row++)
            is_restart[i] |= mended->is_restart[row];
        is_restart[i] |= row < rows && mended->is_restart[row];
    }
    collected->lost =
        clock_lost(&arrivals, recording->t, is_restart, scratch, &collected->lost_known);
    return true;
}

/* Fills the numbers of lines of each kind; `first` is the line of the first sample. */
static void count_lines(const struct recording *recording, const struct collected_text *lines,
                        uint32_t first, struct collected *collected)
{
    size_t missing = 0;
    for (size_t i = 0; i < recording->rows; i++)
        missing += isnan(recording->y[i]) ? 1 : 0;
    collected->lines = lines->came + lines->remarks;
    collected->remarks = lines->remarks;
    collected->last = lines->arrival[lines->count - 1];
    collected->skipped = (size_t)lines->order[first - 1];
    collected->repeated = recording->repeated;
    collected->samples = recording->rows - missing;
    collected->garbled =
        lines->came - collected->skipped - collected->samples - collected->repeated;
    if (collected->clock == CLOCK_DEVICE)
        collected->rate = (struct measured){recording->rate, NAN};
}

/* Adds warnings about the recording's times: how often the device's clock was mended, that times
 * come from arrivals and how accurate they are, and how many lines were lost, or why that is
 * unknown. */
static void warn_clock(struct recording *recording, const struct collected *collected,
                       const struct clock_mended *mended)
{
    if (mended->starts > 0)
        recording_warn(recording,
                       "the device's clock restarted %zu %s; later times follow the arrivals",
                       mended->starts, mended->starts == 1 ? "time" : "times");
    if (mended->wraps > 0)
        recording_warn(recording, "the device's clock overflowed %zu %s; its times are continued",
                       mended->wraps, mended->wraps == 1 ? "time" : "times");
    if (collected->clock == CLOCK_ARRIVAL)
        recording_warn(recording,
                       "the device sends no times; they are taken from a straight line through %zu "
                       "arrivals, %.6g +- %.2g Hz, with a jitter of %.2g ms (at most %.2g ms); "
                       "this limits the accuracy of periods to %.2g %%",
                       recording->rows, collected->rate.value, collected->rate.uncertainty,
                       1000 * collected->jitter, 1000 * collected->largest,
                       100 * collected->rate.uncertainty / collected->rate.value);
    else if (collected->clock == CLOCK_UNEVEN)
        recording_warn(recording, "the device sends no times and its lines arrive unevenly, so the "
                                  "arrival times are used");
    if (collected->lost > 0)
        recording_warn(recording, "%zu %s lost", collected->lost,
                       collected->lost == 1 ? "line was" : "lines were");
    if (!collected->lost_known) {
        const char *const more = collected->lost > 0 ? "more " : "";
        const char *reason;
        if (collected->by_rate)
            reason = "the arrivals are too uneven, or not at rate=";
        else if (collected->clock == CLOCK_DEVICE)
            reason = "the device's times are uneven";
        else
            reason = collected->clock == CLOCK_UNEVEN
                         ? "they arrive unevenly"
                         : "there are few lines, or several arrive at once";
        recording_warn(recording, "it is unknown whether %slines were lost: %s", more, reason);
    }
}

/* Returns the unit of the value stated in the command that collected it. */
static const struct unit *stated_unit(struct text statement)
{
    const struct text key = TEXT(" unit=");
    while (statement.len > 0 && !text_starts(statement, key))
        statement = text_after(statement, 1);
    size_t len = key.len;
    while (len < statement.len && statement.data[len] != ' ')
        len++;
    return statement.len > 0 ? unit_find((struct text){statement.data + key.len, len - key.len})
                             : NULL;
}

/* Reads the table in the lines, by the format that recognizes it, and finds the times of its rows.
 * Returns false with an error. */
static bool read_lines(const struct table_text *text, struct collected_text *lines,
                       const struct load_options *options, struct recording *recording,
                       struct collected *collected, struct arena *arena, struct error *error)
{
    const struct format *self = format_by_name(TEXT("collected"));
    struct table_text own = {
        .name = text->name, .text = buffer_text(&lines->lines), .first = 1, .header = 1};
    struct load_options taken = *options;
    taken.unit = taken.unit ? taken.unit : stated_unit(collected->statement);
    taken.calibration = taken.calibration ? taken.calibration : &collected->calibration;
    if (!table_head(&own, arena))
        return error_memory(error);
    table_find(&own, 0, options, &own.layout, &own.problem);
    if (!format_of(&own, self)->read(&own, options, recording, error) ||
        !enough_rows(recording, error))
        return false;
    const size_t rows = recording->rows;
    uint32_t *line = arena_array(arena, rows, sizeof *line);
    struct clock_mended mended = {.is_restart = NULL};
    if (!line)
        return error_memory(error);
    memcpy(line, recording->line, rows * sizeof *line);
    if (!choose_columns(recording, lines, &taken, collected, &mended, arena, error))
        return false;
    if (collected->clock == CLOCK_DEVICE && !collected->by_rate &&
        !count_lost(recording, lines, &mended, line, rows, arena, collected))
        return error_memory(error);
    count_lines(recording, lines, line[0], collected);
    warn_clock(recording, collected, &mended);
    return true;
}

/* Reads a file of collected lines into a recording. Returns false with an error. */
bool collected_lines(const struct table_text *text, const struct load_options *options,
                     struct recording *recording, struct error *error)
{
    struct arena arena = {0};
    struct collected_text lines = {.count = 0};
    struct collected *collected = arena_alloc(&recording->arena, sizeof *collected);
    char *statement = NULL; /* outlives the text */
    bool done = false;
    if (collected) {
        *collected = (struct collected){.clock = CLOCK_DEVICE};
        if (split_lines(text, &arena, collected, &lines))
            statement = arena_text(&recording->arena, collected->statement);
    }
    if (!statement) {
        error_memory(error);
    } else if (read_lines(text, &lines, options, recording, collected, &arena, error)) {
        collected->statement = text_of(statement);
        recording->collected = collected;
        done = true;
    }
    buffer_free(&lines.lines);
    arena_reset(&arena);
    return done;
}
