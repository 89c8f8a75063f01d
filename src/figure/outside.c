/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds which curves leave the frame, where and how far, and composes the note in the lower frame
 * of a figure, which reports them and the values that a logarithmic axis hides. */
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include "figure/internal.h"

/* Fraction of an axis by which points may lie outside without being reported: live plots widen
 * their axes only when a point is farther outside. */
#define FRAME_MARGIN 0.011

/* Returns how far a position lies beyond the nearer end of its axis, in axis lengths, or 0 if it is
 * inside or outside by at most FRAME_MARGIN. */
static double fraction_excess(double fraction)
{
    if (fraction < -FRAME_MARGIN)
        return -fraction;
    return fraction > 1 + FRAME_MARGIN ? fraction - 1 : 0;
}

/* Describes in *outside which part of curve `index` lies beyond the axes: how many of its samples
 * (count of total), at which time or x the curve first leaves the axes (leaves, position), and its
 * farthest value (farthest, along_x, is_beyond_upper). In a plane x and y count; in other figures
 * samples beyond the x range are ignored, as are values below the minimum of a logarithmic y axis.
 */
void curve_outside(const struct figure *figure, const struct figure_layout *layout, int index,
                   struct curve_outside *outside)
{
    const struct curve *curve = &figure->curve[index];
    const double *when;
    if (curve->t)
        when = curve->t;
    else
        when = figure->plane ? NULL : curve->x;
    bool inside = false;
    double farthest = 0;

    *outside = (struct curve_outside){.position = NAN};
    for (size_t i = 0; curve_goes_on(curve, i); i++) {
        double x = fraction_of(&layout->x, curve->x[i]), y = fraction_of(&layout->y, curve->y[i]);
        if (isnan(x) || isnan(y) || (!figure->plane && fraction_excess(x) > 0) ||
            (figure->y.log && curve->y[i] < figure->y.min))
            continue;
        double x_excess = figure->plane ? fraction_excess(x) : 0, y_excess = fraction_excess(y),
               far = fmax(x_excess, y_excess);
        outside->total++;
        outside->count += far > 0;
        if (far > 0 && inside && !outside->leaves) {
            outside->leaves = true;
            outside->position = when ? when[i] : NAN;
        }
        inside |= !(far > 0);
        if (far > farthest) {
            farthest = far;
            outside->along_x = x_excess > y_excess;
            outside->farthest = outside->along_x ? curve->x[i] : curve->y[i];
            outside->is_beyond_upper = (outside->along_x ? x : y) > 0.5;
        }
    }
}

/* ---- the note, in words ---- */

/* Returns the number of significant digits that distinguishes values along an axis: 3, and more if
 * its range is narrow compared with its values, up to 12. */
static int axis_digits(const struct scale *scale)
{
    double size = fmax(fabs(scale->first_value), fabs(scale->last_value)),
           span = scale->last_value / size - scale->first_value / size;
    return scale->log || !(span > 0) ? 3 : (int)fmin(3 + fmax(floor(-log10(span)), 0), 12);
}

/* Appends a value of an axis with a unit that gives it a readable size (mm instead of 1e-3 m), if
 * its unit has such relatives, else in the unit of the axis. */
static void axis_value_put(struct buffer *output, const struct axis *axis, double value, int digits)
{
    const struct unit *unit = axis->unit ? unit_find(text_of(axis->unit)) : NULL;
    const struct unit *suited = unit ? unit_display(unit->quantity, fabs(value)) : NULL;
    const char *const name = axis->unit ? axis->unit : "";
    if (suited)
        buffer_format(output, "%.*g %s", digits, value / suited->factor, suited->row.name);
    else
        buffer_format(output, "%.*g%s%s", digits, value / axis_factor(axis), *name ? " " : "",
                      name);
}

/* Appends "verlet leaves at 3.2 s, up to 4 cm (7 of 100 samples)". Detail 0 ends after the time, 1
 * adds the farthest value, 2 the count, which is left out for thinned curves. */
static void outside_curve_put(struct buffer *output, const struct figure *figure,
                              const struct figure_layout *layout, int index,
                              const struct curve_outside *outside, int detail)
{
    const struct curve *curve = &figure->curve[index];
    const struct axis *axis = outside->along_x ? &figure->x : &figure->y;
    const char mark[2] = {figure_mark(figure, index), '\0'};

    const char *name;
    if (curve->label && *curve->label)
        name = curve->label;
    else
        name = *mark ? mark : "the curve";
    buffer_put(output, text_of(name));
    buffer_put(output, text_of(!outside->leaves ? " is outside" : " leaves"));
    if (isfinite(outside->position)) {
        const struct axis time = {.unit = "s"};
        buffer_put(output, TEXT(" at "));
        const int position_digits = figure->plane ? 3 : axis_digits(&layout->x);
        axis_value_put(output, figure->plane ? &time : &figure->x, outside->position,
                       position_digits);
    }
    if (detail > 0) {
        buffer_put(output, text_of(outside->is_beyond_upper ? ", up to " : ", down to "));
        axis_value_put(output, axis, outside->farthest,
                       axis_digits(outside->along_x ? &layout->x : &layout->y));
    }
    if (detail > 1 && !curve->thinned)
        buffer_format(output, " (%zu of %zu samples)", outside->count, outside->total);
}

/* Appends a clause for each curve outside of the axes, or nothing if all are inside. Detail 0 to 2
 * as in outside_curve_put(); -1 appends only the number of such curves. */
static void put_outside_curves(struct buffer *output, const struct figure *figure,
                               const struct figure_layout *layout, int detail)
{
    struct curve_outside outside;
    int count = 0;

    for (int i = 0; i < figure->curves; i++) {
        if (!curve_drawn(figure, i) || figure->words)
            continue;
        curve_outside(figure, layout, i, &outside);
        if (!outside.count)
            continue;
        if (detail >= 0) {
            buffer_put(output, count ? TEXT("; ") : TEXT(""));
            outside_curve_put(output, figure, layout, i, &outside, detail);
        }
        count++;
    }
    if (detail < 0 && count)
        buffer_format(output, "%d curve%s outside", count, count == 1 ? "" : "s");
}

/* Returns true if one of the curves shown is thinned, so that counts of its points are not counts
 * of samples. */
static bool has_thinned_curve(const struct figure *figure)
{
    for (int i = 0; i < figure->curves; i++)
        if (curve_drawn(figure, i) && figure->curve[i].thinned)
            return true;
    return false;
}

/* Appends how many values a logarithmic axis does not show, such as "3 values <= 0 not shown", or
 * nothing if it shows all. */
static void put_hidden_count(struct buffer *output, const struct figure *figure,
                             const struct figure_layout *layout)
{
    if (!layout->hidden)
        return;
    buffer_put(output, output->len ? TEXT(", ") : TEXT(""));
    if (has_thinned_curve(figure)) /* points of a thinned curve are not samples: no count */
        buffer_put(output, TEXT("values "));
    else
        buffer_format(output, "%zu value%s ", layout->hidden, layout->hidden == 1 ? "" : "s");
    if (figure->y.log && figure->y.min > 0) {
        buffer_put(output, TEXT("below "));
        axis_value_put(output, &figure->y, figure->y.min, 3);
    } else {
        buffer_put(output, TEXT("<= 0"));
    }
    buffer_put(output, TEXT(" not shown"));
}

/* Drops clauses from the end, at commas and semicolons, until the text fits into `available` cells,
 * so that no clause is cut in the middle. */
static void drop_last_clauses(struct buffer *output, int available)
{
    while (text_width(buffer_text(output)) > available) {
        size_t end = output->len;
        while (end > 0 && !((output->data[end - 1] == ',' || output->data[end - 1] == ';') &&
                            output->data[end] == ' '))
            end--;
        if (end == 0)
            return;
        output->len = end - 1;
        output->data[output->len] = '\0';
    }
}

/* Writes the note of a figure into `output`: the curves that leave the plot, then the figure's own
 * note and hidden values. Chooses the most detailed form that fits into `available` cells. */
void figure_note(const struct figure *figure, const struct figure_layout *layout, int available,
                 struct buffer *output)
{
    static const struct {
        /* Forms from the most to the least detailed: detail of put_outside_curves(), and whether
         * the figure's own note is shown. */
        int detail;
        bool note;
    } ways[] = {{2, true}, {1, true}, {2, false}, {1, false}, {0, false}, {-1, false}};
    struct buffer leaving = {0}, other = {0};

    buffer_put(&other, text_of(figure->note));
    put_hidden_count(&other, figure, layout);
    for (size_t i = 0; i < COUNT_OF(ways); i++) {
        buffer_clear(output);
        buffer_clear(&leaving);
        put_outside_curves(&leaving, figure, layout, ways[i].detail);
        buffer_put(output, buffer_text(&leaving));
        if (!leaving.len || ways[i].note) {
            buffer_put(output, leaving.len && other.len ? TEXT(", ") : TEXT(""));
            buffer_put(output, buffer_text(&other));
        }
        if (!leaving.len || text_width(buffer_text(output)) <= available)
            break;
    }
    drop_last_clauses(output, available);
    buffer_free(&leaving);
    buffer_free(&other);
}
