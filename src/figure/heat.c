/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Heat maps: the edges between their points, the scale of their values, and the character that
 * shades each value. */
#include "figure/internal.h"

#include <math.h>
#include <string.h>

/* Returns i limited to low..high. */
static int limit_index(int i, int low, int high)
{
    if (i < low)
        return low;
    return i > high ? high : i;
}

/* Returns the coordinate of point i along an axis on which points are evenly spaced: its value, or
 * the logarithm. */
static double axis_coordinate(const struct heat_axis *axis, int i)
{
    return axis->log ? log(axis->value[i]) : axis->value[i];
}

/* Returns the edge between points i - 1 and i of an axis, midway between them. The two outer edges
 * are extrapolated; the edges of a single point are half its value away from it. */
double heat_edge(const struct heat_axis *axis, int i)
{
    const int upper = limit_index(i, 1, axis->count - 1);
    if (axis->count < 2)
        return axis->value[0] + (i - 0.5) * (fabs(axis->value[0]) > 0 ? fabs(axis->value[0]) : 1);
    const double a = axis_coordinate(axis, upper - 1), b = axis_coordinate(axis, upper),
                 edge = (a + b) / 2 + (i - upper) * (b - a);
    return axis->log ? exp(edge) : edge;
}

/* Ratio of the largest to the smallest positive value above which shades are spaced
 * logarithmically. */
static const double log_ratio = 300;

/* Finds the range of a map's finite values, with low > high if it has none, and whether the shades
 * are logarithmic. */
struct heat_scale heat_scale_of(const struct heat *heat)
{
    struct heat_scale scale = {.low = HUGE_VAL, .high = -HUGE_VAL};
    for (size_t i = 0; i < (size_t)heat->x.count * (size_t)heat->y.count; i++)
        if (isfinite(heat->value[i])) {
            scale.low = fmin(scale.low, heat->value[i]);
            scale.high = fmax(scale.high, heat->value[i]);
        }
    scale.log = !heat->letters && scale.low > 0 && scale.high > log_ratio * scale.low;
    return scale;
}

/* Returns the position of a value on the scale: 0 at its low end, 1 at its high end, 0 if all
 * values are equal. */
double heat_share(const struct heat_scale *scale, double value)
{
    if (!(scale->high > scale->low))
        return 0;
    return scale->log ? log(value / scale->low) / log(scale->high / scale->low)
                      : (value - scale->low) / (scale->high - scale->low);
}

/* Returns the largest finite value of the points [x0, x1) x [y0, y1), which share a cell, or NAN if
 * none has a value. */
double heat_largest(const struct heat *heat, int x0, int x1, int y0, int y1)
{
    double max = NAN;
    for (int x = x0; x < x1; x++)
        for (int y = y0; y < y1; y++) {
            const double value = heat->value[(size_t)x * (size_t)heat->y.count + (size_t)y];
            max = isfinite(value) && !(value <= max) ? value : max;
        }
    return max;
}

/* Sets *shade to the characters of the shades, from the lowest to the highest value. Returns their
 * number. */
int heat_shades(const struct charset *charset, const uint32_t **shade)
{
    static const uint32_t ascii[] = {' ', '.', ':', '-', '=', '+', '*', '%', '@', '#'};
    /* blank, middle dot, then blocks from light to full */
    static const uint32_t block[] = {' ', 0xB7, 0x2591, 0x2592, 0x2593, 0x2588};
    *shade = charset->plain ? ascii : block;
    return charset->plain ? (int)COUNT_OF(ascii) : (int)COUNT_OF(block);
}

/* Returns the character that shows a value: 'x' if it is missing (NAN), else the letter of its
 * category if the map has letters, else the shade of its position on the scale. */
uint32_t heat_glyph(const struct heat *heat, const struct heat_scale *scale,
                    const struct charset *charset, double value)
{
    const uint32_t *shade;
    const int shades = heat_shades(charset, &shade);
    if (isnan(value))
        return 'x';
    if (!heat->letters) {
        return shade[limit_index((int)floor(heat_share(scale, value) * shades), 0, shades - 1)];
    }
    /* Letters belong to the values -1, 0, 1 ...; all larger values share the last letter. */
    const double last = (double)strlen(heat->letters) - 1;
    return (uint32_t)heat->letters[(int)fmax(0, fmin(value + 1, last))];
}

/* Finds the points [*first, *end) of an axis that cell number `cell` of `cells` shows: those whose
 * middle lies in it, and the one that covers its middle. Returns false if the cell is beyond the
 * map. */
static bool points_in_cell(const struct heat_axis *axis, const struct scale *scale, int cell,
                           int cells, int *first, int *end)
{
    const double low = (double)cell / cells, high = (double)(cell + 1) / cells;
    *first = *end = -1;
    for (int i = 0; i < axis->count; i++) {
        const double begin = fraction_of(scale, heat_edge(axis, i)),
                     finish = fraction_of(scale, heat_edge(axis, i + 1)),
                     middle = (begin + finish) / 2;
        const bool covers = begin <= (low + high) / 2 && finish > (low + high) / 2;
        if (!covers && !(middle >= low && middle < high))
            continue;
        *first = *first < 0 ? i : *first;
        *end = i + 1;
    }
    return *first >= 0;
}

/* Draws a map: each cell shows the largest value of its points. */
void raster_heat(const struct raster *raster, const struct heat *heat)
{
    const struct figure_layout *layout = raster->layout;
    const struct heat_scale scale = heat_scale_of(heat);
    int x0, x1, y0, y1;
    for (int row = 0; row < layout->rows; row++) {
        if (!points_in_cell(&heat->y, &layout->y, layout->rows - 1 - row, layout->rows, &y0, &y1))
            continue;
        for (int column = 0; column < layout->columns; column++)
            if (points_in_cell(&heat->x, &layout->x, column, layout->columns, &x0, &x1))
                canvas_put(
                    raster->canvas, raster->x + column, raster->y + row,
                    heat_glyph(heat, &scale, layout->charset, heat_largest(heat, x0, x1, y0, y1)),
                    STYLE_PLAIN);
    }
}
