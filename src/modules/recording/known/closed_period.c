/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period of a run from returns of its state. For equations that do not depend on time, a single
 * return proves a period; a detector in a single series needs several waves, and regular ones. */
#include "modules/recording/known/known.h"
#include <hooke/base/cancel.h>

#include <math.h>
#include <string.h>

/* Starting rows that are tried; smallest number of returns; Newton steps to the nearest point;
 * substeps of an integration; largest fraction of a period that is tested. */
enum { BASES = 16, BASES_MIN = 3, NEWTON_STEPS = 4, SUBSTEPS = 8, PARTS_MAX = 7 };
/* A period with more waves than this is not a harmonic of a longer one. */
enum { HARMONICS_MAX = 64 };

/* Distance, in half ranges of the variables, up to which two states are the same. */
static const double same_state_max = 1e-3;
/* Relative difference that periods from different starting states may have. */
static const double same_period_max = 1e-3;

/* The part of a run that is searched for returns. */
struct closed_run {
    const struct trace *trace;
    const struct cancel *cancel;
    const struct system *system;
    size_t begin, end;            /* rows of the window */
    double size[LIMIT_VARIABLES]; /* half ranges of the variables in it */
};

/* Moves the state y from time t by `span` [s], in SUBSTEPS steps of the classical Runge-Kutta
 * method. */
static void follow_closed_motion(const struct system *system, double t, double span, double *y)
{
    static const double node[4] = {0, 0.5, 0.5, 1}, weight[4] = {1. / 6, 1. / 3, 1. / 3, 1. / 6};
    const double h = span / SUBSTEPS;
    for (int k = 0; k < SUBSTEPS; k++) {
        double next[LIMIT_VARIABLES], stage[LIMIT_VARIABLES], f[LIMIT_VARIABLES] = {0};
        memcpy(next, y, (size_t)system->n * sizeof *y);
        for (int s = 0; s < 4; s++) {
            for (int i = 0; i < system->n; i++)
                stage[i] = y[i] + node[s] * h * f[i];
            system_derivative(system, t + (k + node[s]) * h, stage, f);
            for (int i = 0; i < system->n; i++)
                next[i] += weight[s] * h * f[i];
        }
        memcpy(y, next, (size_t)system->n * sizeof *y);
    }
}

/* Returns the distance of two states, with each variable in units of its half range. */
static double scaled_distance(const struct closed_run *c, const double *a, const double *b)
{
    double sum = 0;
    for (int i = 0; i < c->system->n; i++)
        sum += c->size[i] > 0 ? pow((a[i] - b[i]) / c->size[i], 2) : a[i] != b[i];
    return sqrt(sum);
}

/* Returns the time [s] from row `base` of a run's trace until the state there recurs, or NAN if it
 * does not. Each row nearest to that state is refined by Newton steps along the motion. Sets *error
 * to the remaining distance, as a time along the motion; *error is unchanged if no row comes near.
 */
static double time_of_return(const struct closed_run *c, size_t base, double *error)
{
    const struct system *system = c->system;
    const double *start = trace_state(c->trace, base);
    double f[LIMIT_VARIABLES] = {0}, speed = 0;
    system_derivative(system, trace_time(c->trace, base), start, f);
    for (int i = 0; i < system->n; i++)
        speed += c->size[i] > 0 ? pow(f[i] / c->size[i], 2) : 0;
    double previous_distance = 0, here = scaled_distance(c, trace_state(c->trace, base + 1), start);
    for (size_t row = base + 1; row + 1 < c->end && !cancelled(c->cancel); row++) {
        const double next_distance = scaled_distance(c, trace_state(c->trace, row + 1), start);
        const bool is_nearest = here < previous_distance && here <= next_distance;
        previous_distance = here;
        here = next_distance;
        if (!is_nearest)
            continue;
        double y[LIMIT_VARIABLES], t = trace_time(c->trace, row);
        memcpy(y, trace_state(c->trace, row), (size_t)system->n * sizeof *y);
        for (int k = 0; k < NEWTON_STEPS; k++) {
            double rate[LIMIT_VARIABLES] = {0}, deviation = 0, slope = 0;
            system_derivative(system, t, y, rate);
            for (int i = 0; i < system->n; i++) {
                const double tangent = c->size[i] > 0 ? f[i] / (c->size[i] * c->size[i]) : 0;
                deviation += (y[i] - start[i]) * tangent;
                slope += rate[i] * tangent;
            }
            follow_closed_motion(system, t, -deviation / slope, y);
            t -= deviation / slope;
        }
        const double left = scaled_distance(c, y, start);
        *error = left / sqrt(speed);
        if (left <= same_state_max)
            return fabs(t - trace_time(c->trace, base));
    }
    return NAN;
}

/* Returns true if the first variable comes back after `span` [s] from states all over the window,
 * even if the others take longer. */
static bool first_repeats(const struct closed_run *c, double span)
{
    const double direction =
        trace_time(c->trace, c->end - 1) > trace_time(c->trace, c->begin) ? 1 : -1;
    bool repeats = true;
    for (size_t b = 0; b < BASES && repeats; b++) {
        const size_t base = c->begin + b * (c->end - c->begin) / BASES;
        const double t = trace_time(c->trace, base) + direction * span;
        if ((t - trace_time(c->trace, c->end - 1)) * direction > 0)
            break;
        double y[LIMIT_VARIABLES];
        const size_t row = trace_row_at(c->trace, t);
        memcpy(y, trace_state(c->trace, row), (size_t)c->system->n * sizeof *y);
        follow_closed_motion(c->system, trace_time(c->trace, row), t - trace_time(c->trace, row),
                             y);
        repeats = fabs(y[0] - trace_state(c->trace, base)[0]) <= same_state_max * c->size[0];
    }
    return repeats;
}

/* Reads one period from the returns to BASES states all over the window. Returns false if they are
 * too few, do not agree, or are no multiple of the drive's period. The period is divided by up to
 * PARTS_MAX if the first variable repeats faster. */
static bool closed_period(const struct closed_run *c, struct period *period)
{
    const double t_begin = trace_time(c->trace, c->begin), t_end = trace_time(c->trace, c->end - 1);
    double T = 0, error_max = 0, shortest = HUGE_VAL, longest = 0;
    int found = 0;
    bool same = true;
    for (size_t b = 0; b < BASES && same; b++) {
        const size_t base = c->begin + b * (c->end - c->begin) / BASES;
        double error = 0;
        const double span = time_of_return(c, base, &error);
        if (isnan(span)) { /* there may not be enough time left */
            same = found > 0 && fabs(t_end - trace_time(c->trace, base)) < 1.1 * T;
            continue;
        }
        T += (span - T) / ++found;
        error_max = fmax(error_max, error);
        shortest = fmin(shortest, span);
        longest = fmax(longest, span);
        same = longest - shortest <= same_period_max * T;
    }
    const double drive = system_drive(c->system), turns = drive > 0 ? T / drive : NAN;
    if (!same || found < BASES_MIN ||
        !(c->system->autonomous || fabs(turns - nearbyint(turns)) <= same_period_max * turns))
        return false;
    for (int parts = PARTS_MAX; parts > 1; parts--)
        if (first_repeats(c, T / parts)) {
            T /= parts;
            break;
        }
    *period = (struct period){.period = {T, (longest - shortest) / 2 + error_max},
                              .periods = floor(fabs(t_end - t_begin) / T),
                              .first = fmin(t_begin, t_end),
                              .last = fmax(t_begin, t_end),
                              .how = "returns of the state"};
    return true;
}

/* Returns true if the relative uncertainty of a period is tiny. */
static bool is_exact(const struct period *period)
{
    static const double uncertainty_max = 1e-4; /* relative */
    return period->period.uncertainty <= uncertainty_max * period->period.value;
}

/* Measures the period of a series of a run, and if that result is uncertain searches returns of the
 * run's state (run is NULL without one). Returns false with the error. */
bool run_series_period(const struct run *run, const struct series *s, struct arena *arena,
                       struct period *period, struct error *error)
{
    struct period closed;
    struct error why;
    const bool found = series_period(s, arena, period, &why);
    if (!found)
        *error = why;
    if (!run || s->n < BASES || (found && is_exact(period) && period->periods >= HARMONICS_MAX))
        return found;
    struct closed_run c = {.trace = run->trace, .cancel = s->cancel, .system = &run->system};
    while (c.begin < trace_count(c.trace) && (trace_time(c.trace, c.begin) < s->t[0] ||
                                              trace_time(c.trace, c.begin) > s->t[s->n - 1]))
        c.begin++;
    c.end = c.begin + s->n;
    if (c.end > trace_count(c.trace) ||
        run_system_to(run, c.begin) != run_system_to(run, c.end - 1))
        return found;
    for (int i = 0; i < run->system.n; i++) {
        double low = HUGE_VAL, high = -HUGE_VAL;
        for (size_t row = c.begin; row < c.end; row++) {
            low = fmin(low, trace_state(c.trace, row)[i]);
            high = fmax(high, trace_state(c.trace, row)[i]);
        }
        c.size[i] = (high - low) / 2;
    }
    if (!closed_period(&c, &closed))
        return found;
    if (!found || !is_exact(period) ||
        fabs(period->period.value - closed.period.value) > same_period_max * closed.period.value)
        *period = closed;
    return true;
}

/* Measures the period of a run's first variable. Tries the crossings of a known centre first, which
 * is fast. Returns false if there is none. */
bool find_run_period(const struct run *run, struct arena *arena, struct measured *period)
{
    struct series series;
    struct period found;
    struct error ignored;
    double centre;
    if (!run_series(run, false, arena, &series, &ignored))
        return false;
    const bool clean =
        run_centre(run, &centre) && series_clean_period(&series, centre, arena, &found);
    if (!clean && !run_series_period(run, &series, arena, &found, &ignored))
        return false;
    *period = found.period;
    return true;
}
