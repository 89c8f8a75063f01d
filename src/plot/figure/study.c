/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws the stored table of a study by the description of its plot (struct study_picture): a curve
 * for each name in a column, or shades over two columns. */
#include <hooke/base/unit.h>
#include <hooke/figure/layout.h>
#include <hooke/plot/drawing.h>
#include <hooke/result.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

const struct table *drawing_stored(const struct session *session, const char *kind)
{
    const struct stored_table *stored = table_store_find(&session->studies.found, text_of(kind));
    return stored ? &stored->table : NULL;
}

/* Returns the value of a column in a row; NAN if the table has no such column (NULL) or it has no
 * values. */
static double row_value(const struct table_column *column, size_t row)
{
    return column && column->value ? column->value[row] : NAN;
}

/* ---- curves ---- */

/* A study's figure while it is built up. */
struct study {
    struct drawing *d;
    const struct study_picture *picture;
    const struct table *table;
    /* The columns of the horizontal axis, of the names of curves, and of the layers. */
    const struct table_column *x, *key_column, *part;
    struct figure_guide *guide; /* [guides] */
    int guides;
};

/* Returns true if a row belongs to a layer and, unless name is NULL, to the curve of this name. */
static bool row_belongs_to_curve(const struct study *s, const struct study_layer *layer,
                                 const char *name, size_t row)
{
    return (!layer->part || (s->part && strcmp(s->part->text[row], layer->part) == 0)) &&
           (!name || strcmp(s->key_column->text[row], name) == 0);
}

/* Returns the label of a curve, such as "rk4, slope 4.00", with the layer's value from the first
 * row that has one, or NULL if out of memory. */
static const char *curve_label(const struct study *s, const struct study_layer *layer,
                               const char *name)
{
    const struct table_column *value = table_column_named(s->table, layer->value);
    struct buffer text = {0};
    size_t row = 0;
    while (value && row < s->table->rows &&
           !(row_belongs_to_curve(s, layer, name, row) && isfinite(row_value(value, row))))
        row++;
    buffer_put(&text, text_of(name ? name : ""));
    if (value && row < s->table->rows)
        buffer_format(&text, "%s%s ", text.len ? ", " : "", layer->named);
    if (value && row < s->table->rows && *value->unit)
        buffer_put(&text,
                   text_of(SHOWN_QUANTITY(row_value(value, row), column_quantity(value), 4)));
    else if (value && row < s->table->rows)
        buffer_format(&text, "%.3f", row_value(value, row));
    const char *label = text.failed ? NULL : arena_text(s->d->arena, buffer_text(&text));
    buffer_free(&text);
    return label;
}

/* Adds the rows of the layer (if `name` is given, only rows of the group of that name) as a curve
 * or, for a guide, as a straight line between the first and the last row. Points leave out rows
 * without numbers or above layer->max; lines have gaps at rows without numbers. Adds nothing if no
 * row has numbers. Returns false with the error if out of memory. */
static bool add_layer_curve(struct study *s, const struct study_layer *layer, const char *name)
{
    struct drawing *d = s->d;
    const struct table_column *y = table_column_named(s->table, layer->y);
    double *x_of = arena_array(d->arena, 2 * s->table->rows + 1, sizeof *x_of),
           *y_of = x_of + s->table->rows;
    size_t n = 0, known = 0;
    if (!x_of)
        return error_memory(d->error);
    for (size_t row = 0; row < s->table->rows; row++) {
        if (!row_belongs_to_curve(s, layer, name, row))
            continue;
        x_of[n] = row_value(s->x, row);
        y_of[n] = row_value(y, row);
        const bool is_known =
            isfinite(x_of[n]) && isfinite(y_of[n]) && !(layer->max > 0 && y_of[n] > layer->max);
        known += is_known;
        n += is_known || layer->line;
    }
    if (known == 0)
        return true;
    if (layer->guide) {
        s->guide[s->guides++] =
            (struct figure_guide){.x = {x_of[0], x_of[n - 1]}, .y = {y_of[0], y_of[n - 1]}};
        return true;
    }
    const char *label = curve_label(s, layer, name);
    d->curve[d->curves++] = (struct curve){.label = label,
                                           .x = x_of,
                                           .y = y_of,
                                           .n = n,
                                           .points = !layer->line,
                                           .cancel = d->session->front.cancel};
    return label || error_memory(d->error);
}

/* Returns true if no earlier row has the name of this one. */
static bool is_first_of_name(const struct study *s, size_t row)
{
    for (size_t previous = 0; previous < row; previous++)
        if (strcmp(s->key_column->text[previous], s->key_column->text[row]) == 0)
            return false;
    return true;
}

/* Returns an upper bound of the number of names: rows of one name usually follow each other. */
static size_t count_names(const struct study *s)
{
    size_t names = 1;
    for (size_t row = 1; s->key_column && row < s->table->rows; row++)
        names += strcmp(s->key_column->text[row - 1], s->key_column->text[row]) != 0;
    return names;
}

/* Adds the curves of all layers, one for each name. Returns false with an error if no row has
 * numbers. */
static bool add_layers(struct study *s)
{
    struct drawing *d = s->d;
    const size_t most = STUDY_LAYERS_MAX * count_names(s);
    d->curve = arena_array(d->arena, most, sizeof *d->curve);
    s->guide = arena_array(d->arena, most, sizeof *s->guide);
    d->curves = 0;
    if (!d->curve || !s->guide)
        return error_memory(d->error);
    for (const struct study_layer *layer = s->picture->layer;
         layer < s->picture->layer + STUDY_LAYERS_MAX && layer->y; layer++) {
        if (!s->key_column && !add_layer_curve(s, layer, NULL))
            return false;
        for (size_t row = 0; s->key_column && row < s->table->rows; row++)
            if ((row == 0 || strcmp(s->key_column->text[row - 1], s->key_column->text[row]) != 0) &&
                is_first_of_name(s, row) && !add_layer_curve(s, layer, s->key_column->text[row]))
                return false;
    }
    return d->curves > 0 || error_set(d->error, ERROR_COMMAND, "no row of '%s' has numbers to draw",
                                      s->picture->table);
}

/* ---- shades ---- */

static int compare_values(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Fills in the ascending values of a column, each once. Returns false if out of memory. */
static bool heat_axis_of(struct study *s, const struct table_column *column, struct heat_axis *axis)
{
    const size_t rows = s->table->rows;
    double *value = arena_array(s->d->arena, rows + 1, sizeof *value);
    size_t n = 0;
    if (!value)
        return error_memory(s->d->error);
    for (size_t row = 0; row < rows; row++)
        if (isfinite(row_value(column, row)))
            value[n++] = column->value[row];
    qsort(value, n, sizeof *value, compare_values);
    size_t kept = n > 0;
    for (size_t i = 1; i < n; i++)
        if (value[i] != value[kept - 1])
            value[kept++] = value[i];
    *axis = (struct heat_axis){
        .label = column->name, .unit = column->unit, .value = value, .count = (int)kept};
    return true;
}

/* Returns the index of a value on an axis of the map, or the axis's count if it is not on it. */
static size_t heat_point_index(const struct heat_axis *axis, double value)
{
    const double *position =
        bsearch(&value, axis->value, (size_t)axis->count, sizeof value, compare_values);
    return position ? (size_t)(position - axis->value) : (size_t)axis->count;
}

/* Returns an axis that reaches from the outer edge of the first point to that of the last,
 * logarithmic if the points are more evenly spaced that way. */
static struct axis heat_outer_axis(struct heat_axis *places, enum quantity quantity)
{
    const double low = places->value[0], high = places->value[places->count - 1],
                 middle = places->value[places->count / 2],
                 part = (double)(places->count / 2) / fmax(1, places->count - 1);
    places->log = places->count > 2 && low > 0 &&
                  fabs(log10(middle / low) / log10(high / low) - part) <
                      fabs((middle - low) / (high - low) - part);
    struct axis axis = {.label = places->label,
                        .unit = places->unit,
                        .first_value = heat_edge(places, 0),
                        .last_value = heat_edge(places, places->count),
                        .fixed = true,
                        .log = places->log};
    if (!axis.log)
        axis_suit(&axis, quantity, fmax(fabs(low), fabs(high)));
    places->unit = axis.unit;
    places->factor = axis.factor;
    return axis;
}

/* Makes a heat map of the column `shade` over x and the first layer's y. Cells without a row have
 * no value. Returns false with an error if no row has numbers. */
static bool draw_shades(struct study *s, struct figure *figure)
{
    struct drawing *d = s->d;
    const struct table_column *y = table_column_named(s->table, s->picture->layer[0].y),
                              *shade = table_column_named(s->table, s->picture->shade);
    struct heat *heat = arena_alloc(d->arena, sizeof *heat);
    if (!heat)
        return error_memory(d->error);
    *heat = (struct heat){.title = shade->name};
    if (!heat_axis_of(s, s->x, &heat->x) || !heat_axis_of(s, y, &heat->y))
        return false;
    const size_t cells = (size_t)heat->x.count * (size_t)heat->y.count;
    double *value = arena_array(d->arena, cells + 1, sizeof *value), size = 0;
    if (!value)
        return error_memory(d->error);
    if (cells == 0)
        return error_set(d->error, ERROR_COMMAND, "no row of '%s' has numbers to draw",
                         s->picture->table);
    for (size_t i = 0; i < cells; i++)
        value[i] = NAN;
    for (size_t row = 0; row < s->table->rows; row++) {
        const size_t i = heat_point_index(&heat->x, row_value(s->x, row)),
                     k = heat_point_index(&heat->y, row_value(y, row));
        if (i < (size_t)heat->x.count && k < (size_t)heat->y.count)
            value[i * (size_t)heat->y.count + k] = row_value(shade, row);
        if (isfinite(row_value(shade, row)))
            size = fmax(size, fabs(shade->value[row]));
    }
    struct axis scale = {.unit = shade->unit};
    axis_suit(&scale, column_quantity(shade), size);
    heat->value = value;
    heat->unit = scale.unit;
    heat->factor = scale.factor;
    figure->heat = heat;
    figure->plane = true;
    figure->x = heat_outer_axis(&heat->x, column_quantity(s->x));
    figure->y = heat_outer_axis(&heat->y, column_quantity(y));
    return true;
}

/* ---- the figure ---- */

/* Returns an axis of a study's curves, with the unit that suits their size. */
static struct axis study_axis(const struct study *s, bool vertical)
{
    const struct drawing *d = s->d;
    const struct table_column *column =
        vertical ? table_column_named(s->table, s->picture->layer[0].y) : s->x;
    const char *label = vertical ? s->picture->y_label : s->picture->x_label;
    const bool log = vertical ? s->picture->log_y || d->request->log : s->picture->log_x;
    struct axis axis = {.label = label ? label : column->name, .unit = column->unit, .log = log};
    const struct extent extent =
        curves_extent(d->curve, d->curves, &(struct extent_window){.vertical = vertical});
    if (!axis.log && extent.low <= extent.high)
        axis_suit(&axis, column_quantity(column), fmax(fabs(extent.low), fabs(extent.high)));
    return axis;
}

/* Makes the figure of a study from its stored table. Returns false with an error and the command
 * that makes one if there is none. */
bool drawing_study(struct drawing *d, const struct study_picture *picture, struct figure *figure)
{
    struct study s = {
        .d = d, .picture = picture, .table = drawing_stored(d->session, picture->table)};
    if (!s.table || s.table->rows == 0) {
        error_set(d->error, ERROR_COMMAND, "there is no result of '%s' to plot", picture->table);
        return error_hint(d->error, "type: %s", picture->made_by);
    }
    s.x = table_column_named(s.table, picture->x);
    s.key_column = table_column_named(s.table, picture->group);
    s.part = table_column_named(s.table, "part");
    *figure = (struct figure){.title = kind_of(d)->row.name, .note = picture->note};
    if (picture->shade)
        return draw_shades(&s, figure);
    if (!add_layers(&s))
        return false;
    figure->plane = picture->equal;
    figure->equal = picture->equal;
    figure->zero_line = picture->equal;
    figure->curve = d->curve;
    figure->curves = d->curves;
    figure->guide = s.guide;
    figure->guides = s.guides;
    figure->x = study_axis(&s, false);
    figure->y = study_axis(&s, true);
    return drawing_ranges(
        d, figure,
        (enum quantity[]){column_quantity(s.x),
                          column_quantity(table_column_named(s.table, picture->layer[0].y))});
}
