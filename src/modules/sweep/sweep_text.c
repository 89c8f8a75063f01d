/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Text of sweeps that are measured over the duration: a table, curves, maps, and remarks. */
#include "modules/sweep/swept.h"

#include <math.h>
#include <string.h>

enum {
    TABLE_ROWS = 40,      /* largest number of rows of a table */
    FIGURE_ROWS_MIN = 10, /* smallest height [row] at which a figure shows more than a table */
    /* curves with more points are drawn by the extremes of this number of blocks */
    THIN_BLOCKS = 2048
};

/* Returns measure m of point i, for swept_map() and others. */
static double swept_cell_value(const struct swept *swept, int64_t i, int m)
{
    return swept_value(swept, i, 0, m);
}

/* A column of the table: its name, quantity, and the unit of its numbers. */
struct sweep_column {
    const char *name;
    enum quantity quantity;
    const struct unit *unit;
};

/* Writes a value in the column's unit, or "-" if it is not finite. */
static void sweep_number_put(struct text_table *table, const struct sweep_column *column,
                             double value, int digits)
{
    const double shown = value / (column->unit ? column->unit->factor : 1) + 0.0;
    cell_text(table, isfinite(value) ? SHOWN_SHORT(shown, digits) : "-");
}

/* Describes column `index` of the table: first the parameters, then the measures. Its unit suits
 * the largest value. */
static struct sweep_column sweep_column_of(const struct swept *swept, int index)
{
    const struct sweep *sweep = swept->sweep;
    const int measure = index - sweep->axes;
    double low, high;
    struct sweep_column column;
    if (measure < 0) { /* the largest value of a parameter is at an end */
        low = swept_position(sweep, index, 0);
        high = swept_position(sweep, index, sweep->count - 1);
        column.name = sweep->axis[index].name;
        column.quantity = sweep->axis[index].quantity;
    } else {
        swept_range(swept, measure, &low, &high);
        column.name = sweep_measure_name(&swept->measure[measure]);
        column.quantity = swept_quantity(swept, measure);
    }
    column.unit =
        swept_unit(low <= high || measure < 0 ? fmax(fabs(low), fabs(high)) : 0, column.quantity);
    return column;
}

/* Appends the table of the sweep with at most TABLE_ROWS points, evenly chosen, and a column for
 * their status if not all were computed. */
static void sweep_table_put(const struct session *session, const struct swept *swept,
                            struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const int64_t every = (sweep->count + TABLE_ROWS - 1) / TABLE_ROWS;
    const bool failures = sweep->failed + sweep->refused > 0 || sweep->finished < sweep->count;
    const int columns = sweep->axes + sweep->measures;
    struct sweep_column column[2 + SWEEP_MEASURES];
    int width, height;
    session_size(session, &width, &height);
    struct text_table table = {
        .arena = arena, .columns = columns + failures, .gap = 3, .max = width};
    for (int c = 0; c < columns; c++) {
        column[c] = sweep_column_of(swept, c);
        const char *unit = swept_unit_name(column[c].unit, column[c].quantity);
        cell_format(&table, *unit ? "%s [%s]" : "%s", column[c].name, unit);
    }
    if (failures)
        cell_text(&table, "status");
    for (int64_t i = 0; i < sweep->count; i += every) {
        for (int c = 0; c < columns; c++)
            sweep_number_put(&table, &column[c],
                             c < sweep->axes ? swept_position(sweep, c, i)
                                             : swept_cell_value(swept, i, c - sweep->axes),
                             session->setup.settings.digits);
        if (failures)
            cell_text(&table, sweep_status_name(sweep->status[i]));
    }
    text_table_put(&table, text);
    static const char *const ordinal[] = {"", "", "nd", "rd", "th"};
    if (every > 1)
        buffer_format(text, "(every %lld%s point; export FILE table writes all)\n",
                      (long long)every, ordinal[every < 4 ? every : 4]);
}

/* Copies to x and y the first, lowest, highest and last point of each block of `each` neighbours,
 * in order of x, as a curve through these looks the same. Returns the number of points, at most 4
 * per block. */
static size_t curve_thin(const struct swept *swept, int measure, int64_t each, double *x, double *y)
{
    const struct sweep *sweep = swept->sweep;
    size_t kept = 0;
    for (int64_t begin = 0; begin < sweep->count; begin += each) {
        const int64_t end = begin + each < sweep->count ? begin + each : sweep->count;
        int64_t low = begin, high = begin;
        double lowest = swept_cell_value(swept, begin, measure), highest = lowest;
        for (int64_t i = begin + 1; i < end; i++) {
            const double value = swept_cell_value(swept, i, measure);
            if (value < lowest || isnan(lowest))
                lowest = value, low = i;
            if (value > highest || isnan(highest))
                highest = value, high = i;
        }
        const bool rises = low < high;
        const int64_t inner[] = {low, high},
                      point[] = {begin, inner[!rises], inner[rises], end - 1};
        for (size_t k = 0; k < COUNT_OF(point); k++)
            if (k == 0 || point[k] > point[k - 1]) {
                x[kept] = swept_position(sweep, 0, point[k]);
                y[kept++] = swept_cell_value(swept, point[k], measure);
            }
    }
    return kept;
}

/* Appends a curve of a measure over the parameter, `height` rows high, logarithmic if its values
 * span a factor above 300. Appends nothing for fewer than three points. */
static void put_curve(const struct session *session, const struct swept *swept, int measure,
                      int height, struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const size_t n = (size_t)sweep->count;
    const int64_t each = sweep->count / THIN_BLOCKS;
    const bool many = each > 4;
    const size_t room = many ? 4 * (n / (size_t)each + 1) : n;
    double *x = arena_array(arena, room, sizeof *x), *y = arena_array(arena, room, sizeof *y);
    double low, high;
    int width, whole;
    if (n < 3 || !x || !y)
        return;
    swept_range(swept, measure, &low, &high);
    const struct sweep_column horizontal = sweep_column_of(swept, 0),
                              vertical = sweep_column_of(swept, 1 + measure);
    const struct curve curve = {
        .x = x, .y = y, .n = curve_thin(swept, measure, many ? each : 1, x, y), .thinned = many};
    const struct figure figure = {
        .title = "sweep",
        .x = {.label = horizontal.name,
              .unit = swept_unit_name(horizontal.unit, horizontal.quantity),
              .factor = horizontal.unit ? horizontal.unit->factor : 1,
              .log = sweep->axis[0].log && x[0] > 0},
        .y = {.label = vertical.name,
              .unit = swept_unit_name(vertical.unit, vertical.quantity),
              .factor = vertical.unit ? vertical.unit->factor : 1,
              .log = low > 0 && high > 300 * low},
        .curve = &curve,
        .curves = 1};
    session_size(session, &width, &whole);
    figure_print(&figure, width, height > 8 ? height : 8, session_charset(session), false, text);
}

/* Appends a map of a measure over two parameters. */
static void put_map(const struct session *session, const struct swept *swept, int measure,
                    int height, struct arena *arena, struct buffer *text)
{
    const struct sweep_column column = sweep_column_of(swept, 2 + measure);
    struct heat heat = {.title = column.name,
                        .unit = swept_unit_name(column.unit, column.quantity),
                        .factor = column.unit ? column.unit->factor : 1};
    if (swept->measure[measure].kind == SWEEP_ATTRACTOR)
        heat.letters = "*012345678+";
    swept_map(session, swept, heat, swept_cell_value, measure, height, arena, text);
}

/* Returns true if a point has a finite value of the measure. */
static bool has_values(const struct swept *swept, int measure)
{
    bool some = false;
    for (int64_t i = 0; i < swept->sweep->count && !some; i++)
        some = isfinite(swept_cell_value(swept, i, measure));
    return some;
}

/* Appends which variable was watched, if the scene has several and none was named. */
static void put_watched(const struct swept *swept, struct buffer *text)
{
    const struct model *model = swept->model;
    const int coordinates = model->order == 2 ? model->n / 2 : model->n;
    const char *first = NULL;
    for (int m = 0; m < swept->sweep->measures && coordinates > 1; m++) {
        const char *name = sweep_measure_name(&swept->measure[m]);
        if (!sweep_watches(&swept->measure[m]) || strchr(name, '('))
            continue;
        buffer_format(text, "%s%s", first ? ", " : "", name);
        first = first ? first : name;
    }
    if (first)
        buffer_format(text, ": for %s, the first variable; 'measure=%s(%s)' for another\n",
                      model->variable[0].name, first, model->variable[1].name);
}

/* Appends a line that explains an attractor's number: its kind, at how many points it occurs and
 * which is the first and, if known, its state and period. */
static void put_attractor(const struct swept *swept, const struct sweep_attractor *a,
                          struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const struct model *model = swept->model;
    const struct basin *b = &a->basin;
    const bool irregular = a->number == ATTRACTOR_IRREGULAR;
    if (irregular && sweep->axes > 1)
        buffer_put(text, TEXT("  *  "));
    else
        buffer_format(text, " %2.0f  ", a->number);
    if (irregular)
        buffer_put(text, TEXT("does not repeat within 1000 checks"));
    else if (a->number == 0)
        buffer_put(text, TEXT("equilibrium"));
    else if (a->known && b->kind == BASIN_ORBIT)
        buffer_put(text, TEXT("closed orbit"));
    else
        buffer_format(text, "response of %.0f period%s of the drive", a->number,
                      a->number == 1 ? "" : "s");
    buffer_format(text, ": %lld of %lld points, the first at ", (long long)a->count,
                  (long long)sweep->count);
    for (int axis = 0; axis < sweep->axes; axis++) {
        const double value = swept_position(sweep, axis, a->first);
        buffer_format(text, "%s%s = %s", axis ? ", " : "", sweep->axis[axis].name,
                      SHOWN_QUANTITY(value, sweep->axis[axis].quantity, 6));
    }
    const char *separator = b->kind == BASIN_EQUILIBRIUM ? ": " : ", through ";
    for (int i = 0; i < model->n && a->known && !irregular; i++, separator = ", ")
        buffer_format(text, "%s%s = %s", separator, model->variable[i].name,
                      SHOWN_QUANTITY(b->state[i], model->variable[i].quantity, 6));
    if (a->known && b->kind == BASIN_ORBIT)
        buffer_format(text, ", period %s", SHOWN_QUANTITY(b->period, QUANTITY_TIME, 6));
    buffer_char(text, '\n');
}

/* Appends a note if only initial values are varied, since all points then have the same
 * attractors. */
static void put_starts(const struct swept *swept, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    int starts = 0;
    for (int a = 0; a < sweep->axes; a++) {
        const struct text name = text_of(sweep->axis[a].name);
        starts += name.len > 1 && name.data[name.len - 1] == '0' &&
                  model_state(swept->model, (struct text){name.data, name.len - 1}) >= 0;
    }
    if (starts == sweep->axes)
        buffer_put(
            text, TEXT("only initial values differ; 'basins' shows the attractor of each start\n"));
}

/* Appends a line such as "103 of 103 points in 0.1 s ...": points, time, steps, lanes and
 * threads. */
void sweep_summary(const struct sweep *sweep, struct buffer *text)
{
    buffer_format(text, "%lld of %lld point%s", (long long)sweep->finished, (long long)sweep->count,
                  sweep->count == 1 ? "" : "s");
    if (sweep->count < sweep->total)
        buffer_format(text, " (numbers %lld to %lld of %lld)", (long long)sweep->first,
                      (long long)(sweep->first + sweep->count - 1), (long long)sweep->total);
    if (!isnan(sweep->seconds))
        buffer_format(text, " in %.3g s", sweep->seconds);
    buffer_format(text, ", %.3g steps", sweep->steps);
    if (sweep->side_by_side > 0)
        buffer_format(text, ", %lld computed in parallel lanes", (long long)sweep->side_by_side);
    buffer_format(text, ", %d thread%s\n", sweep->threads, sweep->threads == 1 ? "" : "s");
}

void sweep_failures(const struct sweep *sweep, struct buffer *text)
{
    if (sweep->failed > 0)
        buffer_format(text, "%lld did not reach the end (diverged or stopped)\n",
                      (long long)sweep->failed);
    if (sweep->refused > 0)
        buffer_format(text, "%lld were refused, the first because %s\n", (long long)sweep->refused,
                      sweep->reason);
}

/* Appends the remarks below the figures: missing periods, summary, watched variable, attractors,
 * and points that failed. */
static void put_remarks(const struct swept *swept, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    for (int m = 0; m < sweep->measures; m++)
        if (!has_values(swept, m) && swept->measure[m].kind == SWEEP_PERIOD &&
            sweep->finished > sweep->failed + sweep->refused)
            buffer_put(text, TEXT("no period: the last third of the duration has fewer than two "
                                  "maxima; use a longer duration\n"));
    sweep_summary(sweep, text);
    put_watched(swept, text);
    for (int k = 0; k < swept->attractors; k++)
        put_attractor(swept, &swept->attractor[k], text);
    if (swept->attractors > 0)
        put_starts(swept, text);
    sweep_failures(sweep, text);
}

/* Returns the number of lines of a text. */
static int text_lines(const struct buffer *text)
{
    int lines = 0;
    for (size_t i = 0; i < text->len; i++)
        lines += text->data[i] == '\n';
    return lines;
}

/* Returns the number of measures that have a figure. */
static int figures_of(const struct swept *swept)
{
    const struct sweep *sweep = swept->sweep;
    int figures = 0;
    for (int m = 0; m < sweep->measures && (sweep->axes > 1 || sweep->count >= 3); m++)
        figures += has_values(swept, m);
    return figures;
}

/* Appends figures of the first `count` measures that have values, each `height` rows high. */
static void put_figures(const struct session *session, const struct swept *swept, int count,
                        int height, struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    for (int m = 0, shown = 0; m < sweep->measures && shown < count; m++)
        if (has_values(swept, m)) {
            (sweep->axes == 1 ? put_curve : put_map)(session, swept, m, height, arena, text);
            shown++;
        }
}

/* Appends figures and remarks in at most `rows` lines, with the table if it fits, and a line that
 * names what was left out. */
static void put_short(const struct session *session, const struct swept *swept, int rows,
                      struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const int figures = figures_of(swept);
    struct buffer table = {0}, remarks = {0};
    put_remarks(swept, &remarks);
    if (sweep->axes == 1)
        sweep_table_put(session, swept, arena, &table);
    /* a line that is wider than the screen takes two, and what is left out takes one */
    int room = rows - text_lines(&remarks) - 2;
    const bool tabled =
        table.len > 0 && (figures == 0 || text_lines(&table) + FIGURE_ROWS_MIN <= room);
    if (tabled) {
        buffer_put(text, buffer_text(&table));
        room -= text_lines(&table);
    }
    int shown = room >= FIGURE_ROWS_MIN ? room / FIGURE_ROWS_MIN : 1;
    shown = shown < figures ? shown : figures;
    if (shown > 0)
        put_figures(session, swept, shown, room / shown, arena, text);
    if (sweep->axes == 1 && !tabled)
        buffer_format(text, "... a table of %lld points%s: --full\n", (long long)sweep->count,
                      shown < figures ? ", more figures" : "");
    else if (shown < figures)
        buffer_format(text, "... %d more figure%s: --full\n", figures - shown,
                      figures - shown == 1 ? "" : "s");
    buffer_put(text, buffer_text(&remarks));
    text->failed |= table.failed || remarks.failed;
    buffer_free(&table);
    buffer_free(&remarks);
}

/* Writes the sweep in at most `rows` lines, where figures are preferred to tables, or all of it if
 * rows is 0. */
void sweep_text(const struct session *session, const struct swept *swept, int rows,
                struct arena *arena, struct buffer *text)
{
    int width, height;
    session_size(session, &width, &height);
    if (rows > 0) {
        put_short(session, swept, rows, arena, text);
        return;
    }
    if (swept->sweep->axes == 1)
        sweep_table_put(session, swept, arena, text);
    put_figures(session, swept, swept->sweep->measures, height - 4, arena, text);
    put_remarks(swept, text);
}
