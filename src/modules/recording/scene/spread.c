/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The uncertainty of a motion that follows from that of its parameters (study_spread()). */
#include "modules/recording/fit/least_squares.h"
#include "modules/recording/scene/curve.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <math.h>
#include <string.h>

/* Tolerance of the integration. */
#define RUN_TOLERANCE 1e-10

/* ---- where the field jumps: differences of runs ---- */

/* The derivatives with dry friction jump at turning points (saltation; Leine and Nijmeijer 2004),
 * which the variational equations between steps do not include. */

#define PARAM_SHIFT_SIGMAS 0.1 /* standard deviations by which a parameter is moved */
#define ROWS_PER_RADIAN 200    /* rows recorded in a radian: their cubic is accurate to 1e-12 */
/* Rows recorded at most. */
#define ROWS_MAX 1e6

/* Returns a run of the scene to time `end` [s] by dop853, with rows that are dense for the scene's
 * natural scale, or NULL if it fails or is cancelled. The caller destroys it. */
struct run *study_run(const struct scene *scene, double end, const struct cancel *cancel)
{
    const struct method *method = method_find("dop853");
    struct system system;
    struct error ignored;
    if (!scene_bind(scene, &system, &ignored))
        return NULL;
    const double span = end - system.t0,
                 natural = system.scale[0] / (ROWS_PER_RADIAN * system.scale[1]);
    struct run_settings settings = {.dt = span / 1e4, .tol = RUN_TOLERANCE};
    settings.record = (struct recording_rule){RECORD_TIMES, 1, natural};
    if (system.order != 2 || !(natural > span / ROWS_MAX))
        settings.record.interval = span / ROWS_MAX;
    struct run *run = span > 0 ? run_create(scene, method, &settings, span, &ignored) : NULL;
    const struct run_target target = {.t = end, .steps = -1};
    while (run && run_advance(run, &target, 0, cancel))
        continue;
    if (run && run->stop == STOP_END)
        return run;
    run_destroy(run);
    return NULL;
}

/* Runs the scene with one parameter moved by increment. Returns NULL if it cannot. */
static struct run *run_with(const struct spread_request *request, int index, double increment)
{
    struct scene scene = *request->scene;
    const struct measured value = {scene.value[index] + increment, 0};
    struct error ignored;
    return scene_set(&scene, index, value, &ignored)
               ? study_run(&scene, request->t[request->n - 1], request->cancel)
               : NULL;
}

/* Adds factor times the run's variable, interpolated at the request's times t [n], to slope[i *
 * known->count], i = 0 to n - 1. Differences of such runs are derivatives by a known parameter. */
static void add_run(const struct spread_request *request, struct run *run, double factor,
                    double *slope)
{
    const size_t rows = trace_count(run->trace);
    const int k = request->variable;
    size_t row = 0;
    for (size_t i = 0; i < request->n; i++) {
        const double t = request->t[i];
        double rate[2][LIMIT_VARIABLES];
        while (row + 2 < rows && trace_time(run->trace, row + 1) < t)
            row++;
        const size_t next = row + 1 < rows ? row + 1 : row;
        const double t_left = trace_time(run->trace, row);
        const double h = trace_time(run->trace, next) - t_left;
        const double *left = trace_state(run->trace, row), *right = trace_state(run->trace, next);
        const double x = h > 0 ? (t - t_left) / h : 0;
        system_derivative(&run->system, t_left, left, rate[0]);
        system_derivative(&run->system, t_left + h, right, rate[1]);
        slope[i * (size_t)request->known->count] +=
            factor * hermite(x, h, left[k], rate[0][k], right[k], rate[1][k]);
    }
}

/* Computes in slope [n][count] the derivatives by the uncertain parameters from differences of
 * runs, one-sided if one side is not allowed, as for negative friction. Returns false with the
 * error. */
static bool slopes_by_runs(const struct spread_request *request, double *slope, struct error *error)
{
    memset(slope, 0, request->n * (size_t)request->known->count * sizeof *slope);
    for (int j = 0; j < request->known->count; j++) {
        const double increment =
            PARAM_SHIFT_SIGMAS * sqrt(request->known->covariance[j * request->known->count + j]);
        struct run *side[2] = {run_with(request, request->known->index[j], -increment),
                               run_with(request, request->known->index[j], increment)};
        double ends[2] = {-1, 1};
        for (int s = 0; s < 2 && increment > 0; s++)
            if (!side[s] && side[1 - s]) {
                side[s] = run_with(request, request->known->index[j], 0);
                ends[s] = 0;
            }
        const bool ok = side[0] && side[1];
        for (int s = 0; s < 2 && ok && increment > 0; s++)
            add_run(request, side[s], (s ? 1 : -1) / (increment * (ends[1] - ends[0])), slope + j);
        run_destroy(side[0]);
        run_destroy(side[1]);
        if (!ok)
            return cancelled(request->cancel)
                       ? error_set(error, ERROR_CANCELLED, "it was stopped")
                       : error_set(error, ERROR_NUMERICAL, "the motion cannot be followed to %g s",
                                   request->t[request->n - 1]);
    }
    return true;
}

/* ---- elsewhere: the variational equations ---- */

/* Computes value [n] and slope [n][count], the derivatives by the uncertain parameters, from the
 * variational equations. Returns false with the error. */
static bool slopes_by_variation(struct scene_curve *c, const struct spread_request *request,
                                double *value, double *slope, struct error *error)
{
    const struct series series = {.t = request->t, .y = request->t, .n = request->n};
    double parameter[CURVE_PARAMETERS];
    for (int j = 0; j < c->frees; j++)
        parameter[j] = c->scene.value[c->index[j]];
    return scene_curve_mesh(c, parameter, &series, error) &&
           (scene_curve_evaluate(c, parameter, request->t, request->n, value, slope) ||
            (cancelled(request->cancel) ? error_set(error, ERROR_CANCELLED, "it was stopped")
                                        : error_set(error, ERROR_NUMERICAL,
                                                    "the derivatives of the motion with respect to "
                                                    "its parameters do not exist up to %g s",
                                                    request->t[request->n - 1])));
}

/* Computes in deviation [n] the standard deviation of a variable at the requested times, from the
 * covariances of the uncertain parameters. Returns false with the error. */
bool study_spread(const struct spread_request *request, struct arena *arena, double *deviation,
                  struct error *error)
{
    const size_t n = request->n, count = (size_t)request->known->count;
    struct scene_curve c = {.scene = *request->scene,
                            .frees = request->known->count,
                            .variable = request->variable,
                            .tol = RUN_TOLERANCE,
                            .cancel = request->cancel};
    struct system system;
    if (!scene_bind(&c.scene, &system, error))
        return false;
    if (request->known->count > CURVE_PARAMETERS ||
        system.n * (request->known->count + 1) > LIMIT_VARIABLES)
        return error_set(error, ERROR_COMMAND,
                         "%d uncertain parameters are too many for this scene",
                         request->known->count);
    double *value = arena_array(arena, n, sizeof *value),
           *slope = arena_array(arena, n * count, sizeof *slope);
    c.variation = arena_alloc(arena, sizeof *c.variation);
    if (!value || !slope || !c.variation)
        return error_memory(error);
    memcpy(c.index, request->known->index, count * sizeof *c.index);
    const bool ok = system.switches > 0 ? slopes_by_runs(request, slope, error)
                                        : slopes_by_variation(&c, request, value, slope, error);
    scene_curve_free(&c);
    for (size_t i = 0; i < n && ok; i++)
        deviation[i] = sqrt(fmax(quadratic_form((int)count, (int)count, slope + i * count,
                                                request->known->covariance, slope + i * count),
                                 0));
    return ok;
}
