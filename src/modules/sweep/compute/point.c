/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Computes points of a sweep, each as a run of its own, and hands them to lanes.c where they can go
 * side by side with the same bits. */
#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include <hooke/scene/typed.h>
#include "modules/sweep/compute/worker.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Sets *scene and *settings to those that all points share. */
void sweep_common(const struct sweep_request *request, struct scene *scene,
                  struct run_settings *settings)
{
    *scene = *request->scene;
    *settings = request->settings;
    /* the last bits of a propagator differ from those of lanes */
    if (settings->kernel == KERNEL_PROPAGATOR)
        settings->kernel = KERNEL_SPECIALISED;
}

/* Allocates the memory of a worker, that of lanes and of stored steps only if the job needs them.
 * Returns false if out of memory; nothing is allocated then. */
bool sweep_worker_init(struct sweep_worker *worker, struct sweep_job *job)
{
    *worker = (struct sweep_worker){.job = job, .refused = -1};
    sweep_common(job->request, &worker->scene, &worker->settings);
    worker->system = malloc((job->in_lanes ? LANE_COUNT : 1) * sizeof *worker->system);
    if (job->in_lanes) {
        worker->lanes = lanes_create();
        worker->row = malloc((size_t)SWEEP_ROWS * 3 * LANE_COUNT * sizeof *worker->row);
        worker->work =
            malloc(method_work_size(job->request->method, job->request->scene->model->n) *
                   sizeof *worker->work);
    }
    if (job->replays)
        worker->replay = malloc((size_t)LANE_COUNT * (size_t)job->room * 2 * sizeof(double));
    if (worker->system && (!job->in_lanes || (worker->lanes && worker->row && worker->work)) &&
        (!job->replays || worker->replay) &&
        (!job->request->section.wanted || section_create(worker)))
        return true;
    sweep_worker_free(worker);
    return false;
}

/* Frees the memory of a worker. */
void sweep_worker_free(struct sweep_worker *worker)
{
    free(worker->system);
    free(worker->row);
    free(worker->replay);
    free(worker->work);
    section_free(worker->section);
    lanes_destroy(worker->lanes);
}

/* Sets the quantity of an axis to a value. Returns false with an error if the value is refused. */
static bool set_axis(const struct sweep_axis *axis, double value, struct scene *scene,
                     struct run_settings *settings, struct error *error)
{
    switch (axis->target) {
    case SWEEP_PARAM:
        return scene_set(scene, axis->index, (struct measured){value, 0}, error);
    case SWEEP_DERIVED:
        return scene_set_derived(scene,
                                 (const struct derived_row *)(const void *)catalog_row(
                                     scene_derived(scene), (size_t)axis->index),
                                 (struct measured){value, 0}, error);
    case SWEEP_DT:
        settings->dt = value;
        return value > 0 || error_set(error, ERROR_COMMAND, "dt must be > 0 (got %.6g s)", value);
    case SWEEP_TOL:
        settings->tol = value;
        return value > 0 || error_set(error, ERROR_COMMAND, "tol must be > 0 (got %.6g)", value);
    }
    return false;
}

/* Sets the swept quantities in `scene` and `settings` to those of point i, counted from the first
 * point of this sweep. Returns false with an error if a value is refused. */
bool sweep_point(const struct sweep_request *request, const struct sweep *sweep, int64_t i,
                 struct scene *scene, struct run_settings *settings, struct error *error)
{
    const double *given = request->scene->value;
    for (int a = 0; a < request->axes; a++)
        /* A derived quantity sets parameters of other names, so that all are restored. */
        if (request->axis[a].target == SWEEP_DERIVED)
            memcpy(scene->value, given, scene_params(scene)->count * sizeof *given);
        else if (request->axis[a].target == SWEEP_PARAM)
            scene->value[request->axis[a].index] = given[request->axis[a].index];
    for (int a = 0; a < request->axes; a++)
        if (!set_axis(&request->axis[a],
                      sweep_axis_value(&request->axis[a], (int)sweep_number(sweep, a, i)), scene,
                      settings, error))
            return false;
    return true;
}

/* Marks point i as refused and keeps the reason if it is the first such point. */
void sweep_refuse(struct sweep_worker *worker, int64_t i, const struct error *error)
{
    worker->job->sweep->status[i] = SWEEP_REFUSED;
    if (worker->refused >= 0 && worker->refused < i)
        return;
    worker->refused = i;
    snprintf(worker->reason, sizeof worker->reason, "%s", error->text);
}

double *sweep_values(struct sweep_worker *worker, int64_t i)
{
    if (worker->job->request->columns > 0)
        return worker->part;
    return worker->job->sweep->value + i * worker->job->sweep->measures;
}

/* Returns the value of a measure that depends on time and state only, or NAN. */
double sweep_measured(const struct sweep_measure *measure, const struct system *system, double t,
                      const double *y)
{
    switch (measure->kind) {
    case SWEEP_REACHED:
        return t;
    case SWEEP_VARIABLE:
        return y[measure->variable];
    case SWEEP_OBSERVED:
        return system_observe(system, measure->variable, t, y);
    default:
        return NAN;
    }
}

/* Returns the value of a measure at the end of a run. Amplitudes, means and extremes are taken from
 * the time `opens` [s] on. */
static double run_measure(const struct run *run, const struct sweep_measure *measure,
                          const struct scene *scene, double opens)
{
    struct run_errors errors;
    struct ledger ledger;
    if (sweep_watches(measure))
        return watch_run(run, measure, scene, opens);
    switch (measure->kind) {
    case SWEEP_ERROR:
        run_errors(run, &errors);
        return errors.max;
    case SWEEP_ENERGY_ERROR:
        run_ledger(run, &ledger);
        return ledger.error_max;
    case SWEEP_ATTRACTOR:
        return measure->attractor(scene, run->cancel, NULL);
    case SWEEP_STEPS:
        return (double)run->steps;
    case SWEEP_EVALS:
        return (double)run->cost.evals;
    case SWEEP_OBSERVABLE:
        return run_observable(run, measure->observable);
    default:
        return sweep_measured(measure, &run->system, run->t, run->y);
    }
}

/* Returns true if all measures are attractors, which are found without the run. */
static bool needs_no_run(const struct sweep_request *request)
{
    bool none = true;
    for (int m = 0; m < request->measures; m++)
        none &= request->measure[m].kind == SWEEP_ATTRACTOR;
    return none;
}

/* Returns true if the measure has a value for a run that ended early. */
static bool holds_when_failed(enum sweep_kind kind)
{
    return kind == SWEEP_STEPS || kind == SWEEP_EVALS || kind == SWEEP_REACHED ||
           kind == SWEEP_ATTRACTOR;
}

/* Returns true if what is measured needs the states of the whole run. */
bool sweep_needs_trace(const struct sweep_job *job)
{
    bool needed = job->watches;
    for (int m = 0; m < job->request->measures; m++) {
        const struct sweep_measure *measure = &job->request->measure[m];
        needed |= measure->kind == SWEEP_ERROR;
    }
    return needed;
}

/* Returns true if a measure needs the work done during the run, and so the energy balance. */
static bool needs_work(const struct sweep_job *job)
{
    bool needed = false;
    for (int m = 0; m < job->request->measures; m++) {
        const struct sweep_measure *measure = &job->request->measure[m];
        const bool observes =
            measure->kind == SWEEP_OBSERVABLE || measure->column == SWEEP_OBSERVABLE;
        needed |= measure->kind == SWEEP_ENERGY_ERROR ||
                  (measure->expression && measure->expression->works) ||
                  (observes && measure->observable->needs & NEED_WORK);
    }
    return needed;
}

/* Creates the run of point i, which records all rows only if a measure needs them. Returns NULL if
 * the run is refused, and marks the point as refused. */
struct run *sweep_run(struct sweep_worker *worker, int64_t i)
{
    struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    struct error error = {0};
    struct run *run = NULL;
    if (sweep_point(request, job->sweep, i, &worker->scene, &worker->settings, &error)) {
        struct run_settings settings = worker->settings;
        settings.record = sweep_needs_trace(job)
                              ? (struct recording_rule){.rule = RECORD_AUTO, .every = 1}
                              : (struct recording_rule){.rule = RECORD_EVERY, .every = INT64_MAX};
        settings.unbalanced = !needs_work(job);
        run = run_create(&worker->scene, request->method, &settings, request->duration, &error);
    }
    if (!run)
        sweep_refuse(worker, i, &error);
    return run;
}

/* Advances the run to its end, stores its measures as the results of point i and destroys it.
 * `evals` replaces the counted evaluations unless negative, as for steps that lanes have made. */
void sweep_measure_run(struct sweep_worker *worker, int64_t i, struct run *run, int64_t evals)
{
    struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    const struct run_target target = {
        .t = needs_no_run(request) ? run->system.t0 : run->system.t0 + request->duration,
        .steps = -1};
    struct error ignored;
    sweep_point(request, job->sweep, i, &worker->scene, &worker->settings, &ignored);
    while (run_advance(run, &target, 0, request->cancel)) {
    }
    if (evals >= 0)
        run->cost.evals = evals;
    if (run->stop != STOP_CANCELLED) {
        for (int m = 0; m < request->measures; m++) {
            const struct sweep_measure *measure = &request->measure[m];
            const bool there = run->stop == STOP_END || holds_when_failed(measure->kind);
            sweep_values(worker, i)[m] =
                there ? run_measure(run, measure, &worker->scene, run->system.t0 + job->opens)
                      : NAN;
        }
        sweep_combine(worker, i);
        if (!cancelled(request->cancel)) /* a measure may be incomplete when cancelled */
            job->sweep->status[i] = (signed char)run->stop;
    }
    worker->steps += (double)run->steps;
    run_destroy(run);
}

/* Computes and measures point i by a run of its own. */
void sweep_alone(struct sweep_worker *worker, int64_t i)
{
    if (worker->section) {
        section_alone(worker, i);
        return;
    }
    struct run *run = sweep_run(worker, i);
    if (run)
        sweep_measure_run(worker, i, run, -1);
}

/* Computes the missing points of a task: `block` of at most job->width points along the axis of
 * lanes, in `line` of the other axis. Returns the number of points. */
int64_t sweep_task(struct sweep_worker *worker, int64_t line, int64_t block)
{
    int64_t computed = 0;
    const struct sweep_job *job = worker->job;
    const struct sweep *sweep = job->sweep;
    const int64_t axis_count = sweep->axis[job->lane_axis].count,
                  last = sweep->axes > 1 ? sweep->axis[1].count : 1;
    for (int64_t k = block * job->width; k < axis_count && k < (block + 1) * job->width; k++) {
        int64_t number = k;
        if (sweep->axes > 1)
            number = job->lane_axis == 1 ? line * last + k : k * last + line;
        const int64_t i = number - sweep->first;
        if (i < 0 || i >= sweep->count || sweep->status[i] != SWEEP_MISSING)
            continue;
        if (cancelled(job->request->cancel))
            return computed;
        computed++;
        if (job->in_lanes)
            sweep_gather(worker, i);
        else
            sweep_alone(worker, i);
    }
    if (job->in_lanes && !cancelled(job->request->cancel))
        sweep_flush(worker);
    worker->used = 0;
    return computed;
}
