/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws a heat map in text: shades that differ without colour, labelled axes, and a legend of the
 * shades. */
#include <hooke/base/number.h>
#include "modules/sweep/swept.h"

#include <math.h>
#include <string.h>

/* Blanks between labels, lines of the legend, and size of a label. */
enum { LABEL_GAP = 3, LEGEND_LINES = 2, LABEL_SIZE = 40 };

/* Returns the number of cells for so many points: all available ones, or the largest multiple of
 * the points. */
static int cells_for(int points, int available)
{
    return points >= available ? available : available / points * points;
}

/* Finds the points of cell i of `cells`: [*first, *end), at least one. */
static void points_of(int i, int cells, int points, int *first, int *end)
{
    *first = (int)((int64_t)i * points / cells);
    *end = (int)((int64_t)(i + 1) * points / cells);
    *end = *end > *first ? *end : *first + 1;
}

/* Returns the largest value among the points of a cell. */
static double cell_value(const struct heat *heat, int column, int columns, int row, int rows)
{
    int x0, x1, y0, y1;
    points_of(column, columns, heat->x.count, &x0, &x1);
    points_of(row, rows, heat->y.count, &y0, &y1);
    return heat_largest(heat, x0, x1, y0, y1);
}

/* Writes a value in units of `factor` as a short number. */
static void format_label(double value, double factor, char output[LABEL_SIZE])
{
    struct buffer text = {0};
    buffer_short(&text, value / (factor > 0 ? factor : 1) + 0.0, 4);
    const size_t len = text.len < LABEL_SIZE ? text.len : LABEL_SIZE - 1;
    if (text.data)
        memcpy(output, text.data, len);
    output[text.data ? len : 0] = '\0';
    buffer_free(&text);
}

/* Appends a name with its unit, if any. */
static void heat_name_put(struct buffer *output, const char *name, const char *unit)
{
    buffer_put(output, text_of(name));
    if (unit && *unit)
        buffer_format(output, " [%s]", unit);
}

/* Appends a character several times. */
static void put_repeated(struct buffer *output, char c, int times)
{
    for (int i = 0; i < times; i++)
        buffer_char(output, c);
}

/* Appends the line of labels below the columns, as many as fit. `gutter` is the width left of the
 * columns [cell]. */
static void put_x_labels(const struct heat *heat, int gutter, int columns, struct buffer *output)
{
    char text[LABEL_SIZE];
    int cursor = -gutter;
    for (int column = 0; column < columns; column++) {
        int first, end, previous;
        points_of(column, columns, heat->x.count, &first, &end);
        points_of(column - 1, columns, heat->x.count, &previous, &end);
        format_label(heat->x.value[first], heat->x.factor, text);
        const int len = (int)strlen(text);
        if ((column > 0 && previous == first) || column < cursor ||
            column + len > columns + LABEL_GAP)
            continue;
        put_repeated(output, ' ', column - (cursor > 0 ? cursor - LABEL_GAP : cursor));
        buffer_put(output, text_of(text));
        cursor = column + len + LABEL_GAP;
    }
    buffer_char(output, '\n');
}

/* Appends the shades with the limits of their values, folded at `width` characters; `gaps` adds
 * that x marks cells without value. */
static void put_legend(const struct heat *heat, const struct heat_scale *scale,
                       const struct charset *charset, bool gaps, int width, struct buffer *output)
{
    const uint32_t *shade;
    const int shades = heat_shades(charset, &shade);
    const double ratio = scale->log ? scale->high / scale->low : 1;
    char text[LABEL_SIZE];
    int cursor = 0;
    for (int i = 0; i <= shades; i++) {
        const double share = (double)i / shades;
        format_label(scale->log ? scale->low * pow(ratio, share)
                                : scale->low + (scale->high - scale->low) * i / shades,
                     heat->factor, text);
        const int len = (int)strlen(text) + (i < shades ? 5 : 0);
        if (cursor + len > width) {
            buffer_char(output, '\n');
            cursor = 0;
        }
        buffer_put(output, text_of(text));
        if (i < shades) {
            buffer_put(output, TEXT(" ["));
            buffer_codepoint(output, shade[i]);
            buffer_put(output, TEXT("] "));
        }
        cursor += len;
    }
    buffer_put(output, gaps ? TEXT("   x: no value\n") : TEXT("\n"));
}

/* Draws a map as text in at most width x height characters: shades or letters in cells, axes at its
 * edges and a legend below; for screen readers a description in words. Returns false if out of
 * memory. */
bool heat_print(const struct heat *heat, int width, int height, const struct charset *charset,
                struct buffer *output)
{
    if (charset->words)
        return charset->words->print_heat(heat, width, output);
    const struct heat_scale scale = heat_scale_of(heat);
    char text[LABEL_SIZE];
    int gutter = 0;
    for (int y = 0; y < heat->y.count; y++) {
        format_label(heat->y.value[y], heat->y.factor, text);
        gutter = (int)strlen(text) > gutter ? (int)strlen(text) : gutter;
    }
    gutter += 1;
    const int columns = cells_for(heat->x.count, width - gutter > 1 ? width - gutter : 1);
    const int available = height - 3 - LEGEND_LINES;
    const int rows = cells_for(heat->y.count, available > 1 ? available : 1);
    bool gaps = false;
    heat_name_put(output, heat->title, heat->unit);
    buffer_put(output, TEXT(" over "));
    heat_name_put(output, heat->x.label, heat->x.unit);
    buffer_put(output, TEXT(" (right) and "));
    heat_name_put(output, heat->y.label, heat->y.unit);
    buffer_put(output, TEXT(" (up)\n"));
    for (int line = rows - 1; line >= 0; line--) {
        int first, end, previous = -1;
        points_of(line, rows, heat->y.count, &first, &end);
        if (line > 0)
            points_of(line - 1, rows, heat->y.count, &previous, &end);
        /* One label for each point, at its lowest line, and not on every line. */
        const bool labelled = previous != first && (rows / (rows < 8 ? rows : 8) < 2 ||
                                                    line % (rows / 8) == 0 || line == rows - 1);
        text[0] = '\0';
        if (labelled)
            format_label(heat->y.value[first], heat->y.factor, text);
        put_repeated(output, ' ', gutter - 1 - (int)strlen(text));
        buffer_put(output, text_of(text));
        buffer_char(output, '|');
        for (int column = 0; column < columns; column++) {
            const double value = cell_value(heat, column, columns, line, rows);
            gaps |= isnan(value);
            buffer_codepoint(output, heat_glyph(heat, &scale, charset, value));
        }
        while (output->len > 0 && !output->failed && output->data[output->len - 1] == ' ')
            output->data[--output->len] = '\0';
        buffer_char(output, '\n');
    }
    put_repeated(output, ' ', gutter - 1);
    buffer_char(output, '+');
    put_repeated(output, '-', columns);
    buffer_char(output, '\n');
    put_x_labels(heat, gutter, columns, output);
    if (scale.low <= scale.high && heat->letters)
        buffer_put(output, gaps ? TEXT("x: none\n") : TEXT(""));
    else if (scale.low <= scale.high)
        put_legend(heat, &scale, charset, gaps, width, output);
    else
        buffer_put(output, TEXT("no point has a value\n"));
    return !output->failed;
}
