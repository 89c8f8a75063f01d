/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Describes heat maps in sentences. */
#include "modules/words/internal.h"

#include <math.h>

/* Appends the number and the range of the values on an axis. */
static void put_heat_axis(const struct heat_axis *axis, struct buffer *output)
{
    const double factor = axis->factor > 0 ? axis->factor : 1;
    buffer_format(output, "%d values of %s from ", axis->count, axis->label);
    figure_number(axis->value[0] / factor, output);
    buffer_put(output, TEXT(" to "));
    figure_number(axis->value[axis->count - 1] / factor, output);
    if (axis->unit && *axis->unit)
        buffer_format(output, " %s", axis->unit);
}

/* Appends a sentence on an extreme value of the map: what (lowest or highest), heat->value[index],
 * and both coordinates of that point. */
static void put_heat_place(const struct heat *heat, size_t index, const char *what,
                           struct buffer *output)
{
    const struct axis x = {.label = heat->x.label, .unit = heat->x.unit, .factor = heat->x.factor},
                      y = {.label = heat->y.label, .unit = heat->y.unit, .factor = heat->y.factor},
                      value = {.unit = heat->unit, .factor = heat->factor};
    const size_t row = (size_t)heat->y.count;
    buffer_format(output, " It is %s, ", what);
    figure_value(&value, heat->value[index], NULL, output);
    buffer_format(output, ", at %s = ", x.label);
    figure_value(&x, heat->x.value[index / row], NULL, output);
    buffer_format(output, ", %s = ", y.label);
    figure_value(&y, heat->y.value[index % row], NULL, output);
    buffer_put(output, TEXT("."));
}

/* Describes a heat map: its axes, its lowest and highest points, and the number of points without
 * value (NaN). Returns false if out of memory. */
bool describe_heat(const struct heat *heat, struct buffer *output)
{
    const size_t n = (size_t)heat->x.count * (size_t)heat->y.count;
    size_t low = n, high = n, missing = 0;
    for (size_t i = 0; i < n; i++) {
        if (isnan(heat->value[i])) {
            missing++;
            continue;
        }
        low = low == n || heat->value[i] < heat->value[low] ? i : low;
        high = high == n || heat->value[i] > heat->value[high] ? i : high;
    }
    buffer_format(output, "%s over ", heat->title ? heat->title : "A map");
    put_heat_axis(&heat->x, output);
    buffer_put(output, TEXT(" and "));
    put_heat_axis(&heat->y, output);
    buffer_put(output, TEXT("."));
    if (low < n) {
        put_heat_place(heat, low, "lowest", output);
        put_heat_place(heat, high, "highest", output);
    }
    if (missing > 0)
        buffer_format(output, " %zu of %zu points have no value.", missing, n);
    return !output->failed;
}
