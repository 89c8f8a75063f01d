/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Access to the numbers of a sweep by point, event and measure, as a table and as a map. */
#include "modules/sweep/swept.h"

#include <math.h>

/* The values of a point at a section are its repeats, then for each event the time and the
 * measures. */
double swept_value(const struct swept *swept, int64_t i, int64_t k, int m)
{
    const double *value = swept->sweep->value + i * swept->sweep->measures;
    return swept->section ? value[2 + k * (1 + swept->measures) + m] : value[m];
}

/* Returns how many events of point i were kept at the section, or 1 without a section. */
int64_t swept_events(const struct swept *swept, int64_t i)
{
    int64_t count = 0;
    if (!swept->section)
        return 1;
    while (count < swept->section->keep && !isnan(swept_value(swept, i, count, -1)))
        count++;
    return count;
}

double swept_repeats(const struct swept *swept, int64_t i)
{
    return swept->sweep->value[i * swept->sweep->measures];
}

double swept_position(const struct sweep *sweep, int axis, int64_t i)
{
    return sweep_axis_value(&sweep->axis[axis], (int)sweep_number(sweep, axis, i));
}

enum quantity swept_quantity(const struct swept *swept, int m)
{
    return sweep_measure_quantity(&swept->measure[m], swept->model);
}

/* Sets *low and *high to the smallest and largest finite value of measure m, or to HUGE_VAL and
 * -HUGE_VAL if there is none. */
void swept_range(const struct swept *swept, int m, double *low, double *high)
{
    *low = HUGE_VAL;
    *high = -HUGE_VAL;
    for (int64_t i = 0; i < swept->sweep->count; i++) {
        const int64_t count = swept_events(swept, i);
        for (int64_t k = 0; k < count; k++) {
            const double value = swept_value(swept, i, k, m);
            if (!isfinite(value))
                continue;
            *low = value < *low ? value : *low;
            *high = value > *high ? value : *high;
        }
    }
}

const struct unit *swept_unit(double max, enum quantity quantity)
{
    return unit_display(quantity, quantity == QUANTITY_TIME && max >= 0.1 ? 1 : max);
}

const char *swept_unit_name(const struct unit *unit, enum quantity quantity)
{
    return unit ? unit->row.name : quantity_unit(quantity);
}

/* ---- maps ---- */

/* Makes an axis of a map with `count` values, evenly distributed over `span` steps of the sweep's
 * axis from number `first` on. Its value is NULL if out of memory. */
struct heat_axis swept_axis(const struct sweep *sweep, int axis, int64_t first, int64_t span,
                            int count, struct arena *arena)
{
    const struct sweep_axis *source = &sweep->axis[axis];
    const struct unit *unit =
        swept_unit(fmax(fabs(source->begin), fabs(source->end)), source->quantity);
    double *value = arena_array(arena, (size_t)count, sizeof *value);
    for (int i = 0; value && i < count; i++)
        value[i] = sweep_axis_value(source, (int)(first + i * span / count));
    return (struct heat_axis){.label = source->name,
                              .unit = swept_unit_name(unit, source->quantity),
                              .factor = unit ? unit->factor : 1,
                              .value = value,
                              .count = count};
}

/* Draws value(swept, i, m) of each point i of a sweep over two parameters as a map in text, at
 * least HEIGHT_MIN rows high; `heat` gives title and unit. Draws nothing for too many points or if
 * out of memory. */
void swept_map(const struct session *session, const struct swept *swept, struct heat heat,
               double value(const struct swept *swept, int64_t i, int m), int m, int height,
               struct arena *arena, struct buffer *text)
{
    enum { POINTS_MAX = 1 << 24, HEIGHT_MIN = 8 };
    const struct sweep *sweep = swept->sweep;
    const int columns = sweep->axis[0].count, rows = sweep->axis[1].count;
    const size_t n = (size_t)sweep->total;
    double *all = n <= POINTS_MAX ? arena_array(arena, n, sizeof *all) : NULL;
    int width, whole;
    heat.x = swept_axis(sweep, 0, 0, columns, columns, arena);
    heat.y = swept_axis(sweep, 1, 0, rows, rows, arena);
    heat.value = all;
    if (!all || !heat.x.value || !heat.y.value)
        return;
    for (size_t i = 0; i < n; i++)
        all[i] = NAN;
    for (int64_t i = 0; i < sweep->count; i++)
        all[sweep->first + i] = value(swept, i, m);
    session_size(session, &width, &whole);
    heat_print(&heat, width, height > HEIGHT_MIN ? height : HEIGHT_MIN, session_charset(session),
               text);
}

/* ---- the table ---- */

/* Appends a column; the name is copied. Returns false if out of memory. */
static bool add_column(struct table *table, struct table_column *column, const char *name,
                       const char *unit, size_t rows, struct arena *arena)
{
    double *value = arena_array(arena, rows + 1, sizeof *value);
    struct table_column *added = &column[table->columns++];
    *added = (struct table_column){arena_text(arena, text_of(name)), unit, value, NULL, false};
    return value && added->name;
}

/* Adds the table's columns of numbers: point, parameters, measures, and at a section event, time,
 * the first measure at the next event, and number of repeats. Returns false if out of memory. */
static bool add_columns(const struct swept *swept, struct table *table, struct table_column *column,
                        struct arena *arena)
{
    const struct sweep *sweep = swept->sweep;
    const size_t rows = table->rows;
    const char *first = sweep_measure_name(&swept->measure[0]);
    bool ok = add_column(table, column, "point", "", rows, arena);
    for (int a = 0; a < sweep->axes && ok; a++)
        ok = add_column(table, column, sweep->axis[a].name, quantity_unit(sweep->axis[a].quantity),
                        rows, arena);
    if (swept->section)
        ok = ok && add_column(table, column, "event", "", rows, arena) &&
             add_column(table, column, "t", "s", rows, arena);
    for (int m = 0; m < swept->measures && ok; m++)
        ok = add_column(table, column, sweep_measure_name(&swept->measure[m]),
                        quantity_unit(swept_quantity(swept, m)), rows, arena);
    if (swept->section) {
        struct buffer next = {0};
        buffer_format(&next, "%s_next", first);
        ok = ok && !next.failed &&
             add_column(table, column, buffer_view(&next), quantity_unit(swept_quantity(swept, 0)),
                        rows, arena) &&
             add_column(table, column, "repeats", "", rows, arena);
        buffer_free(&next);
    }
    return ok;
}

/* Fills in the numbers of a row of the table: event k of the `events` of point i; the columns are
 * those of add_columns(). */
static void fill_row(const struct swept *swept, int64_t i, int64_t k, int64_t events,
                     const struct table_column *column, size_t row)
{
    const struct sweep *sweep = swept->sweep;
    double number[5 + 2 + SWEEP_MEASURES];
    int n = 0;
    number[n++] = (double)(sweep->first + i);
    for (int a = 0; a < sweep->axes; a++)
        number[n++] = swept_position(sweep, a, i);
    if (swept->section) {
        number[n++] = events > 0 ? (double)(swept->section->skip + k + 1) : NAN;
        number[n++] = swept_value(swept, i, k, -1);
    }
    for (int m = 0; m < swept->measures; m++)
        number[n++] = swept_value(swept, i, k, m);
    if (swept->section) {
        number[n++] = k + 1 < events ? swept_value(swept, i, k + 1, 0) : NAN;
        number[n++] = swept_repeats(swept, i);
    }
    for (int c = 0; c < n; c++)
        ((double *)(uintptr_t)column[c].value)[row] = number[c];
}

/* Returns the number of rows of a point: one per event, one without events, none at a section if
 * the point is missing. */
static int64_t row_count(const struct swept *swept, int64_t i)
{
    const int64_t events = swept_events(swept, i);
    return events > 0 ? events : swept->sweep->status[i] != SWEEP_MISSING;
}

/* Makes the table of results in the arena: a row per point, or per event at a section. Returns
 * false if out of memory. */
bool swept_table(const struct swept *swept, struct arena *arena, struct table *table)
{
    const struct sweep *sweep = swept->sweep;
    struct table_column *column =
        arena_array(arena, (size_t)(1 + 2 + 2 + swept->measures + 2 + 1), sizeof *column);
    size_t row = 0;
    *table = (struct table){.column = column};
    for (int64_t i = 0; i < sweep->count; i++)
        table->rows += (size_t)row_count(swept, i);
    const char **status = arena_array(arena, table->rows + 1, sizeof *status);
    if (!column || !status || !add_columns(swept, table, column, arena))
        return false;
    column[table->columns++] = (struct table_column){.name = "status", .unit = "", .text = status};
    for (int64_t i = 0; i < sweep->count; i++) {
        const int64_t events = swept_events(swept, i), rows = row_count(swept, i);
        const bool alike = i > 0 && row > 0 && sweep->status[i] == sweep->status[i - 1];
        const char *name = alike ? status[row - 1] : sweep_status_name(sweep->status[i]);
        for (int64_t k = 0; k < rows; k++, row++) {
            fill_row(swept, i, k, events, column, row);
            status[row] = name;
        }
    }
    return true;
}
