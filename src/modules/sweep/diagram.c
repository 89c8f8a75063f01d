/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Text of sweeps at a section: orbit diagrams as densities, maps of repeats, and ranges of
 * repeats. */
#include <hooke/base/numeric.h>
#include "modules/sweep/swept.h"

#include <math.h>

enum {
    DIAGRAM_ROWS = 20,    /* least height of the diagram in a full answer [row] */
    DIAGRAM_ROWS_MIN = 6, /* least height in a short answer [row] */
    DIAGRAM_COLUMNS = 200 /* largest width [cell] */
};

/* ---- densities ---- */

/* A grid of cells in which points are counted. */
struct density {
    int columns, rows;
    double y_begin, step; /* lower end of the first row, and height of a row */
    double *value;        /* [columns][rows] log2(1 + points) */
};

/* Counts in d->value the points of all events in each cell, whose column is the parameter and row
 * the first measure, and replaces each count by log2(1 + count). */
static void count_points(const struct swept *swept, const struct density *d)
{
    for (int64_t i = 0; i < swept->sweep->count; i++)
        for (int64_t k = swept_events(swept, i) - 1; k >= 0; k--) {
            const double y = swept_value(swept, i, k, 0);
            const int column = (int)(i * d->columns / swept->sweep->count),
                      row = (int)((y - d->y_begin) / d->step);
            if (isfinite(y) && row >= 0)
                d->value[column * d->rows + (row < d->rows ? row : d->rows - 1)]++;
        }
    for (int c = 0; c < d->columns * d->rows; c++)
        d->value[c] = log2(1 + d->value[c]);
}

/* Appends an orbit diagram of the first measure over the parameter, `height` rows high. Appends
 * nothing if out of memory or without points. */
static void put_density(const struct session *session, const struct swept *swept, int height,
                        struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    int width, whole;
    double high;
    session_size(session, &width, &whole);
    struct density d = {.columns = int_min(int_max(width - 12, 8), DIAGRAM_COLUMNS),
                        .rows = int_max(height, DIAGRAM_ROWS_MIN)};
    d.columns = sweep->count < d.columns ? (int)sweep->count : d.columns;
    swept_range(swept, 0, &d.y_begin, &high);
    const double span = high - d.y_begin;
    d.step = (span > 0 ? span : fmax(fabs(d.y_begin), 1) * 1e-6) / d.rows;
    double *y = arena_array(arena, (size_t)d.rows, sizeof *y);
    d.value = arena_array(arena, (size_t)(d.columns * d.rows), sizeof *d.value);
    const struct heat_axis x = swept_axis(sweep, 0, sweep->first, sweep->count, d.columns, arena);
    if (!x.value || !y || !d.value || !isfinite(d.y_begin))
        return;
    for (int r = 0; r < d.rows; r++)
        y[r] = d.y_begin + (r + 0.5) * d.step;
    count_points(swept, &d);
    const enum quantity quantity = swept_quantity(swept, 0);
    const struct unit *unit = swept_unit(fmax(fabs(d.y_begin), fabs(high)), quantity);
    const struct heat heat = {.title = "log2(1 + points)",
                              .unit = "",
                              .factor = 1,
                              .x = x,
                              .y = {.label = sweep_measure_name(&swept->measure[0]),
                                    .unit = swept_unit_name(unit, quantity),
                                    .factor = unit ? unit->factor : 1,
                                    .value = y,
                                    .count = d.rows},
                              .value = d.value};
    heat_print(&heat, width, d.rows + 5, session_charset(session), text);
}

/* Returns the value of a map of repeats: the number of events after which the states repeat, -1 if
 * they do not, NAN without events. */
static double repeats_of(const struct swept *swept, int64_t i, int m)
{
    (void)m;
    const double repeats = swept_repeats(swept, i);
    if (swept_events(swept, i) == 0)
        return NAN;
    return isnan(repeats) ? -1 : repeats;
}

/* Appends the map of repeats over two parameters. */
static void put_repeats(const struct session *session, const struct swept *swept, int height,
                        struct arena *arena, struct buffer *text)
{
    swept_map(session, swept,
              (struct heat){.title = "repeats", .unit = "", .factor = 1, .letters = "*0123456789+"},
              repeats_of, 0, height, arena, text);
    buffer_put(text, TEXT("number: the states repeat after that many events; +: 10 or more; *: "
                          "not, or not yet\n"));
}

/* ---- in words ---- */

/* Appends at most `max` ranges of the parameter in which states repeat after the same number of
 * events; NaN means that they do not repeat. */
static void put_stretches(const struct swept *swept, int max, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const struct sweep_axis *axis = &sweep->axis[0];
    int lines = 0;
    for (int64_t i = 0, end; i < sweep->count; i = end) {
        const double repeats = swept_repeats(swept, i);
        end = i + 1;
        while (end < sweep->count && (swept_repeats(swept, end) == repeats ||
                                      (isnan(repeats) && isnan(swept_repeats(swept, end)))))
            end++;
        if (++lines > max) {
            buffer_put(text, TEXT("  ... (export FILE table writes all)\n"));
            return;
        }
        buffer_format(text, "  %s = %s", axis->name,
                      SHOWN_QUANTITY(swept_position(sweep, 0, i), axis->quantity, 6));
        if (end > i + 1)
            buffer_format(text, " to %s",
                          SHOWN_QUANTITY(swept_position(sweep, 0, end - 1), axis->quantity, 6));
        if (swept_events(swept, i) == 0)
            buffer_put(text, TEXT(": no event\n"));
        else if (isnan(repeats))
            buffer_put(text, TEXT(": does not repeat, or not yet\n"));
        else
            buffer_format(text, ": %.0f point%s\n", repeats, repeats == 1 ? "" : "s");
    }
}

/* Writes a sweep at a section in text: its diagram, and the number of points that lack events.
 * `rows` is the height of the answer, or 0 for the whole diagram. */
void diagram_text(const struct session *session, const struct swept *swept, int rows,
                  struct arena *arena, struct buffer *text)
{
    /* rows of the answer besides those of the diagram and of the ranges */
    enum { AXES = 5, SUMMARY = 4, SHORT_STRETCHES = 4 };
    const struct sweep *sweep = swept->sweep;
    const struct sweep_section *section = swept->section;
    int width, height;
    session_size(session, &width, &height);
    const int left = rows - AXES - SUMMARY;
    int64_t all = 0, fewer = 0;
    for (int64_t i = 0; i < sweep->count; i++) {
        const int64_t count = swept_events(swept, i);
        all += count;
        fewer += count < section->keep && sweep->status[i] == STOP_END;
    }
    if (sweep->axes > 1)
        put_repeats(session, swept, rows > 0 ? rows - SUMMARY : height - 4, arena, text);
    else {
        const int whole = height - 9 > DIAGRAM_ROWS ? height - 9 : DIAGRAM_ROWS;
        put_density(session, swept, rows > 0 ? left - SHORT_STRETCHES : whole, arena, text);
        put_stretches(swept, rows > 0 ? SHORT_STRETCHES - 1 : DIAGRAM_ROWS, text);
    }
    buffer_format(text, "%lld points of the section; at each value the first %lld are left out\n",
                  (long long)all, (long long)section->skip);
    sweep_summary(sweep, text);
    if (fewer > 0)
        buffer_format(
            text,
            "at %lld parameter value%s fewer than %lld points were found: no event happened "
            "within one duration\n",
            (long long)fewer, plural_s(fewer), (long long)section->keep);
    sweep_failures(sweep, text);
}
