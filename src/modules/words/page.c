/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Figures for screen readers: sentences, and a few rows of numbers in columns. */
#include "modules/words/internal.h"

#include <hooke/figure/layout.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/numeric.h>

#include <math.h>

#define CURVE_ROWS 11   /* number of rows of a table, which divide the axis into ten equal parts */
#define COLUMN_CELLS 14 /* least width of a column [cell] */
#define CURVES_MAX 12   /* largest number of curves in a table */

/* ---- a table of values at equally spaced x ---- */

/* Returns true if x never decreases, so that y is a function of x. */
static bool is_ascending(const struct curve *curve)
{
    for (size_t i = 1; curve_goes_on(curve, i); i++)
        if (!(curve->x[i] >= curve->x[i - 1]))
            return false;
    return curve->n > 1;
}

/* Returns the value of a curve at x, linear between samples; NAN outside, and beside a missing
 * sample. */
static double curve_at(const struct curve *curve, double x)
{
    const size_t high = first_from(curve->x, curve->n, x);
    if (high == curve->n || (high == 0 && curve->x[0] > x))
        return NAN;
    if (curve->x[high] == x)
        return curve->y[high];
    const double low = curve->x[high - 1], part = (x - low) / (curve->x[high] - low);
    return curve->y[high - 1] + part * (curve->y[high] - curve->y[high - 1]);
}

/* Appends a text aligned to the right in `width` cells. */
static void page_cell_put(struct text text, int width, struct buffer *output)
{
    for (int i = text_width(text); i < width; i++)
        buffer_char(output, ' ');
    buffer_put(output, text);
}

/* Returns the width of a column with that heading. */
static int column_width(const struct buffer *heading)
{
    const int needed = text_width(buffer_text(heading));
    return needed > COLUMN_CELLS ? needed : COLUMN_CELLS;
}

/* Appends the heading of a column, if it fits into `room` cells. Returns the width of the column,
 * or 0. */
static int put_heading(const char *name, const struct axis *axis, int room, struct buffer *output)
{
    struct buffer text = {0};
    const char *const unit = axis->unit ? axis->unit : "";
    buffer_format(&text, axis->unit && *axis->unit ? " %s [%s]" : " %s", name, unit);
    const int width = column_width(&text) <= room ? column_width(&text) : 0;
    if (width)
        page_cell_put(buffer_text(&text), width, output);
    buffer_free(&text);
    return width;
}

/* Appends a number as the axis shows it, or "-" if it is NAN. */
static void page_number_put(double value, const struct axis *axis, int width, struct buffer *output)
{
    struct buffer text = {0};
    const double shown = value / (axis->factor > 0 ? axis->factor : 1);
    buffer_format(&text, " %.5g", shown == 0 ? 0 : shown);
    page_cell_put(isnan(value) ? TEXT(" -") : buffer_text(&text), width, output);
    buffer_free(&text);
}

/* Appends a table of CURVE_ROWS rows with x and the value of each curve, with as many columns as
 * fit into `room` characters. x goes in equal steps (equal factors on a logarithmic axis) through
 * the range of the curves that the axis shows. Appends nothing if x does not ascend along some
 * curve, or if the figure is a plane. */
static void page_table_put(const struct figure *figure, int room, struct buffer *output)
{
    double x_begin = HUGE_VAL, x_end = -HUGE_VAL;
    int columns = 0, wide[CURVES_MAX + 1];
    for (int i = 0; i < figure->curves; i++) {
        const struct curve *curve = &figure->curve[i];
        if (curve->n > 0 && !is_ascending(curve))
            return; /* no function of x */
        if (curve->n > 0) {
            x_begin = fmin(x_begin, curve->x[0]);
            x_end = fmax(x_end, curve->x[curve->n - 1]);
        }
    }
    if (figure->x.fixed) {
        x_begin = fmax(x_begin, figure->x.first_value);
        x_end = fmin(x_end, figure->x.last_value);
    }
    if (figure->plane || !(x_end > x_begin) || (figure->x.log && !(x_begin > 0)))
        return;
    room -= wide[0] = put_heading(figure->x.label, &figure->x, room, output);
    for (int i = 0; i < figure->curves && i < CURVES_MAX; i++) {
        const struct curve *curve = &figure->curve[i];
        wide[i + 1] = put_heading(curve->label && *curve->label ? curve->label : figure->y.label,
                                  curve_axis(figure, curve, true), room, output);
        if (wide[i + 1] == 0)
            break;
        room -= wide[i + 1];
        columns++;
    }
    buffer_char(output, '\n');
    for (int row = 0; row < CURVE_ROWS; row++) {
        const double part = (double)row / (CURVE_ROWS - 1);
        double x;
        if (row + 1 == CURVE_ROWS)
            x = x_end;
        else
            x = figure->x.log ? x_begin * pow(x_end / x_begin, part)
                              : x_begin + part * (x_end - x_begin);
        page_number_put(x, &figure->x, wide[0], output);
        for (int i = 0; i < columns; i++) {
            const struct curve *curve = &figure->curve[i];
            page_number_put(curve->n ? curve_at(curve, x) : NAN, curve_axis(figure, curve, true),
                            wide[i + 1], output);
        }
        buffer_char(output, '\n');
    }
}

/* Prints a figure as a description and a table, in lines of `width` [cells]. */
bool words_print(const struct figure *figure, int width, struct buffer *output)
{
    struct buffer text = {0};
    const bool ok = describe_figure(figure, &text);
    buffer_folded(output, buffer_text(&text), width);
    buffer_char(output, '\n');
    page_table_put(figure, width, output);
    buffer_free(&text);
    return ok && !output->failed;
}

/* Prints a heat map as a description. */
bool words_heat(const struct heat *heat, int width, struct buffer *output)
{
    struct buffer text = {0};
    const bool ok = describe_heat(heat, &text);
    buffer_folded(output, buffer_text(&text), width);
    buffer_char(output, '\n');
    buffer_free(&text);
    return ok && !output->failed;
}

/* ---- in a rectangle of cells ---- */

/* Returns the number of lines of a text. */
static int lines_of(const struct buffer *folded)
{
    int lines = 1;
    for (size_t i = 0; i < folded->len; i++)
        lines += folded->data[i] == '\n';
    return lines;
}

/* Removes the last sentence of a text. Returns false if there is only one. */
static bool drop_sentence(struct buffer *text)
{
    size_t end = text->len > 1 ? text->len - 1 : 0;
    while (end > 1 && !(text->data[end - 1] == '.' && text->data[end] == ' '))
        end--;
    if (end <= 1)
        return false;
    text->len = end;
    text->data[end] = '\0';
    return true;
}

/* Draws the figure's description into a rectangle of cells, (x, y) its upper left corner. Last
 * sentences are dropped until the text fits into `height` lines. Returns false if out of memory. */
bool words_draw(const struct figure *figure, struct canvas *canvas, int x, int y, int width,
                int height)
{
    struct buffer text = {0}, folded = {0};
    struct text rest, line;
    const bool ok = describe_figure(figure, &text);
    do {
        buffer_clear(&folded);
        buffer_folded(&folded, buffer_text(&text), width);
    } while (lines_of(&folded) > height && drop_sentence(&text));
    rest = buffer_text(&folded);
    for (int row = 0; row < height; row++) {
        for (int column = 0; column < width; column++)
            canvas_put(canvas, x + column, y + row, ' ', STYLE_PLAIN);
        if (text_split(&rest, '\n', &line))
            canvas_text(canvas, x, y + row, line, STYLE_PLAIN);
    }
    buffer_free(&folded);
    buffer_free(&text);
    return ok;
}
