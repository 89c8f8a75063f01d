/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Heat maps: edges of their places, range of their values. */
#include <hooke/figure.h>

#include <math.h>

double heat_edge(const struct heat_axis *axis, int i)
{
    const int last = axis->count - 1, upper = i < 1 ? 1 : i > last ? last : i;
    if (axis->count < 2)
        return axis->value[0] + (i - 0.5) * (fabs(axis->value[0]) > 0 ? fabs(axis->value[0]) : 1);
    const double a = axis->log ? log(axis->value[upper - 1]) : axis->value[upper - 1],
                 b = axis->log ? log(axis->value[upper]) : axis->value[upper],
                 edge = (a + b) / 2 + (i - upper) * (b - a);
    return axis->log ? exp(edge) : edge;
}

void heat_range(const struct heat *heat, double range[2])
{
    range[0] = HUGE_VAL;
    range[1] = -HUGE_VAL;
    for (size_t i = 0; i < (size_t)heat->x.count * (size_t)heat->y.count; i++)
        if (isfinite(heat->value[i])) {
            range[0] = fmin(range[0], heat->value[i]);
            range[1] = fmax(range[1], heat->value[i]);
        }
}
