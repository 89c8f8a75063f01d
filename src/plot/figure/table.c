/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Plots columns of a table against each other as points, a curve for each method, event or other
 * word. */
#include <hooke/base/unit.h>
#include <hooke/plot/drawing.h>

#include <hooke/plot.h>

#include <math.h>
#include <string.h>

#define LOG_AXIS_RATIO 300 /* Ratio of positive values from which an axis is logarithmic. */
/* The same ratio for an axis whose other axis is logarithmic, so that power laws are lines. */
#define LOG_BOTH_RATIO 10
/* most words in a column that separate curves */
#define GROUPS_MAX 8
#define MARKS_MAX 100 /* number of points above which they are drawn as a cloud of dots */

/* Finds a column of numbers by its name. Returns NULL with an error that lists the columns if there
 * is none. */
static const struct table_column *find_column(const struct drawing *d, struct text name)
{
    const struct table *table = d->request->table;
    for (int c = 0; c < table->columns; c++)
        if (table->column[c].value && text_is(name, table->column[c].name))
            return &table->column[c];
    struct suggestion suggestion = {.wanted = name};
    struct buffer names = {0};
    for (int c = 0; c < table->columns; c++)
        if (table->column[c].value) {
            suggestion_offer(&suggestion, table->column[c].name);
            buffer_format(&names, "%s%s", names.len ? ", " : "", table->column[c].name);
        }
    error_at(d->error, name, "the table has no column of numbers '%.*s'",
             (int)(name.len < 64 ? name.len : 64), name.data);
    suggestion_hint(&suggestion, d->error);
    error_hint(d->error, "it has %s", buffer_view(&names));
    buffer_free(&names);
    return NULL;
}

enum quantity column_quantity(const struct table_column *column)
{
    const struct unit *unit = unit_find(text_of(column->unit));
    return unit && unit->factor == 1 ? unit->quantity : QUANTITY_NUMBER;
}

/* Returns the axis of a column: logarithmic if its values are positive and the ratio of the largest
 * to the smallest exceeds min_ratio, unless the user's range (`wanted`, or NULL) begins at 0 or
 * below. */
static struct axis column_axis(const struct table_column *column, size_t rows, double min_ratio,
                               const struct figure_range *wanted)
{
    struct axis axis = {.label = column->name, .unit = column->unit};
    double low = HUGE_VAL, high = 0, size = 0;
    for (size_t i = 0; i < rows; i++) {
        const double value = column->value[i];
        if (!isfinite(value))
            continue;
        low = fmin(low, value);
        high = fmax(high, value);
        size = fmax(size, fabs(value));
    }
    axis.log = low > 0 && high > min_ratio * low && !(wanted && wanted->end[0] <= 0);
    if (!axis.log)
        axis_suit(&axis, column_quantity(column), size);
    return axis;
}

/* ---- curves ---- */

/* Returns the index of a row's group, which is added if it is new, or -1 if there are too many. */
static int group_index(const char *const *value, int *count, const char *group[GROUPS_MAX])
{
    for (int g = 0; g < *count; g++)
        if (strcmp(group[g], *value) == 0)
            return g;
    if (*count == GROUPS_MAX)
        return -1;
    group[*count] = *value;
    return (*count)++;
}

/* Returns the first column of texts with 2 to GROUPS_MAX different ones, and sets group [*count] to
 * these, in order of appearance. Returns NULL with *count = 1 if there is no such column. */
static const struct table_column *find_groups(const struct table *table, int *count,
                                              const char *group[GROUPS_MAX])
{
    for (int c = 0; c < table->columns; c++) {
        const struct table_column *column = &table->column[c];
        bool few = column->text;
        *count = 0;
        for (size_t i = 0; i < table->rows && few; i++)
            few = group_index(&column->text[i], count, group) >= 0;
        if (few && *count > 1)
            return column;
    }
    *count = 1;
    return NULL;
}

/* Returns the label of a group. A column that holds yes or no is labelled by its question: fitted,
 * not fitted. */
static const char *group_label(struct drawing *d, const struct table_column *group_column,
                               const char *group)
{
    struct buffer label = {0};
    if (!group_column || (strcmp(group, "true") != 0 && strcmp(group, "false") != 0))
        return group;
    buffer_format(&label, "%s%s", strcmp(group, "true") == 0 ? "" : "not ", group_column->name);
    const char *kept = label.failed ? group : arena_text(d->arena, buffer_text(&label));
    buffer_free(&label);
    return kept;
}

/* Adds the points of the rows of a group, or of all rows if group_column is NULL. Returns false if
 * out of memory. */
static bool add_curve(struct drawing *d, const struct table_column *x, const struct table_column *y,
                      const struct table_column *group_column, const char *group)
{
    const struct table *table = d->request->table;
    double *value = arena_array(d->arena, 2 * table->rows + 1, sizeof *value);
    size_t n = 0;
    if (!value)
        return error_memory(d->error);
    for (size_t i = 0; i < table->rows; i++) {
        if (!isfinite(x->value[i]) || !isfinite(y->value[i]) ||
            (group_column && strcmp(group_column->text[i], group) != 0))
            continue;
        value[n] = x->value[i];
        value[table->rows + n++] = y->value[i];
    }
    if (n > 0)
        d->curve[d->curves++] = (struct curve){.label = group_label(d, group_column, group),
                                               .x = value,
                                               .y = value + table->rows,
                                               .n = n,
                                               .points = true,
                                               .cloud = n > MARKS_MAX};
    return true;
}

/* Makes the figure of those columns of request->table that the request names, over its horizontal
 * column; with a single column, rows are grouped into curves by a column of texts. Returns false
 * with an error if a column is unknown, if units differ, or if no row has numbers. */
bool drawing_table(struct drawing *d, struct figure *figure)
{
    const struct figure_request *request = d->request;
    const struct table *table = request->table;
    const struct table_column *x = find_column(d, request->horizontal_column), *first = NULL;
    const char *group[GROUPS_MAX] = {NULL};
    int groups = 1;
    const struct table_column *group_column =
        request->columns == 1 ? find_groups(table, &groups, group) : NULL;
    d->curve = arena_array(d->arena, (size_t)request->columns + GROUPS_MAX, sizeof *d->curve);
    if (!x || !d->curve)
        return x && error_memory(d->error);
    for (int i = 0; i < request->columns; i++) {
        const struct table_column *y = find_column(d, request->column[i]);
        if (!y)
            return false;
        first = first ? first : y;
        if (strcmp(first->unit, y->unit) != 0) {
            const char *const unit = y->unit[0] ? y->unit : "1";
            error_at(d->error, request->column[i], "%s [%s] and %s [%s] do not share an axis",
                     first->name, first->unit[0] ? first->unit : "1", y->name, unit);
            return false;
        }
        for (int g = 0; g < groups; g++)
            if (!add_curve(d, x, y, group_column, group_column ? group[g] : y->name))
                return false;
    }
    if (!first || d->curves == 0)
        return error_at(d->error, request->column[0], "no row has numbers in both columns");
    *figure = (struct figure){.title = request->title,
                              .curve = d->curve,
                              .curves = d->curves,
                              .y = column_axis(first, table->rows, LOG_AXIS_RATIO, request->y)};
    figure->y.log |= request->log;
    figure->x =
        column_axis(x, table->rows, figure->y.log ? LOG_BOTH_RATIO : LOG_AXIS_RATIO, request->x);
    return drawing_ranges(d, figure, (enum quantity[]){column_quantity(x), column_quantity(first)});
}
