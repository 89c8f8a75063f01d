/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Ranges of axes: from the extent of curves to the two ends of an axis, and from values to
 * fractions of its length. */
#include "figure/internal.h"

#include <float.h>

/* Returns the scale from first to last, which may be descending. */
struct scale scale_of(double first, double last, bool log)
{
    if (log) {
        double low = log10(first);
        return (struct scale){first, last, true, 1, low, 1 / (log10(last) - low)};
    }
    /* Computes in units of about the larger end, so that last - first cannot overflow. The unit is
     * a power of two, so that nothing is rounded where both ends are nearly the same. */
    int exponent;
    frexp(fmax(fabs(first), fabs(last)), &exponent);
    double unit = ldexp(1, -exponent), origin = first * unit;
    return (struct scale){first, last, false, unit, origin, 1 / (last * unit - origin)};
}

double scale_fraction(const struct scale *scale, double value)
{
    return fraction_of(scale, value);
}

/* Returns true if the axis has a fixed range that can be drawn: finite, wider than the rounding of
 * its values, and positive if logarithmic. Other fixed ranges are ignored. */
static bool has_fixed_range(const struct axis *axis)
{
    double size = fmax(fabs(axis->first_value), fabs(axis->last_value));
    return axis->fixed && size > 1 / RANGE_VALUE_MAX && size <= RANGE_VALUE_MAX &&
           axis->last_value / size - axis->first_value / size > 1e-13 &&
           (!axis->log || axis->first_value > 0);
}

/* Returns the smallest value that an axis can show; a logarithmic axis shows positive values. */
static double axis_min(const struct axis *axis)
{
    return axis->log ? fmax(axis->min, DBL_TRUE_MIN) : -DBL_MAX;
}

/* Returns the range of the samples that `window` selects, with bands and error bars if it asks for
 * them; low > high if it selects none. */
struct extent curves_extent(const struct curve *curve, int curves,
                            const struct extent_window *window)
{
    struct extent extent = {INFINITY, -INFINITY, 0};
    const double *ends = window->other_range;
    for (int c = 0; c < curves; c++) {
        const bool y = window->vertical,
                   counts = !window->panel || window->panel == curve[c].panel + 1;
        const double *value = y ? curve[c].y : curve[c].x;
        const double *other_value = y ? curve[c].x : curve[c].y;
        const double *band = window->bands ? curve[c].spread : NULL;
        const double *bar = window->bars ? curve[c].bar : NULL;
        for (size_t i = 0; counts && curve_goes_on(&curve[c], i); i++) {
            if (!isfinite(value[i]) || (window->min > 0 && value[i] < window->min) ||
                (ends &&
                 (isnan(other_value[i]) || other_value[i] < ends[0] || other_value[i] > ends[1])))
                continue;
            const double margin = bar && isfinite(bar[i]) ? bar[i] : 0;
            const double half = fmax(band ? band[i] : 0, margin);
            extent.low = fmin(extent.low, value[i] - half);
            extent.high = fmax(extent.high, value[i] + half);
        }
    }
    return extent;
}

/* Returns true if sample i is outside of a fixed x range, so that it is not the y axis that hides
 * it. */
static bool is_outside_x_range(const struct figure *figure, const struct curve *curve,
                               bool vertical, size_t i)
{
    return vertical && has_fixed_range(&figure->x) &&
           !(curve->x[i] >= figure->x.first_value && curve->x[i] <= figure->x.last_value);
}

/* Counts the values of the panel's curves that a logarithmic axis cannot show. */
static size_t count_hidden(const struct figure *figure, bool vertical)
{
    const double min = axis_min(vertical ? &figure->y : &figure->x);
    size_t hidden = 0;
    for (int c = 0; c < figure->curves; c++) {
        const struct curve *curve = &figure->curve[c];
        const double *value = vertical ? curve->y : curve->x;
        for (size_t i = 0; curve_goes_on(curve, i) && curve_drawn(figure, c); i++)
            hidden += value[i] < min && !is_outside_x_range(figure, curve, vertical, i);
    }
    return hidden;
}

/* Returns a linear range for an extent: with a margin of 4 % above and below the curves, extended
 * to the next tick if that is near (not for equal axes). A constant gets a range around it. want
 * and max are the desired and the largest number of ticks. */
static struct scale linear_scale(const struct figure *figure, bool vertical, struct extent extent,
                                 int want, int max)
{
    const struct axis *axis = vertical ? &figure->y : &figure->x;
    double air = vertical || figure->equal ? 0.04 : 0;
    /* An extent below this fraction of its values is the rounding of a few hundred doubles. */
    double thin = 1e-13;
    double low = fmax(extent.low, -RANGE_VALUE_MAX), high = fmin(extent.high, RANGE_VALUE_MAX);
    double size = fmax(fabs(low), fabs(high)), factor = axis_factor(axis);

    /* No sample; only zeros; nearly constant on an axis that keeps zero; constant; the usual case.
     */
    if (low > high) {
        low = 0;
        high = factor;
    } else if (size < 1 / RANGE_VALUE_MAX) {
        low = -factor;
        high = factor;
    } else if (axis->flat > 0 && high - low <= axis->flat * size) {
        low = low > 0 ? 0 : low * (1 + air);
        high = high < 0 ? 0 : high * (1 + air);
    } else if (high - low <= thin * size) {
        low -= 0.1 * size;
        high += 0.1 * size;
    } else {
        double sign = low; /* values that never are negative get no negative range */
        low -= air * (high - low);
        if (sign >= 0 && low < 0)
            low = 0;
        sign = high;
        high += air * (high - low);
        if (sign <= 0 && high > 0)
            high = 0;
    }
    struct ticks ticks = ticks_search(low / factor, high / factor, want, max, true);
    if (!figure->equal && ticks.count > 1) {
        /* Ticks beyond the range are taken only if they add at most 35 % of it. */
        double max_air = 0.35 * (high - low), last = tick_value(&ticks, ticks.count - 1, false);
        low = fmax(fmin(low, ticks.first * factor), low - max_air);
        high = fmin(fmax(high, last * factor), high + max_air);
    }
    return scale_of(low, high, false);
}

/* Returns a logarithmic range for an extent: a margin of 3 % on both sides, and at least two powers
 * of ten among the numbers that labels show. */
static struct scale log_scale(struct extent extent, const struct axis *axis)
{
    double shift = log10(axis_factor(axis));
    /* One decade of margin to RANGE_VALUE_MAX and to its inverse. */
    double low = fmin(fmax(log10(extent.low), -299), 299) - shift;
    double high = fmin(fmax(log10(extent.high), -299), 299) - shift;

    if (extent.low > extent.high)
        return scale_of(axis_factor(axis), 10 * axis_factor(axis), true);
    double air = 0.03 * (high - low);
    low -= air;
    high += air;
    if (floor(high) - ceil(low) < 1) {
        low = floor(low - 1e-9);
        high = ceil(high + 1e-9);
    }
    return scale_of(pow(10, fmax(low + shift, -300)), pow(10, fmin(high + shift, 300)), true);
}

/* Returns the extent of the figure's curves along an axis. If x is fixed, only samples inside its
 * range count for y. Panels share their x axis unless the figure is a plane. */
struct extent axis_extent(const struct figure *figure, bool vertical, bool bars)
{
    const struct axis *axis = vertical ? &figure->y : &figure->x;
    const struct axis *other = vertical ? &figure->x : &figure->y;
    const bool follows = vertical && has_fixed_range(other), wide = vertical && !axis->log,
               whole = !vertical && !figure->plane;
    const double first = follows ? other->first_value : axis_min(other);
    const double other_range[2] = {first, follows ? other->last_value : NAN};
    const int panel = whole ? 0 : figure->panel + 1;
    const struct extent_window window = {.vertical = vertical,
                                         .other_range = other_range,
                                         .min = axis->log ? axis_min(axis) : 0,
                                         .panel = panel,
                                         .bands = wide,
                                         .bars = wide && bars};
    struct extent extent =
        curves_extent(figure->curve, has_fixed_range(axis) ? 0 : figure->curves, &window);
    extent.hidden = axis->log ? count_hidden(figure, vertical) : 0;
    return extent;
}

/* Returns the fixed range of an axis, or chooses one for the extent of its curves. */
struct scale axis_scale(const struct figure *figure, bool vertical, struct extent extent, int want,
                        int max)
{
    const struct axis *axis = vertical ? &figure->y : &figure->x;

    if (has_fixed_range(axis))
        return scale_of(axis->first_value, axis->last_value, axis->log);
    if (axis->log)
        return log_scale(extent, axis);
    return linear_scale(figure, vertical, extent, want, max);
}
