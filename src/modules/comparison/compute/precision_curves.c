/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The study behind `precision`: each method is swept from coarse steps to the floor of rounding and
 * its errors are measured; then everything is timed (precision_time.c). */
#include "modules/comparison/compute/suspect.h"
#include <hooke/base/cancel.h>

#include <stdlib.h>
#include <string.h>

#define SECONDS_DEFAULT 12.0 /* time allowed unless the request states one [s] */
#define SECONDS_STIFF 20.0   /* the same for stiff scenes */
#define SWEEP_SHARE 0.45     /* share of the time for measuring errors; the rest is for timing */
#define SECONDS_QUICK 0.4    /* [s] time for timing with `timing quick` */
#define LOG2_FIRST 0         /* the coarsest step is duration/2^this */
#define LOG2_LAST 27         /* the finest step is duration/2^this */
#define TOL_FIRST 1e-2       /* loosest and */
#define TOL_LAST 1e-14       /* tightest tolerance of a sweep */
/* Largest cost of a solve (evaluations, Jacobians and solves of linear systems) once its curve has
 * POINTS_ENOUGH points. */
#define COST_USUAL 2.1e6
#define COST_MAX 6e6 /* the same before that */
/* The same before the curve has POINTS_FIRST points, as the cost of explicit methods in stiff
 * scenes is of interest, too. */
#define COST_FIRST 2.4e7
#define COST_TRIAL 2e5 /* cost after which the whole cost of an adaptive solve is estimated */
#define POINTS_ENOUGH 4
#define POINTS_FIRST 1
/* Errors that stop falling are taken for rounding only below this, or near the reference's
 * accuracy. */
#define FLOOR_ERROR 1e-9
#define ERROR_SETTLED 0.05 /* failures end a sweep after an error this small */
#define FAILURES_MAX 3     /* number of failures in a row that end a sweep */
#define FLOOR_POINTS 2     /* number of points without gain that end a sweep */

bool precision_meaningful(const struct precision_point *point)
{
    return !point->refused && point->stop == STOP_END && point->errors.max < 1;
}

/* State of the sweep of all methods. */
struct sweeping {
    const struct precision_request *request;
    struct precision *precision;
    struct precision_curve *curve; /* curve of the present method */
    double *grid;                  /* [STUDY_TIMES][n] states of the last solve */
    struct witnesses witnesses;    /* finest runs, which may contradict the reference */
    int hardest;                   /* grid interval in which the motion goes furthest */
    size_t capacity;               /* points allocated in precision->point */
    int64_t begin;                 /* clock when the curve was begun [ns] */
    int meaningful;                /* points of the curve with a meaningful error */
    double best;                   /* error so far */
    int stale, failures;           /* points in a row without gain, and failures in a row */
};

/* Appends a point to the present curve. Returns NULL if out of memory. */
static struct precision_point *add_point(struct sweeping *sweep)
{
    struct precision *precision = sweep->precision;
    if ((size_t)precision->points == sweep->capacity) {
        const size_t capacity = sweep->capacity ? 2 * sweep->capacity : 64;
        void *grown = realloc(precision->point, capacity * sizeof *precision->point);
        if (!grown)
            return NULL;
        precision->point = grown;
        sweep->capacity = capacity;
    }
    sweep->curve->count++;
    return &precision->point[precision->points++];
}

/* Returns the order between two points, or NAN if one of them failed. */
static double local_order(const struct precision_point *coarse, const struct precision_point *fine)
{
    const double ratio = fine->tol > 0 ? coarse->tol / fine->tol : coarse->dt / fine->dt;
    const double order = log(coarse->errors.max / fine->errors.max) / log(ratio);
    return precision_meaningful(coarse) && precision_meaningful(fine) && isfinite(order) ? order
                                                                                         : NAN;
}

/* Returns the index of the grid interval in which the reference moves furthest, in amplitudes. */
static int hardest_interval(const struct precision *precision)
{
    const struct reference *reference = &precision->reference;
    double max = 0;
    int found = 0;
    for (int k = 0; k + 1 < STUDY_TIMES; k++) {
        const double *y = reference->y + k * reference->n;
        const double distance = grid_distance(reference, y, y + reference->n);
        if (distance > max) {
            max = distance;
            found = k;
        }
    }
    return found;
}

/* Returns true if steps of this size lose the motion, as tried in the one of 256 intervals in which
 * it moves furthest, from the reference's state: they then lose all of it, which is found at 1/256
 * of the cost. The point is filled in then. Returns false if the motion is not lost there, if the
 * steps are longer than a quarter of the interval, or with *memory false if out of memory. */
static bool lost_in_probe(const struct sweeping *sweep, struct precision_point *point, bool *memory)
{
    const struct precision *precision = sweep->precision;
    const struct reference *reference = &precision->reference;
    const double interval = precision->duration / (STUDY_TIMES - 1);
    const double *y_begin = reference->y + sweep->hardest * reference->n;
    const struct run_settings settings = precision_settings(precision, point);
    struct system system = precision->system;
    struct solver solver;
    if (point->tol > 0 || point->dt > interval / 4)
        return false;
    system.t0 += interval * sweep->hardest;
    memcpy(system.start, y_begin, (size_t)system.n * sizeof *y_begin);
    *memory = solver_init(&solver, &system, sweep->curve->choice.method, &settings, interval);
    if (!*memory)
        return false;
    const int64_t begin = clock_cpu_ns();
    point->stop = solver_run(&solver, NULL, sweep->request->cancel);
    point->seconds = (double)(clock_cpu_ns() - begin) * 1e-9;
    point->steps = solver.steps;
    point->cost = solver.step.cost;
    if (point->stop == STOP_END)
        point->errors.max = grid_distance(reference, solver.y, y_begin + reference->n);
    solver_free(&solver);
    point->probed = !precision_meaningful(point);
    point->part = 1.0 / (STUDY_TIMES - 1);
    return point->probed;
}

/* Returns the largest cost that the next solve of the sweep may have. */
static double cost_max(const struct sweeping *sweep)
{
    if (sweep->meaningful >= POINTS_ENOUGH)
        return COST_USUAL;
    const bool implicit = sweep->curve->choice.method->flags & METHOD_IMPLICIT;
    return sweep->meaningful >= POINTS_FIRST || implicit ? COST_MAX : COST_FIRST;
}

/* Solves the whole duration. An adaptive solve is given up after COST_TRIAL if the part that it has
 * reached by then shows that all of it costs too much, unless the setting is `wanted` by the user.
 * Returns why the solve ended. */
static enum stop curve_solve(const struct sweeping *sweep, struct solver *solver, bool wanted)
{
    const struct cancel *cancel = sweep->request->cancel;
    if (solver->tol > 0 && !wanted) {
        solver->max = (int64_t)COST_TRIAL;
        const enum stop stop = solver_run(solver, sweep->grid, cancel);
        const double part = (solver->step.t - solver->system->t0) / solver->span;
        if (stop != STOP_FULL ||
            solve_work(&solver->step.cost, solver->steps) > part * fmax(cost_max(sweep), COST_MAX))
            return stop;
        solver_start(solver);
    }
    solver->max = (int64_t)COST_FIRST;
    return solver_run(solver, sweep->grid, cancel);
}

/* Solves and measures a point, which is first tried by lost_in_probe() unless the setting is
 * `wanted` by the user. Returns false if out of memory. */
static bool measure_point(struct sweeping *sweep, struct precision_point *point, bool wanted)
{
    const struct precision *precision = sweep->precision;
    const struct precision_curve *curve = sweep->curve;
    const struct run_settings settings = precision_settings(precision, point);
    struct error ignored;
    struct solver solver;
    point->path = study_path(&precision->system, curve->choice.method, &settings);
    point->time = (struct timing_result){.minimum = NAN, .median = NAN, .spread = NAN};
    point->recording = point->order = NAN;
    point->errors = (struct study_errors){NAN, NAN, NAN, NAN, NAN};
    if (point->tol == 0 && !method_fits(curve->choice.method, &precision->system,
                                        curve->choice.drag, point->dt, &ignored)) {
        point->refused = true;
        return true;
    }
    bool memory = true;
    if ((!wanted && lost_in_probe(sweep, point, &memory)) || !memory)
        return memory;
    point->errors.max = NAN;
    if (!solver_init(&solver, &precision->system, curve->choice.method, &settings,
                     precision->duration))
        return false;
    const int64_t begin = clock_cpu_ns();
    point->stop = curve_solve(sweep, &solver, wanted);
    point->seconds = (double)(clock_cpu_ns() - begin) * 1e-9;
    point->steps = solver.steps;
    point->cost = solver.step.cost;
    const double reached =
        point->tol > 0 ? solver.step.t - precision->system.t0 : (double)solver.steps * point->dt;
    point->part = point->stop == STOP_END ? 1 : fmin(reached / precision->duration, 1);
    point->costly = !wanted && solve_work(&point->cost, point->steps) > COST_MAX;
    solver_free(&solver);
    if (point->stop == STOP_END) {
        grid_errors(&precision->system, &precision->reference, sweep->grid, &point->errors);
        witness_store(&sweep->witnesses, precision->curves, &precision->reference,
                      curve->choice.method, point->steps, sweep->grid);
    }
    point->is_below_reference = point->errors.max <= precision->reference.accuracy;
    return true;
}

/* Returns true if the point just measured ends the sweep: by failures, by errors that no longer
 * fall, by the cost of the next point, or by the share of time `fraction` [s] of the curve. */
static bool ends_sweep(struct sweeping *sweep, const struct precision_point *point, double fraction)
{
    struct precision_curve *curve = sweep->curve;
    const double error = point->errors.max, accuracy = sweep->precision->reference.accuracy;
    /* the factor by which the next setting costs more */
    const double each = curve->adaptive ? pow(10, 1.0 / curve->choice.method->order) : 2;
    const double next =
        each * solve_work(&point->cost, point->steps) * (point->probed ? STUDY_TIMES - 1 : 1);
    if (!precision_meaningful(point)) {
        curve->cut = clock_seconds(sweep->begin) > 2 * fraction;
        sweep->failures++;
        return curve->cut || next > cost_max(sweep) ||
               (sweep->best < ERROR_SETTLED && sweep->failures == FAILURES_MAX) ||
               point->stop == STOP_FULL;
    }
    sweep->meaningful++;
    sweep->failures = 0;
    sweep->stale = error > 0.6 * sweep->best && error < fmax(FLOOR_ERROR, 100 * accuracy)
                       ? sweep->stale + 1
                       : 0;
    sweep->best = fmin(sweep->best, error);
    if (sweep->stale == FLOOR_POINTS || error == 0)
        return true;
    if (next > cost_max(sweep))
        return true;
    curve->cut = clock_seconds(sweep->begin) > fraction;
    return curve->cut;
}

/* Fills in the i-th setting of the sweep, from coarse to fine. Returns false if there are no
 * more. */
static bool setting_at(const struct sweeping *sweep, int i, struct precision_point *point)
{
    const struct precision_request *request = sweep->request;
    const double duration = sweep->precision->duration;
    if (sweep->curve->adaptive) {
        const double first =
            isnan(request->tol[0]) ? TOL_FIRST : fmax(request->tol[0], request->tol[1]);
        const double last =
            isnan(request->tol[0]) ? TOL_LAST : fmin(request->tol[0], request->tol[1]);
        /* A division by an exact power of ten rounds to the decade itself. */
        point->tol = first / pow(10, i);
        point->dt = 0;
        return point->tol >= last * (1 - 1e-9);
    }
    int first = LOG2_FIRST, last = LOG2_LAST;
    if (!isnan(request->dt[0])) {
        const double coarse = fmax(request->dt[0], request->dt[1]),
                     fine = fmin(request->dt[0], request->dt[1]);
        first = (int)ceil(log2(duration / coarse) - 1e-9);
        last = (int)floor(log2(duration / fine) + 1e-9);
        if (last < first) /* no power of two between them: the nearest */
            first = last = (int)lround(log2(duration / sqrt(coarse * fine)));
    }
    point->dt = ldexp(duration, -(first + i));
    return first + i <= last;
}

/* Measures the points of the present curve in about `fraction` [s]. Returns false with an error if
 * out of memory or cancelled; the curve is not counted as finished then. */
static bool sweep_curve(struct sweeping *sweep, double fraction, struct error *error)
{
    struct precision *precision = sweep->precision;
    struct precision_curve *curve = sweep->curve;
    const bool wanted = !isnan(curve->adaptive ? sweep->request->tol[0] : sweep->request->dt[0]);
    sweep->begin = clock_ns();
    sweep->meaningful = sweep->stale = sweep->failures = 0;
    sweep->best = HUGE_VAL;
    struct precision_point next = {.curve = precision->curves};
    for (int i = 0; setting_at(sweep, i, &next); i++) {
        struct precision_point point = next;
        if (!measure_point(sweep, &point, wanted))
            return error_memory(error);
        if (cancelled(sweep->request->cancel))
            return error_set(error, ERROR_CANCELLED, "stopped");
        struct precision_point *previous =
            curve->count ? &precision->point[precision->points - 1] : NULL;
        if (previous)
            point.order = local_order(previous, &point);
        /* Only the last of consecutive settings without a meaningful error is kept. */
        const bool instead =
            previous && !wanted && !precision_meaningful(previous) && !precision_meaningful(&point);
        struct precision_point *index = instead ? previous : add_point(sweep);
        if (!index)
            return error_memory(error);
        *index = point;
        const bool is_finished = ends_sweep(sweep, &point, fraction);
        if (is_finished && (!wanted || curve->cut))
            break;
    }
    precision->curves++;
    return true;
}

/* Checks the request, binds the scene and initializes the curves. Returns false with an error if
 * the request is invalid, a method does not apply, or out of memory. */
static bool prepare_precision_curves(const struct precision_request *request,
                                     struct precision *precision, struct error *error)
{
    const bool fixed = !isnan(request->dt[0]) && isnan(request->tol[0]);
    if (!(request->duration > 0) || !isfinite(request->duration))
        return error_set(error, ERROR_COMMAND, "the duration must be > 0 (got %.6g s)",
                         request->duration);
    for (int i = 0; i < 2; i++)
        if (request->dt[i] <= 0 || request->tol[i] <= 0 ||
            isnan(request->dt[i]) != isnan(request->dt[0]) ||
            isnan(request->tol[i]) != isnan(request->tol[0]))
            return error_set(error, ERROR_COMMAND,
                             "a sweep needs two ends above 0, as in dt=1ms:100ms");
    precision->scene = *request->scene;
    precision->duration = request->duration;
    precision->compensated = request->compensated;
    precision->curve = calloc((size_t)request->choices + 1, sizeof *precision->curve);
    if (!precision->curve)
        return error_memory(error);
    if (!scene_bind(request->scene, &precision->system, error))
        return false;
    for (int c = 0; c < request->choices; c++) {
        struct precision_curve *curve = &precision->curve[c];
        curve->choice = request->choice[c];
        curve->adaptive = curve->choice.method->flags & METHOD_ADAPTIVE && !fixed;
        curve->slope = curve->r2 = NAN;
        if (!method_applies(curve->choice.method, &precision->system, &curve->choice.drag, error))
            return false;
    }
    return true;
}

/* Sweeps all curves against the reference, in about `seconds` since the clock `begin` [ns], and
 * leaves their finest runs in sweep->witnesses. Returns false with an error as sweep_curve()
 * does. */
static bool sweep_once(struct sweeping *sweep, int64_t begin, double seconds, struct error *error)
{
    struct precision *precision = sweep->precision;
    const int choices = sweep->request->choices;
    bool ok = true;
    precision->points = precision->curves = 0;
    for (int c = 0; c < choices; c++)
        sweep->witnesses.one[c].method = NULL;
    sweep->hardest = hardest_interval(precision);
    for (int c = 0; c < choices && ok; c++) {
        const double left = SWEEP_SHARE * seconds - clock_seconds(begin);
        sweep->curve = &precision->curve[c];
        sweep->curve->first = precision->points;
        sweep->curve->count = 0;
        ok = sweep_curve(sweep, fmax(left, 0.02 * seconds) / (choices - c), error);
    }
    return ok;
}

/* Solves all points of all curves, within about `seconds` from `begin` (a time of clock_ns()). If
 * the finest runs contradict the reference, it is computed again with steps like theirs, and all
 * curves are solved anew. Returns false with an error if out of memory or cancelled. */
static bool sweep_all(const struct precision_request *request, struct precision *precision,
                      int64_t begin, double seconds, struct error *error)
{
    struct sweeping sweep = {.request = request, .precision = precision};
    struct reference *reference = &precision->reference;
    double step;
    sweep.grid = malloc((size_t)STUDY_TIMES * (size_t)precision->system.n * sizeof *sweep.grid);
    bool ok = sweep.grid && witnesses_init(&sweep.witnesses, &precision->system, request->choices);
    if (!ok)
        error_memory(error);
    ok = ok && sweep_once(&sweep, begin, seconds, error);
    if (ok && reference_suspect(reference, &sweep.witnesses, &step) && !reference->again) {
        struct error none;
        if (references_again(request->references, request->scene, &precision->system,
                             request->duration, step, request->cancel, reference, &none)) {
            ok = sweep_once(&sweep, begin, 2 * seconds, error);
            if (ok)
                reference_suspect(reference, &sweep.witnesses, &step);
        }
    }
    witnesses_free(&sweep.witnesses);
    free(sweep.grid);
    return ok;
}

/* Sweeps each choice from coarse steps to the floor of rounding, then times all points together. */
bool study_precision(const struct precision_request *request, struct precision *precision,
                     struct error *error)
{
    *precision = (struct precision){0};
    if (!prepare_precision_curves(request, precision, error) ||
        !references_get(request->references, request->scene, &precision->system, request->duration,
                        request->cancel, &precision->reference, error))
        return false;
    const int64_t begin = clock_ns();
    const double usual =
        precision_is_stiff(&precision->system, request->duration) ? SECONDS_STIFF : SECONDS_DEFAULT;
    const double seconds = request->seconds > 0 ? request->seconds : usual;
    bool ok = sweep_all(request, precision, begin, seconds, error);
    if (!ok) /* drop the points of the curve that was not finished */
        precision->points = precision->curve[precision->curves].first;
    for (int c = 0; c < precision->curves; c++)
        precision_fit(precision, c);
    if (!ok && error->code == ERROR_CANCELLED)
        return error_set(error, ERROR_CANCELLED,
                         "stopped: %d of %d methods finished, nothing timed", precision->curves,
                         request->choices);
    if (ok && request->timing != TIMING_OFF)
        ok = precision_time(request, precision,
                            request->timing == TIMING_QUICK && !(request->seconds > 0)
                                ? SECONDS_QUICK
                                : fmax(seconds - clock_seconds(begin), 0.1 * seconds),
                            error);
    return ok &&
           (!cancelled(request->cancel) ||
            error_set(error, ERROR_CANCELLED, "stopped: all errors are measured, not all times"));
}

/* Frees everything that the study owns and zeroes it. */
void precision_free(struct precision *precision)
{
    reference_free(&precision->reference);
    free(precision->point);
    free(precision->curve);
    *precision = (struct precision){0};
}
