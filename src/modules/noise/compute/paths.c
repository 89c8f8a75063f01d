/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Follows paths of a scene with noise, and computes statistics of many. */
#include "modules/noise/compute/paths.h"

#include "modules/noise/compute/random.h"

#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>

#include <gsl/gsl_statistics_double.h>
#include <stdlib.h>
#include <string.h>

/* ---- steps and rows ---- */

/* Returns false with *error if the step makes a linear scene grow by 10 % more over the whole path
 * than the scene does itself. */
static bool check_growth(const struct noise_forcing *forcing, const struct noise_method *method,
                         const struct path_grid *grid, struct error *error)
{
    static const double growth_max = 0.1; /* logarithm of the factor: 10 % */
    const double excess = noise_stepper_excess_growth(forcing, method, grid->h);
    if (isnan(excess) || excess * (double)grid->steps <= growth_max)
        return true;
    const double limit =
        noise_stepper_stable_limit(forcing, method, grid->h, growth_max / grid->span);
    struct buffer text = {0};
    buffer_quantity(&text, grid->h, QUANTITY_TIME, 4);
    error_set(error, ERROR_COMMAND,
              "dt = %s is too large for %s: each step multiplies the motion by %.4g",
              buffer_view(&text), method->row.name, exp(excess));
    buffer_clear(&text);
    buffer_quantity(&text, limit, QUANTITY_TIME, 3);
    if (limit > 0)
        error_hint(error, "use dt <= %s; smaller steps are more accurate", buffer_view(&text));
    else
        error_hint(error, "no dt is small enough; use method=%s",
                   noise_method_natural(forcing)->row.name);
    buffer_free(&text);
    return false;
}

/* Divides the span [s] into steps of at most dt [s] and rows of which about `intervals` + 1 are
 * recorded, in *grid. Rounds the number of steps up. Returns false with an error if there are too
 * many steps, or if the method is unstable or does not suit the scene. */
bool noise_path_grid_make(const struct noise_forcing *forcing, const struct noise_method *method,
                          double span, double dt, size_t intervals, struct path_grid *grid,
                          struct error *error)
{
    static const double rounding = 1e-9; /* relative to a step: 1 s / 0.1 s are 10 steps */
    if (method->needs_velocity && forcing->system.order != 2) {
        error_set(error, ERROR_COMMAND, "%s needs velocities, but the scene has none",
                  method->row.name);
        return error_hint(error, "method=%s", noise_method_natural(forcing)->row.name);
    }
    const double wanted = ceil(span / dt - rounding);
    if (!(wanted <= PATH_STEPS_MAX))
        return error_set(error, ERROR_COMMAND, "%.3g steps are too many; the limit is %.0g", wanted,
                         (double)PATH_STEPS_MAX);
    const int64_t steps = wanted < 1 ? 1 : (int64_t)wanted;
    const int64_t rows = steps < (int64_t)intervals ? steps : (int64_t)intervals;
    *grid = (struct path_grid){.t0 = forcing->system.t0, .span = span};
    grid->steps = steps;
    /* The stride is increased, up to twice, if rows are then evenly spaced to the end. */
    const int64_t least = (steps + rows - 1) / rows;
    for (grid->stride = least; steps % grid->stride != 0;)
        if (++grid->stride > 2 * least) {
            grid->stride = least;
            break;
        }
    grid->rows = (size_t)((steps + grid->stride - 1) / grid->stride) + 1;
    grid->h = span / (double)steps;
    return check_growth(forcing, method, grid, error);
}

double noise_path_time(const struct path_grid *grid, size_t row)
{
    const int64_t step = (int64_t)row * grid->stride;
    return grid->t0 + (double)(step < grid->steps ? step : grid->steps) * grid->h;
}

/* Evaluates an observable, a variable of the state, or a quantity that a typed scene observes. */
double noise_path_value(const struct noise_forcing *forcing, const struct path_column *column,
                        double t, const double *y)
{
    const struct system *system = &forcing->system;
    if (column->observable) {
        const struct sample sample = {.run = column->run, .t = t, .y = y, .system = system};
        return column->observable->value(&sample);
    }
    return column->variable < system->n
               ? y[column->variable]
               : system_observe(system, column->variable - system->n, t, y);
}

/* ---- one path ---- */

/* Follows path number `path` of the request to its end state y [n], and passes every stride-th
 * state and the last one to row(), unless that is NULL. Checks Ctrl-C from time to time. Returns
 * the number of steps made, fewer than all if the path diverged or was cancelled. */
int64_t noise_path_follow(const struct path_request *request, uint64_t path, double *y,
                          void (*row)(void *context, size_t row, double t, const double *y),
                          void *context)
{
    enum { CANCEL_CHECK_STEPS = 1024 };
    const struct noise_forcing *forcing = request->forcing;
    const struct path_grid *grid = &request->grid;
    const double root = sqrt(grid->h);
    struct noise_stepper stepper;
    double noise[LIMIT_VARIABLES];
    noise_stepper_begin(&stepper, forcing, request->method, grid->h);
    memcpy(y, forcing->system.start, (size_t)forcing->system.n * sizeof *y);
    if (row)
        row(context, 0, grid->t0, y);
    for (int64_t i = 0; i < grid->steps; i++) {
        if (i % CANCEL_CHECK_STEPS == 0 && cancelled(request->cancel))
            return i;
        noise_normal_numbers(request->seed, path, (uint64_t)i, forcing->count, noise);
        for (int k = 0; k < forcing->count; k++)
            noise[k] *= root;
        if (!noise_stepper_step(&stepper, grid->t0 + (double)i * grid->h, y, noise))
            return i;
        if (row && ((i + 1) % grid->stride == 0 || i + 1 == grid->steps)) {
            const size_t place = (size_t)((i + grid->stride) / grid->stride);
            row(context, place, noise_path_time(grid, place), y);
        }
    }
    return grid->steps;
}

/* ---- the same path with half the step ---- */

/* Follows path number `path` with half the grid's step and stores the state at the end in y. The
 * noise is that of the full steps, each increment divided in two by a Brownian bridge (Levy 1939),
 * so that both results can be compared. Returns false if the path diverges or if cancelled. */
static bool follow_halves(const struct path_request *request, uint64_t path, double *y)
{
    enum { CANCEL_CHECK_STEPS = 1024 };
    static const uint64_t bridge_paths = (uint64_t)1
                                         << 31; /* numbers of paths that no ensemble uses */
    const struct noise_forcing *forcing = request->forcing;
    const struct path_grid *grid = &request->grid;
    const double root = sqrt(grid->h), half = grid->h / 2;
    struct noise_stepper stepper;
    double increment[LIMIT_VARIABLES], bridge[LIMIT_VARIABLES], noise[2][LIMIT_VARIABLES];
    noise_stepper_begin(&stepper, forcing, request->method, half);
    memcpy(y, forcing->system.start, (size_t)forcing->system.n * sizeof *y);
    for (int64_t i = 0; i < grid->steps; i++) {
        const double t = grid->t0 + (double)i * grid->h;
        if (i % CANCEL_CHECK_STEPS == 0 && cancelled(request->cancel))
            return false;
        noise_normal_numbers(request->seed, path, (uint64_t)i, forcing->count, increment);
        noise_normal_numbers(request->seed, path + bridge_paths, (uint64_t)i, forcing->count,
                             bridge);
        for (int k = 0; k < forcing->count; k++) {
            noise[0][k] = root / 2 * (increment[k] + bridge[k]);
            noise[1][k] = root / 2 * (increment[k] - bridge[k]);
        }
        if (!noise_stepper_step(&stepper, t, y, noise[0]) ||
            !noise_stepper_step(&stepper, t + half, y, noise[1]))
            return false;
    }
    return true;
}

/* Computes in distance [n] the root mean square, over `paths` paths, of the difference between the
 * states `end` and those that the same noise gives with half the step. Returns false if a path
 * diverges or if cancelled. */
bool noise_path_half_step(const struct path_request *request, const double *end, int64_t paths,
                          double *distance)
{
    const int n = request->forcing->system.n;
    memset(distance, 0, (size_t)n * sizeof *distance);
    for (int64_t path = 0; path < paths; path++) {
        double y[LIMIT_VARIABLES];
        if (!follow_halves(request, (uint64_t)path, y))
            return false;
        for (int i = 0; i < n; i++)
            distance[i] = hypot(distance[i], (y[i] - end[path * n + i]) / sqrt((double)paths));
    }
    return true;
}

/* ---- ensembles ---- */

/* Data that the threads share. */
struct ensemble_work {
    const struct path_request *request;
    const struct path_column *column;
    struct ensemble *ensemble;
};

/* One path of an ensemble, as context of keep_row(). */
struct ensemble_path {
    struct ensemble_work *work;
    int64_t path;
};

/* Stores the value of the column at one row. */
static void keep_row(void *context, size_t row, double t, const double *y)
{
    const struct ensemble_path *path = context;
    struct ensemble *ensemble = path->work->ensemble;
    ensemble->value[row * (size_t)ensemble->paths + (size_t)path->path] =
        noise_path_value(path->work->request->forcing, path->work->column, t, y);
}

/* Follows path number `index` of an ensemble and stores its values and end; `context` is the struct
 * ensemble_work. Values after a divergence are NAN. */
static void follow_one(void *context, int thread, int64_t index)
{
    (void)thread;
    struct ensemble_work *work = context;
    struct ensemble *ensemble = work->ensemble;
    struct ensemble_path path = {work, index};
    const int n = work->request->forcing->system.n;
    for (size_t row = 0; row < ensemble->rows; row++)
        ensemble->value[row * (size_t)ensemble->paths + (size_t)index] = NAN;
    double *end = ensemble->end + index * n;
    const int64_t steps = noise_path_follow(work->request, (uint64_t)index, end, keep_row, &path);
    for (int i = 0; i < n && steps < work->request->grid.steps; i++)
        end[i] = NAN;
}

double noise_ensemble_bytes(const struct path_request *request, int64_t paths)
{
    return (double)paths * ((double)request->grid.rows + request->forcing->system.n) *
           (double)sizeof(double);
}

/* Allocates the ensemble, follows its paths over threads, and counts those that diverge. Returns
 * false with an error if out of memory or cancelled; the caller frees the ensemble in either
 * case. */
bool noise_ensemble_follow(const struct path_request *request, const struct path_column *column,
                           int64_t paths, struct parallel parallel, struct ensemble *ensemble,
                           struct error *error)
{
    const size_t n = (size_t)request->forcing->system.n;
    *ensemble = (struct ensemble){.paths = paths, .rows = request->grid.rows};
    ensemble->value = calloc((size_t)paths * ensemble->rows, sizeof *ensemble->value);
    ensemble->end = calloc((size_t)paths * n, sizeof *ensemble->end);
    if (!ensemble->value || !ensemble->end)
        return error_memory(error);
    struct ensemble_work work = {request, column, ensemble};
    parallel.work = follow_one;
    parallel.context = &work;
    parallel_do(&parallel, paths);
    if (parallel.progress)
        parallel.progress(parallel.progress_context, 2);
    if (cancelled(parallel.cancel))
        return error_set(error, ERROR_CANCELLED, "stopped; no ensemble was kept");
    for (int64_t i = 0; i < paths; i++)
        ensemble->diverged += isnan(ensemble->end[(size_t)i * n]);
    return true;
}

void noise_ensemble_free(struct ensemble *ensemble)
{
    free(ensemble->value);
    free(ensemble->end);
    *ensemble = (struct ensemble){0};
}

/* ---- statistics ---- */

/* Returns the mean of n values and its standard error, without overflow and exact for constant
 * values. The mean is NAN for n = 0, the error for n < 2. */
struct measured noise_mean_of(const double *value, size_t n)
{
    /* Sums deviations from the first value, so that constant values have no spread. */
    double sum = 0, largest = 0, squares = 0;
    for (size_t i = 0; i < n; i++)
        sum += (value[i] - value[0]) / (double)n;
    const double mean = n ? value[0] + sum : NAN;
    for (size_t i = 0; i < n; i++)
        largest = fmax(largest, fabs(value[i] - mean));
    /* Squares of deviations of any size are within the range of numbers. */
    for (size_t i = 0; i < n && largest > 0; i++)
        squares += (value[i] - mean) / largest * ((value[i] - mean) / largest);
    return (struct measured){mean,
                             n > 1 ? largest * sqrt(squares / (double)(n - 1) / (double)n) : NAN};
}

/* Returns the quantile of ascending values [n], between two of them by a straight line (Hyndman,
 * Fan 1996, definition 7), so that the median of an even number is the middle of two. */
static double ascending_quantile(const double *ascending, size_t n, double share)
{
    return n ? gsl_stats_quantile_from_sorted_data(ascending, 1, n, share) : NAN;
}

/* Returns mean, standard deviation and quantiles of a row over the paths that have not diverged.
 * scratch has room for 2 * paths values. */
struct ensemble_row noise_ensemble_statistics(const struct ensemble *ensemble,
                                              const struct path_grid *grid, size_t row,
                                              double *scratch)
{
    const double *value = ensemble->value + row * (size_t)ensemble->paths;
    size_t n = 0;
    for (int64_t i = 0; i < ensemble->paths; i++)
        if (!isnan(value[i]))
            scratch[n++] = value[i];
    const struct measured mean = noise_mean_of(scratch, n);
    struct ensemble_row found = {.t = noise_path_time(grid, row),
                                 .mean = mean.value,
                                 .sd = mean.uncertainty * sqrt((double)n),
                                 .paths = (int64_t)n};
    sort_values(scratch, n, scratch + ensemble->paths, NULL);
    found.low = ascending_quantile(scratch, n, 0.05);
    found.lower = ascending_quantile(scratch, n, 0.25);
    found.median = ascending_quantile(scratch, n, 0.5);
    found.upper = ascending_quantile(scratch, n, 0.75);
    found.high = ascending_quantile(scratch, n, 0.95);
    return found;
}
