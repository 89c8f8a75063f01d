/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The points of a sweep: in lanes where the method and the scene allow it, else as a run of its own. The same bits. */
#include "sweep.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = 64 }; /* steps between looks at what the lanes do */

#define SUSPICIOUS 1e100 /* diverging: that goes alone, where it is stopped at the right step */

void sweep_common(const struct sweep_request *request, struct scene *scene, struct run_settings *settings)
{
    *scene = *request->scene;
    *settings = request->settings;
    if (settings->kernel == KERNEL_PROPAGATOR) /* whose last bits are others than those of lanes */
        settings->kernel = KERNEL_SPECIALISED;
}

bool sweep_worker_init(struct sweep_worker *worker, struct sweep_job *job)
{
    *worker = (struct sweep_worker){.job = job, .refused = -1};
    sweep_common(job->request, &worker->scene, &worker->settings);
    worker->system = malloc((job->in_lanes ? LANES : 1) * sizeof *worker->system);
    if (job->in_lanes) {
        worker->lanes = lanes_create();
        worker->row = malloc((size_t)ROWS * 2 * LANES * sizeof *worker->row);
        worker->work = malloc(method_work_size(job->request->method, job->request->scene->model->n) * sizeof *worker->work);
    }
    if (worker->system && (!job->in_lanes || (worker->lanes && worker->row && worker->work)))
        return true;
    sweep_worker_free(worker);
    return false;
}

void sweep_worker_free(struct sweep_worker *worker)
{
    free(worker->system);
    free(worker->row);
    free(worker->work);
    lanes_destroy(worker->lanes);
}

static bool set_axis(const struct sweep_axis *axis, double value, struct scene *scene, struct run_settings *settings,
                     struct error *error)
{
    const struct catalog *derived = scene_derived(scene);
    switch (axis->target) {
    case SWEEP_PARAM:
        return scene_set(scene, axis->place, (struct measured){value, 0}, error);
    case SWEEP_DERIVED:
        return scene_set_derived(scene, (const struct derived_row *)(const void *)catalog_row(derived, (size_t)axis->place),
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

bool sweep_point(const struct sweep_request *request, const struct sweep *sweep, int64_t i, struct scene *scene,
                 struct run_settings *settings, struct error *error)
{
    memcpy(scene->value, request->scene->value, scene_params(scene)->count * sizeof *scene->value);
    for (int a = 0; a < request->axes; a++)
        if (!set_axis(&request->axis[a], sweep_axis_value(&request->axis[a], (int)sweep_number(sweep, a, i)), scene,
                      settings, error))
            return false;
    return true;
}

static void refuse(struct sweep_worker *worker, int64_t i, const struct error *error)
{
    worker->job->sweep->status[i] = SWEEP_REFUSED;
    if (worker->refused >= 0 && worker->refused < i)
        return;
    worker->refused = i;
    snprintf(worker->reason, sizeof worker->reason, "%s", error->text);
}

static double *values_of(const struct sweep_worker *worker, int64_t i)
{
    return worker->job->sweep->value + i * worker->job->sweep->measures;
}

/* ---- alone ---- */

static double run_measure(const struct run *run, const struct sweep_measure *measure, double opens)
{
    struct run_errors errors;
    struct ledger ledger;
    switch (measure->kind) {
    case SWEEP_AMPLITUDE:
    case SWEEP_PERIOD:
    case SWEEP_MEAN:
    case SWEEP_MAX:
    case SWEEP_MIN:
        return watch_run(run, measure, opens);
    case SWEEP_ERROR:
        run_errors(run, &errors);
        return errors.max;
    case SWEEP_ENERGY_ERROR:
        run_ledger(run, &ledger);
        return ledger.error_max;
    case SWEEP_STEPS:
        return (double)run->steps;
    case SWEEP_EVALS:
        return (double)run->cost.evals;
    case SWEEP_REACHED:
        return run->t;
    case SWEEP_VARIABLE:
        return run->y[measure->variable];
    case SWEEP_OBSERVED:
        return system_observe(&run->system, measure->variable, run->t, run->y);
    case SWEEP_OBSERVABLE:
        return run_observable(run, measure->observable);
    }
    return NAN;
}

static bool holds_when_failed(enum sweep_kind kind)
{
    return kind == SWEEP_STEPS || kind == SWEEP_EVALS || kind == SWEEP_REACHED;
}

/* Does what is measured need the states on the way? */
static bool needs_trace(const struct sweep_job *job)
{
    bool needed = job->watches;
    for (int m = 0; m < job->request->measures; m++) {
        const struct sweep_measure *measure = &job->request->measure[m];
        needed |= measure->kind == SWEEP_ERROR || measure->kind == SWEEP_ENERGY_ERROR ||
                  (measure->kind == SWEEP_OBSERVABLE && measure->observable->needs & NEED_WORK);
    }
    return needed;
}

static void go_alone(struct sweep_worker *worker, int64_t i)
{
    struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    struct error error = {0};
    struct run *run = NULL;
    if (sweep_point(request, job->sweep, i, &worker->scene, &worker->settings, &error)) {
        struct run_settings settings = worker->settings;
        settings.record =
            needs_trace(job) ? (struct recording_rule){RECORD_AUTO, 1} : (struct recording_rule){RECORD_EVERY, INT64_MAX};
        run = run_create(&worker->scene, request->method, &settings, request->duration, &error);
    }
    if (!run) {
        refuse(worker, i, &error);
        return;
    }
    const struct run_target target = {.t = run->system.t0 + request->duration, .steps = -1};
    while (run_advance(run, &target, 0, request->cancel)) {
    }
    if (run->stop != STOP_CANCELLED) {
        for (int m = 0; m < request->measures; m++) {
            const struct sweep_measure *measure = &request->measure[m];
            const bool there = run->stop == STOP_END || holds_when_failed(measure->kind);
            values_of(worker, i)[m] = there ? run_measure(run, measure, run->system.t0 + job->opens) : NAN;
        }
        job->sweep->status[i] = (signed char)run->stop;
    }
    worker->steps += (double)run->steps;
    run_destroy(run);
}

/* ---- in lanes ---- */

/* The last, shorter step, as a run takes it. */
static bool finish_lane(const struct sweep_worker *worker, int lane, double *y, int64_t *evals)
{
    const struct sweep_job *job = worker->job;
    const struct system *system = &worker->system[lane];
    const struct method *method = job->request->method;
    const double h = job->request->settings.dt;
    struct step step = {.system = system,
                        .drag = worker->drag,
                        .t = system->t0 + (double)job->whole * h,
                        .h = job->rest,
                        .y = y,
                        .work = worker->work};
    const bool ok = method_turning_step(method, &step) == STEP_OK;
    *evals += step.cost.evals;
    return ok;
}

static double lane_measure(const struct sweep_worker *worker, int lane, const struct sweep_measure *measure,
                           const double *y, int64_t evals)
{
    const struct sweep_job *job = worker->job;
    const struct system *system = &worker->system[lane];
    const double end = system->t0 + job->request->duration;
    if (sweep_watches(measure))
        return watch_value(&worker->watch[lane], measure->kind);
    switch (measure->kind) {
    case SWEEP_STEPS:
        return (double)(job->whole + (job->rest != 0));
    case SWEEP_EVALS:
        return (double)evals;
    case SWEEP_REACHED:
        return end;
    case SWEEP_VARIABLE:
        return y[measure->variable];
    case SWEEP_OBSERVED:
        return system_observe(system, measure->variable, end, y);
    case SWEEP_OBSERVABLE:
        return measure->observable->value(&(struct sample){.t = end, .y = y, .system = system});
    default:
        return NAN;
    }
}

static bool suspicious(const double *y, int n)
{
    for (int i = 0; i < n; i++)
        if (!(fabs(y[i]) <= SUSPICIOUS))
            return true;
    return false;
}

static bool all_suspicious(const struct sweep_worker *worker)
{
    double y[LIMIT_VARIABLES];
    for (int lane = 0; lane < LANES; lane++) {
        lanes_state(worker->lanes, lane, y);
        if (!suspicious(y, worker->system[0].n))
            return false;
    }
    return true;
}

/* The speeds at the end of the last step, whose time is the end's own. */
static void speeds_at_end(const struct sweep_worker *worker, double end, double *speeds)
{
    double y[LIMIT_VARIABLES];
    for (int lane = 0; lane < worker->used; lane++) {
        lanes_state(worker->lanes, lane, y);
        speeds[lane] = watch_speed(&worker->system[lane], 0, end, y);
    }
}

/* One row after another: whose velocity has changed its sign? before: the row before these. */
static void watch_lanes(struct sweep_worker *worker, const double *before, int64_t first, int64_t count)
{
    const double t0 = worker->system[0].t0, h = worker->job->request->settings.dt;
    const bool ends = first + count == worker->job->whole && worker->job->rest == 0;
    if (ends && worker->system[0].order == 1)
        speeds_at_end(worker, t0 + worker->job->request->duration, worker->row + (2 * count - 1) * LANES);
    for (int64_t i = 0; i < count; i++) {
        const double *row = worker->row + i * 2 * LANES;
        uint64_t turned = 0;
        for (int lane = 0; lane < LANES; lane++) {
            uint64_t a, b;
            memcpy(&a, before + LANES + lane, sizeof a);
            memcpy(&b, row + LANES + lane, sizeof b);
            turned |= a ^ b;
        }
        const double from = t0 + (double)(first + i) * h;
        const double to = ends && i == count - 1 ? t0 + worker->job->request->duration : t0 + (double)(first + i + 1) * h;
        for (int lane = 0; lane < worker->used && turned >> 63; lane++)
            if (watch_turns(before[LANES + lane], row[LANES + lane]))
                watch_turn(&worker->watch[lane], from, before[lane], before[LANES + lane], to, row[lane],
                           row[LANES + lane]);
        before = row;
    }
}

/* The first step at whose end the window is open. */
static int64_t opening_step(const struct sweep_worker *worker)
{
    const double t0 = worker->system[0].t0, h = worker->job->request->settings.dt, opens = t0 + worker->job->opens;
    int64_t i = (int64_t)floor(worker->job->opens / h);
    while (i > 0 && t0 + (double)i * h >= opens)
        i--;
    while (t0 + (double)i * h < opens)
        i++;
    return i < worker->job->whole ? i : worker->job->whole;
}

static int64_t least(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* False: cancelled. */
static bool march(struct sweep_worker *worker)
{
    const struct sweep_job *job = worker->job;
    const int64_t opening = job->watches ? opening_step(worker) : job->whole;
    double before[2 * LANES];
    for (int lane = 0; lane < worker->used; lane++)
        watch_begin(&worker->watch[lane], worker->system[lane].start[0]);
    for (int64_t i = 0; i < job->whole;) {
        const bool watching = job->tops || (job->watches && i >= opening);
        const int64_t count = least(i < opening ? opening - i : job->whole - i, watching ? ROWS : 16 * ROWS);
        if (watching)
            lanes_row(worker->lanes, before);
        for (int lane = 0; lane < worker->used && watching && i == opening; lane++)
            watch_open(&worker->watch[lane], before[lane]);
        lanes_march(worker->lanes, count, watching ? worker->row : NULL);
        if (watching)
            watch_lanes(worker, before, i, count);
        i += count;
        if (cancelled(job->request->cancel))
            return false;
        if (all_suspicious(worker))
            break;
    }
    return true;
}

static void finish_lanes(struct sweep_worker *worker)
{
    struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    for (int lane = 0; lane < worker->used; lane++) {
        const int64_t i = worker->point[lane];
        struct watch *watch = &worker->watch[lane];
        const struct system *system = &worker->system[lane];
        int64_t evals = lanes_evals(worker->lanes, lane);
        double y[LIMIT_VARIABLES], was[LIMIT_VARIABLES];
        lanes_state(worker->lanes, lane, y);
        memcpy(was, y, sizeof y);
        if (suspicious(y, system->n) || (job->rest != 0 && !finish_lane(worker, lane, y, &evals))) {
            go_alone(worker, i);
            continue;
        }
        if (job->watches) {
            const double from = system->t0 + (double)job->whole * request->settings.dt,
                         end = system->t0 + request->duration;
            if (!watch->open && (job->rest == 0 ? end : from) >= system->t0 + job->opens)
                watch_open(watch, was[0]);
            const double speed0 = watch_speed(system, 0, from, was), speed1 = watch_speed(system, 0, end, y);
            if (job->rest != 0 && watch_turns(speed0, speed1))
                watch_turn(watch, from, was[0], speed0, end, y[0], speed1);
            if (!watch->open)
                watch_open(watch, y[0]);
            watch_end(watch, y[0]);
        }
        for (int m = 0; m < request->measures; m++)
            values_of(worker, i)[m] = lane_measure(worker, lane, &request->measure[m], y, evals);
        job->sweep->status[i] = STOP_END;
        worker->side_by_side++;
        worker->steps += (double)(job->whole + (job->rest != 0));
    }
}

/* What has been gathered goes. */
static void flush(struct sweep_worker *worker)
{
    const struct sweep_request *request = worker->job->request;
    if (worker->used == 0)
        return;
    const bool begun =
        lanes_begin(worker->lanes, request->method, worker->drag, &worker->system[0], request->settings.dt);
    for (int lane = 0; begun && lane < LANES; lane++)
        lanes_set(worker->lanes, lane, &worker->system[lane < worker->used ? lane : worker->used - 1]);
    for (int lane = 0; !begun && lane < worker->used; lane++) /* no memory */
        go_alone(worker, worker->point[lane]);
    if (begun && march(worker))
        finish_lanes(worker);
    worker->used = 0;
}

static void gather(struct sweep_worker *worker, int64_t i)
{
    struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    const double h = request->settings.dt;
    struct error error = {0};
    struct system *system = &worker->system[worker->used];
    enum drag drag = request->settings.drag;
    if (!sweep_point(request, job->sweep, i, &worker->scene, &worker->settings, &error) ||
        !scene_bind(&worker->scene, system, &error) || !method_applies(request->method, system, &drag, &error) ||
        !method_fits(request->method, system, drag, h, &error)) {
        refuse(worker, i, &error);
        return;
    }
    if (!lanes_fit(request->method, system, drag, h)) {
        go_alone(worker, i);
        return;
    }
    if (worker->used > 0 && (drag != worker->drag || !lanes_alike(&worker->system[0], system))) {
        const struct system next = *system;
        flush(worker);
        worker->system[0] = next;
    }
    worker->drag = drag;
    worker->point[worker->used++] = i;
    if (worker->used == LANES)
        flush(worker);
}

void sweep_task(struct sweep_worker *worker, int64_t line, int64_t block)
{
    const struct sweep_job *job = worker->job;
    const struct sweep *sweep = job->sweep;
    const int64_t along = sweep->axis[job->along].count, last = sweep->axes > 1 ? sweep->axis[1].count : 1;
    for (int64_t k = block * LANES; k < along && k < (block + 1) * LANES; k++) {
        const int64_t number = sweep->axes < 2 ? k : job->along == 1 ? line * last + k : k * last + line;
        const int64_t i = number - sweep->first;
        if (i < 0 || i >= sweep->count)
            continue;
        if (cancelled(job->request->cancel))
            return;
        if (job->in_lanes)
            gather(worker, i);
        else
            go_alone(worker, i);
    }
    if (job->in_lanes && !cancelled(job->request->cancel))
        flush(worker);
    worker->used = 0;
}
