/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Extremes and means of a column of a run, updated from step to step. */
#include "modules/sweep/compute/worker.h"

#include <stdlib.h>

void watch_begin(struct extremes *watch, double y)
{
    *watch = (struct extremes){.top = y, .bottom = y};
}

void watch_open(struct extremes *watch, double y)
{
    watch->open = true;
    watch->low = watch->high = y;
}

/* Returns the cubic through values and velocities at both ends of a step of h [s], at its fraction
 * theta (Hairer, Norsett, Wanner 1993, eq. II.6.7). */
static double hermite_value(double h, double y0, double v0, double y1, double v1, double theta)
{
    const double rise = y1 - y0, rest = 1 - theta;
    return rest * y0 + theta * y1 +
           theta * rest * ((1 - 2 * theta) * -rise + rest * h * v0 - theta * h * v1);
}

/* Records an extreme between the states (t0, y0) and (t1, y1), whose velocities v0 and v1 have
 * different signs: a minimum if v0 is negative, otherwise a maximum. Time and value are
 * interpolated. */
void watch_turn(struct extremes *watch, double t0, double y0, double v0, double t1, double y1,
                double v1)
{
    if (v0 == v1) /* both 0 */
        return;
    const double theta = v0 / (v0 - v1), h = t1 - t0, y = hermite_value(h, y0, v0, y1, v1, theta);
    if (signbit(v0)) {
        watch->bottom = y < watch->bottom ? y : watch->bottom;
        watch->low = y < watch->low ? y : watch->low;
        return;
    }
    watch->top = y > watch->top ? y : watch->top;
    watch->high = y > watch->high ? y : watch->high;
    if (watch->open) {
        watch->last = t0 + theta * h;
        if (watch->maxima++ == 0)
            watch->first = watch->last;
    }
}

/* Takes note of the last value y. */
void watch_end(struct extremes *watch, double y)
{
    watch->top = y > watch->top ? y : watch->top;
    watch->bottom = y < watch->bottom ? y : watch->bottom;
    watch->low = y < watch->low ? y : watch->low;
    watch->high = y > watch->high ? y : watch->high;
}

/* Returns the watched measure of that kind, or NAN if too little was seen (for a period, less than
 * two maxima). */
double watch_value(const struct extremes *watch, enum sweep_kind kind)
{
    switch (kind) {
    case SWEEP_AMPLITUDE:
        return watch->open ? (watch->high - watch->low) / 2 : NAN;
    case SWEEP_PERIOD:
        return watch->maxima > 1 ? (watch->last - watch->first) / (double)(watch->maxima - 1) : NAN;
    case SWEEP_MEAN:
        if (watch->span > 0)
            return watch->area / watch->span;
        return watch->open ? watch->high : NAN;
    case SWEEP_MAX:
        return watch->top;
    case SWEEP_MIN:
        return watch->bottom;
    default:
        return NAN;
    }
}

/* ---- recorded runs ---- */

/* Returns the time derivative of a state variable. */
double watch_speed(const struct system *system, int variable, double t, const double *y)
{
    if (system->order == 2 && variable < system->n / 2)
        return y[system->n / 2 + variable];
    double dydt[LIMIT_VARIABLES];
    system_derivative(system, t, y, dydt);
    return dydt[variable];
}

/* Returns the derivative of a column at row i, by the parabola through the row and its
 * neighbours. */
static double column_speed(const struct trace *trace, const double *column, size_t n, size_t i)
{
    const size_t left = i > 0 ? i - 1 : 0;
    const size_t right = i + 1 < n ? i + 1 : n - 1;
    const double left_step = trace_time(trace, i) - trace_time(trace, left),
                 right_step = trace_time(trace, right) - trace_time(trace, i),
                 rise = (column[i] - column[left]) / left_step,
                 next = (column[right] - column[i]) / right_step;
    if (!(left_step + right_step > 0))
        return 0;
    if (i == left || i == right)
        return i == left ? next : rise;
    return (rise * right_step + next * left_step) / (left_step + right_step);
}

/* Sets *column, which the caller frees also on failure, to the watched values at all rows, or to
 * NULL if the measure is a state variable. Returns false if they cannot be computed or if out of
 * memory. */
static bool make_column(const struct run *run, const struct sweep_measure *measure,
                        const struct scene *scene, double **column)
{
    struct error ignored;
    *column = NULL;
    if (measure->column < SWEEP_OBSERVED)
        return true;
    if (!(*column = malloc(trace_count(run->trace) * sizeof **column)))
        return false;
    if (measure->column == SWEEP_FORMULA)
        return expression_column(run, measure->expression, scene, *column);
    if (measure->column == SWEEP_OBSERVED)
        run_observed_column(run, measure->variable, *column);
    else if (!run_column(run, measure->observable, *column, &ignored))
        return false;
    return true;
}

/* Returns the measure of a recorded run. Amplitude, period and mean are taken from the time `opens`
 * [s] on, minima and maxima over the whole run. Returns NAN if too little was seen. */
double watch_run(const struct run *run, const struct sweep_measure *measure,
                 const struct scene *scene, double opens)
{
    const struct trace *trace = run->trace;
    const size_t n = trace_count(trace);
    struct extremes watch = {0};
    double *column, t0 = 0, y0 = 0, v0 = 0;
    const bool there = make_column(run, measure, scene, &column);
    for (size_t i = 0; there && i < n; i++) {
        const double *state = trace_state(trace, i);
        const double t1 = trace_time(trace, i), y1 = column ? column[i] : state[measure->variable];
        const double v1 = column ? column_speed(trace, column, n, i)
                                 : watch_speed(&run->system, measure->variable, t1, state);
        if (i == 0)
            watch_begin(&watch, y1);
        else if (watch_turns(v0, v1))
            watch_turn(&watch, t0, y0, v0, t1, y1, v1);
        if (watch.open) {
            watch.area += watch_area(t1 - t0, y0, v0, y1, v1);
            watch.span += t1 - t0;
        } else if (t1 >= opens) {
            watch_open(&watch, y1);
        }
        t0 = t1;
        y0 = y1;
        v0 = v1;
    }
    watch_end(&watch, y0);
    free(column);
    return there ? watch_value(&watch, measure->kind) : NAN;
}
