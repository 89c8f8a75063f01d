/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Axes of a figure: applies ranges that the user asked for, and gives curves of very different size
 * a logarithmic axis if all are positive, else a second panel. drawing_scales() is the entry. */
#include <hooke/figure/layout.h>
#include <hooke/base/unit.h>
#include <hooke/plot/drawing.h>

#include <hooke/plot.h>

#include <math.h>

#define SHARED_AXIS_RATIO 10 /* Curves whose sizes differ by at most this ratio share an axis. */
/* A logarithmic axis leaves out values below this fraction of the smallest curve. */
#define DECADES_LEFT 1e-6
#define ENERGY_FLAT_RELATIVE 0.01 /* An energy that varies by less is shown from zero. */
#define CURVE_MARGIN 0.04         /* Fraction of a range that is left free beyond the curves. */

/* ---- ranges that were asked for ---- */

/* Returns true if a range was given with at least one end. */
static bool has_ends(const struct figure_range *range)
{
    return range && (!isnan(range->end[0]) || !isnan(range->end[1]));
}

/* Finds the extent of the curves along an axis, for samples inside of the range that the user has
 * set for the other one. */
static struct extent find_extent(const struct drawing *d, bool vertical)
{
    const struct figure_range *other_range = vertical ? d->request->x : d->request->y;
    return curves_extent(
        d->curve, d->curves,
        &(struct extent_window){.vertical = vertical,
                                .other_range = other_range ? other_range->end : NULL});
}

/* Returns false with an error if the user's range has a unit of another quantity than the axis. */
static bool check_range_unit(const struct drawing *d, const struct figure_range *range,
                             const struct axis *axis, enum quantity quantity)
{
    if (range->quantity == QUANTITY_OTHER || range->quantity == quantity)
        return true;
    const char *label = axis->label ? axis->label : "";
    const char *unit = axis->unit && *axis->unit ? axis->unit : "1";
    error_at(d->error, range->text, "the axis of %s is in %s", label, unit);
    return error_hint(d->error, "a number without a unit is in %s",
                      quantity_unit(quantity)[0] ? quantity_unit(quantity) : "1");
}

/* Applies the range that was asked for to an axis; an open end is where the curves end, with a
 * margin. Returns false with an error if it is empty, not positive on a logarithmic axis, or of the
 * wrong quantity. */
static bool apply_range(const struct drawing *d, bool vertical, enum quantity quantity,
                        struct figure *figure)
{
    const struct figure_range *range = vertical ? d->request->y : d->request->x;
    struct axis *axis = vertical ? &figure->y : &figure->x;
    const double air = axis->log || !(vertical || figure->plane) ? 0 : CURVE_MARGIN;
    if (!has_ends(range))
        return true;
    if (!check_range_unit(d, range, axis, quantity))
        return false;
    const struct extent extent = find_extent(d, vertical);
    axis->first_value = range->end[0];
    axis->last_value = range->end[1];
    if (isnan(range->end[0]))
        axis->first_value = extent.low - air * (range->end[1] - extent.low);
    if (isnan(range->end[1]))
        axis->last_value = extent.high + air * (extent.high - range->end[0]);
    axis->fixed = true;
    if (axis->log && !(axis->first_value > 0))
        return error_at(d->error, range->text, "a logarithmic axis must begin above zero");
    if (!(axis->first_value < axis->last_value))
        return error_at(d->error, range->text, "no curve lies in this range");
    if ((vertical || figure->plane) && !figure->equal)
        axis_suit(axis, quantity, fmax(fabs(axis->first_value), fabs(axis->last_value)));
    return true;
}

bool drawing_ranges(const struct drawing *d, struct figure *figure, const enum quantity quantity[2])
{
    return apply_range(d, true, quantity[1], figure) && apply_range(d, false, quantity[0], figure);
}

/* ---- curves of different size ---- */

/* Returns the size of the curve inside of the window of time, or 0 if nothing is there. */
static double size_of_curve(const struct drawing *d, int i, bool x)
{
    const struct extent_window window = {
        .vertical = !x, .other_range = plot_is_timed(d->request->kind) && !x ? d->window : NULL};
    const struct extent extent = curves_extent(&d->curve[i], 1, &window);
    return extent.low <= extent.high ? fmax(fabs(extent.low), fabs(extent.high)) : 0;
}

/* Returns the size of each curve; in a plane the larger of both. Returns NULL if out of memory. */
static const double *curve_sizes(const struct drawing *d, const struct figure *figure)
{
    double *size = arena_array(d->arena, (size_t)d->curves + 1, sizeof *size);
    for (int i = 0; size && i < d->curves; i++) {
        size[i] = size_of_curve(d, i, false);
        if (figure->equal)
            size[i] = fmax(size[i], size_of_curve(d, i, true));
    }
    return size;
}

/* Returns the smallest positive size. */
static double min_size(const double *size, int n)
{
    double min = HUGE_VAL;
    for (int i = 0; i < n; i++)
        min = size[i] > 0 ? fmin(min, size[i]) : min;
    return min;
}

/* Returns the size that separates small from large curves, at the widest gap between sizes, or 0 if
 * one axis can hold all. Curves at rest have size 0 and do not count. */
static double separating_size(const double *size, int n)
{
    double max = 0, widest = 1, parting = 0;
    for (int i = 0; i < n; i++) {
        double next = HUGE_VAL;
        max = fmax(max, size[i]);
        for (int j = 0; j < n; j++)
            next = size[j] > size[i] ? fmin(next, size[j]) : next;
        if (size[i] > 0 && isfinite(next) && next / size[i] > widest) {
            widest = next / size[i];
            parting = sqrt(size[i]) * sqrt(next);
        }
    }
    return max > SHARED_AXIS_RATIO * min_size(size, n) ? parting : 0;
}

/* Returns true if the plot is one of positive quantities and no curve has a negative value. */
static bool is_positive(const struct drawing *d, enum quantity quantity)
{
    if (!kind_of(d)->positive && quantity != QUANTITY_ENERGY)
        return false;
    for (int c = 0; c < d->curves; c++)
        for (size_t i = 0; curve_goes_on(&d->curve[c], i); i++)
            if (d->curve[c].y[i] < 0)
                return false;
    return true;
}

/* Returns the size of the largest curve of a panel. */
static double panel_size(const struct drawing *d, bool x, int panel)
{
    double size = 0;
    for (int i = 0; i < d->curves; i++)
        if (d->curve[i].panel == panel)
            size = fmax(size, size_of_curve(d, i, x));
    return size;
}

/* Divides the curves between two panels: those larger than `parting` go to the second. Gives each
 * panel its own axes. Returns false if out of memory. */
static bool divide_panels(struct drawing *d, struct figure *figure, enum quantity x_quantity,
                          enum quantity y_quantity, const double *size, double parting)
{
    struct axis *second = arena_array(d->arena, 2, sizeof *second);
    if (!second)
        return error_memory(d->error);
    for (int i = 0; i < d->curves; i++)
        d->curve[i].panel = size[i] > parting;
    second[0] = figure->x;
    second[1] = figure->y;
    for (int panel = 0; panel < 2; panel++) {
        struct axis *x = panel ? &second[0] : &figure->x;
        struct axis *y = panel ? &second[1] : &figure->y;
        y->label = drawing_y_label(d, panel);
        if (!y->label)
            return error_memory(d->error);
        axis_suit(y, y_quantity, panel_size(d, false, panel));
        if (figure->plane)
            axis_suit(x, x_quantity, panel_size(d, true, panel));
        if (figure->equal) {
            y->factor = x->factor;
            y->unit = x->unit;
        }
    }
    figure->second = second;
    return true;
}

/* Adds a note with the variation of an energy that is drawn from zero and therefore seems constant.
 * Returns false if out of memory. */
static bool note_small_variation(struct drawing *d, struct figure *figure)
{
    const struct extent extent = find_extent(d, true);
    const double varies = (extent.high - extent.low) / fmax(fabs(extent.low), fabs(extent.high));
    if (d->request->follow || !(figure->y.flat > 0) ||
        !(varies > 1e-15 && varies <= figure->y.flat))
        return true;
    struct buffer text = {0};
    const char *const note = figure->note ? figure->note : "";
    buffer_format(&text, "%s%svaries by %.2g of its size, 'y=:' shows it", note,
                  figure->note ? ", " : "", varies);
    figure->note = text.failed ? NULL : arena_text(d->arena, buffer_text(&text));
    buffer_free(&text);
    return figure->note || error_memory(d->error);
}

/* Chooses ranges, logarithmic axis and panels of a figure; quantity[0] is that of the horizontal
 * axis, quantity[1] of the vertical one. Returns false with an error. */
bool drawing_scales(struct drawing *d, struct figure *figure, const enum quantity quantity[2])
{
    const struct figure_request *request = d->request;
    const bool wanted = has_ends(request->y) || (figure->plane && has_ends(request->x));
    figure->y.log = request->log;
    if (!drawing_ranges(d, figure, quantity))
        return false;
    if (request->y)
        figure->y.flat = -1;
    else
        figure->y.flat = kind_of(d)->flat ? ENERGY_FLAT_RELATIVE : 0;
    const bool one = wanted || request->full || request->log;
    if (one)
        return true;
    const double *size = curve_sizes(d, figure);
    if (!size)
        return error_memory(d->error);
    const double parting = separating_size(size, d->curves);
    if (!(parting > 0))
        return note_small_variation(d, figure);
    if (!is_positive(d, quantity[1]))
        return divide_panels(d, figure, quantity[0], quantity[1], size, parting);
    figure->y.log = true;
    figure->y.min = DECADES_LEFT * min_size(size, d->curves);
    return true;
}
