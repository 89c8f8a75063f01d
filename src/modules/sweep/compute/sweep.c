/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Computes a sweep with several threads. Points are gathered into tasks of up to LANE_COUNT
 * neighbours. Each result has its own place, so that nothing depends on which thread computes what.
 * Only results are kept, not runs. */
#include "modules/sweep/compute/worker.h"
#include <hooke/base/cancel.h>
#include <hooke/run/parallel.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define RESULTS_MAX ((size_t)1 << 30) /* [byte] */

/* Returns the number on the axis of point i of the sweep. */
int64_t sweep_number(const struct sweep *sweep, int axis, int64_t i)
{
    const int64_t number = sweep->first + i;
    if (sweep->axes < 2) /* avoids a slow division */
        return axis == 0 ? number : 0;
    return axis == 0 ? number / sweep->axis[1].count : number % sweep->axis[1].count;
}

const char *sweep_status_name(int status)
{
    if (status == SWEEP_MISSING)
        return "missing";
    return status == SWEEP_REFUSED ? "refused" : stop_name((enum stop)status);
}

void sweep_free(struct sweep *sweep)
{
    free(sweep->value);
    free(sweep->status);
    sweep->value = NULL;
    sweep->status = NULL;
}

#define CELL_MOST 64       /* largest number of points in a cell */
#define PROGRESS_CELLS 128 /* smallest number of cells of a sweep with more points */

/* Returns the number of points of a cell; the last of `total` points may have fewer. */
int64_t sweep_cell(int64_t total)
{
    const int64_t cell = total / PROGRESS_CELLS;
    if (cell < 1)
        return 1;
    return cell < CELL_MOST ? cell : CELL_MOST;
}

/* Returns the number of the first point of a shard, counted from 0, or of the end if it is the
 * number of shards. Multiplies in double, as cells * shards may exceed an int64_t. */
static int64_t shard_begin(const struct sweep_request *request, int64_t total, int64_t shard)
{
    const int64_t cell = sweep_cell(total), cells = (total + cell - 1) / cell,
                  begin = shard == request->shards
                              ? cells
                              : (int64_t)floor((double)cells *
                                               ((double)shard / (double)request->shards));
    return begin * cell < total ? begin * cell : total;
}

/* Sets axes, number of results per point, total, first and count of the sweep to the points that
 * the request asks for: all, those of its shard, or request->count points from request->first on.
 * Results are not allocated. */
void study_sweep_stretch(const struct sweep_request *request, struct sweep *sweep)
{
    const struct sweep_section *section = &request->section;
    *sweep = (struct sweep){.axes = request->axes, .measures = request->measures, .total = 1};
    if (request->columns > 0)
        sweep->measures = request->columns;
    if (section->wanted)
        sweep->measures = 1 + (int)section->keep * (1 + request->measures);
    for (int a = 0; a < request->axes; a++) {
        sweep->axis[a] = request->axis[a];
        sweep->total *= request->axis[a].count;
    }
    sweep->first = shard_begin(request, sweep->total, request->shard - 1);
    sweep->count = shard_begin(request, sweep->total, request->shard) - sweep->first;
    if (request->count > 0) {
        sweep->first = request->first;
        sweep->count = request->count;
    }
}

/* Allocates results, with all points missing. Returns false with an error if they are too large, if
 * out of memory, or if cancelled. */
static bool results_create(struct sweep *sweep, const struct cancel *cancel, struct error *error)
{
    const double bytes = (double)sweep->count * ((double)sweep->measures * sizeof(double) + 1);
    if (bytes > (double)RESULTS_MAX) {
        error_set(error, ERROR_COMMAND,
                  "%lld points with %d result%s each need %.3g bytes; the limit is %zu",
                  (long long)sweep->count, sweep->measures, sweep->measures > 1 ? "s" : "", bytes,
                  RESULTS_MAX);
        return error_hint(error, "use fewer points, or a part: --shard 1/%.0f",
                          ceil(bytes / (double)RESULTS_MAX));
    }
    const size_t n = (size_t)sweep->count;
    sweep->value = malloc((n * (size_t)sweep->measures + 1) * sizeof *sweep->value);
    sweep->status = malloc(n + 1);
    if (!sweep->value || !sweep->status)
        return error_memory(error);
    for (size_t i = 0; i < n * (size_t)sweep->measures; i++) {
        if (cancelled_at(cancel, i))
            return error_set(error, ERROR_CANCELLED, "stopped: 0 of %lld points finished",
                             (long long)sweep->count);
        sweep->value[i] = NAN;
    }
    for (size_t i = 0; i < n; i++)
        sweep->status[i] = SWEEP_MISSING;
    return true;
}

/* Copies status and results of the points that are finished in `previous`, whose first point may be
 * another one. */
static void copy_finished(const struct sweep *previous, struct sweep *sweep)
{
    const int64_t shift = sweep->first - previous->first;
    for (int64_t i = 0; i < sweep->count; i++) {
        const int64_t k = i + shift;
        if (k < 0 || k >= previous->count)
            continue;
        sweep->status[i] = previous->status[k];
        memcpy(sweep->value + i * sweep->measures, previous->value + k * sweep->measures,
               (size_t)sweep->measures * sizeof *sweep->value);
    }
    memcpy(sweep->reason, previous->reason, sizeof sweep->reason);
}

/* Returns true if lanes can provide this measure: they show only the first variable and its
 * velocity. */
static bool lane_measures(const struct sweep_measure *measure)
{
    if (sweep_watches(measure))
        return measure->column == SWEEP_VARIABLE && measure->variable == 0;
    return measure->kind != SWEEP_ERROR && measure->kind != SWEEP_ATTRACTOR &&
           measure->kind != SWEEP_ENERGY_ERROR &&
           (measure->kind != SWEEP_OBSERVABLE ||
            !(measure->observable->needs &
              ~(unsigned)(NEED_MECHANICS | NEED_LINE | NEED_POWER | NEED_ENERGY)));
}

/* Binds the scene of point `number` of the whole sweep. Returns false if it is refused. */
static bool bind_end(const struct sweep_request *request, const struct sweep *sweep, int64_t number,
                     struct system *system)
{
    struct scene scene;
    struct run_settings settings;
    struct error ignored = {0};
    sweep_common(request, &scene, &settings);
    return sweep_point(request, sweep, number - sweep->first, &scene, &settings, &ignored) &&
           scene_bind(&scene, system, &ignored);
}

/* Returns true if points along the axis step at different times. */
static bool sets_clock(const struct sweep_axis *axis)
{
    return axis->target == SWEEP_DT || text_is(text_of(axis->name), "t0");
}

/* Returns true if the drive, or the times of steps, at the `end` point of an axis differ from those
 * of point 0. */
static bool changes_drive(const struct sweep_request *request, const struct sweep *sweep, int axis,
                          int64_t end)
{
    struct system *a = malloc(sizeof *a), *b = malloc(sizeof *b);
    const bool differs =
        sets_clock(&request->axis[axis]) ||
        (a && b && bind_end(request, sweep, 0, a) && bind_end(request, sweep, end, b) &&
         (a->oscillator.omega != b->oscillator.omega ||
          a->oscillator.phase != b->oscillator.phase));
    free(a);
    free(b);
    return differs;
}

/* Returns the axis along which lanes lie: the one that leaves the drive unchanged, as what depends
 * on time alone is then computed once for many lanes; otherwise the longer one. */
static int choose_along(const struct sweep_request *request, const struct sweep *sweep)
{
    if (request->axes < 2)
        return 0;
    const int count[] = {request->axis[0].count, request->axis[1].count},
              longer = count[0] <= count[1];
    const bool first = changes_drive(request, sweep, 0, (int64_t)(count[0] - 1) * count[1]);
    const bool second = changes_drive(request, sweep, 1, count[1] - 1);
    return first == second || count[first] <= SWEEP_FEW ? longer : first;
}

static int thread_count(const struct sweep_request *request, int64_t tasks)
{
    return parallel_threads(&(struct parallel){.threads = request->threads}, tasks);
}

/* Returns true if points can run in lanes. Tries one at the begin, middle and end of the sweep, as
 * a point at an end may lack a force (F0 = 0) that all others have. */
static bool can_use_lanes(const struct sweep_job *job)
{
    const struct sweep_request *request = job->request;
    const struct sweep *sweep = job->sweep;
    struct system *system = malloc(sizeof *system);
    const int64_t number[] = {sweep->first, sweep->first + sweep->count / 2,
                              sweep->first + sweep->count - 1};
    bool go = false;
    for (size_t i = 0; system && !go && i < COUNT_OF(number); i++) {
        struct error ignored = {0};
        enum drag drag = request->settings.drag;
        go = bind_end(request, sweep, number[i], system) &&
             method_applies(request->method, system, &drag, &ignored) &&
             sweep_lanes_fit(job, system, drag);
    }
    free(system);
    return go;
}

/* Divides the points of this sweep into tasks: chooses the axis along which points share lanes, and
 * sets the numbers of lines and blocks and the points per block (width). */
static void divide_tasks(struct sweep_job *job)
{
    const struct sweep_request *request = job->request;
    const struct sweep *sweep = job->sweep;
    const int64_t last = request->axes > 1 ? request->axis[1].count : 1, row = sweep->first / last,
                  rows = (sweep->first + sweep->count - 1) / last - row + 1;
    job->lane_axis = choose_along(request, sweep);
    if (job->lane_axis == 0 && request->axes > 1 && rows < LANE_COUNT &&
        rows < request->axis[0].count)
        job->lane_axis = 1; /* this shard has too few rows to fill lanes */
    if (sweep->count == 0) {
        job->lines = job->blocks = job->width = 1; /* nothing to do */
        return;
    }
    job->width = job->in_lanes && can_use_lanes(job) ? LANE_COUNT : 1;
    if (job->lane_axis == 0) {
        job->lines = last;
        job->block = row / job->width;
        job->blocks = (row + rows - 1) / job->width - job->block + 1;
        return;
    }
    const int64_t first_column = rows > 1 ? 0 : sweep->first % last;
    const int64_t last_column = rows > 1 ? last - 1 : (sweep->first + sweep->count - 1) % last;
    job->line = row;
    job->lines = rows;
    job->block = first_column / job->width;
    job->blocks = last_column / job->width - job->block + 1;
}

/* Decides whether points run in lanes and how their measures are obtained there: watched while
 * stepping, or replayed to runs. Plans one point in *plan; its numbers are NAN if it cannot be
 * planned. */
static void choose_lanes(struct sweep_job *job, struct plan *plan)
{
    const struct sweep_request *request = job->request;
    const struct run_settings *settings = &request->settings;
    struct system *system = malloc(sizeof *system);
    struct error ignored = {0};
    *plan = (struct plan){.steps = NAN, .seconds = NAN};
    const bool planned =
        system && bind_end(request, job->sweep, job->sweep->first, system) &&
        plan_make(system, request->method, settings, request->duration, plan, &ignored);
    bool possible = planned && !settings->compensated && settings->kernel != KERNEL_GENERAL;
    bool starts = false; /* starts at other times */
    for (int a = 0; a < request->axes; a++) {
        job->clocks |= sets_clock(&request->axis[a]);
        starts |= sets_clock(&request->axis[a]) && request->axis[a].target != SWEEP_DT;
    }
    for (int m = 0; m < request->measures; m++) {
        job->replays |= !lane_measures(&request->measure[m]);
        /* attractors take long by themselves */
        possible &= request->measure[m].kind != SWEEP_ATTRACTOR;
    }
    if (job->replays) /* only position and velocity of a lane can be replayed */
        possible = possible && system->order == 2 && system->n == 2 && !request->section.wanted &&
                   (job->clocks || (plan->whole > 0 &&
                                    (!sweep_needs_trace(job) || plan->whole <= SWEEP_REPLAYED)));
    job->adapts = planned && plan->adaptive;
    possible = possible && !(job->clocks && request->section.wanted) && !(job->adapts && starts) &&
               (job->adapts ? !job->replays && !request->section.wanted
                            : job->clocks || !job->watches || plan->steps <= LIMIT_SAMPLES);
    free(system);
    job->in_lanes = possible;
    job->replays &= possible;
    if (possible) {
        job->whole = plan->whole;
        job->rest = plan->partial;
        job->in_pieces = job->replays && !sweep_needs_trace(job) &&
                         (job->clocks || plan->whole > SWEEP_REPLAYED);
        job->room = job->clocks || job->in_pieces ? SWEEP_REPLAYED : plan->whole;
    }
}

/* ---- threads ---- */

/* Computes a task on a thread. */
static void compute_task(void *context, int thread, int64_t task)
{
    struct sweep_job *job = context;
    const int64_t computed = sweep_task(&job->worker[thread], job->line + task / job->blocks,
                                        job->block + task % job->blocks);
    atomic_fetch_add(&job->computed, computed);
}

/* Reports the fraction of computed points. Those that were finished before do not count. */
static void report_points(void *context, double fraction)
{
    (void)fraction;
    struct sweep_job *job = context;
    const struct sweep_request *request = job->request;
    if (request->progress)
        request->progress(request->context, (double)atomic_load(&job->computed) /
                                                (double)(job->missing > 0 ? job->missing : 1));
}

/* Adds the counts of `count` workers and the numbers of finished, refused and failed points to the
 * sweep. Sets sweep->reason to the reason of the first refused point, unless it is already that of
 * an earlier point. */
static void sum_results(struct sweep *sweep, const struct sweep_worker *all, int count)
{
    int64_t refused = -1;
    for (int64_t i = 0; i < sweep->count && refused < 0 && sweep->reason[0]; i++)
        refused = sweep->status[i] == SWEEP_REFUSED ? i : -1;
    for (int i = 0; i < count; i++) {
        const struct sweep_worker *worker = &all[i];
        sweep->steps += worker->steps;
        sweep->side_by_side += worker->side_by_side;
        if (worker->refused >= 0 && (refused < 0 || worker->refused < refused)) {
            refused = worker->refused;
            snprintf(sweep->reason, sizeof sweep->reason, "%s", worker->reason);
        }
    }
    for (int64_t i = 0; i < sweep->count; i++) {
        sweep->finished += sweep->status[i] != SWEEP_MISSING;
        sweep->refused += sweep->status[i] == SWEEP_REFUSED;
        sweep->failed += sweep->status[i] >= 0 && sweep->status[i] != STOP_END;
    }
}

/* Computes all tasks with as many threads as wanted, or as there is memory for. Returns false with
 * an error if there is memory for none. */
static bool run_workers(struct sweep_job *job, struct error *error)
{
    const struct sweep_request *request = job->request;
    struct sweep *sweep = job->sweep;
    const int64_t tasks = job->lines * job->blocks;
    const int count = thread_count(request, tasks);
    int ready = 0;
    for (int64_t i = 0; i < sweep->count; i++)
        job->missing += sweep->status[i] == SWEEP_MISSING;
    job->worker = calloc((size_t)count, sizeof *job->worker);
    while (job->worker && ready < count && sweep_worker_init(&job->worker[ready], job))
        ready++;
    const struct parallel parallel = {.threads = ready,
                                      .cancel = request->cancel,
                                      .progress = report_points,
                                      .progress_context = job,
                                      .work = compute_task,
                                      .context = job};
    if (ready > 0)
        sweep->threads = parallel_do(&parallel, tasks);
    sum_results(sweep, job->worker, ready);
    for (int i = 0; i < ready; i++)
        sweep_worker_free(&job->worker[i]);
    free(job->worker);
    return ready > 0 || error_memory(error);
}

/* Replaces the predicted steps and time by those of a point at a section, which does not last for
 * the duration. */
static void plan_section(const struct sweep_request *request, const struct sweep *sweep,
                         struct plan *plan)
{
    struct system *system = malloc(sizeof *system);
    const double steps = system && bind_end(request, sweep, sweep->first, system)
                             ? section_steps(request, system)
                             : NAN;
    plan->seconds *= steps / plan->steps;
    plan->steps = steps;
    free(system);
}

/* Returns the job of a request: which measures are watched, and whether lanes are used. Also plans
 * one point in *plan. */
static struct sweep_job job_of(const struct sweep_request *request, struct sweep *sweep,
                               struct plan *plan)
{
    struct sweep_job job = {
        .request = request, .sweep = sweep, .opens = request->duration * (2.0 / 3)};
    for (int m = 0; m < request->measures; m++) {
        job.tops |= request->measure[m].kind == SWEEP_MAX || request->measure[m].kind == SWEEP_MIN;
        job.watches |= sweep_watches(&request->measure[m]);
        job.means |= request->measure[m].kind == SWEEP_MEAN;
    }
    choose_lanes(&job, plan);
    return job;
}

/* Time that a point takes besides its steps [ns], as a run of its own and in lanes. */
#define NS_ALONE 4000.0
#define NS_IN_LANES 200.0
/* Factors by which steps in lanes are faster, with watched and with replayed measures. */
#define LANES_GAIN 50.0
#define REPLAY_GAIN 2.0

/* Returns the mean number of fixed steps relative to that with the present dt, if dt is swept,
 * otherwise 1. */
static double steps_factor(const struct sweep_request *request)
{
    double more = 1;
    for (int a = 0; a < request->axes; a++) {
        const struct sweep_axis *axis = &request->axis[a];
        double sum = 0;
        for (int i = 0; i < axis->count && axis->target == SWEEP_DT; i++)
            sum += request->settings.dt / sweep_axis_value(axis, i);
        more *= axis->target == SWEEP_DT ? sum / axis->count : 1;
    }
    return more;
}

/* Estimates the number of steps and the computing time [s] of all points of the request. Both are
 * NAN if its first point cannot be planned. */
void study_sweep_predict(const struct sweep_request *request, double *steps, double *seconds)
{
    struct sweep sweep;
    struct plan plan;
    study_sweep_stretch(request, &sweep);
    const struct sweep_job job = job_of(request, &sweep, &plan);
    if (request->section.wanted)
        plan_section(request, &sweep, &plan);
    if (!job.adapts) {
        plan.seconds *= steps_factor(request);
        plan.steps *= steps_factor(request);
    }
    const bool lanes = job.in_lanes && sweep.count > SWEEP_FEW && can_use_lanes(&job);
    double each = plan.seconds + NS_ALONE * 1e-9;
    if (lanes)
        each = job.replays ? plan.seconds / REPLAY_GAIN + NS_ALONE * 1e-9
                           : plan.seconds / LANES_GAIN + NS_IN_LANES * 1e-9;
    *steps = plan.steps * (double)sweep.count;
    *seconds = each * (double)sweep.count / thread_count(request, sweep.count);
}

/* Largest number of points of a batch. If lanes lie along the first axis, LANE_COUNT of its rows
 * belong together. */
#define BATCH_MOST ((int64_t)1 << 18)

/* Returns the number of points that keep all threads busy when computed at once: one for each
 * thread, or LANE_COUNT for each if points are computed in lanes. If lanes lie along the first of
 * two axes, it is that of LANE_COUNT whole rows, unless these exceed BATCH_MOST. */
int64_t study_sweep_batch(const struct sweep_request *request)
{
    struct sweep sweep;
    struct plan plan;
    study_sweep_stretch(request, &sweep);
    const struct sweep_job job = job_of(request, &sweep, &plan);
    const int64_t threads = thread_count(request, INT64_MAX);
    if (!job.in_lanes || !can_use_lanes(&job))
        return threads;
    const int64_t last = request->axes > 1 ? request->axis[1].count : 1;
    const bool rows = request->axes > 1 && choose_along(request, &sweep) == 0;
    return rows && LANE_COUNT * last <= BATCH_MOST ? LANE_COUNT * last : LANE_COUNT * threads;
}

/* Computes the sweep into *sweep, which the caller frees also on failure. Returns false with an
 * error if out of memory, if stopped before all points are finished, or if every point was
 * refused. */
bool study_sweep(const struct sweep_request *request, struct sweep *sweep, struct error *error)
{
    const int64_t begin = clock_ns();
    struct plan plan;
    study_sweep_stretch(request, sweep);
    if (!results_create(sweep, request->cancel, error))
        return false;
    struct sweep_job job = job_of(request, sweep, &plan);
    if (request->previous)
        copy_finished(request->previous, sweep);
    divide_tasks(&job);
    const bool ok = run_workers(&job, error);
    sweep->seconds = clock_seconds(begin);
    if (!ok)
        return false;
    if (sweep->finished < sweep->count)
        return cancelled(request->cancel)
                   ? error_set(error, ERROR_CANCELLED, "stopped: %lld of %lld points finished",
                               (long long)sweep->finished, (long long)sweep->count)
                   : error_memory(error);
    if (sweep->refused == sweep->count && sweep->count > 0)
        return error_set(error, ERROR_COMMAND, "every point was refused: %s", sweep->reason);
    return true;
}
