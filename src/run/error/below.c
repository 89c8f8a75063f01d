/* SPDX-License-Identifier: GPL-3.0-or-later */
/* run_below_tolerance(): variables of an adaptive run whose present value is below the error that
 * it may have, so that none of its digits is reliable. */
#include "run/error/follower.h"

#include <float.h>
#include <math.h>

#define ADDED_UP 10 /* errors of all steps of a run add up to about this many tolerances */
/* A value below this many times its error has no reliable first digit. */
#define DIGIT_ERROR_FACTOR 10
/* A value that would exceed the tolerance within this part of the run passes through 0. */
#define PASSAGE_FRACTION 0.01

/* Returns the estimated error of variable i where the second opinion last looked, or 0 if no
 * estimate is available. */
static double known_error(const struct run *run, int i)
{
    const struct opinion *opinion = &run->opinion;
    return !isnan(opinion->t) && isnan(opinion->lost) ? opinion->end[i] : 0;
}

/* Sets magnitude_floor [n] of each variable whose magnitude is below the error that tolerance or
 * second opinion give to that error, and 0 for the others. Variables that only pass through 0 at
 * that moment do not count. Returns the number of variables that are below. */
int run_below_tolerance(const struct run *run, double *magnitude_floor)
{
    const struct system *system = &run->system;
    const double soon = PASSAGE_FRACTION * fabs(run->t - system->t0),
                 tol = fmax(run->controller.tol, 10 * DBL_EPSILON);
    double slope[LIMIT_VARIABLES];
    int count = 0;
    memset(magnitude_floor, 0, (size_t)system->n * sizeof *magnitude_floor);
    if (!run->plan.adaptive || run->steps == 0 || stop_is_failure(run->stop))
        return 0;
    system_derivative(system, run->t, run->y, slope);
    for (int i = 0; i < system->n; i++) {
        const double size = fmin(run->controller.scale[i], opinion_size(run, i)),
                     accumulated_error = ADDED_UP * tol * size, error = known_error(run, i);
        const double allowed = fmax(accumulated_error, DIGIT_ERROR_FACTOR * error);
        if (run->y[i] == 0 || !(fabs(run->y[i]) < allowed && fabs(slope[i]) * soon < allowed))
            continue;
        magnitude_floor[i] = fmax(accumulated_error, fabs(run->y[i]) + error);
        count++;
    }
    return count;
}

/* Returns true if a variable with an absolute tolerance is small compared with its largest
 * values. */
bool run_asks_small_values(const struct run *run)
{
    /* Errors may be 100 tolerances; a value is small up to a hundred times that. */
    static const double small_tolerances = 1e4;
    const struct system *system = &run->system;
    double size[LIMIT_VARIABLES] = {0};
    bool asks = false;
    for (int i = 0; i < system->n; i++)
        asks |= system->atol[i] > 0;
    if (asks)
        run_sizes_add(run, 0, trace_count(run->trace), size);
    for (int i = 0; i < system->n && asks; i++)
        if (system->atol[i] > 0 &&
            fabs(run->y[i]) < small_tolerances * run->controller.tol * size[i])
            return true;
    return false;
}
