/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points of a sweep in lanes: gathered until they are as many as there are lanes, stepped and
 * watched side by side. */
#include "study/sweep/sweep.h"

#include <hooke/base/numeric.h>

#include <string.h>

#define SUSPICIOUS 1e100 /* diverging: that goes alone, where it is stopped at the right step */

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

static double lane_measure(const struct sweep_worker *worker, int lane,
                           const struct sweep_measure *measure, const double *y, int64_t steps,
                           int64_t evals)
{
    const struct sweep_job *job = worker->job;
    const struct system *system = &worker->system[lane];
    const double end = system->t0 + job->request->duration;
    if (sweep_watches(measure))
        return watch_value(&worker->watch[lane], measure->kind);
    switch (measure->kind) {
    case SWEEP_STEPS:
        return (double)steps;
    case SWEEP_EVALS:
        return (double)evals;
    case SWEEP_OBSERVABLE:
        return observable_defined(measure->observable, system, false)
                   ? measure->observable->value(
                         &(struct sample){.t = end, .y = y, .system = system})
                   : NAN;
    default:
        return sweep_measured(measure, system, end, y);
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

/* Does a velocity change its sign from one row to the next? */
CLONES static bool any_turns(const double *before, const double *row)
{
    uint64_t turned = 0;
    for (int lane = 0; lane < LANES; lane++) {
        uint64_t a, b;
        memcpy(&a, before + LANES + lane, sizeof a);
        memcpy(&b, row + LANES + lane, sizeof b);
        turned |= a ^ b;
    }
    return turned >> 63;
}

CLONES static void add_areas(double h, const double *restrict before, const double *restrict row,
                             double *restrict area)
{
    for (int lane = 0; lane < LANES; lane++)
        area[lane] +=
            watch_area(h, before[lane], before[LANES + lane], row[lane], row[LANES + lane]);
}

/* One row after another: whose velocity has changed its sign? before: the row before these. */
static void watch_lanes(struct sweep_worker *worker, const double *before, int64_t opening,
                        int64_t first, int64_t count)
{
    const double t0 = worker->system[0].t0, h = worker->job->request->settings.dt;
    const bool ends = first + count == worker->job->whole && worker->job->rest == 0;
    if (ends && worker->system[0].order == 1)
        speeds_at_end(worker, t0 + worker->job->request->duration,
                      worker->row + (2 * count - 1) * LANES);
    for (int64_t i = 0; i < count; i++) {
        const double *row = worker->row + i * 2 * LANES;
        const double from = t0 + (double)(first + i) * h;
        const double to = ends && i == count - 1 ? t0 + worker->job->request->duration
                                                 : t0 + (double)(first + i + 1) * h;
        const bool turns = any_turns(before, row);
        for (int lane = 0; lane < worker->used && turns; lane++)
            if (watch_turns(before[LANES + lane], row[LANES + lane]))
                watch_turn(&worker->watch[lane], from, before[lane], before[LANES + lane], to,
                           row[lane], row[LANES + lane]);
        if (worker->job->means && first >= opening) {
            add_areas(to - from, before, row, worker->area);
            worker->span += to - from;
        }
        before = row;
    }
}

/* The states that have come by, for each lane by itself: so many rows at once fill a line of the
 * cache. */
static void keep_rows(struct sweep_worker *worker, int64_t first, int64_t count)
{
    enum { AT_ONCE = 4 };
    for (int64_t begin = 0; begin < count; begin += AT_ONCE)
        for (int lane = 0; lane < worker->used; lane++) {
            double *kept = worker->replay + (lane * worker->job->whole + first) * 2;
            for (int64_t i = begin; i < count && i < begin + AT_ONCE; i++) {
                kept[2 * i] = worker->row[i * 2 * LANES + lane];
                kept[2 * i + 1] = worker->row[(i * 2 + 1) * LANES + lane];
            }
        }
}

/* The first step at whose end the window is open. */
static int64_t opening_step(const struct sweep_worker *worker)
{
    const double t0 = worker->system[0].t0, h = worker->job->request->settings.dt,
                 opens = t0 + worker->job->opens;
    int64_t i = (int64_t)floor(worker->job->opens / h);
    while (i > 0 && t0 + (double)i * h >= opens)
        i--;
    while (t0 + (double)i * h < opens)
        i++;
    return i < worker->job->whole ? i : worker->job->whole;
}

static int64_t min(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* False: cancelled. */
static bool march(struct sweep_worker *worker)
{
    const struct sweep_job *job = worker->job;
    const int64_t opening = job->watches && !job->replays ? opening_step(worker) : job->whole;
    double before[2 * LANES];
    for (int lane = 0; lane < worker->used; lane++)
        watch_begin(&worker->watch[lane], worker->system[lane].start[0]);
    memset(worker->area, 0, sizeof worker->area);
    worker->span = 0;
    for (int64_t i = 0; i < job->whole;) {
        const bool watching = job->replays || job->tops || (job->watches && i >= opening);
        const int64_t count = min(i < opening ? opening - i : job->whole - i,
                                  watching ? SWEEP_ROWS : 16 * SWEEP_ROWS);
        if (watching)
            lanes_row(worker->lanes, before);
        for (int lane = 0; lane < worker->used && watching && i == opening; lane++)
            watch_open(&worker->watch[lane], before[lane]);
        lanes_march(worker->lanes, count, watching ? worker->row : NULL);
        if (job->replays)
            keep_rows(worker, i, count);
        else if (watching)
            watch_lanes(worker, before, opening, i, count);
        i += count;
        if (cancelled(job->request->cancel))
            return false;
        if (all_suspicious(worker))
            break;
    }
    return true;
}

/* What is measured of a lane that has come to its end. */
static void measure_lane(struct sweep_worker *worker, int lane, const double *y, int64_t steps,
                         int64_t evals)
{
    const struct sweep_request *request = worker->job->request;
    const int64_t i = worker->point[lane];
    for (int m = 0; m < request->measures; m++)
        sweep_values(worker, i)[m] =
            lane_measure(worker, lane, &request->measure[m], y, steps, evals);
    sweep_combine(worker, i);
    worker->job->sweep->status[i] = STOP_END;
    worker->side_by_side++;
    worker->steps += (double)steps;
}

static void finish_lanes(struct sweep_worker *worker)
{
    struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    for (int lane = 0; lane < worker->used; lane++) {
        const int64_t i = worker->point[lane];
        struct extremes *watch = &worker->watch[lane];
        const struct system *system = &worker->system[lane];
        int64_t evals = lanes_evals(worker->lanes, lane);
        double y[LIMIT_VARIABLES], was[LIMIT_VARIABLES];
        lanes_state(worker->lanes, lane, y);
        memcpy(was, y, sizeof y);
        if (suspicious(y, system->n) || (job->rest != 0 && !finish_lane(worker, lane, y, &evals))) {
            sweep_alone(worker, i);
            continue;
        }
        if (job->replays) {
            sweep_replay(worker, i, worker->replay + lane * job->whole * 2, evals);
            worker->side_by_side++;
            continue;
        }
        if (job->watches) {
            const double from = system->t0 + (double)job->whole * request->settings.dt,
                         end = system->t0 + request->duration;
            if (!watch->open && (job->rest == 0 ? end : from) >= system->t0 + job->opens)
                watch_open(watch, was[0]);
            const double speed0 = watch_speed(system, 0, from, was),
                         speed1 = watch_speed(system, 0, end, y);
            if (job->rest != 0 && watch_turns(speed0, speed1))
                watch_turn(watch, from, was[0], speed0, end, y[0], speed1);
            watch->area = worker->area[lane];
            watch->span = worker->span;
            if (!watch->open) {
                watch_open(watch, y[0]);
            } else if (job->rest != 0) {
                watch->area += watch_area(end - from, was[0], speed0, y[0], speed1);
                watch->span += end - from;
            }
            watch_end(watch, y[0]);
        }
        measure_lane(worker, lane, y, job->whole + (job->rest != 0), evals);
    }
}

/* ---- steps whose size follows the error ---- */

struct adaptive_watch {
    double open[LANES], span[LANES]; /* has the window begun? how long it is [s] */
    int closed;                      /* windows that have not */
};

CLONES static void add_own_areas(const double *restrict before, const double *restrict row,
                                 const double *restrict open, double *restrict area,
                                 double *restrict span)
{
    for (int lane = 0; lane < LANES; lane++) {
        const double h = row[lane] - before[lane];
        const double more = watch_area(h, before[LANES + lane], before[2 * LANES + lane],
                                       row[LANES + lane], row[2 * LANES + lane]);
        area[lane] += open[lane] != 0 ? more : 0;
        span[lane] += open[lane] != 0 ? h : 0;
    }
}

/* Rows of t, y, v after attempts; before: the row before these. */
static void watch_attempts(struct sweep_worker *worker, const double *before, int64_t count,
                           struct adaptive_watch *of)
{
    const double opens = worker->system[0].t0 + worker->job->opens;
    const double *row = worker->row;
    for (int64_t i = 0; i < count; i++, before = row, row += 3 * LANES) {
        const bool turns = any_turns(before + LANES, row + LANES);
        for (int lane = 0; lane < worker->used && turns; lane++)
            if (watch_turns(before[2 * LANES + lane], row[2 * LANES + lane]))
                watch_turn(&worker->watch[lane], before[lane], before[LANES + lane],
                           before[2 * LANES + lane], row[lane], row[LANES + lane],
                           row[2 * LANES + lane]);
        if (worker->job->means)
            add_own_areas(before, row, of->open, worker->area, of->span);
        for (int lane = 0; lane < worker->used && of->closed > 0; lane++)
            if (of->open[lane] == 0 && row[lane] >= opens) {
                watch_open(&worker->watch[lane], row[LANES + lane]);
                of->open[lane] = 1;
                of->closed--;
            }
    }
}

/* False: cancelled. */
static bool march_adaptive(struct sweep_worker *worker, struct adaptive_watch *of)
{
    const struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    const double t0 = worker->system[0].t0;
    double before[3 * LANES] = {0};
    *of = (struct adaptive_watch){.closed = worker->used};
    memset(worker->area, 0, sizeof worker->area);
    for (int lane = 0; lane < worker->used; lane++) {
        const double *start = worker->system[lane].start;
        watch_begin(&worker->watch[lane], start[0]);
        before[lane] = t0;
        before[LANES + lane] = start[0];
        before[2 * LANES + lane] = start[1];
    }
    lanes_control(worker->lanes, worker->used, worker->tol, t0 + request->duration, RUN_CREEP);
    lanes_adapted_row(worker->lanes, worker->row);
    for (int64_t count = 1, more = 1; more; count = SWEEP_ROWS) {
        if (count > 1)
            more = lanes_adapt(worker->lanes, count, job->watches ? worker->row : NULL);
        if (job->watches) {
            watch_attempts(worker, before, count, of);
            memcpy(before, worker->row + 3 * (count - 1) * LANES, sizeof before);
        }
        if (cancelled(request->cancel))
            return false;
    }
    return true;
}

static void finish_adaptive(struct sweep_worker *worker, const struct adaptive_watch *of)
{
    for (int lane = 0; lane < worker->used; lane++) {
        struct extremes *watch = &worker->watch[lane];
        int64_t steps, evals;
        double y[LIMIT_VARIABLES];
        lanes_state(worker->lanes, lane, y);
        if (!lanes_adapted(worker->lanes, lane, &steps, &evals) ||
            suspicious(y, worker->system[lane].n) ||
            (worker->job->watches && steps >= LIMIT_SAMPLES - 1)) {
            sweep_alone(worker, worker->point[lane]);
            continue;
        }
        watch->area = worker->area[lane];
        watch->span = of->span[lane];
        watch_end(watch, y[0]);
        measure_lane(worker, lane, y, steps, evals);
    }
}

/* So many points take less time alone, as measured: forces of oscillators fill a vector, sines go
 * one by one, who steps by its own control waits for the slowest. */
static int few(const struct sweep_worker *worker)
{
    const struct model *model = worker->system[0].model;
    const int points = model->typed ? 5 : model == &oscillator_model ? SWEEP_FEW : 20;
    return worker->job->adapts && points < SWEEP_FEW_ADAPTIVE ? SWEEP_FEW_ADAPTIVE : points;
}

void sweep_flush(struct sweep_worker *worker)
{
    const struct sweep_request *request = worker->job->request;
    const struct system *first = &worker->system[0];
    if (worker->used == 0)
        return;
    const bool begun =
        worker->used > few(worker) &&
        lanes_begin(worker->lanes, request->method, worker->drag, first, request->settings.dt);
    for (int lane = 0; begun && lane < LANES; lane++)
        lanes_set(worker->lanes, lane,
                  &worker->system[lane < worker->used ? lane : worker->used - 1]);
    for (int lane = 0; !begun && lane < worker->used; lane++) /* few, or no memory */
        sweep_alone(worker, worker->point[lane]);
    struct adaptive_watch adaptive;
    if (begun && worker->section)
        section_march(worker);
    else if (begun && worker->job->adapts && march_adaptive(worker, &adaptive))
        finish_adaptive(worker, &adaptive);
    else if (begun && !worker->job->adapts && march(worker))
        finish_lanes(worker);
    worker->used = 0;
}

/* The potential of typed forces is looked for only where somebody asks for an energy. */
static bool bind_point(const struct sweep_request *request, const struct scene *scene,
                       struct system *system, struct error *error)
{
    bool energy = request->method->flags & METHOD_POTENTIAL;
    for (int m = 0; m < request->measures; m++)
        energy |= request->measure[m].kind == SWEEP_OBSERVABLE &&
                  request->measure[m].observable->needs & NEED_ENERGY;
    return energy ? scene_bind(scene, system, error) : scene_bind_motion(scene, system, error);
}

bool sweep_lanes_fit(const struct sweep_job *job, const struct system *system, enum drag drag)
{
    const struct sweep_request *request = job->request;
    return (job->adapts ? lanes_adapt_fit : lanes_fit)(request->method, system, drag,
                                                       request->settings.dt);
}

void sweep_gather(struct sweep_worker *worker, int64_t i)
{
    struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    const double h = request->settings.dt;
    struct error error = {0};
    struct system *system = &worker->system[worker->used];
    enum drag drag = request->settings.drag;
    if (!sweep_point(request, job->sweep, i, &worker->scene, &worker->settings, &error) ||
        !bind_point(request, &worker->scene, system, &error) ||
        !method_applies(request->method, system, &drag, &error) ||
        (!job->adapts && !method_fits(request->method, system, drag, h, &error))) {
        sweep_refuse(worker, i, &error);
        return;
    }
    const double tol = worker->settings.tol; /* which points that go alone change */
    if (!sweep_lanes_fit(job, system, drag)) {
        sweep_alone(worker, i);
        return;
    }
    if (worker->used > 0 && (drag != worker->drag || !lanes_alike(&worker->system[0], system))) {
        const struct system next = *system;
        sweep_flush(worker);
        worker->system[0] = next;
    }
    worker->drag = drag;
    worker->tol[worker->used] = tol;
    worker->point[worker->used++] = i;
    if (worker->used == LANES)
        sweep_flush(worker);
}
