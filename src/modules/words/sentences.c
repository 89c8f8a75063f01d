/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Readings of figures as sentences. */
#include "modules/words/internal.h"

#include <hooke/result.h>

#include <math.h>

#define SPOKEN_DIGITS 4
#define CURVES_DESCRIBED 3         /* Number of curves that get a sentence each. */
#define ZERO_RELATIVE 1e-12        /* A value below this part of the range is 0. */
#define RANGE_ROUNDING 1e-9        /* A range below this part of its size is rounding. */
#define AMPLITUDE_CHANGE_MIN 0.005 /* Amplitudes that differ by less are the same. */
/* A middle that moves by more than this part of the amplitude is no level. */
#define LEVEL_CHANGE_MAX 0.3

/* ---- numbers as the axes show them ---- */

static void put_digits(double value, int digits, struct buffer *out)
{
    buffer_format(out, "%.*g", digits, value == 0 ? 0 : value);
}

void figure_number(double value, struct buffer *out)
{
    put_digits(value, SPOKEN_DIGITS, out);
}

/* So many that a thousandth of the range can be told. */
static int digits_for(const double range[2])
{
    const double size = fmax(fabs(range[0]), fabs(range[1])), span = range[1] - range[0];
    const double more = span > RANGE_ROUNDING * size ? ceil(log10(size / span) - 0.5) : 0;
    return SPOKEN_DIGITS + (int)fmax(more, 0);
}

static void put_unit(const struct axis *axis, struct buffer *out)
{
    if (axis->unit && *axis->unit)
        buffer_format(out, " %s", axis->unit);
}

void figure_value(const struct axis *axis, double value, const double *range, struct buffer *out)
{
    if (range && !axis->log && fabs(value) < ZERO_RELATIVE * fmax(fabs(range[0]), fabs(range[1])))
        value = 0;
    put_digits(value / axis_factor(axis), range ? digits_for(range) : SPOKEN_DIGITS, out);
    put_unit(axis, out);
}

static void put_range(const struct axis *axis, const double range[2], struct buffer *out)
{
    buffer_format(out, "%s from ", axis->label && *axis->label ? axis->label : "values");
    put_digits(range[0] / axis_factor(axis), digits_for(range), out);
    buffer_put(out, TEXT(" to "));
    put_digits(range[1] / axis_factor(axis), digits_for(range), out);
    put_unit(axis, out);
}

/* "1/s" of a rate over that axis, in the numbers that it shows. */
static void put_rate(const struct axis *axis, double rate, struct buffer *out)
{
    figure_number(rate * axis_factor(axis), out);
    if (axis->unit && *axis->unit)
        buffer_format(out, " 1/%s", axis->unit);
    else
        buffer_format(out, " for each unit of %s", axis->label);
}

/* ---- what a curve does ---- */

struct described {
    const struct figure_reading *figure;
    const struct curve_reading *curve;
    const struct axis *x, *y;
    const double *across, *up; /* ranges */
};

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

static void put_place(const struct described *s, struct curve_point point, struct buffer *out)
{
    figure_value(s->y, point.y, s->up, out);
    buffer_format(out, " at %s = ", s->x->label);
    figure_value(s->x, point.x, s->across, out);
}

static void put_ends(const struct described *s, struct buffer *out)
{
    const struct curve_reading *c = s->curve;
    buffer_put(out, TEXT("starts at "));
    if (s->figure->figure->plane) {
        const struct curve_point *ends[] = {&c->start, &c->end};
        for (int i = 0; i < 2; i++) {
            buffer_format(out, "%s%s = ", i ? " and ends at " : "", s->x->label);
            figure_value(s->x, ends[i]->x, s->across, out);
            buffer_format(out, ", %s = ", s->y->label);
            figure_value(s->y, ends[i]->y, s->up, out);
        }
        return;
    }
    figure_value(s->y, c->start.y, s->up, out);
    buffer_put(out, TEXT(" and ends at "));
    figure_value(s->y, c->end.y, s->up, out);
}

static void put_extremes(const struct described *s, struct buffer *out)
{
    buffer_put(out, TEXT("lowest "));
    put_place(s, s->curve->low, out);
    buffer_put(out, TEXT(", highest "));
    put_place(s, s->curve->high, out);
}

static void put_trend(const struct described *s, struct buffer *out)
{
    const struct curve_reading *c = s->curve;
    const bool rises = c->course == COURSE_RISES;
    buffer_format(out, "%s %s", rises ? "rises" : "falls",
                  c->all_along ? "all along" : "on the whole");
    if (c->factor > 0 && fabs(log(c->factor)) > AMPLITUDE_CHANGE_MIN) {
        buffer_put(out, TEXT(", by a factor of "));
        figure_number(c->factor > 1 ? c->factor : 1 / c->factor, out);
    }
    if (isfinite(c->power)) {
        buffer_format(out, ", as %s to the power of ", s->x->label);
        figure_number(c->power, out);
    } else if (isfinite(c->rate) && fabs(log(c->factor)) > AMPLITUDE_CHANGE_MIN) {
        buffer_put(out, TEXT(", exponentially at "));
        put_rate(s->x, c->rate, out);
        buffer_put(out, c->rate > 0 ? TEXT(", doubling every ") : TEXT(", halving every "));
        figure_value(s->x, log(2) / fabs(c->rate), NULL, out);
    }
}

static void put_amplitudes(const struct described *s, struct buffer *out)
{
    const struct curve_reading *c = s->curve;
    const double part = c->amplitude[1] / c->amplitude[0] - 1;
    if (fabs(part) < AMPLITUDE_CHANGE_MIN) {
        buffer_put(out, TEXT("; its amplitude stays at "));
        figure_value(s->y, c->amplitude[0], NULL, out);
        buffer_put(out, TEXT(" (the last differs from the first by "));
        put_digits(100 * part, 2, out);
        buffer_put(out, TEXT(" %)"));
        return;
    }
    if (fabs(c->amplitude[1] - c->amplitude[0]) < c->noise) {
        buffer_put(out, TEXT("; its amplitude, "));
        figure_value(s->y, c->amplitude[0], NULL, out);
        buffer_put(out, TEXT(", changes by less than the noise"));
        return;
    }
    buffer_format(out, "; its amplitude %s from ", part > 0 ? "grows" : "shrinks");
    figure_value(s->y, c->amplitude[0], NULL, out);
    buffer_put(out, TEXT(" to "));
    figure_value(s->y, c->amplitude[1], NULL, out);
    if (isfinite(c->growth)) {
        buffer_put(out, TEXT(", exponentially at "));
        put_rate(s->x, c->growth, out);
    }
}

static void put_oscillation(const struct described *s, struct buffer *out)
{
    const struct curve_reading *c = s->curve;
    const double level = 0.5 * (c->level[0] + c->level[1]),
                 large = fmax(c->amplitude[0], c->amplitude[1]);
    if (fabs(c->level[1] - c->level[0]) > LEVEL_CHANGE_MAX * large) {
        buffer_put(out, TEXT("oscillates about a middle that goes from "));
        figure_value(s->y, c->level[0], s->up, out);
        buffer_put(out, TEXT(" to "));
        figure_value(s->y, c->level[1], s->up, out);
        buffer_char(out, ',');
    } else {
        buffer_put(out, TEXT("oscillates about "));
        figure_value(s->y, fabs(level) < AMPLITUDE_CHANGE_MIN * large ? 0 : level, s->up, out);
    }
    buffer_put(out, TEXT(" with a period of "));
    if (isfinite(c->spread) && c->spread > 1e-6 * c->period) {
        const double factor = axis_factor(s->x);
        buffer_measured(out, (struct measured){c->period / factor, c->spread / factor},
                        QUANTITY_NUMBER, SPOKEN_DIGITS);
        put_unit(s->x, out);
    } else {
        figure_value(s->x, c->period, NULL, out);
    }
    buffer_format(out, " and crosses the middle %zu time%s", c->crossings,
                  c->crossings == 1 ? "" : "s");
    put_amplitudes(s, out);
}

static void put_winding(const struct described *s, struct buffer *out)
{
    const struct curve_reading *c = s->curve;
    const double part = c->distance[1] / c->distance[0] - 1;
    buffer_put(out, TEXT("winds "));
    figure_number(fabs(c->winds), out);
    buffer_format(out, " times %s about ", c->winds > 0 ? "counterclockwise" : "clockwise");
    if (c->about_origin) {
        buffer_put(out, TEXT("the origin"));
    } else {
        buffer_format(out, "%s = ", s->x->label);
        figure_value(s->x, c->about.x, s->across, out);
        buffer_format(out, ", %s = ", s->y->label);
        figure_value(s->y, c->about.y, s->up, out);
    }
    if (!isfinite(part))
        return;
    if (fabs(part) < AMPLITUDE_CHANGE_MIN) {
        buffer_put(out, TEXT(" and closes: its distance from there stays at "));
        figure_value(s->x, c->distance[0], NULL, out);
        return;
    }
    buffer_format(out, " and spirals %s: its distance from there goes from ",
                  part > 0 ? "outwards" : "inwards");
    figure_value(s->x, c->distance[0], NULL, out);
    buffer_put(out, TEXT(" to "));
    figure_value(s->x, c->distance[1], NULL, out);
    const double turns = floor(fabs(c->winds));
    buffer_format(out, " in %.0f turn%s", turns, turns > 1 ? "s" : "");
}

/* Without its subject; false: nothing more than its ends is known. */
static bool put_course(const struct described *s, struct buffer *out)
{
    switch (s->curve->course) {
    case COURSE_NONE:
        return false;
    case COURSE_CONSTANT:
        buffer_put(out, TEXT("stays at "));
        figure_value(s->y, s->curve->start.y, s->up, out);
        return true;
    case COURSE_SCATTERS:
        buffer_put(out, TEXT("scatters about "));
        figure_value(s->y, s->curve->level[0], s->up, out);
        buffer_put(out, TEXT(" with a standard deviation of "));
        figure_value(s->y, s->curve->spread, NULL, out);
        return true;
    case COURSE_RISES:
    case COURSE_FALLS:
        put_trend(s, out);
        return true;
    case COURSE_OSCILLATES:
        put_oscillation(s, out);
        return true;
    case COURSE_WINDS:
        put_winding(s, out);
        return true;
    case COURSE_TURNS:
        if (s->figure->figure->plane)
            return false;
        if (isfinite(s->curve->power)) {
            buffer_format(out, "goes as %s to the power of ", s->x->label);
            figure_number(s->curve->power, out);
            return true;
        }
        buffer_format(out, "turns %zu time%s without a period", s->curve->turns,
                      s->curve->turns == 1 ? "" : "s");
        return true;
    }
    return false;
}

/* ---- sentences ---- */

static void put_gaps(const struct described *s, struct buffer *out)
{
    if (s->curve->gaps > 0)
        buffer_format(out, ", with %zu sample%s that %s no place in it", s->curve->gaps,
                      s->curve->gaps == 1 ? "" : "s", s->curve->gaps == 1 ? "has" : "have");
    if (!(s->curve->hole[1] > s->curve->hole[0]))
        return;
    buffer_format(out, ", without samples from %s = ", s->x->label);
    figure_value(s->x, s->curve->hole[0], s->across, out);
    buffer_put(out, TEXT(" to "));
    figure_value(s->x, s->curve->hole[1], s->across, out);
}

/* What a figure of one curve says in two sentences. */
static void put_alone(const struct described *s, const char *name, struct buffer *out)
{
    buffer_format(out, " %s ", name);
    const bool known = put_course(s, out);
    if (!known)
        put_ends(s, out);
    put_gaps(s, out);
    buffer_put(out, TEXT("."));
    if (s->curve->n < 2) {
        buffer_put(out, TEXT(" One point tells no course."));
        return;
    }
    if (s->curve->course == COURSE_CONSTANT) {
        buffer_put(out, TEXT(" From the lowest value to the highest it is "));
        figure_value(s->y, s->curve->high.y - s->curve->low.y, NULL, out);
        buffer_put(out, TEXT("."));
        return;
    }
    buffer_put(out, TEXT(" It "));
    if (known) {
        put_ends(s, out);
        buffer_put(out, TEXT(", "));
    } else {
        buffer_put(out, TEXT("is "));
    }
    put_extremes(s, out);
    buffer_put(out, TEXT("."));
}

static void put_curve(const struct described *s, bool briefly, struct buffer *out)
{
    struct buffer course = {0};
    buffer_format(out, "%s ", s->curve->label);
    if (s->curve->n == 0) {
        buffer_put(out, TEXT("has no point that can be shown"));
        return;
    }
    const bool known = put_course(s, &course), constant = s->curve->course == COURSE_CONSTANT;
    buffer_put(out, buffer_text(&course));
    if (!known || !(briefly || constant)) {
        buffer_put(out, known ? TEXT("; it ") : TEXT(""));
        put_ends(s, out);
        if (!s->figure->figure->plane) {
            buffer_put(out, TEXT(", "));
            put_extremes(s, out);
        }
    }
    if (!briefly)
        put_gaps(s, out);
    buffer_free(&course);
}

static void put_curves(const struct figure_reading *reading, struct buffer *out)
{
    const int curves = reading->figure->curves;
    for (int i = 0; i < curves; i++) {
        const struct described s = subject_of(reading, i);
        buffer_put(out, i == 0 || curves <= CURVES_DESCRIBED ? TEXT(" ") : TEXT("; "));
        put_curve(&s, curves > CURVES_DESCRIBED, out);
        if (curves <= CURVES_DESCRIBED || i + 1 == curves)
            buffer_put(out, TEXT("."));
    }
}

static const char *title_of(const struct figure *figure)
{
    return figure->title && *figure->title ? figure->title : "A figure";
}

static void put_intro(const struct figure_reading *reading, struct buffer *out)
{
    const struct figure *figure = reading->figure;
    buffer_format(out, "%s: ", title_of(figure));
    put_range(&figure->x, reading->x, out);
    buffer_put(out, TEXT(", "));
    put_range(&figure->y, reading->y[0], out);
    if (figure->second) {
        buffer_put(out, TEXT("; in a second panel "));
        if (figure->plane) {
            put_range(&figure->second[0], reading->second_x, out);
            buffer_put(out, TEXT(", "));
        }
        put_range(&figure->second[1], reading->y[1], out);
    }
    if (figure->x.log || figure->y.log)
        buffer_format(out, " (%s logarithmic)",
                      figure->x.log && figure->y.log ? "both axes"
                      : figure->x.log                ? "horizontally"
                                                     : "vertically");
    if (figure->curves == 1)
        buffer_format(out, ", %s %s, %zu point%s",
                      figure->curve[0].points ? "points of" : "a line:", reading->curve[0].label,
                      reading->curve[0].n, reading->curve[0].n == 1 ? "" : "s");
    for (int i = 0; figure->curves > 1 && i < figure->curves; i++)
        buffer_format(out, "%s%s%s",
                      i == 0                    ? ", curves: "
                      : i + 1 == figure->curves ? " and "
                                                : ", ",
                      reading->curve[i].label, figure->curve[i].points ? " (points)" : "");
    buffer_put(out, TEXT("."));
}

static void put_distances(const struct figure_reading *reading, struct buffer *out)
{
    if (reading->distances == 0)
        return;
    buffer_format(out, " Farthest from %s: ", reading->curve[reading->reference].label);
    for (int i = 0; i < reading->distances; i++) {
        const struct curve_distance *distance = &reading->distance[i];
        const struct described s = subject_of(reading, distance->curve);
        buffer_format(out, "%s%s by ", i ? "; " : "", s.curve->label);
        figure_value(s.y, distance->largest, NULL, out);
        buffer_format(out, " at %s = ", s.x->label);
        figure_value(s.x, distance->at, s.across, out);
        buffer_put(out, TEXT(" (rms "));
        figure_value(s.y, distance->rms, NULL, out);
        buffer_put(out, TEXT(")"));
    }
    buffer_put(out, TEXT("."));
}

static void put_order(const struct figure_reading *reading, struct buffer *out)
{
    if (reading->ordered < 2 || reading->figure->plane || reading->figure->second)
        return;
    buffer_put(out, TEXT(" At the right end, from top to bottom: "));
    for (int i = 0; i < reading->ordered; i++)
        buffer_format(out, "%s%s", i ? ", " : "", reading->curve[reading->order[i]].label);
    buffer_put(out, TEXT("."));
}

static void put_bands(const struct figure_reading *reading, struct buffer *out)
{
    for (int i = 0; i < reading->figure->curves; i++) {
        const struct described s = subject_of(reading, i);
        if (!isfinite(s.curve->widest.y))
            continue;
        /* with three curves there are six sentences already: it ends the last of them */
        const bool full = reading->figure->curves == CURVES_DESCRIBED && out->len > 0;
        out->len -= full;
        buffer_format(out, "%s band about %s is widest, +- ", full ? "; the" : " The",
                      s.curve->label);
        put_place(&s, (struct curve_point){s.curve->widest.x, s.curve->widest.y}, out);
        buffer_put(out, TEXT("."));
        return;
    }
}

bool describe_reading(const struct figure_reading *reading, struct buffer *out)
{
    const struct figure *figure = reading->figure;
    size_t points = 0;
    for (int i = 0; i < figure->curves; i++)
        points += reading->curve[i].n;
    if (points == 0) {
        buffer_format(out, "%s: nothing that can be shown.", title_of(figure));
        return !out->failed;
    }
    if (figure->words) {
        buffer_put(out, text_of(figure->words));
        return !out->failed;
    }
    put_intro(reading, out);
    if (figure->curves == 1) {
        const struct described s = subject_of(reading, 0);
        put_alone(&s, s.curve->label, out);
    } else {
        put_curves(reading, out);
    }
    put_distances(reading, out);
    put_order(reading, out);
    put_bands(reading, out);
    return !out->failed;
}

bool describe_figure(const struct figure *figure, struct buffer *out)
{
    struct arena arena = {0};
    struct figure_reading reading;
    const bool ok = figure_read(figure, &arena, &reading) && describe_reading(&reading, out);
    arena_reset(&arena);
    return ok;
}
