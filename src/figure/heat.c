/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Heat maps: edges of their places, the scale of their values, and its characters. */
#include <hooke/figure.h>

#include <math.h>
#include <string.h>

static int limited(int i, int low, int high)
{
    if (i < low)
        return low;
    return i > high ? high : i;
}

static double place_of(const struct heat_axis *axis, int i)
{
    return axis->log ? log(axis->value[i]) : axis->value[i];
}

double heat_edge(const struct heat_axis *axis, int i)
{
    const int upper = limited(i, 1, axis->count - 1);
    if (axis->count < 2)
        return axis->value[0] + (i - 0.5) * (fabs(axis->value[0]) > 0 ? fabs(axis->value[0]) : 1);
    const double a = place_of(axis, upper - 1), b = place_of(axis, upper),
                 edge = (a + b) / 2 + (i - upper) * (b - a);
    return axis->log ? exp(edge) : edge;
}

/* Ratio of positive values from which their scale is logarithmic. */
static const double log_ratio = 300;

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

double heat_share(const struct heat_scale *scale, double value)
{
    if (!(scale->high > scale->low))
        return 0;
    return scale->log ? log(value / scale->low) / log(scale->high / scale->low)
                      : (value - scale->low) / (scale->high - scale->low);
}

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

int heat_shades(const struct charset *charset, const uint32_t **shade)
{
    static const uint32_t ascii[] = {' ', '.', ':', '-', '=', '+', '*', '%', '@', '#'};
    /* space, dot, light .. full */
    static const uint32_t block[] = {' ', 0xB7, 0x2591, 0x2592, 0x2593, 0x2588};
    *shade = charset->plain ? ascii : block;
    return charset->plain ? (int)COUNT_OF(ascii) : (int)COUNT_OF(block);
}

uint32_t heat_glyph(const struct heat *heat, const struct heat_scale *scale,
                    const struct charset *charset, double value)
{
    const uint32_t *shade;
    const int shades = heat_shades(charset, &shade);
    if (isnan(value))
        return 'x';
    if (!heat->letters) {
        return shade[limited((int)floor(heat_share(scale, value) * shades), 0, shades - 1)];
    }
    const double last = (double)strlen(heat->letters) - 1;
    return (uint32_t)heat->letters[(int)fmax(0, fmin(value + 1, last))];
}
