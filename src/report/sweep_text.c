/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/report.h>
#include <hooke/study/sweep.h>

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    TABLE_ROWS = 40,
    FIGURE_ROWS_MIN = 10, /* [row] below which a figure says less than a table */
    /* A curve of many points is drawn from so many stretches: several to each column of dots. */
    THIN_BLOCKS = 2048,
    MAP_MAX = 1 << 24 /* [point] */
};

static double value_at(const struct sweep *sweep, int64_t i, int measure)
{
    return sweep->value[i * sweep->measures + measure];
}

static double position_at(const struct sweep *sweep, int axis, int64_t i)
{
    return sweep_axis_value(&sweep->axis[axis], (int)sweep_number(sweep, axis, i));
}

static enum quantity quantity_of(const struct swept *swept, int measure)
{
    return sweep_measure_quantity(&swept->measure[measure], swept->model);
}

static double size_max(double max, double value)
{
    const double size = fabs(value);
    return size > max && size <= DBL_MAX ? size : max;
}

/* The unit in which most values say something: that of the largest. */
static const struct unit *unit_of(double max, enum quantity quantity)
{
    return unit_display(quantity, quantity == QUANTITY_TIME && max >= 0.1 ? 1 : max);
}

/* Of these values, each so many behind the one before. */
static const struct unit *unit_of_values(const double *value, size_t count, int stride,
                                         enum quantity quantity)
{
    double max = 0;
    for (size_t i = 0; i < count; i++)
        max = size_max(max, value[i * (size_t)stride]);
    return unit_of(max, quantity);
}

/* Of a parameter over the points of this sweep: the largest is at an end. */
static const struct unit *unit_of_axis(const struct sweep *sweep, int axis)
{
    const double max =
        size_max(fabs(position_at(sweep, axis, 0)), position_at(sweep, axis, sweep->count - 1));
    return unit_of(max, sweep->axis[axis].quantity);
}

static const char *unit_name(const struct unit *unit, enum quantity quantity)
{
    return unit ? unit->row.name : quantity_unit(quantity);
}

/* A column: its heading with the unit, then numbers. */
struct sweep_column {
    const char *name;
    enum quantity quantity;
    const struct unit *unit;
};

static void put_number(struct text_table *table, const struct sweep_column *column, double value,
                       int digits)
{
    struct buffer text = {0};
    if (isfinite(value))
        buffer_short(&text, value / (column->unit ? column->unit->factor : 1) + 0.0, digits);
    else
        buffer_char(&text, '-');
    cell_take(table, &text);
}

static struct sweep_column column_of(const struct swept *swept, int index)
{
    const struct sweep *sweep = swept->sweep;
    const int measure = index - sweep->axes;
    if (measure < 0)
        return (struct sweep_column){sweep->axis[index].name, sweep->axis[index].quantity,
                                     unit_of_axis(sweep, index)};
    const enum quantity quantity = quantity_of(swept, measure);
    return (struct sweep_column){
        sweep_measure_name(&swept->measure[measure]), quantity,
        unit_of_values(sweep->value + measure, (size_t)sweep->count, sweep->measures, quantity)};
}

/* Every so many points, so that the table can be read. */
static void put_table(const struct session *session, const struct swept *swept, struct arena *arena,
                      struct buffer *text)
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
        column[c] = column_of(swept, c);
        struct buffer heading = {0};
        const char *unit = unit_name(column[c].unit, column[c].quantity);
        buffer_put(&heading, text_of(column[c].name));
        if (*unit)
            buffer_format(&heading, " [%s]", unit);
        cell_take(&table, &heading);
    }
    if (failures)
        cell_text(&table, "status");
    for (int64_t i = 0; i < sweep->count; i += every) {
        for (int c = 0; c < columns; c++)
            put_number(&table, &column[c],
                       c < sweep->axes ? position_at(sweep, c, i)
                                       : value_at(sweep, i, c - sweep->axes),
                       session->setup.settings.digits);
        if (failures)
            cell_text(&table, sweep_status_name(sweep->status[i]));
    }
    text_table_put(&table, text);
    if (every > 1)
        buffer_format(text, "(every %lld%s point; all of them: export FILE table)\n",
                      (long long)every,
                      every == 2   ? "nd"
                      : every == 3 ? "rd"
                                   : "th");
}

static double *axis_values(const struct sweep_axis *axis, struct arena *arena)
{
    double *value = arena_array(arena, (size_t)axis->count, sizeof *value);
    for (int i = 0; value && i < axis->count; i++)
        value[i] = sweep_axis_value(axis, i);
    return value;
}

/* Positive, and over decades. */
static bool spans_decades(const struct sweep *sweep, int measure)
{
    double low = HUGE_VAL, high = 0;
    for (int64_t i = 0; i < sweep->count; i++) {
        const double value = value_at(sweep, i, measure);
        if (!isfinite(value))
            continue;
        low = value < low ? value : low;
        high = value > high ? value : high;
    }
    return low > 0 && high > 300 * low;
}

/* Takes the first, lowest, highest and last of each `each` neighbours, which look the same. Returns
 * how many points these are. */
static size_t thin(const struct sweep *sweep, int measure, int64_t each, double *x, double *y)
{
    size_t kept = 0;
    for (int64_t begin = 0; begin < sweep->count; begin += each) {
        const int64_t end = begin + each < sweep->count ? begin + each : sweep->count;
        int64_t low = begin, high = begin;
        double lowest = value_at(sweep, begin, measure), highest = lowest;
        for (int64_t i = begin + 1; i < end; i++) {
            const double value = value_at(sweep, i, measure);
            if (value < lowest || isnan(lowest))
                lowest = value, low = i;
            if (value > highest || isnan(highest))
                highest = value, high = i;
        }
        const int64_t place[] = {begin, low < high ? low : high, low < high ? high : low, end - 1};
        for (size_t k = 0; k < COUNT_OF(place); k++)
            if (k == 0 || place[k] > place[k - 1]) {
                x[kept] = position_at(sweep, 0, place[k]);
                y[kept++] = value_at(sweep, place[k], measure);
            }
    }
    return kept;
}

static void put_curve(const struct session *session, const struct swept *swept, int measure,
                      int height, struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const size_t n = (size_t)sweep->count;
    const int64_t each = sweep->count / THIN_BLOCKS;
    const bool many = each > 4;
    const size_t room = many ? 4 * (n / (size_t)each + 1) : n;
    double *x = arena_array(arena, room, sizeof *x), *y = arena_array(arena, room, sizeof *y);
    int width, whole;
    if (n < 3 || !x || !y)
        return;
    const struct sweep_column across = column_of(swept, 0), up = column_of(swept, 1 + measure);
    const struct curve curve = {
        .x = x, .y = y, .n = thin(sweep, measure, many ? each : 1, x, y), .thinned = many};
    const struct figure figure = {.title = "sweep",
                                  .x = {.label = across.name,
                                        .unit = unit_name(across.unit, across.quantity),
                                        .factor = across.unit ? across.unit->factor : 1,
                                        .log = sweep->axis[0].log && x[0] > 0},
                                  .y = {.label = up.name,
                                        .unit = unit_name(up.unit, up.quantity),
                                        .factor = up.unit ? up.unit->factor : 1,
                                        .log = spans_decades(sweep, measure)},
                                  .curve = &curve,
                                  .curves = 1};
    session_size(session, &width, &whole);
    figure_print(&figure, width, height > 8 ? height : 8, session_charset(session), false, text);
}

/* A shard has gaps where the others belong. */
static void put_map(const struct session *session, const struct swept *swept, int measure,
                    int height, struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const struct sweep_axis *across = &sweep->axis[0], *up = &sweep->axis[1];
    const size_t n = (size_t)sweep->total;
    if (n > MAP_MAX)
        return;
    double *value = arena_array(arena, n, sizeof *value), *x = axis_values(across, arena),
           *y = axis_values(up, arena);
    int width, whole;
    if (!value || !x || !y)
        return;
    for (size_t i = 0; i < n; i++)
        value[i] = NAN;
    for (int64_t i = 0; i < sweep->count; i++)
        value[sweep->first + i] = value_at(sweep, i, measure);
    const enum quantity quantity = quantity_of(swept, measure);
    const struct unit *unit = unit_of_values(value, n, 1, quantity),
                      *x_unit = unit_of_values(x, (size_t)across->count, 1, across->quantity),
                      *y_unit = unit_of_values(y, (size_t)up->count, 1, up->quantity);
    const struct heat heat = {
        .title = sweep_measure_name(&swept->measure[measure]),
        .unit = unit_name(unit, quantity),
        .factor = unit ? unit->factor : 1,
        .x = {across->name, unit_name(x_unit, across->quantity), x_unit ? x_unit->factor : 1, x,
              across->count},
        .y = {up->name, unit_name(y_unit, up->quantity), y_unit ? y_unit->factor : 1, y, up->count},
        .value = value,
        .letters = swept->measure[measure].kind == SWEEP_ATTRACTOR ? "*012345678+" : NULL};
    session_size(session, &width, &whole);
    heat_print(&heat, width, height > 8 ? height : 8, session_charset(session), text);
}

static bool has_values(const struct sweep *sweep, int measure)
{
    bool some = false;
    for (int64_t i = 0; i < sweep->count && !some; i++)
        some = isfinite(value_at(sweep, i, measure));
    return some;
}

/* Of a scene in which more than one thing moves. */
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
        buffer_format(text, ": of %s, the first variable; 'measure=%s(%s)' of another\n",
                      model->variable[0].name, first, model->variable[1].name);
}

/* What its number stands for, how often, and the first of them. */
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
        buffer_put(text, TEXT("does not repeat within 1000 looks"));
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
        buffer_format(text, "%s%s = ", axis ? ", " : "", sweep->axis[axis].name);
        buffer_quantity(text, position_at(sweep, axis, a->first), sweep->axis[axis].quantity, 6);
    }
    for (int i = 0; i < model->n && a->known && !irregular; i++) {
        buffer_format(text, "%s%s = ",
                      i                              ? ", "
                      : b->kind == BASIN_EQUILIBRIUM ? ": "
                                                     : ", through ",
                      model->variable[i].name);
        buffer_quantity(text, b->state[i], model->variable[i].quantity, 6);
    }
    if (a->known && b->kind == BASIN_ORBIT) {
        buffer_put(text, TEXT(", period "));
        buffer_quantity(text, b->period, QUANTITY_TIME, 6);
    }
    buffer_char(text, '\n');
}

/* Where nothing but starts is varied, all points have the same attractors. */
static void put_starts(const struct swept *swept, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    int starts = 0;
    for (int a = 0; a < sweep->axes; a++) {
        const struct text name = text_of(sweep->axis[a].name);
        starts += name.len > 1 && name.at[name.len - 1] == '0' &&
                  model_state(swept->model, (struct text){name.at, name.len - 1}) >= 0;
    }
    if (starts == sweep->axes)
        buffer_put(text, TEXT("only starts differ: 'basins' says which attractor each comes to\n"));
}

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
        buffer_format(text, ", %lld side by side in lanes", (long long)sweep->side_by_side);
    buffer_format(text, ", %d thread%s\n", sweep->threads, sweep->threads == 1 ? "" : "s");
}

void sweep_failures(const struct sweep *sweep, struct buffer *text)
{
    if (sweep->failed > 0)
        buffer_format(text, "%lld did not get to the end (diverged and the like)\n",
                      (long long)sweep->failed);
    if (sweep->refused > 0)
        buffer_format(text, "%lld refused, the first because %s\n", (long long)sweep->refused,
                      sweep->reason);
}

/* What stands below the figures. */
static void put_remarks(const struct swept *swept, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    for (int m = 0; m < sweep->measures; m++)
        if (!has_values(sweep, m) && swept->measure[m].kind == SWEEP_PERIOD &&
            sweep->finished > sweep->failed + sweep->refused)
            buffer_put(text, TEXT("no period: the last third of the duration has fewer than two "
                                  "maxima; give it a longer "
                                  "duration\n"));
    sweep_summary(sweep, text);
    put_watched(swept, text);
    for (int k = 0; k < swept->attractors; k++)
        put_attractor(swept, &swept->attractor[k], text);
    if (swept->attractors > 0)
        put_starts(swept, text);
    sweep_failures(sweep, text);
}

static int text_lines(const struct buffer *text)
{
    int lines = 0;
    for (size_t i = 0; i < text->len; i++)
        lines += text->data[i] == '\n';
    return lines;
}

static int figures_of(const struct sweep *sweep)
{
    int figures = 0;
    for (int m = 0; m < sweep->measures && (sweep->axes > 1 || sweep->count >= 3); m++)
        figures += has_values(sweep, m);
    return figures;
}

static void put_figures(const struct session *session, const struct swept *swept, int count,
                        int height, struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    for (int m = 0, shown = 0; m < sweep->measures && shown < count; m++)
        if (has_values(sweep, m)) {
            (sweep->axes == 1 ? put_curve : put_map)(session, swept, m, height, arena, text);
            shown++;
        }
}

/* Figures first, a table beside them where it is short, and what is left out in a line. */
static void put_short(const struct session *session, const struct swept *swept, int rows,
                      struct arena *arena, struct buffer *text)
{
    const struct sweep *sweep = swept->sweep;
    const int figures = figures_of(sweep);
    struct buffer table = {0}, remarks = {0};
    put_remarks(swept, &remarks);
    if (sweep->axes == 1)
        put_table(session, swept, arena, &table);
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
        put_table(session, swept, arena, text);
    put_figures(session, swept, swept->sweep->measures, height - 4, arena, text);
    put_remarks(swept, text);
}

/* The number of each point, parameters, measures. */
static void fill_column(const struct sweep *sweep, int column, double *value)
{
    const int axis = column - 1, measure = axis - sweep->axes;
    if (column == 0)
        for (int64_t i = 0; i < sweep->count; i++)
            value[i] = (double)(sweep->first + i);
    else if (measure >= 0)
        for (int64_t i = 0; i < sweep->count; i++)
            value[i] = value_at(sweep, i, measure);
    else
        for (int64_t i = 0; i < sweep->count; i++)
            value[i] = position_at(sweep, axis, i);
}

bool sweep_table(const struct swept *swept, struct arena *arena, struct table *table)
{
    const struct sweep *sweep = swept->sweep;
    const size_t n = (size_t)sweep->count;
    const int columns = 1 + sweep->axes + sweep->measures;
    struct table_column *out = arena_array(arena, (size_t)columns + 1, sizeof *out);
    const char **status = arena_array(arena, n + 1, sizeof *status);
    if (!out || !status)
        return false;
    for (int c = 0; c < columns; c++) {
        double *value = arena_array(arena, n + 1, sizeof *value);
        const int axis = c - 1, measure = axis - sweep->axes;
        if (!value)
            return false;
        fill_column(sweep, c, value);
        out[c] = (struct table_column){.name = "point", .unit = "", .value = value};
        if (c > 0 && measure < 0) {
            out[c].name = arena_text(arena, text_of(sweep->axis[axis].name));
            out[c].unit = quantity_unit(sweep->axis[axis].quantity);
        } else if (c > 0) {
            out[c].name = arena_text(arena, text_of(sweep_measure_name(&swept->measure[measure])));
            out[c].unit = quantity_unit(quantity_of(swept, measure));
        }
        if (!out[c].name)
            return false;
    }
    for (size_t i = 0; i < n; i++) /* most are alike */
        status[i] = i > 0 && sweep->status[i] == sweep->status[i - 1]
                        ? status[i - 1]
                        : sweep_status_name(sweep->status[i]);
    out[columns] = (struct table_column){.name = "status", .unit = "", .text = status};
    *table = (struct table){.column = out, .columns = columns + 1, .rows = n};
    return true;
}
