/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Heat maps as sentences. */
#include "modules/words/internal.h"

#include <math.h>

static void put_heat_axis(const struct heat_axis *axis, struct buffer *out)
{
    const double factor = axis->factor > 0 ? axis->factor : 1;
    buffer_format(out, "%d values of %s from ", axis->count, axis->label);
    figure_number(axis->value[0] / factor, out);
    buffer_put(out, TEXT(" to "));
    figure_number(axis->value[axis->count - 1] / factor, out);
    if (axis->unit && *axis->unit)
        buffer_format(out, " %s", axis->unit);
}

static void put_heat_place(const struct heat *heat, size_t at, const char *what, struct buffer *out)
{
    const struct axis x = {.label = heat->x.label, .unit = heat->x.unit, .factor = heat->x.factor},
                      y = {.label = heat->y.label, .unit = heat->y.unit, .factor = heat->y.factor},
                      value = {.unit = heat->unit, .factor = heat->factor};
    const size_t row = (size_t)heat->y.count;
    buffer_format(out, " It is %s, ", what);
    figure_value(&value, heat->value[at], NULL, out);
    buffer_format(out, ", at %s = ", x.label);
    figure_value(&x, heat->x.value[at / row], NULL, out);
    buffer_format(out, ", %s = ", y.label);
    figure_value(&y, heat->y.value[at % row], NULL, out);
    buffer_put(out, TEXT("."));
}

bool describe_heat(const struct heat *heat, struct buffer *out)
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
    buffer_format(out, "%s over ", heat->title ? heat->title : "A map");
    put_heat_axis(&heat->x, out);
    buffer_put(out, TEXT(" and "));
    put_heat_axis(&heat->y, out);
    buffer_put(out, TEXT("."));
    if (low < n) {
        put_heat_place(heat, low, "lowest", out);
        put_heat_place(heat, high, "highest", out);
    }
    if (missing > 0)
        buffer_format(out, " %zu of %zu points have no value.", missing, n);
    return !out->failed;
}
