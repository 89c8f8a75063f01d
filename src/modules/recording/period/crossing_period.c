/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period from crossings of a level: the straight line through their times against their
 * number. */
#include "modules/recording/period/cycle.h"

#include <math.h>
#include <stdio.h>

/* Largest number of crossings of a wave, of crossings in a pattern; and smallest number of
 * crossings after a wave became regular. */
enum { WAVE_CROSSINGS = 512, PATTERN_MAX = 8, SETTLED_MIN = 4 };

/* Samples a period from which on a quintic interpolates crossings to rounding. */
static const double smooth_samples = 20;

/* Adds half the difference between the periods of rising and of falling edges to the uncertainty:
 * if the amplitude changes, a level is passed progressively later on one edge, and earlier on the
 * other. all[count] are crossings of both directions. */
static void widen_by_falling_edges(const struct crossing *all, size_t count, struct period *period)
{
    double first = NAN, last = NAN; /* [s] how long the level is passed for */
    for (size_t i = 1; i < count; i++) {
        if (all[i].rising || !all[i - 1].rising)
            continue;
        last = all[i].t - all[i - 1].t;
        first = isnan(first) ? last : first;
    }
    if (isfinite(first) && period->periods >= 1)
        period->period.uncertainty =
            hypot(period->period.uncertainty, 0.5 * (last - first) / period->periods);
}

/* Copies the rising crossings, possibly within the same array. Returns their number. */
static size_t keep_rising(const struct crossing *all, size_t count, struct crossing *rising)
{
    size_t rising_count = 0;
    for (size_t i = 0; i < count; i++)
        if (all[i].rising)
            rising[rising_count++] = all[i];
    return rising_count;
}

/* Finds the first `capacity` up-crossings of a level. Returns their number. */
static size_t up_crossings(const struct series *series, const struct overview *o, double level,
                           struct crossing *crossing, size_t capacity)
{
    const size_t count = series_crossings(series, o, level, crossing, capacity);
    return keep_rising(crossing, count < capacity ? count : capacity, crossing);
}

/* Returns the uncertainty [s] of a crossing at t that lies in an edge, that is somewhere between
 * two samples, because a large part of the swing or a step of the sensor (quantum) lies between
 * them. Returns 0 if the series passes the level smoothly. */
static double edge_uncertainty(const struct series *s, const struct overview *o, double quantum,
                               double t)
{
    static const double edge_share = 0.3;
    const struct samples all = {.t = s->t, .n = s->n};
    const size_t next = samples_index(&all, t);
    if (next == 0 || next >= s->n)
        return 0;
    const double jump = fabs(s->y[next] - s->y[next - 1]),
                 width = (s->t[next] - s->t[next - 1]) / sqrt(12);
    if (jump > edge_share * (o->high - o->low))
        return width;
    return quantum > 0 ? width * fmin(quantum / jump, 1) : 0; /* jump may be 0 */
}

/* Adds the effect of equal errors of all edges on the period, as they do not show in the
 * scatter. */
static void widen_by_edges(const struct series *s, const struct overview *o, struct period *period)
{
    const double quantum = samples_quantum(&(struct samples){.y = s->y, .n = s->n}),
                 edge = edge_uncertainty(s, o, quantum, period->first);
    period->period.uncertainty =
        hypot(period->period.uncertainty, M_SQRT2 * edge / fmax(period->periods, 1));
}

/* Returns the error of the period [s] by interpolation, which two or three crossings do not show in
 * their scatter, or NAN if there are too few. It is estimated from every second sample, with which
 * interpolation of the fifth degree is off by 2^6 times as much. */
static double interpolation_error(const struct series *series, const struct overview *o,
                                  struct arena *arena, double period)
{
    struct crossing crossing[8];
    const size_t n = (series->n + 1) / 2;
    double *t = arena_array(arena, n, sizeof *t), *y = arena_array(arena, n, sizeof *y);
    for (size_t i = 0; t && y && i < n; i++) {
        t[i] = series->t[2 * i];
        y[i] = series->y[2 * i];
    }
    const struct series half = {.t = t, .y = y, .n = t && y ? n : 0};
    struct period coarse;
    size_t used;
    const size_t rising_count = up_crossings(&half, o, o->mean, crossing, COUNT_OF(crossing));
    return rising_count >= 2 &&
                   crossings_period(crossing, rising_count, period, true, arena, &coarse, &used)
               ? fabs(coarse.period.value - period) / 63
               : NAN;
}

/* Reads the period from a line through the up-crossings of the mean, and adds the errors of edges
 * and of interpolation. Returns false with the error if noise leaves fewer than two. */
bool crossing_period(const struct series *series, const struct overview *o, struct arena *arena,
                     struct period *period, struct error *error)
{
    size_t capacity = 4 * (size_t)o->periods + 16, used;
    struct crossing *crossing = arena_array(arena, capacity, sizeof *crossing),
                    *edge = arena_array(arena, capacity, sizeof *edge);
    if (!crossing || !edge)
        return error_memory(error);
    const size_t all = series_crossings(series, o, o->mean, edge, capacity),
                 edges = all < capacity ? all : capacity,
                 rising_count = keep_rising(edge, edges, crossing);
    *period = (struct period){.level = o->mean, .how = "up-crossings"};
    if (rising_count >= 2 && crossings_period(crossing, rising_count, o->period,
                                              overview_is_exact(o), arena, period, &used)) {
        widen_by_edges(series, o, period);
        if (overview_is_exact(o))
            widen_by_falling_edges(edge, edges, period);
        if (rising_count < 4 && overview_is_exact(o))
            period->period.uncertainty =
                hypot(period->period.uncertainty,
                      interpolation_error(series, o, arena, period->period.value));
        return true;
    }
    error_set(error, ERROR_COMMAND,
              "no period: the noise leaves fewer than two clear up-crossings of %g", o->mean);
    return error_hint(error, "'measure spectrum' lists the lines of such a signal");
}

/* Returns true if the times between crossings repeat after `pattern` of them, to the share
 * `regular` of the time between two. For longer patterns the tolerance shrinks, as one crossing
 * could be off. */
static bool repeats_after(const struct crossing *rising, size_t count, size_t pattern,
                          double regular)
{
    if (count < 2 * pattern + 1)
        return false;
    for (size_t i = 1; i + pattern < count; i++) {
        const double cycle = rising[i + pattern].t - rising[i].t,
                     change = cycle - (rising[i - 1 + pattern].t - rising[i - 1].t);
        if (!(fabs(change) <= regular * cycle / (double)pattern))
            return false;
    }
    return true;
}

/* Regularity that the times between crossings must have. */
struct regularity {
    double difference; /* largest relative difference */
    size_t longest;    /* longest pattern [crossings]: with noise, many repeat by chance */
    size_t crossings_min;
    bool may_settle; /* the wave may become regular only later */
};

/* Requirements by kind of wave. */
static const struct regularity regularities[] = {
    [WAVE_EXACT] = {.difference = 0.01, .longest = PATTERN_MAX, .may_settle = true},
    [WAVE_NOISY] = {.difference = 1e-4, .longest = 1, .crossings_min = 7},
    [WAVE_FEW] = {.difference = 1e-4, .longest = 1}};

/* Returns the number of crossings after which their times repeat, or 0 if they do not. */
static size_t crossing_pattern(const struct crossing *rising, size_t count,
                               const struct regularity *r)
{
    for (size_t pattern = 1; pattern <= r->longest && count >= r->crossings_min; pattern++)
        if (repeats_after(rising, count, pattern, r->difference))
            return pattern;
    return 0;
}

/* Measures the period from rising crossings of `level` (the middle between the extremes if NAN) at
 * times that repeat within the tolerance of *r, possibly in a pattern of several crossings. If
 * r->may_settle, the first crossings may be left out, with a warning. `capacity` is the largest
 * number of crossings. Returns false if they do not repeat or if out of memory. */
static bool regular_period(const struct series *series, double level, const struct regularity *r,
                           size_t capacity, struct arena *arena, struct period *period)
{
    struct crossing *crossing = arena_array(arena, capacity, sizeof *crossing),
                    *edge = arena_array(arena, capacity, sizeof *edge);
    double *scratch = arena_array(arena, capacity, sizeof *scratch);
    struct overview o = {.low = HUGE_VAL, .high = -HUGE_VAL};
    size_t first = 0, used;
    if (!crossing || !edge || !scratch)
        return false;
    for (size_t i = 0; i < series->n; i++) {
        o.low = series->y[i] < o.low ? series->y[i] : o.low;
        o.high = series->y[i] > o.high ? series->y[i] : o.high;
    }
    o.mean = isnan(level) ? o.low + (o.high - o.low) / 2 : level;
    const size_t all = series_crossings(series, &o, o.mean, edge, capacity),
                 edges = all < capacity ? all : capacity,
                 rising_count = keep_rising(edge, edges, crossing);
    size_t pattern = crossing_pattern(crossing, rising_count, r);
    while (r->may_settle && pattern == 0 && rising_count > first + SETTLED_MIN + 1) {
        first++;
        pattern = crossing_pattern(crossing + first, rising_count - first, r);
        pattern = rising_count - first > 2 * pattern + SETTLED_MIN ? pattern : 0;
    }
    if (pattern == 0)
        return false;
    size_t cycles = 0;
    for (size_t i = first; i < rising_count; i += pattern)
        crossing[cycles++] = crossing[i];
    for (size_t i = 1; i < cycles; i++)
        scratch[i - 1] = crossing[i].t - crossing[i - 1].t;
    const double cycle = values_quantile(scratch, cycles - 1, 0.5);
    *period = (struct period){.level = o.mean, .how = "up-crossings"};
    if (!crossings_period(crossing, cycles, cycle, true, arena, period, &used))
        return false;
    widen_by_edges(series, &o, period);
    widen_by_falling_edges(edge, edges, period);
    if (first > 0)
        snprintf(period->warning, sizeof period->warning,
                 "the period changes at first; it is measured from t = %.6g s on, where it repeats "
                 "to 1 %%",
                 crossing[0].t);
    return true;
}

bool wave_period(const struct series *series, enum wave_kind kind, struct arena *arena,
                 struct period *period)
{
    return regular_period(series, NAN, &regularities[kind], WAVE_CROSSINGS, arena, period);
}

/* Demands exact regularity over the whole series and enough samples in each period. */
bool series_clean_period(const struct series *series, double centre, struct arena *arena,
                         struct period *period)
{
    struct regularity whole = regularities[WAVE_EXACT];
    whole.may_settle = false;
    return regular_period(series, centre, &whole, series->n / 2 + 1, arena, period) &&
           period->period.value * (double)(series->n - 1) >=
               smooth_samples * (series->t[series->n - 1] - series->t[0]);
}
