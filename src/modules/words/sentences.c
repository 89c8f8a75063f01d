/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes descriptions of figures as sentences. */
#include "modules/words/internal.h"

#include <hooke/result.h>

#include <math.h>

#define SPOKEN_DIGITS 4            /* number of digits of numbers */
#define CURVES_DESCRIBED 3         /* number of curves that get a sentence each */
#define ZERO_RELATIVE 1e-12        /* a value below this fraction of the range is 0 */
#define RANGE_ROUNDING 1e-9        /* a range below this fraction of its values is rounding */
#define AMPLITUDE_CHANGE_MIN 0.005 /* amplitudes that differ by less are equal */
#define LEVEL_CHANGE_MAX 0.3       /* a level moves by at most this fraction of the amplitude */

/* ---- numbers as the axes show them ---- */

/* Appends a number with so many digits. */
static void put_digits(double value, int digits, struct buffer *output)
{
    buffer_format(output, "%.*g", digits, value == 0 ? 0 : value);
}

void figure_number(double value, struct buffer *output)
{
    put_digits(value, SPOKEN_DIGITS, output);
}

/* Returns the number of digits that show a thousandth of the range. */
static int digits_for(const double range[2])
{
    const double size = fmax(fabs(range[0]), fabs(range[1])), span = range[1] - range[0];
    const double more = span > RANGE_ROUNDING * size ? ceil(log10(size / span) - 0.5) : 0;
    return SPOKEN_DIGITS + (int)fmax(more, 0);
}

static void put_unit(const struct axis *axis, struct buffer *output)
{
    if (axis->unit && *axis->unit)
        buffer_format(output, " %s", axis->unit);
}

void figure_value(const struct axis *axis, double value, const double *range, struct buffer *output)
{
    if (range && !axis->log && fabs(value) < ZERO_RELATIVE * fmax(fabs(range[0]), fabs(range[1])))
        value = 0;
    put_digits(value / axis_factor(axis), range ? digits_for(range) : SPOKEN_DIGITS, output);
    put_unit(axis, output);
}

/* Appends "LABEL from A to B UNIT". */
static void put_range(const struct axis *axis, const double range[2], struct buffer *output)
{
    buffer_format(output, "%s from ", axis->label && *axis->label ? axis->label : "values");
    put_digits(range[0] / axis_factor(axis), digits_for(range), output);
    buffer_put(output, TEXT(" to "));
    put_digits(range[1] / axis_factor(axis), digits_for(range), output);
    put_unit(axis, output);
}

/* Appends a rate per unit of the axis, such as "2 1/s". */
static void put_rate(const struct axis *axis, double rate, struct buffer *output)
{
    figure_number(rate * axis_factor(axis), output);
    if (axis->unit && *axis->unit)
        buffer_format(output, " 1/%s", axis->unit);
    else
        buffer_format(output, " per unit of %s", axis->label);
}

/* ---- what a curve does ---- */

/* A curve with what sentences about it need. */
struct described {
    const struct figure_reading *figure;
    const struct curve_reading *curve;
    const struct axis *x, *y;
    const double *x_range, *y_range; /* ranges of its axes */
};

/* Returns curve i with its axes. */
static struct described subject_of(const struct figure_reading *reading, int i)
{
    const struct figure *figure = reading->figure;
    const struct curve *curve = &figure->curve[i];
    const int panel = figure->second && curve->panel > 0;
    return (struct described){reading,
                              &reading->curve[i],
                              curve_axis(figure, curve, false),
                              curve_axis(figure, curve, true),
                              panel && figure->plane ? reading->second_x : reading->x,
                              reading->y[panel]};
}

/* Appends "Y at x = X". */
static void put_place(const struct described *s, struct curve_point point, struct buffer *output)
{
    figure_value(s->y, point.y, s->y_range, output);
    buffer_format(output, " at %s = ", s->x->label);
    figure_value(s->x, point.x, s->x_range, output);
}

/* Appends the first and the last value of the curve; in a plane, both coordinates of its ends. */
static void put_ends(const struct described *s, struct buffer *output)
{
    const struct curve_reading *c = s->curve;
    buffer_put(output, TEXT("starts at "));
    if (s->figure->figure->plane) {
        const struct curve_point *ends[] = {&c->start, &c->end};
        for (int i = 0; i < 2; i++) {
            buffer_format(output, "%s%s = ", i ? " and ends at " : "", s->x->label);
            figure_value(s->x, ends[i]->x, s->x_range, output);
            buffer_format(output, ", %s = ", s->y->label);
            figure_value(s->y, ends[i]->y, s->y_range, output);
        }
        return;
    }
    figure_value(s->y, c->start.y, s->y_range, output);
    buffer_put(output, TEXT(" and ends at "));
    figure_value(s->y, c->end.y, s->y_range, output);
}

/* Appends the lowest and the highest point. */
static void put_extremes(const struct described *s, struct buffer *output)
{
    buffer_put(output, TEXT("lowest "));
    put_place(s, s->curve->low, output);
    buffer_put(output, TEXT(", highest "));
    put_place(s, s->curve->high, output);
}

/* Appends how the curve rises or falls: by which factor, and as a power or exponentially. */
static void put_trend(const struct described *s, struct buffer *output)
{
    const struct curve_reading *c = s->curve;
    const bool rises = c->course == COURSE_RISES;
    const char *const extent = c->all_along ? "throughout" : "overall";
    buffer_format(output, "%s %s", rises ? "rises" : "falls", extent);
    if (c->factor > 0 && fabs(log(c->factor)) > AMPLITUDE_CHANGE_MIN) {
        buffer_put(output, TEXT(", by a factor of "));
        figure_number(c->factor > 1 ? c->factor : 1 / c->factor, output);
    }
    if (isfinite(c->power)) {
        buffer_format(output, ", as %s to the power of ", s->x->label);
        figure_number(c->power, output);
    } else if (isfinite(c->rate) && fabs(log(c->factor)) > AMPLITUDE_CHANGE_MIN) {
        buffer_put(output, TEXT(", exponentially at "));
        put_rate(s->x, c->rate, output);
        buffer_put(output, c->rate > 0 ? TEXT(", doubling every ") : TEXT(", halving every "));
        figure_value(s->x, log(2) / fabs(c->rate), NULL, output);
    }
}

/* Appends how the amplitude of an oscillation changes. */
static void put_amplitudes(const struct described *s, struct buffer *output)
{
    const struct curve_reading *c = s->curve;
    const double part = c->amplitude[1] / c->amplitude[0] - 1;
    if (fabs(part) < AMPLITUDE_CHANGE_MIN) {
        buffer_put(output, TEXT("; its amplitude stays at "));
        figure_value(s->y, c->amplitude[0], NULL, output);
        buffer_put(output, TEXT(" (the last differs from the first by "));
        put_digits(100 * part, 2, output);
        buffer_put(output, TEXT(" %)"));
        return;
    }
    if (fabs(c->amplitude[1] - c->amplitude[0]) < c->noise) {
        buffer_put(output, TEXT("; its amplitude, "));
        figure_value(s->y, c->amplitude[0], NULL, output);
        buffer_put(output, TEXT(", changes by less than the noise"));
        return;
    }
    buffer_format(output, "; its amplitude %s from ", part > 0 ? "grows" : "shrinks");
    figure_value(s->y, c->amplitude[0], NULL, output);
    buffer_put(output, TEXT(" to "));
    figure_value(s->y, c->amplitude[1], NULL, output);
    if (isfinite(c->growth)) {
        buffer_put(output, TEXT(", exponentially at "));
        put_rate(s->x, c->growth, output);
    }
}

/* Appends the centre of an oscillation, its period, number of crossings and amplitudes. */
static void put_oscillation(const struct described *s, struct buffer *output)
{
    const struct curve_reading *c = s->curve;
    const double level = 0.5 * (c->level[0] + c->level[1]),
                 large = fmax(c->amplitude[0], c->amplitude[1]);
    if (fabs(c->level[1] - c->level[0]) > LEVEL_CHANGE_MAX * large) {
        buffer_put(output, TEXT("oscillates about a centre that moves from "));
        figure_value(s->y, c->level[0], s->y_range, output);
        buffer_put(output, TEXT(" to "));
        figure_value(s->y, c->level[1], s->y_range, output);
        buffer_char(output, ',');
    } else {
        buffer_put(output, TEXT("oscillates about "));
        figure_value(s->y, fabs(level) < AMPLITUDE_CHANGE_MIN * large ? 0 : level, s->y_range,
                     output);
    }
    buffer_put(output, TEXT(" with a period of "));
    if (isfinite(c->spread) && c->spread > 1e-6 * c->period) {
        const double factor = axis_factor(s->x);
        buffer_measured(output, (struct measured){c->period / factor, c->spread / factor},
                        QUANTITY_NUMBER, SPOKEN_DIGITS);
        put_unit(s->x, output);
    } else {
        figure_value(s->x, c->period, NULL, output);
    }
    buffer_format(output, " and crosses its centre %zu time%s", c->crossings,
                  c->crossings == 1 ? "" : "s");
    put_amplitudes(s, output);
}

/* Appends how often a curve in a plane winds, around which point, and how it spirals. */
static void put_winding(const struct described *s, struct buffer *output)
{
    const struct curve_reading *c = s->curve;
    const double part = c->distance[1] / c->distance[0] - 1;
    buffer_put(output, TEXT("winds "));
    figure_number(fabs(c->winds), output);
    buffer_format(output, " times %s about ", c->winds > 0 ? "counterclockwise" : "clockwise");
    if (c->about_origin) {
        buffer_put(output, TEXT("the origin"));
    } else {
        buffer_format(output, "%s = ", s->x->label);
        figure_value(s->x, c->centre.x, s->x_range, output);
        buffer_format(output, ", %s = ", s->y->label);
        figure_value(s->y, c->centre.y, s->y_range, output);
    }
    if (!isfinite(part))
        return;
    if (fabs(part) < AMPLITUDE_CHANGE_MIN) {
        buffer_put(output, TEXT(" and closes; its distance from there stays at "));
        figure_value(s->x, c->distance[0], NULL, output);
        return;
    }
    buffer_format(output, " and spirals %s; its distance from there changes from ",
                  part > 0 ? "outwards" : "inwards");
    figure_value(s->x, c->distance[0], NULL, output);
    buffer_put(output, TEXT(" to "));
    figure_value(s->x, c->distance[1], NULL, output);
    const double turns = floor(fabs(c->winds));
    buffer_format(output, " in %.0f turn%s", turns, turns > 1 ? "s" : "");
}

/* Appends what a curve does, or appends nothing and returns false if only its ends are known. */
static bool put_course(const struct described *s, struct buffer *output)
{
    switch (s->curve->course) {
    case COURSE_NONE:
        return false;
    case COURSE_CONSTANT:
        buffer_put(output, TEXT("stays at "));
        figure_value(s->y, s->curve->start.y, s->y_range, output);
        return true;
    case COURSE_SCATTERS:
        buffer_put(output, TEXT("scatters about "));
        figure_value(s->y, s->curve->level[0], s->y_range, output);
        buffer_put(output, TEXT(" with a standard deviation of "));
        figure_value(s->y, s->curve->spread, NULL, output);
        return true;
    case COURSE_RISES:
    case COURSE_FALLS:
        put_trend(s, output);
        return true;
    case COURSE_OSCILLATES:
        put_oscillation(s, output);
        return true;
    case COURSE_WINDS:
        put_winding(s, output);
        return true;
    case COURSE_TURNS:
        if (s->figure->figure->plane)
            return false;
        if (isfinite(s->curve->power)) {
            buffer_format(output, "varies as %s to the power of ", s->x->label);
            figure_number(s->curve->power, output);
            return true;
        }
        buffer_format(output, "changes direction %zu time%s without a period", s->curve->turns,
                      s->curve->turns == 1 ? "" : "s");
        return true;
    }
    return false;
}

/* ---- sentences ---- */

/* Appends how many samples cannot be shown, and the longest interval without any. */
static void put_gaps(const struct described *s, struct buffer *output)
{
    if (s->curve->gaps > 0)
        buffer_format(output, ", except for %zu sample%s that cannot be shown", s->curve->gaps,
                      s->curve->gaps == 1 ? "" : "s");
    if (!(s->curve->hole[1] > s->curve->hole[0]))
        return;
    buffer_format(output, ", without samples from %s = ", s->x->label);
    figure_value(s->x, s->curve->hole[0], s->x_range, output);
    buffer_put(output, TEXT(" to "));
    figure_value(s->x, s->curve->hole[1], s->x_range, output);
}

/* Describes the only curve of a figure, called name, in two sentences: its course and its ends. */
static void put_alone(const struct described *s, const char *name, struct buffer *output)
{
    buffer_format(output, " %s ", name);
    const bool known = put_course(s, output);
    if (!known)
        put_ends(s, output);
    put_gaps(s, output);
    buffer_put(output, TEXT("."));
    if (s->curve->n < 2) {
        buffer_put(output, TEXT(" There is only one point."));
        return;
    }
    if (s->curve->course == COURSE_CONSTANT) {
        buffer_put(output, TEXT(" The highest value exceeds the lowest by "));
        figure_value(s->y, s->curve->high.y - s->curve->low.y, NULL, output);
        buffer_put(output, TEXT("."));
        return;
    }
    buffer_put(output, TEXT(" It "));
    if (known) {
        put_ends(s, output);
        buffer_put(output, TEXT(", "));
    } else {
        buffer_put(output, TEXT("is "));
    }
    put_extremes(s, output);
    buffer_put(output, TEXT("."));
}

/* Appends a sentence on one of several curves, without full stop; `briefly` omits its ends. */
static void put_curve(const struct described *s, bool briefly, struct buffer *output)
{
    struct buffer course = {0};
    buffer_format(output, "%s ", s->curve->label);
    if (s->curve->n == 0) {
        buffer_put(output, TEXT("has no points to show"));
        return;
    }
    const bool known = put_course(s, &course), constant = s->curve->course == COURSE_CONSTANT;
    buffer_put(output, buffer_text(&course));
    if (!known || !(briefly || constant)) {
        buffer_put(output, known ? TEXT("; it ") : TEXT(""));
        put_ends(s, output);
        if (!s->figure->figure->plane) {
            buffer_put(output, TEXT(", "));
            put_extremes(s, output);
        }
    }
    if (!briefly)
        put_gaps(s, output);
    buffer_free(&course);
}

static void put_curves(const struct figure_reading *reading, struct buffer *output)
{
    const int curves = reading->figure->curves;
    for (int i = 0; i < curves; i++) {
        const struct described s = subject_of(reading, i);
        buffer_put(output, i == 0 || curves <= CURVES_DESCRIBED ? TEXT(" ") : TEXT("; "));
        put_curve(&s, curves > CURVES_DESCRIBED, output);
        if (curves <= CURVES_DESCRIBED || i + 1 == curves)
            buffer_put(output, TEXT("."));
    }
}

static const char *title_of(const struct figure *figure)
{
    return figure->title && *figure->title ? figure->title : "A figure";
}

/* Appends the first sentence: title, axes with their ranges, and curves. */
static void put_intro(const struct figure_reading *reading, struct buffer *output)
{
    const struct figure *figure = reading->figure;
    buffer_format(output, "%s: ", title_of(figure));
    put_range(&figure->x, reading->x, output);
    buffer_put(output, TEXT(", "));
    put_range(&figure->y, reading->y[0], output);
    if (figure->second) {
        buffer_put(output, TEXT("; in a second panel "));
        if (figure->plane) {
            put_range(&figure->second[0], reading->second_x, output);
            buffer_put(output, TEXT(", "));
        }
        put_range(&figure->second[1], reading->y[1], output);
    }
    if (figure->x.log || figure->y.log) {
        const char *which;
        if (figure->x.log && figure->y.log)
            which = "both axes";
        else
            which = figure->x.log ? "horizontally" : "vertically";
        buffer_format(output, " (%s logarithmic)", which);
    }
    if (figure->curves == 1) {
        const char *const kind = figure->curve[0].points ? "points of" : "a line:";
        buffer_format(output, ", %s %s, %zu point%s", kind, reading->curve[0].label,
                      reading->curve[0].n, reading->curve[0].n == 1 ? "" : "s");
    }
    for (int i = 0; figure->curves > 1 && i < figure->curves; i++) {
        const char *separator = ", ";
        if (i == 0)
            separator = ", curves: ";
        else if (i + 1 == figure->curves)
            separator = " and ";
        buffer_format(output, "%s%s%s", separator, reading->curve[i].label,
                      figure->curve[i].points ? " (points)" : "");
    }
    buffer_put(output, TEXT("."));
}

/* Appends the largest and rms distance of each other curve from the reference curve. */
static void put_distances(const struct figure_reading *reading, struct buffer *output)
{
    if (reading->distances == 0)
        return;
    buffer_format(output, " Largest distance from %s: ", reading->curve[reading->reference].label);
    for (int i = 0; i < reading->distances; i++) {
        const struct curve_distance *distance = &reading->distance[i];
        const struct described s = subject_of(reading, distance->curve);
        buffer_format(output, "%s%s by ", i ? "; " : "", s.curve->label);
        figure_value(s.y, distance->largest, NULL, output);
        buffer_format(output, " at %s = ", s.x->label);
        figure_value(s.x, distance->x, s.x_range, output);
        buffer_put(output, TEXT(" (rms "));
        figure_value(s.y, distance->rms, NULL, output);
        buffer_put(output, TEXT(")"));
    }
    buffer_put(output, TEXT("."));
}

/* Appends a sentence on the order of the curves at the right end. */
static void put_order(const struct figure_reading *reading, struct buffer *output)
{
    if (reading->ordered < 2 || reading->figure->plane || reading->figure->second)
        return;
    buffer_put(output, TEXT(" Order at the right end, from top to bottom: "));
    for (int i = 0; i < reading->ordered; i++)
        buffer_format(output, "%s%s", i ? ", " : "", reading->curve[reading->order[i]].label);
    buffer_put(output, TEXT("."));
}

/* Appends where the uncertainty band of the first curve that has one is widest. */
static void put_bands(const struct figure_reading *reading, struct buffer *output)
{
    for (int i = 0; i < reading->figure->curves; i++) {
        const struct described s = subject_of(reading, i);
        if (!isfinite(s.curve->widest.y))
            continue;
        /* three curves have six sentences already, so this ends the last of them */
        const bool full = reading->figure->curves == CURVES_DESCRIBED && output->len > 0;
        output->len -= full;
        buffer_format(output, "%s band about %s is widest, +- ", full ? "; the" : " The",
                      s.curve->label);
        put_place(&s, (struct curve_point){s.curve->widest.x, s.curve->widest.y}, output);
        buffer_put(output, TEXT("."));
        return;
    }
}

bool describe_reading(const struct figure_reading *reading, struct buffer *output)
{
    const struct figure *figure = reading->figure;
    size_t points = 0;
    for (int i = 0; i < figure->curves; i++)
        points += reading->curve[i].n;
    if (points == 0) {
        buffer_format(output, "%s: nothing to show.", title_of(figure));
        return !output->failed;
    }
    if (figure->words) {
        buffer_put(output, text_of(figure->words));
        return !output->failed;
    }
    put_intro(reading, output);
    if (figure->curves == 1) {
        const struct described s = subject_of(reading, 0);
        put_alone(&s, s.curve->label, output);
    } else {
        put_curves(reading, output);
    }
    put_distances(reading, output);
    put_order(reading, output);
    put_bands(reading, output);
    return !output->failed;
}

bool describe_figure(const struct figure *figure, struct buffer *output)
{
    struct arena arena = {0};
    struct figure_reading reading;
    if (figure->heat && !figure->curves)
        return describe_heat(figure->heat, output);
    const bool ok = figure_read(figure, &arena, &reading) && describe_reading(&reading, output);
    arena_reset(&arena);
    return ok;
}
