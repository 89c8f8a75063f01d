/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Describes a figure in numbers, curve by curve: ends, extremes, trends, distances, order. */
#include "modules/words/internal.h"

#include <hooke/figure/layout.h>
#include <hooke/base/unit.h>
#include <hooke/data/series.h>

#include <stdlib.h>

/* a smaller range, relative to the values, is rounding of many steps */
#define STEADY_ROUNDING 1e-9
/* a curve whose standard deviation is below this many times its noise has nothing else in it */
#define ALL_NOISE 1.3
/* larger values, whose squares may overflow, are described by ends and extremes only */
#define HUGE_SIZE 1e150
/* Largest deviation of a logarithm from its line, as a fraction of its change. */
#define LINE_DEVIATION_MAX 0.05

const struct axis *curve_axis(const struct figure *figure, const struct curve *curve, bool vertical)
{
    if (curve->panel > 0 && figure->second)
        return &figure->second[vertical];
    return vertical ? &figure->y : &figure->x;
}

/* Returns true if the horizontal axis of the curve is time. */
static bool is_timed(const struct figure *figure, const struct curve *curve)
{
    const struct axis *x = curve_axis(figure, curve, false);
    const struct unit *unit = x->unit ? unit_find(text_of(x->unit)) : NULL;
    return !figure->plane && !x->log && unit && unit->quantity == QUANTITY_TIME;
}

/* ---- points ---- */

/* Returns true if the axis can show a value; with `window` it must lie between the axis's fixed
 * ends, too. */
static bool axis_shows(const struct axis *axis, double value, bool window)
{
    return isfinite(value) && (!axis->log || value > 0) &&
           (!window || !axis->fixed || (value >= axis->first_value && value <= axis->last_value));
}

/* Returns true if point i of the curve can be shown. */
static bool curve_is_shown(const struct figure *figure, const struct axis *x, const struct axis *y,
                           const struct curve *curve, size_t i)
{
    return isfinite(curve->x[i]) && axis_shows(x, curve->x[i], !figure->plane) &&
           axis_shows(y, curve->y[i], false);
}

/* Orders points for qsort() by x. */
static int compare_x(const void *a, const void *b)
{
    const struct curve_point *p = a, *q = b;
    return (p->x > q->x) - (p->x < q->x);
}

/* Copies the points of the curve that the axes show to *points, in the arena; by ascending x if
 * `sorted`. points->n is at first the largest number of points, then their number. Returns false if
 * out of memory. */
static bool copy_points(const struct figure *figure, const struct curve *curve, bool sorted,
                        struct arena *arena, struct points *points)
{
    const struct axis *x = curve_axis(figure, curve, false), *y = curve_axis(figure, curve, true);
    struct curve_point *point = arena_array(arena, points->n + 1, sizeof *point);
    double *both = arena_array(arena, 2 * points->n + 1, sizeof *both);
    size_t n = 0;
    if (!point || !both)
        return false;
    for (size_t i = 0; n < points->n && curve_goes_on(curve, i); i++)
        if (curve_is_shown(figure, x, y, curve, i))
            point[n++] = (struct curve_point){curve->x[i], curve->y[i]};
    if (sorted)
        qsort(point, n, sizeof *point, compare_x);
    for (size_t i = 0; i < n; i++) {
        both[i] = point[i].x;
        both[points->n + i] = point[i].y;
    }
    points->x = both;
    points->y = both + points->n;
    points->n = n;
    return true;
}

/* Collects in *points the points of a curve that the axes show; they are copied only if some are
 * left out or, outside of planes, if x does not ascend. Sets number, ends and gaps in *reading.
 * Points outside of the window of time are not gaps. Returns false if out of memory. */
static bool points_gather(const struct figure *figure, const struct curve *curve,
                          struct arena *arena, struct points *points, struct curve_reading *reading)
{
    const struct axis *x = curve_axis(figure, curve, false), *y = curve_axis(figure, curve, true);
    bool ascending = true;
    size_t n = 0, i = 0;
    for (; curve_goes_on(curve, i); i++) {
        if (curve_is_shown(figure, x, y, curve, i)) {
            const struct curve_point point = {curve->x[i], curve->y[i]};
            ascending &= n == 0 || point.x > reading->end.x;
            reading->start = n++ == 0 ? point : reading->start;
            reading->end = point;
        } else {
            reading->gaps += isnan(curve->x[i]) || axis_shows(x, curve->x[i], !figure->plane);
        }
    }
    reading->n = n;
    *points = (struct points){.x = curve->x, .y = curve->y, .n = n, .cancel = curve->cancel};
    const bool sorted = !ascending && !figure->plane;
    return (n == i && !sorted) || copy_points(figure, curve, sorted, arena, points);
}

/* Computes the noise of measured values; lines have none. */
static void find_noise(const struct curve *curve, struct arena *arena, struct points *points)
{
    if (!curve->points)
        return;
    enum { ROWS = 16384 }; /* so many points suffice to estimate the noise */
    const size_t n = points->n < ROWS ? points->n : ROWS, first = (points->n - n) / 2;
    const struct series series = {points->x + first, points->y + first, n,
                                  QUANTITY_OTHER,    curve->cancel,     0};
    const double noise = series_noise(&series, arena);
    points->noise = noise > 0 ? noise : 0;
    points->measured = true;
}

/* ---- trends ---- */

/* Returns the slope of ln|y| over x (over ln x if over_logarithm) by least squares in a first pass.
 * Returns NAN if the second pass finds a deviation from the line above LINE_DEVIATION_MAX of its
 * height. */
static double slope_of_logarithm(const struct points *p, bool over_logarithm)
{
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, far = 0, low = HUGE_VAL, high = -HUGE_VAL;
    for (int pass = 0; pass < 2; pass++) {
        const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx),
                     intercept = (sy - slope * sx) / n;
        for (size_t i = 0; points_go_on(p, i); i++) {
            const double x = over_logarithm ? log(p->x[i]) : p->x[i] - p->x[0],
                         y = log(fabs(p->y[i]));
            if (pass) {
                far = fmax(far, fabs(y - intercept - slope * x));
                continue;
            }
            n++;
            sx += x;
            sy += y;
            sxx += x * x;
            sxy += x * y;
            low = fmin(low, y);
            high = fmax(high, y);
        }
        if (pass)
            return far <= LINE_DEVIATION_MAX * (high - low) ? slope : NAN;
    }
    return NAN;
}

/* Returns the largest movement of a curve against its direction: below the highest value before if
 * it rises, above the lowest value before if it falls. */
static double largest_return(const struct points *p, bool rises)
{
    double furthest = p->y[0], back = 0;
    for (size_t i = 1; points_go_on(p, i); i++) {
        const double y = p->y[i];
        furthest = rises ? fmax(furthest, y) : fmin(furthest, y);
        back = fmax(back, fabs(furthest - y));
    }
    return back;
}

/* Returns true if the curve is noise around a constant level: the means of its first and last third
 * differ by at most 5 standard errors or one standard deviation of the noise. Sets level and spread
 * (standard deviation) of *reading then. */
static bool is_scattered(const struct points *p, struct curve_reading *reading)
{
    const size_t third = p->n / 3;
    double sum[2] = {0}, mean = 0, square = 0;
    if (!(p->noise > 0) || third < 3)
        return false;
    for (size_t i = 0; i < third; i++) {
        sum[0] += p->y[i];
        sum[1] += p->y[p->n - 1 - i];
    }
    const double change = fabs(sum[1] - sum[0]) / (double)third;
    if (change > p->noise * fmax(1, 5 * sqrt(2 / (double)third)))
        return false;
    for (size_t i = 0; points_go_on(p, i); i++)
        mean += p->y[i] / (double)p->n;
    for (size_t i = 0; points_go_on(p, i); i++)
        square += (p->y[i] - mean) * (p->y[i] - mean) / (double)(p->n - 1);
    reading->level[0] = reading->level[1] = mean;
    reading->spread = sqrt(square);
    return true;
}

/* Finds how a curve without a period rises, falls or scatters. Sets course, and, where they apply:
 * factor (last value by first), rate (exponential) or power (both axes logarithmic). */
static void read_trend(const struct figure *figure, const struct curve *curve,
                       const struct points *p, struct curve_reading *reading)
{
    const struct axis *x = curve_axis(figure, curve, false), *y = curve_axis(figure, curve, true);
    const double first = p->y[0], last = p->y[p->n - 1], least = reading->low.y,
                 most = reading->high.y;
    const bool one_sign = least > 0 || most < 0;
    if (reading->turns == 0 && is_scattered(p, reading)) {
        reading->course = COURSE_SCATTERS;
        return;
    }
    if (reading->turns == 0) {
        const bool rises = last > first;
        const double least_back = fmax(TURN_SIGMAS * p->noise, TURN_ROUNDING * (most - least));
        reading->course = rises ? COURSE_RISES : COURSE_FALLS;
        reading->all_along = largest_return(p, rises) <= least_back;
    }
    if (one_sign && reading->turns == 0 && isfinite(last / first) && isfinite(first / last))
        reading->factor = reading->end.y / reading->start.y;
    if (p->n < 3)
        return;
    if (x->log && y->log)
        reading->power = slope_of_logarithm(p, true);
    else if (one_sign && reading->turns == 0)
        reading->rate = slope_of_logarithm(p, false);
}

/* Finds the widest point of the band around a curve. */
static void read_band(const struct curve *curve, struct curve_reading *reading)
{
    for (size_t i = 0; curve->spread && curve_goes_on(curve, i); i++)
        if (!(curve->spread[i] <= reading->widest.y))
            reading->widest = (struct curve_point){curve->x[i], curve->spread[i]};
}

/* Returns the label of a curve, its mark, or "the curve"; NULL if out of memory. */
static const char *name_of(const struct figure *figure, int i, struct arena *arena)
{
    const char mark[2] = {figure_mark(figure, i), '\0'};
    if (figure->curve[i].label && *figure->curve[i].label)
        return figure->curve[i].label;
    return *mark ? arena_text(arena, text_of(mark)) : "the curve";
}

/* Describes curve i in *reading, and collects its points in *points, in the arena. Quantities that
 * do not apply remain NAN; a curve of less than two points, or of huge values, has no course.
 * Returns false if out of memory. */
static bool read_curve(const struct figure *figure, int i, struct arena *arena,
                       struct points *points, struct curve_reading *reading)
{
    const struct curve *curve = &figure->curve[i];
    *reading = (struct curve_reading){.label = name_of(figure, i, arena),
                                      .factor = NAN,
                                      .rate = NAN,
                                      .power = NAN,
                                      .period = NAN,
                                      .spread = NAN,
                                      .level = {NAN, NAN},
                                      .amplitude = {NAN, NAN},
                                      .growth = NAN,
                                      .winds = NAN,
                                      .distance = {NAN, NAN},
                                      .hole = {NAN, NAN},
                                      .widest = {NAN, NAN}};
    if (!reading->label || !points_gather(figure, curve, arena, points, reading))
        return false;
    read_band(curve, reading);
    if (points->n == 0)
        return true;
    reading->low = reading->high = point_at(points, 0);
    for (size_t k = 1; points_go_on(points, k); k++) {
        const struct curve_point point = point_at(points, k);
        reading->low = point.y < reading->low.y ? point : reading->low;
        reading->high = point.y > reading->high.y ? point : reading->high;
    }
    if (points->n < 2)
        return true;
    const double swing = reading->high.y - reading->low.y,
                 size = fmax(fabs(reading->low.y), fabs(reading->high.y));
    if (size > HUGE_SIZE)
        return true;
    reading->course = COURSE_CONSTANT;
    if (!(swing > STEADY_ROUNDING * size))
        return true;
    reading->course = COURSE_TURNS;
    if (figure->plane) {
        read_winding(points, figure->equal, reading);
        return true;
    }
    find_noise(curve, arena, points);
    reading->noise = points->noise;
    if (is_scattered(points, reading) && reading->spread < ALL_NOISE * points->noise) {
        reading->course = COURSE_SCATTERS; /* a few outliers are not swings */
        return true;
    }
    struct points whole = *points;
    if ((curve->points && !drop_echoes(&whole, arena)) ||
        !read_turns(&whole, is_timed(figure, curve), arena, reading))
        return false;
    read_trend(figure, curve, points, reading);
    if (isfinite(reading->period))
        reading->course = COURSE_OSCILLATES;
    return true;
}

/* ---- curves beside each other ---- */

/* Returns the value of a curve at x, interpolated linearly between points found by bisection; NAN
 * outside of its points. */
static double points_value(const struct points *p, double x)
{
    size_t low = 0, high = p->n;
    if (p->n == 0 || !(x >= p->x[0] && x <= p->x[p->n - 1]))
        return NAN;
    while (high - low > 1) {
        const size_t i = low + (high - low) / 2;
        if (p->x[i] <= x)
            low = i;
        else
            high = i;
    }
    if (low + 1 == p->n || p->x[low] == x)
        return p->y[low];
    const struct curve_point a = point_at(p, low), b = point_at(p, low + 1);
    return a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x);
}

/* Computes the largest and the rms difference in y between two curves, at the points of `source` if
 * at_from is set, otherwise at those of `target`; the other curve is interpolated. Points without a
 * value there are left out. Both results are NAN if no point remains. */
static struct curve_distance distance_between(const struct points *source,
                                              const struct points *target, bool at_from)
{
    const struct points *here = at_from ? source : target;
    const struct points *there = at_from ? target : source;
    struct curve_distance distance = {.largest = NAN, .x = NAN, .rms = NAN};
    double sum = 0; /* sum of squares, in units of the largest */
    size_t n = 0;
    for (size_t i = 0; points_go_on(here, i); i++) {
        const double difference = fabs(here->y[i] - points_value(there, here->x[i]));
        if (!isfinite(difference))
            continue;
        if (!(difference <= distance.largest)) {
            sum *= difference > 0 && n > 0
                       ? distance.largest / difference * (distance.largest / difference)
                       : 1;
            distance.largest = difference;
            distance.x = here->x[i];
        }
        sum += difference > 0 ? difference / distance.largest * (difference / distance.largest) : 0;
        n++;
    }
    distance.rms = n ? distance.largest * sqrt(sum / (double)n) : NAN;
    return distance;
}

/* Chooses the reference curve (measured points if there are any, otherwise the first curve) and
 * computes the distances of all others from it. Sets reading->reference to -1 if there are none, as
 * in planes and over logarithmic axes. Returns false if out of memory. */
static bool read_distances(const struct figure *figure, const struct points *points,
                           struct arena *arena, struct figure_reading *reading)
{
    int reference = -1;
    for (int i = 0; i < figure->curves; i++) {
        const bool data = figure->curve[i].points, has = reading->curve[i].n > 1;
        if (has && (reference < 0 || (data && !figure->curve[reference].points)))
            reference = i;
    }
    reading->reference = -1;
    reading->distance = arena_array(arena, (size_t)figure->curves + 1, sizeof *reading->distance);
    if (!reading->distance)
        return false;
    for (int i = 0; i < figure->curves && reference >= 0 && !figure->plane; i++) {
        if (i == reference || reading->curve[i].n < 2 || figure->x.log)
            continue;
        struct curve_distance distance =
            distance_between(&points[reference], &points[i],
                             figure->curve[reference].points || points[i].n < points[reference].n);
        distance.curve = i;
        if (isfinite(distance.largest))
            reading->distance[reading->distances++] = distance;
    }
    if (reading->distances > 0)
        reading->reference = reference;
    return true;
}

/* Sorts the curves that have points by the value at their right ends, highest first, into
 * reading->order. Returns false if out of memory. */
static bool read_order(const struct figure *figure, struct arena *arena,
                       struct figure_reading *reading)
{
    reading->order = arena_array(arena, (size_t)figure->curves + 1, sizeof *reading->order);
    if (!reading->order)
        return false;
    for (int i = 0; i < figure->curves; i++) {
        if (reading->curve[i].n == 0)
            continue;
        int place = reading->ordered++;
        for (;
             place > 0 && reading->curve[reading->order[place - 1]].end.y < reading->curve[i].end.y;
             place--)
            reading->order[place] = reading->order[place - 1];
        reading->order[place] = i;
    }
    return true;
}

/* ---- what the axes hold ---- */

/* Extends the range so that it holds [low, high]. */
static void range_extend(double range[2], double low, double high)
{
    range[0] = low < range[0] ? low : range[0];
    range[1] = high > range[1] ? high : range[1];
}

/* Sets reading->x, second_x and y to the ranges that the axes of one or two panels show: their
 * fixed ends, else the range of the curves in the panel. Outside of planes both panels share the x
 * axis, so that the range of the first panel includes all curves. */
static void read_ranges(const struct figure *figure, const struct points *points,
                        struct figure_reading *reading)
{
    double x[2][2] = {{HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, -HUGE_VAL}};
    double y[2][2] = {{HUGE_VAL, -HUGE_VAL}, {HUGE_VAL, -HUGE_VAL}};
    for (int i = 0; i < figure->curves; i++) {
        const int panel = figure->second && figure->curve[i].panel > 0;
        for (size_t k = 0; points_go_on(&points[i], k); k++) {
            const double coordinate = points[i].x[k];
            range_extend(x[panel], coordinate, coordinate);
            if (!figure->plane && panel)
                range_extend(x[0], coordinate, coordinate);
        }
        if (points[i].n > 0)
            range_extend(y[panel], reading->curve[i].low.y, reading->curve[i].high.y);
    }
    const struct axis *axis[2][2] = {{&figure->x, &figure->y},
                                     {figure->second ? &figure->second[0] : &figure->x,
                                      figure->second ? &figure->second[1] : &figure->y}};
    for (int end = 0; end < 2; end++)
        for (int panel = 0; panel < 2; panel++) {
            const struct axis *x_axis = axis[panel][0], *y_axis = axis[panel][1];
            const double fixed_x = end ? x_axis->last_value : x_axis->first_value;
            const double fixed_y = end ? y_axis->last_value : y_axis->first_value;
            const double seen_x = x_axis->fixed ? fixed_x : x[panel][end];
            *(panel ? &reading->second_x[end] : &reading->x[end]) = seen_x;
            reading->y[panel][end] = y_axis->fixed ? fixed_y : y[panel][end];
        }
}

/* Describes a figure in numbers, which sentences are made from: curves, ranges, distances and
 * order, in the arena. Returns false if out of memory or if stopped by Ctrl-C. */
bool figure_read(const struct figure *figure, struct arena *arena, struct figure_reading *reading)
{
    const size_t n = (size_t)figure->curves;
    struct points *points = arena_array(arena, n + 1, sizeof *points);
    *reading = (struct figure_reading){.figure = figure};
    reading->curve = arena_array(arena, n + 1, sizeof *reading->curve);
    if (!points || !reading->curve)
        return false;
    for (int i = 0; i < figure->curves; i++)
        if (!read_curve(figure, i, arena, &points[i], &reading->curve[i]))
            return false;
    read_ranges(figure, points, reading);
    return read_distances(figure, points, arena, reading) && read_order(figure, arena, reading) &&
           !figure_stopped(figure);
}
