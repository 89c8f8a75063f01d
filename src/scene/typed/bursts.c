/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Bursts of typed equations: changes so short that samples miss them. Along a path between two
 * states, the bounds of the equations on an interval (interval arithmetic, Moore 1966) are compared
 * with samples in it. If they allow more change, the interval is halved, until samples show the
 * change, or until nothing that matters can hide in it. */
#include <hooke/scene/bursts.h>

#include "scene/typed/typed.h"

#include <float.h>
#include <math.h>

#include "scene/formula/jet.h"

#define INTERVAL_SAMPLES 7
/* Bounds up to this many times the sampled change count as seen, because bounds are too wide. */
#define BOUND_SLACK_FACTOR 8.0
/* Change of a variable, as a part of its size, that is negligible in an interval. */
#define HIDDEN_MOTION_MAX 1e-13
#define DEPTH_MIN 6 /* number of halvings; longer intervals are no bursts */
#define DEPTH_MOST 50
#define BOUND_ROUNDING_RELATIVE 1e-12
/* fraction of a path: closer to a switch at its end, the path does not show what follows */
#define AT_ENDS 1e-6
/* Shortest interval that is bounded, in units of the last place of t. */
#define INTERVAL_MIN_ULPS 16
#define ROW_BOUNDS_MAX 3000 /* Number of bounds that are computed between two rows. */
/* A derivative at an end above this many times the change shows that the segment is not smooth. */
#define SMOOTH_SLOPE_MAX 4

/* The path of the motion in a step, between its two states: a polynomial in s from 0 to 1. Also has
 * bounds of all names on an interval of s, for the expression that is being examined. */
struct motion_path {
    const struct system *system;
    const struct typed *typed;
    const double *c; /* coefficients of the bound term */
    double t[2];     /* [s] times at its ends */
    const double *y_begin, *y_end;
    /* the state is y_begin + s (rate + s (bend[0] + s bend[1])) */
    double bend[2][LIMIT_VARIABLES];
    double rate[LIMIT_VARIABLES];
    /* bounds of names on an interval of s, and at its centre */
    struct jet name[TYPED_NAMES_MAX], centre[TYPED_NAMES_MAX];
};

/* Sets the coefficients of the path of each variable: Hermite's cubic through both states with the
 * derivatives there, or a straight line if one of these is so large that the cubic would swing far
 * out between the states (SMOOTH_SLOPE_MAX). */
static void path_bend(const struct system *system, struct motion_path *path)
{
    const double h = path->t[1] - path->t[0];
    double first[LIMIT_VARIABLES], last[LIMIT_VARIABLES];
    system_derivative(system, path->t[0], path->y_begin, first);
    system_derivative(system, path->t[1], path->y_end, last);
    for (int i = 0; i < system->n; i++) {
        const double difference = path->y_end[i] - path->y_begin[i], a = h * first[i],
                     b = h * last[i];
        const bool curved =
            fmax(fabs(a), fabs(b)) <= SMOOTH_SLOPE_MAX * fabs(difference) + system->scale[i];
        path->rate[i] = curved ? a : difference;
        path->bend[0][i] = curved ? 3 * difference - 2 * a - b : 0;
        path->bend[1][i] = curved ? a + b - 2 * difference : 0;
    }
}

/* Returns bounds of variable i for s from a to b. */
static struct jet path_jet(const struct motion_path *path, int i, double a, double b)
{
    const double c = path->rate[i], d = path->bend[0][i], e = path->bend[1][i],
                 length2 = (b - a) * (b - a) / 8;
    const double bend[] = {2 * d + 6 * e * a, 2 * d + 6 * e * b};
    const double slope[] = {c + a * (2 * d + 3 * e * a), c + b * (2 * d + 3 * e * b)};
    const double value[] = {path->y_begin[i] + a * (c + a * (d + a * e)),
                            path->y_begin[i] + b * (c + b * (d + b * e))};
    const double margin = fmax(fabs(bend[0]), fabs(bend[1])) * length2,
                 turn = fabs(6 * e) * length2;
    return (struct jet){
        interval_wide(fmin(value[0], value[1]) - margin, fmax(value[0], value[1]) + margin, 2),
        interval_wide(fmin(slope[0], slope[1]) - turn, fmax(slope[0], slope[1]) + turn, 2),
        interval_wide(fmin(bend[0], bend[1]), fmax(bend[0], bend[1]), 2)};
}

/* Returns bounds of a linear function from `first` to `last`, for s from a to b. */
static struct jet parameter_jet(double first, double last, double a, double b)
{
    const double begin = first + (last - first) * a, end = first + (last - first) * b;
    return (struct jet){interval_wide(fmin(begin, end), fmax(begin, end), 2),
                        interval_point(last - first), interval_point(0)};
}

/* Sets the bounds of all names but observed quantities, for s from a to b in [0, 1]; a == b is a
 * point. */
static void name_all(const struct motion_path *path, double a, double b, struct jet *name)
{
    const struct typed *typed = path->typed;
    const int n = typed->model.n;
    name[0] = parameter_jet(path->t[0], path->t[1], a, b);
    for (int i = 0; i < n; i++)
        name[1 + i] = path_jet(path, i, a, b);
    for (int i = 0; i <= typed->reads; i++)
        name[1 + n + i] = jet_number(path->c[1 + i]);
}

/* Computes bounds of an expression of the names on [a, b]. */
static struct jet bounds_of(const struct motion_path *path, const struct expr *expr, double a,
                            double b)
{
    return a == b ? expr_jet(expr, path->name)
                  : expr_jet_about(expr, path->name, path->centre,
                                   (b - a) / 2 * (1 + BOUND_ROUNDING_RELATIVE));
}

/* Returns bounds of the right-hand side of equation `row`, and of its derivatives by s, for s from
 * a to b. */
static struct jet row_bounds(struct motion_path *path, int row, double a, double b)
{
    const struct typed *typed = path->typed;
    const int first = typed_first_observed(typed);
    const double middle = a + (b - a) / 2;
    struct jet sum = jet_number(0);
    name_all(path, a, b, path->name);
    if (a != b)
        name_all(path, middle, middle, path->centre);
    for (int i = 0; i < typed->observes; i++) {
        path->name[first + i] = bounds_of(path, typed->observe[i], a, b);
        if (a != b)
            path->centre[first + i] = expr_jet(typed->observe[i], path->centre);
    }
    for (enum typed_group g = 0; g < GROUPS; g++)
        if (typed->group[g] && typed->group[g][row])
            sum = jet_add(sum, bounds_of(path, typed->group[g][row], a, b));
    return sum;
}

/* Returns the right-hand side of equation `row` (an acceleration or, in scenes of first order, a
 * rate) at that fraction, 0 to 1, of the path; NAN where it is not finite. */
static double row_value(const struct motion_path *path, int row, double fraction)
{
    const struct system *system = path->system;
    double y[LIMIT_VARIABLES], slope[LIMIT_VARIABLES];
    for (int i = 0; i < system->n; i++)
        y[i] = path->y_begin[i] +
               fraction *
                   (path->rate[i] + fraction * (path->bend[0][i] + fraction * path->bend[1][i]));
    system_derivative(system, path->t[0] + (path->t[1] - path->t[0]) * fraction, y, slope);
    const double value = slope[system->n - typed_rows(path->typed) + row];
    return isfinite(value) ? value : NAN;
}

/* Returns the largest magnitude of a number in the interval. */
static double interval_magnitude_max(struct interval a)
{
    return fmax(fabs(a.lo), fabs(a.hi));
}

/* Change of a derivative in an interval, in its unit: that which bounds of it allow (hidden), and
 * that which samples of it show (seen). */
struct interval_change {
    double hidden, seen;
};

/* Compares the bounds of equation `row` on the part [a, b] of the path with INTERVAL_SAMPLES - 1
 * samples of it: as deviations from the straight line between its ends or as a range, whichever
 * bound is tighter. Both members are 0 where it is not a finite number or changes by rounding
 * only. */
static struct interval_change interval_compare(struct motion_path *path, int row, double a,
                                               double b)
{
    const struct jet bounds = row_bounds(path, row, a, b);
    const double width = bounds.value.hi - bounds.value.lo, length = b - a;
    /* deviation from the straight line between the ends */
    const double bent = interval_magnitude_max(bounds.bend) * length * length / 8;
    const double first = row_value(path, row, a), last = row_value(path, row, b);
    double low = fmin(first, last), high = fmax(first, last), deviation = 0;
    for (int i = 1; i < INTERVAL_SAMPLES; i++) {
        const double fraction = (double)i / INTERVAL_SAMPLES,
                     value = row_value(path, row, a + length * fraction);
        low = fmin(low, value);
        high = fmax(high, value);
        deviation = fmax(deviation, fabs(value - first - (last - first) * fraction));
    }
    const double hidden = fmin(bent, width);
    if (isnan(width) ||
        hidden < BOUND_ROUNDING_RELATIVE *
                     interval_magnitude_max(bounds.value)) /* no number there, or rounding */
        return (struct interval_change){0, 0};
    return bent < width ? (struct interval_change){bent, deviation}
                        : (struct interval_change){width, high - low};
}

/* Returns true if the samples of equation `row` in [a, b] differ from Lagrange's polynomial through
 * points outside by more than 1/BOUND_SLACK_FACTOR of `seen`, the change that they show. A smooth
 * force whose second derivative changes sign in [a, b] also stays far below its bounds, but agrees
 * with the polynomial, and is thus told from a burst. */
static bool stands_out(const struct motion_path *path, int row, double a, double b, double seen)
{
    enum { POINTS = 6 };
    static const double around_it[3][POINTS] = {
        {-1, -0.5, 0, 1, 1.5, 2}, {0, 1, 1.5, 2, 2.5, 3}, {-2, -1.5, -1, -0.5, 0, 1}};
    /* The points are on one side where the other one would be beyond an end of the path. */
    const double *node = around_it[0];
    if (a < b - a)
        node = around_it[1];
    else if (b + (b - a) > 1)
        node = around_it[2];
    double value[POINTS], deviation = 0;
    for (int k = 0; k < POINTS; k++)
        value[k] = row_value(path, row, a + node[k] * (b - a));
    for (int i = 1; i < INTERVAL_SAMPLES; i++) {
        const double fraction = (double)i / INTERVAL_SAMPLES;
        double interpolated = 0;
        for (int k = 0; k < POINTS; k++) {
            double weight = 1;
            for (int j = 0; j < POINTS; j++)
                weight *= j == k ? 1 : (fraction - node[j]) / (node[k] - node[j]);
            interpolated += weight * value[k];
        }
        const double difference = fabs(row_value(path, row, a + fraction * (b - a)) - interpolated);
        deviation = isnan(difference) ? INFINITY : fmax(deviation, difference);
    }
    return deviation * BOUND_SLACK_FACTOR > seen;
}

/* Appends the part [a, b] of the path, as times [s], to burst [max], or joins it with one that it
 * touches; drops it if the array is full. Returns the new number of bursts. */
static int burst_append(const struct motion_path *path, double a, double b, struct burst *burst,
                        int count, int max)
{
    const double t_begin = path->t[0] + (path->t[1] - path->t[0]) * a,
                 t_end = path->t[0] + (path->t[1] - path->t[0]) * b;
    for (int i = 0; i < count; i++)
        if (fmin(t_begin, t_end) <= fmax(burst[i].t_begin, burst[i].t_end) &&
            fmax(t_begin, t_end) >= fmin(burst[i].t_begin, burst[i].t_end)) {
            const bool forward = path->t[1] > path->t[0];
            burst[i].t_begin =
                forward ? fmin(burst[i].t_begin, t_begin) : fmax(burst[i].t_begin, t_begin);
            burst[i].t_end = forward ? fmax(burst[i].t_end, t_end) : fmin(burst[i].t_end, t_end);
            return count;
        }
    if (count < max)
        burst[count++] = (struct burst){t_begin, t_end};
    return count;
}

/* Searches the path for bursts of equation `row`, by halving intervals in which more than
 * HIDDEN_MOTION_MAX of `size`, the size of the variable [SI], can hide. With `sure`, only intervals
 * that stand out of the motion around them count, and the ends of the path are left out. *allowed
 * is reduced by each interval examined, and 0 ends the search. Returns the new number of bursts in
 * burst [max], of which there were `count` before. */
static int row_search(struct motion_path *path, int row, double size, bool sure, int64_t *allowed,
                      struct burst *burst, int count, int max)
{
    const double length = fabs(path->t[1] - path->t[0]);
    const double ulps =
        INTERVAL_MIN_ULPS * DBL_EPSILON * fmax(fabs(path->t[0]), fabs(path->t[1])) / length;
    const double ends = sure ? fmin(fmax(AT_ENDS, ulps), 0.25) : 0;
    struct {
        double a, b;
        int depth;
    } stack[DEPTH_MOST + 2];
    int top = 0;
    stack[top].a = ends;
    stack[top].b = 1 - ends;
    stack[top++].depth = 0;
    for (int looks = 0; top > 0 && looks<ROW_BOUNDS_MAX && * allowed> 0; looks++, --*allowed) {
        const double a = stack[--top].a, b = stack[top].b, middle = a + (b - a) / 2;
        const int depth = stack[top].depth;
        const struct interval_change stretch = interval_compare(path, row, a, b);
        if (!(stretch.hidden * (b - a) * fabs(path->t[1] - path->t[0]) > HIDDEN_MOTION_MAX * size))
            continue;
        const bool seen = stretch.hidden <= BOUND_SLACK_FACTOR * stretch.seen;
        if (seen && depth >= DEPTH_MIN && (!sure || stands_out(path, row, a, b, stretch.seen)))
            count = burst_append(path, a == ends ? 0 : a, b == 1 - ends ? 1 : b, burst, count, max);
        /* one sample of a long stretch may have met a burst by chance */
        if (seen && (depth >= DEPTH_MIN || !stands_out(path, row, a, b, stretch.seen)))
            continue;
        /* a jump, or no number */
        if (depth == DEPTH_MOST)
            continue;
        stack[top].a = middle;
        stack[top].b = b;
        stack[top++].depth = depth + 1;
        stack[top].a = a;
        stack[top].b = middle;
        stack[top++].depth = depth + 1;
    }
    return count;
}

/* Searches the path for bursts of each derivative in turn. */
int bursts_within(const struct system *system, const double t[2], const double *y_begin,
                  const double *y_end, bool sure, int64_t *allowed, struct burst *burst, int count,
                  int max)
{
    const struct typed *typed = system->model->typed;
    if (!typed)
        return count;
    struct motion_path path = {.system = system,
                               .typed = typed,
                               .c = system->typed.c,
                               .t = {t[0], t[1]},
                               .y_begin = y_begin,
                               .y_end = y_end};
    const int rows = typed_rows(typed);
    path_bend(system, &path);
    for (int i = 0; i < rows; i++)
        count = row_search(&path, i, system->scale[system->n - rows + i], sure, allowed, burst,
                           count, max);
    return count;
}

int system_bursts(const struct system *system, const double t[2], const double *y_begin,
                  const double *y_end, bool sure, struct burst *burst, int count, int max)
{
    int64_t allowed = INT64_MAX;
    return bursts_within(system, t, y_begin, y_end, sure, &allowed, burst, count, max);
}
