/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sweeps at a section: orbit diagrams, as a table, as densities in text. */
#include <hooke/report.h>
#include <hooke/study/sweep.h>

#include <math.h>
#include <string.h>

enum {
    DIAGRAM_ROWS = 20,    /* at least, of the whole answer */
    DIAGRAM_ROWS_MIN = 6, /* of the short one */
    DIAGRAM_COLUMNS = 200,
    MAP_MAX = 1 << 24 /* points */
};

/* ---- the numbers of a point ---- */

static const double *events_of(const struct swept *swept, int64_t i)
{
    return swept->sweep->value + i * swept->sweep->measures + 1;
}

static int64_t event_count(const struct swept *swept, int64_t i)
{
    const double *value = events_of(swept, i);
    int64_t count = 0;
    while (count < swept->section->keep && !isnan(value[count * (1 + swept->measures)]))
        count++;
    return count;
}

/* From the smallest to the largest of a column, over all points. */
static double span_of(const struct swept *swept, int column)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (int64_t i = 0; i < swept->sweep->count; i++) {
        const int64_t count = event_count(swept, i);
        for (int64_t k = 0; k < count; k++) {
            const double value = events_of(swept, i)[k * (1 + swept->measures) + 1 + column];
            low = isfinite(value) ? fmin(low, value) : low;
            high = isfinite(value) ? fmax(high, value) : high;
        }
    }
    return high - low;
}

/* After so many events its states come again; NAN: not within half of those kept. */
static double repeats_at(const struct swept *swept, int64_t i)
{
    return events_of(swept, i)[-1];
}

static double position_at(const struct sweep *sweep, int axis, int64_t i)
{
    return sweep_axis_value(&sweep->axis[axis], (int)sweep_number(sweep, axis, i));
}

static enum quantity quantity_of(const struct swept *swept, int measure)
{
    return sweep_measure_quantity(&swept->measure[measure], swept->model);
}

/* ---- the table ---- */

/* Before what is measured: the number of the point, the parameters, event, t. */
static int columns_before(const struct sweep *sweep)
{
    return 3 + sweep->axes;
}

static bool name_columns(const struct swept *swept, struct arena *arena,
                         struct table_column *column)
{
    const struct sweep *sweep = swept->sweep;
    const int n = swept->measures, before = columns_before(sweep);
    struct buffer next = {0};
    buffer_format(&next, "%s_next", sweep_measure_name(&swept->measure[0]));
    column[0] = (struct table_column){.name = "point", .unit = ""};
    for (int a = 0; a < sweep->axes; a++)
        column[1 + a] =
            (struct table_column){.name = arena_text(arena, text_of(sweep->axis[a].name)),
                                  .unit = quantity_unit(sweep->axis[a].quantity)};
    column[before - 2] = (struct table_column){.name = "event", .unit = ""};
    column[before - 1] = (struct table_column){.name = "t", .unit = "s"};
    for (int m = 0; m <= n; m++)
        column[before + m] = (struct table_column){
            .name = m < n ? arena_text(arena, text_of(sweep_measure_name(&swept->measure[m])))
                          : arena_text(arena, buffer_text(&next)),
            .unit = quantity_unit(quantity_of(swept, m < n ? m : 0))};
    column[before + n + 1] = (struct table_column){.name = "repeats", .unit = ""};
    column[before + n + 2] = (struct table_column){.name = "status", .unit = ""};
    bool ok = !next.failed;
    for (int c = 0; c < before + n + 3; c++)
        ok &= column[c].name != NULL;
    buffer_free(&next);
    return ok;
}

/* What is missing has none. */
static size_t row_count(const struct swept *swept, int64_t i)
{
    const int64_t count = event_count(swept, i);
    return count > 0 ? (size_t)count : swept->sweep->status[i] != SWEEP_MISSING;
}

/* The numbers of a table, a column behind the other. */
struct numbers {
    double *value;
    size_t rows;
};

static double *cell(const struct numbers *numbers, int column, size_t row)
{
    return numbers->value + (size_t)column * numbers->rows + row;
}

/* Rows of point i from `row` on; returns how many. */
static size_t fill_rows(const struct swept *swept, int64_t i, const struct numbers *to, size_t row)
{
    const struct sweep *sweep = swept->sweep;
    const int n = swept->measures, width = 1 + n, before = columns_before(sweep);
    const int64_t count = event_count(swept, i), rows = (int64_t)row_count(swept, i);
    for (int64_t k = 0; k < rows; k++, row++) {
        const double *at = events_of(swept, i) + k * width;
        *cell(to, 0, row) = (double)(sweep->first + i);
        for (int a = 0; a < sweep->axes; a++)
            *cell(to, 1 + a, row) = position_at(sweep, a, i);
        *cell(to, before - 2, row) = count > 0 ? (double)(swept->section->skip + k + 1) : NAN;
        for (int m = 0; m <= n; m++)
            *cell(to, before - 1 + m, row) = at[m];
        *cell(to, before + n, row) = k + 1 < count ? at[width + 1] : NAN;
        *cell(to, before + n + 1, row) = repeats_at(swept, i);
    }
    return (size_t)rows;
}

bool diagram_table(const struct swept *swept, struct arena *arena, struct table *table)
{
    const struct sweep *sweep = swept->sweep;
    const int columns = columns_before(sweep) + swept->measures + 3, numbers = columns - 1;
    struct table_column *column = arena_array(arena, (size_t)columns, sizeof *column);
    size_t rows = 0, row = 0;
    for (int64_t i = 0; i < sweep->count; i++)
        rows += row_count(swept, i);
    const char **status = arena_array(arena, rows + 1, sizeof *status);
    const struct numbers all = {arena_array(arena, (size_t)numbers * (rows + 1), sizeof *all.value),
                                rows + 1};
    if (!column || !status || !all.value || !name_columns(swept, arena, column))
        return false;
    for (int c = 0; c < numbers; c++)
        column[c].value = cell(&all, c, 0);
    for (int64_t i = 0; i < sweep->count; i++) {
        const size_t more = fill_rows(swept, i, &all, row);
        for (size_t k = 0; k < more; k++)
            status[row + k] = sweep_status_name(sweep->status[i]);
        row += more;
    }
    column[numbers].text = status;
    *table = (struct table){.column = column, .columns = columns, .rows = rows};
    return true;
}

/* ---- densities ---- */

/* The unit in which a column's largest value says something. */
static const struct unit *unit_of(const struct swept *swept, int column)
{
    double max = 0;
    for (int64_t i = 0; i < swept->sweep->count; i++)
        for (int64_t k = event_count(swept, i) - 1; k >= 0; k--)
            max = fmax(max, fabs(events_of(swept, i)[k * (1 + swept->measures) + 1 + column]));
    return unit_display(quantity_of(swept, column), max);
}

struct density {
    int columns, rows;
    double from, step; /* of a row */
    double *value;     /* [columns][rows] log2(1 + points) */
};

static void count_points(const struct swept *swept, const struct density *d)
{
    for (int64_t i = 0; i < swept->sweep->count; i++)
        for (int64_t k = event_count(swept, i) - 1; k >= 0; k--) {
            const double y = events_of(swept, i)[k * (1 + swept->measures) + 1];
            const int column = (int)(i * d->columns / swept->sweep->count),
                      row = (int)((y - d->from) / d->step);
            if (isfinite(y) && row >= 0)
                d->value[column * d->rows + (row < d->rows ? row : d->rows - 1)]++;
        }
    for (int c = 0; c < d->columns * d->rows; c++)
        d->value[c] = log2(1 + d->value[c]);
}

static void put_density(const struct session *session, const struct swept *swept, int height,
                        struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    int width, whole;
    session_size(session, &width, &whole);
    const double span = span_of(swept, 0);
    struct density d = {.columns = width - 12 > 8 ? width - 12 : 8,
                        .rows = height > DIAGRAM_ROWS_MIN ? height : DIAGRAM_ROWS_MIN,
                        .from = HUGE_VAL};
    d.columns = d.columns < DIAGRAM_COLUMNS ? d.columns : DIAGRAM_COLUMNS;
    d.columns = sweep->count < d.columns ? (int)sweep->count : d.columns;
    for (int64_t i = 0; i < sweep->count; i++)
        for (int64_t k = event_count(swept, i) - 1; k >= 0; k--)
            d.from = fmin(d.from, events_of(swept, i)[k * (1 + swept->measures) + 1]);
    d.step = (span > 0 ? span : fmax(fabs(d.from), 1) * 1e-6) / d.rows;
    double *x = arena_array(arena, (size_t)d.columns, sizeof *x),
           *y = arena_array(arena, (size_t)d.rows, sizeof *y);
    d.value = arena_array(arena, (size_t)(d.columns * d.rows), sizeof *d.value);
    if (!x || !y || !d.value || !isfinite(d.from))
        return;
    for (int c = 0; c < d.columns; c++)
        x[c] = position_at(sweep, 0, (int64_t)c * sweep->count / d.columns);
    for (int r = 0; r < d.rows; r++)
        y[r] = d.from + (r + 0.5) * d.step;
    count_points(swept, &d);
    const struct sweep_axis *axis = &sweep->axis[0];
    const struct unit *unit = unit_of(swept, 0),
                      *across =
                          unit_display(axis->quantity, fmax(fabs(axis->from), fabs(axis->to)));
    const struct heat heat = {.title = "log2(1 + points)",
                              .unit = "",
                              .factor = 1,
                              .x = {axis->name,
                                    across ? across->row.name : quantity_unit(axis->quantity),
                                    across ? across->factor : 1, x, d.columns},
                              .y = {sweep_measure_name(&swept->measure[0]),
                                    unit ? unit->row.name : quantity_unit(quantity_of(swept, 0)),
                                    unit ? unit->factor : 1, y, d.rows},
                              .value = d.value};
    heat_print(&heat, width, d.rows + 5, session_charset(session), text);
}

/* ---- over two parameters ---- */

/* After how many events states come again. */
static void put_repeats(const struct session *session, const struct swept *swept, int height,
                        struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const size_t n = (size_t)sweep->total;
    double *at[2], *value = n <= MAP_MAX ? arena_array(arena, n, sizeof *value) : NULL;
    struct heat_axis side[2];
    int width, whole;
    for (int a = 0; a < 2; a++) {
        const struct sweep_axis *axis = &sweep->axis[a];
        const struct unit *unit =
            unit_display(axis->quantity, fmax(fabs(axis->from), fabs(axis->to)));
        at[a] = arena_array(arena, (size_t)axis->count, sizeof *at[a]);
        if (!at[a] || !value)
            return;
        for (int i = 0; i < axis->count; i++)
            at[a][i] = sweep_axis_value(axis, i);
        side[a] = (struct heat_axis){.label = axis->name,
                                     .unit = unit ? unit->row.name : quantity_unit(axis->quantity),
                                     .factor = unit ? unit->factor : 1,
                                     .value = at[a],
                                     .count = axis->count};
    }
    for (size_t i = 0; i < n; i++)
        value[i] = NAN;
    for (int64_t i = 0; i < sweep->count; i++) {
        const double after = repeats_at(swept, i);
        value[sweep->first + i] = event_count(swept, i) == 0 ? NAN : isnan(after) ? -1 : after;
    }
    const struct heat heat = {.title = "repeats",
                              .unit = "",
                              .factor = 1,
                              .x = side[0],
                              .y = side[1],
                              .value = value,
                              .letters = "*0123456789+"};
    session_size(session, &width, &whole);
    heat_print(&heat, width, height > 8 ? height : 8, session_charset(session), text);
    buffer_put(text, TEXT("1, 2 ..: after so many events its states come again, +: after 10 or "
                          "more, *: they do not, or not yet\n"));
}

/* ---- in words ---- */

/* Where what repeats does so after another number of events than the point before. */
static void put_stretches(const struct swept *swept, int max, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const struct sweep_axis *axis = &sweep->axis[0];
    int lines = 0;
    for (int64_t i = 0, end; i < sweep->count; i = end) {
        const double after = repeats_at(swept, i);
        end = i + 1;
        while (end < sweep->count &&
               (repeats_at(swept, end) == after || (isnan(after) && isnan(repeats_at(swept, end)))))
            end++;
        if (++lines > max) {
            buffer_put(text, TEXT("  ... (all of them: export FILE table)\n"));
            return;
        }
        buffer_format(text, "  %s = ", axis->name);
        buffer_quantity(text, position_at(sweep, 0, i), axis->quantity, 6);
        if (end > i + 1) {
            buffer_put(text, TEXT(" to "));
            buffer_quantity(text, position_at(sweep, 0, end - 1), axis->quantity, 6);
        }
        if (event_count(swept, i) == 0)
            buffer_put(text, TEXT(": no event\n"));
        else if (isnan(after))
            buffer_put(text, TEXT(": does not repeat, or not yet\n"));
        else
            buffer_format(text, ": %.0f point%s\n", after, after == 1 ? "" : "s");
    }
}

void diagram_text(const struct session *session, const struct swept *swept, int rows,
                  struct arena *arena, struct buffer *text)
{
    /* [row] Of the answer, besides those of the diagram and of the stretches. */
    enum { AXES = 5, SUMMARY = 4, SHORT_STRETCHES = 4 };
    const struct sweep *sweep = swept->sweep;
    const struct sweep_section *section = swept->section;
    int width, height;
    session_size(session, &width, &height);
    const int left = rows - AXES - SUMMARY;
    int64_t all = 0, fewer = 0;
    for (int64_t i = 0; i < sweep->count; i++) {
        const int64_t count = event_count(swept, i);
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
    buffer_format(text, "%lld points of the section, after %lld left out at each value\n",
                  (long long)all, (long long)section->skip);
    sweep_summary(sweep, text);
    if (fewer > 0)
        buffer_format(text,
                      "%lld have fewer than %lld: no event came for as long as the duration\n",
                      (long long)fewer, (long long)section->keep);
    sweep_failures(sweep, text);
}
