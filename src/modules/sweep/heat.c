/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A heat map in text: shades that are told apart without colour, labelled axes, a legend of the
 * shades. */
#include <hooke/base/number.h>
#include "modules/sweep/swept.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const uint32_t ascii_shades[] = {' ', '.', ':', '-', '=', '+', '*', '%', '@', '#'};
/* space, dot, light .. full */
static const uint32_t block_shades[] = {' ', 0xB7, 0x2591, 0x2592, 0x2593, 0x2588};

enum { LABEL_GAP = 3, LEGEND_LINES = 2, LABEL_SIZE = 40, NO_VALUE = 'x' };

struct shades {
    const uint32_t *shade;
    int count;
    double low, high;
};

static int shade_of(const struct shades *shades, double value)
{
    const double span = shades->high - shades->low;
    const int i = span > 0 ? (int)floor((value - shades->low) / span * shades->count) : 0;
    return i < 0 ? 0 : i >= shades->count ? shades->count - 1 : i;
}

static struct shades shades_of(const struct heat *heat, const struct charset *charset)
{
    struct shades shades = {.shade = charset->plain ? ascii_shades : block_shades,
                            .count = charset->plain ? (int)COUNT_OF(ascii_shades)
                                                    : (int)COUNT_OF(block_shades),
                            .low = HUGE_VAL,
                            .high = -HUGE_VAL};
    for (size_t i = 0; i < (size_t)heat->x.count * (size_t)heat->y.count; i++)
        if (isfinite(heat->value[i])) {
            shades.low = fmin(shades.low, heat->value[i]);
            shades.high = fmax(shades.high, heat->value[i]);
        }
    return shades;
}

static uint32_t sign_of(const struct heat *heat, const struct shades *shades, double value)
{
    if (isnan(value))
        return NO_VALUE;
    if (!heat->letters)
        return shades->shade[shade_of(shades, value)];
    const double last = (double)strlen(heat->letters) - 1;
    return (uint32_t)heat->letters[(int)fmax(0, fmin(value + 1, last))];
}

/* As many cells as there is room for, a whole number for each point where that is possible. */
static int cells_for(int points, int available)
{
    return points >= available ? available : available / points * points;
}

/* The points of cell i of `cells`: from *first, up to *end. */
static void points_of(int i, int cells, int points, int *first, int *end)
{
    *first = (int)((int64_t)i * points / cells);
    *end = (int)((int64_t)(i + 1) * points / cells);
    *end = *end > *first ? *end : *first + 1;
}

static double cell_value(const struct heat *heat, int column, int columns, int row, int rows)
{
    int x0, x1, y0, y1;
    double max = NAN;
    points_of(column, columns, heat->x.count, &x0, &x1);
    points_of(row, rows, heat->y.count, &y0, &y1);
    for (int x = x0; x < x1; x++)
        for (int y = y0; y < y1; y++) {
            const double value = heat->value[(size_t)x * (size_t)heat->y.count + (size_t)y];
            max = isfinite(value) && !(value <= max) ? value : max;
        }
    return max;
}

static void label(double value, double factor, char out[LABEL_SIZE])
{
    struct buffer text = {0};
    buffer_short(&text, value / (factor > 0 ? factor : 1) + 0.0, 4);
    const size_t len = text.len < LABEL_SIZE ? text.len : LABEL_SIZE - 1;
    if (text.data)
        memcpy(out, text.data, len);
    out[text.data ? len : 0] = '\0';
    buffer_free(&text);
}

static void heat_name_put(struct buffer *out, const char *name, const char *unit)
{
    buffer_put(out, text_of(name));
    if (unit && *unit)
        buffer_format(out, " [%s]", unit);
}

static void put_times(struct buffer *out, char c, int times)
{
    for (int i = 0; i < times; i++)
        buffer_char(out, c);
}

/* Labels below the columns, as many as fit. */
static void put_x_labels(const struct heat *heat, int gutter, int columns, struct buffer *out)
{
    char text[LABEL_SIZE];
    int at = -gutter;
    for (int column = 0; column < columns; column++) {
        int first, end, before;
        points_of(column, columns, heat->x.count, &first, &end);
        points_of(column - 1, columns, heat->x.count, &before, &end);
        label(heat->x.value[first], heat->x.factor, text);
        const int len = (int)strlen(text);
        if ((column > 0 && before == first) || column < at || column + len > columns + LABEL_GAP)
            continue;
        put_times(out, ' ', column - (at > 0 ? at - LABEL_GAP : at));
        buffer_put(out, text_of(text));
        at = column + len + LABEL_GAP;
    }
    buffer_char(out, '\n');
}

static void put_legend(const struct heat *heat, const struct shades *shades, bool gaps, int width,
                       struct buffer *out)
{
    char from[LABEL_SIZE];
    int at = 0;
    for (int i = 0; i <= shades->count; i++) {
        label(shades->low + (shades->high - shades->low) * i / shades->count, heat->factor, from);
        const int len = (int)strlen(from) + (i < shades->count ? 5 : 0);
        if (at + len > width) {
            buffer_char(out, '\n');
            at = 0;
        }
        buffer_put(out, text_of(from));
        if (i < shades->count) {
            buffer_put(out, TEXT(" ["));
            buffer_codepoint(out, shades->shade[i]);
            buffer_put(out, TEXT("] "));
        }
        at += len;
    }
    buffer_put(out, gaps ? TEXT("   x: no value\n") : TEXT("\n"));
}

bool heat_print(const struct heat *heat, int width, int height, const struct charset *charset,
                struct buffer *out)
{
    if (charset->words)
        return charset->words->print_heat(heat, width, out);
    const struct shades shades = shades_of(heat, charset);
    char text[LABEL_SIZE];
    int gutter = 0;
    for (int y = 0; y < heat->y.count; y++) {
        label(heat->y.value[y], heat->y.factor, text);
        gutter = (int)strlen(text) > gutter ? (int)strlen(text) : gutter;
    }
    gutter += 1;
    const int columns = cells_for(heat->x.count, width - gutter > 1 ? width - gutter : 1);
    const int available = height - 3 - LEGEND_LINES;
    const int rows = cells_for(heat->y.count, available > 1 ? available : 1);
    bool gaps = false;
    heat_name_put(out, heat->title, heat->unit);
    buffer_put(out, TEXT(" over "));
    heat_name_put(out, heat->x.label, heat->x.unit);
    buffer_put(out, TEXT(" (right) and "));
    heat_name_put(out, heat->y.label, heat->y.unit);
    buffer_put(out, TEXT(" (up)\n"));
    for (int line = rows - 1; line >= 0; line--) {
        int first, end, below = -1;
        points_of(line, rows, heat->y.count, &first, &end);
        if (line > 0)
            points_of(line - 1, rows, heat->y.count, &below, &end);
        /* One label for each point, at its lowest line, and not on every line. */
        const bool labelled = below != first && (rows / (rows < 8 ? rows : 8) < 2 ||
                                                 line % (rows / 8) == 0 || line == rows - 1);
        text[0] = '\0';
        if (labelled)
            label(heat->y.value[first], heat->y.factor, text);
        put_times(out, ' ', gutter - 1 - (int)strlen(text));
        buffer_put(out, text_of(text));
        buffer_char(out, '|');
        for (int column = 0; column < columns; column++) {
            const double value = cell_value(heat, column, columns, line, rows);
            gaps |= isnan(value);
            buffer_codepoint(out, sign_of(heat, &shades, value));
        }
        while (out->len > 0 && !out->failed && out->data[out->len - 1] == ' ')
            out->data[--out->len] = '\0';
        buffer_char(out, '\n');
    }
    put_times(out, ' ', gutter - 1);
    buffer_char(out, '+');
    put_times(out, '-', columns);
    buffer_char(out, '\n');
    put_x_labels(heat, gutter, columns, out);
    if (shades.low <= shades.high && heat->letters)
        buffer_put(out, gaps ? TEXT("x: none\n") : TEXT(""));
    else if (shades.low <= shades.high)
        put_legend(heat, &shades, gaps, width, out);
    else
        buffer_put(out, TEXT("no point has a value\n"));
    return !out->failed;
}
