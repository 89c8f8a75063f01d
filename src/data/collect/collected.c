/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Files of lines that were collected: the lines alone are a table that the other formats read; the
 * times of their arrival are a column beside it, where it has none.
 */
#include "data/table/table.h"

#include <hooke/base/numeric.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CUT "\\..."
#define UNIT_NEAR 0.1 /* the device's clock is in ms, us: its rate over that of the arrivals */
#define GAP 1.5       /* steps: lines between are lost */

/* ---- writing ---- */

static bool is_plain(struct text line, size_t i, size_t *len)
{
    const unsigned char c = (unsigned char)line.at[i];
    *len = 1;
    if (c < 0x80)
        return c == '\t' || (c >= ' ' && c < 0x7F);
    const uint32_t codepoint = text_codepoint((struct text){line.at + i, line.len - i}, len);
    const bool plain = codepoint != CODEPOINT_INVALID && !codepoint_hidden(codepoint);
    *len = plain ? *len : 1;
    return plain;
}

void collected_put(struct buffer *file, double arrival, struct text line)
{
    while (line.len > 0 && line.at[line.len - 1] == '\r')
        line.len--;
    buffer_format(file, "%.6f\t", arrival);
    const size_t end = line.len < COLLECTED_LINE ? line.len : COLLECTED_LINE;
    for (size_t i = 0, len; i < end; i += len)
        if (is_plain(line, i, &len))
            buffer_put(file, (struct text){line.at + i, len});
        else
            buffer_format(file, "\\x%02X", (unsigned char)line.at[i]);
    buffer_put(file, line.len > end ? TEXT(CUT "\n") : TEXT("\n"));
}

/* ---- reading ---- */

struct collected_text {
    struct buffer lines; /* as they came; what is garbled is empty */
    double *arrival;     /* [count] of each line, NAN: none is known */
    double *order;       /* [count] counted from 0, without blank ones and remarks */
    size_t count, came;
};

static bool split_lines(const struct table_text *text, struct arena *arena,
                        struct collected *collected, struct collected_text *out)
{
    struct text rest = text->text, line;
    size_t max = 1;
    for (size_t i = 0; i < rest.len; i++)
        max += rest.at[i] == '\n';
    out->arrival = arena_array(arena, max, sizeof *out->arrival);
    out->order = arena_array(arena, max, sizeof *out->order);
    if (!out->arrival || !out->order)
        return false;
    while (rest.len > 0 && text_split(&rest, '\n', &line)) {
        const struct text mark = TEXT(COLLECTED_STATEMENT);
        size_t used = 0;
        double arrival;
        if (text_starts(line, mark)) {
            collected->statement = (struct text){line.at + mark.len, line.len - mark.len};
            continue;
        }
        if (line.len == 0 || line.at[0] == '#' ||
            real_scan(line, '.', &arrival, &used) != REAL_OK || used == line.len ||
            line.at[used] != '\t' || out->count == max)
            continue;
        const struct text came = {line.at + used + 1, line.len - used - 1};
        const bool garbled = came.len > 0 && memchr(came.at, '\\', came.len);
        out->arrival[out->count] = arrival;
        out->order[out->count++] = (double)out->came;
        out->came += garbled || (text_trim(came).len > 0 && !table_comment(came));
        if (!garbled)
            buffer_put(&out->lines, came);
        buffer_char(&out->lines, '\n');
    }
    return !out->lines.failed;
}

/* ---- times ---- */

/* The device's clock counts thousandths where it says nothing, but the arrivals do. */
static const struct unit *clock_unit(struct recording *recording,
                                     const struct collected_text *lines)
{
    static const char *const names[] = {"ms", "us"};
    const struct column *time = &recording->column[recording->time];
    const size_t last = recording->rows - 1;
    const double span = lines->arrival[recording->line[last] - 1] -
                        lines->arrival[recording->line[0] - 1],
                 counted = time->value[last] - time->value[0];
    for (size_t i = 0; i < COUNT_OF(names) && !time->unit[0] && span > 0; i++) {
        const struct unit *unit = NULL;
        if (unit_spelled(text_of(names[i]), &recording->arena, &unit) && unit &&
            fabs(counted * unit->factor / span - 1) < UNIT_NEAR)
            return unit;
    }
    return NULL;
}

/* A column with the times of the samples, from the arrivals of their lines. */
static bool add_arrivals(struct recording *recording, const struct collected_text *lines,
                         struct collected *collected, struct arena *arena)
{
    const size_t n = recording->rows;
    struct column *column =
        arena_array(&recording->arena, (size_t)recording->columns + 1, sizeof *column);
    double *arrival = arena_array(arena, n + 1, sizeof *arrival),
           *order = arena_array(arena, n + 1, sizeof *order);
    if (!column || !arrival || !order)
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
    for (size_t i = 0; i < n; i++) {
        arrival[i] = lines->arrival[recording->line[i] - 1];
        order[i] = lines->order[recording->line[i] - 1];
    }
    return arrival_times(&(struct arrivals){arrival, order, n}, arena, collected, own->value);
}

/* By the columns alone, if one is a clock; else by the arrivals. */
static bool choose_columns(struct recording *recording, const struct collected_text *lines,
                           struct load_options *options, struct collected *collected,
                           struct arena *arena, struct error *error)
{
    char number[16];
    struct error none = {0};
    const bool chosen = recording_choose(recording, options, &none);
    if (chosen && recording->source == TIME_COLUMN) {
        collected->clock = CLOCK_DEVICE;
        if (!options->time_unit)
            options->time_unit = clock_unit(recording, lines);
        return recording_time(recording, options, error);
    }
    if (options->rate > 0 || options->time.len > 0) {
        *error = none;
        return chosen && recording_time(recording, options, error);
    }
    if (!add_arrivals(recording, lines, collected, arena))
        return error_memory(error);
    snprintf(number, sizeof number, "%d", recording->columns);
    options->time = text_of(number);
    options->time_unit = NULL;
    return recording_choose(recording, options, error) && recording_time(recording, options, error);
}

/* ---- what is told ---- */

static void count_lines(struct recording *recording, const struct collected_text *lines,
                        size_t rows, uint32_t first, struct collected *collected)
{
    collected->lines = lines->came;
    collected->last = lines->arrival[lines->count - 1];
    collected->skipped = (size_t)lines->order[first - 1];
    collected->garbled = lines->came - collected->skipped - rows;
    for (size_t i = 0; i < recording->rows; i++)
        collected->garbled += isnan(recording->y[i]) ? 1 : 0;
    if (collected->clock != CLOCK_DEVICE)
        return;
    double *step = malloc(recording->rows * sizeof *step);
    collected->rate = (struct measured){recording->rate, NAN};
    for (size_t i = 0; step && i + 1 < recording->rows; i++)
        step[i] = recording->t[i + 1] - recording->t[i];
    const double usual = step ? quantile(step, recording->rows - 1, 0.5) : NAN;
    for (size_t i = 0; i + 1 < recording->rows && usual > 0; i++) {
        const double steps = (recording->t[i + 1] - recording->t[i]) / usual;
        collected->lost += steps > GAP && steps < 1e9 ? (size_t)(nearbyint(steps) - 1) : 0;
    }
    free(step);
}

static void warn_clock(struct recording *recording, const struct collected *collected)
{
    if (collected->clock == CLOCK_ARRIVAL)
        recording_warn(recording,
                       "the device sends no times: those of a line through %zu arrivals, "
                       "%.6g +- %.2g Hz; they jitter by %.2g ms (at most %.2g ms)",
                       recording->rows, collected->rate.value, collected->rate.uncertainty,
                       1000 * collected->jitter, 1000 * collected->largest);
    else if (collected->clock == CLOCK_UNEVEN)
        recording_warn(recording,
                       "the device sends no times, and its lines arrive unevenly: the times of "
                       "arrival are taken as they are");
    if (collected->lost > 0)
        recording_warn(recording, "%zu %s lost on the way", collected->lost,
                       collected->lost == 1 ? "line was" : "lines were");
}

static bool read_lines(const struct table_text *text, struct collected_text *lines,
                       const struct load_options *options, struct recording *recording,
                       struct collected *collected, struct arena *arena, struct error *error)
{
    const struct format *self =
        (const struct format *)(const void *)catalog_find(&format_catalog, TEXT("collected"));
    struct table_text own = {
        .name = text->name, .text = buffer_text(&lines->lines), .first = 1, .header = 1};
    struct load_options taken = *options;
    if (!table_head(&own, arena))
        return error_memory(error);
    table_find(&own, 0, options, &own.layout, &own.problem);
    if (!format_of(&own, self)->read(&own, options, recording, error) ||
        !enough_rows(recording, error))
        return false;
    const size_t rows = recording->rows;
    const uint32_t first = recording->line[0];
    if (!choose_columns(recording, lines, &taken, collected, arena, error))
        return false;
    count_lines(recording, lines, rows, first, collected);
    warn_clock(recording, collected);
    return true;
}

bool collected_lines(const struct table_text *text, const struct load_options *options,
                     struct recording *recording, struct error *error)
{
    struct arena arena = {0};
    struct collected_text lines = {.count = 0};
    struct collected *collected = arena_alloc(&recording->arena, sizeof *collected);
    bool done = collected != NULL;
    if (done) {
        *collected = (struct collected){.clock = CLOCK_DEVICE};
        done = split_lines(text, &arena, collected, &lines);
    }
    char *statement =
        done ? arena_text(&recording->arena, collected->statement) : NULL; /* outlives the text */
    done = statement ? read_lines(text, &lines, options, recording, collected, &arena, error)
                     : error_memory(error);
    if (done) {
        collected->statement = text_of(statement);
        recording->collected = collected;
    }
    buffer_free(&lines.lines);
    arena_reset(&arena);
    return done;
}
