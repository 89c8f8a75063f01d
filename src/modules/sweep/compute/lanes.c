/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points of a sweep in lanes: they are gathered until all lanes are used, then stepped and watched
 * side by side. Results have the same bits as those of point.c. */
#include "modules/sweep/compute/worker.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <string.h>

/* A point with a larger state runs alone, as a run stops at the right step. */
#define DIVERGENCE_MIN 1e100

/* Makes the last step of a lane, of length clock->rest, which is shorter than the others, from
 * state y (in and out) as a run does. Adds its evaluations to *evals. Returns false if the step
 * fails. */
static bool finish_lane(const struct sweep_worker *worker, int lane, double *y, int64_t *evals)
{
    const struct system *system = &worker->system[lane];
    const struct lane_clock *clock = &worker->clock[lane];
    const struct method *method = worker->job->request->method;
    struct step step = {.system = system,
                        .drag = worker->drag,
                        .t = system->t0 + (double)clock->whole * clock->h,
                        .h = clock->rest,
                        .y = y,
                        .work = worker->work};
    const bool ok = method_turning_step(method, &step) == STEP_OK;
    *evals += step.cost.evals;
    return ok;
}

/* Returns the value of a measure for a lane that has come to its end in state y after that many
 * steps and evaluations, or NAN if the measure is not defined there. */
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

/* Returns true if a state is so large, or not a number, that the point must run alone. */
bool lane_suspicious(const double *y, int n)
{
    for (int i = 0; i < n; i++)
        if (!(fabs(y[i]) <= DIVERGENCE_MIN))
            return true;
    return false;
}

/* Returns true if all lanes will have to run alone, so that stepping on is of no use. */
static bool all_suspicious(const struct sweep_worker *worker)
{
    double y[LIMIT_VARIABLES];
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        lanes_state(worker->lanes, lane, y);
        if (!lane_suspicious(y, worker->system[0].n))
            return false;
    }
    return true;
}

/* Computes lanes_turning_groups(): bit g of the result is set if a velocity of group g, of
 * TURN_GROUP lanes, has changed its sign between two rows. A row holds the positions of all lanes,
 * then their velocities; the exclusive or of their sign bits is fast for vector instructions, and
 * CLONES compiles for several sets of these. */
CLONES static unsigned turning_groups(const double *previous, const double *row)
{
    unsigned groups = 0;
    for (int group = 0; group < LANE_COUNT / TURN_GROUP; group++) {
        uint64_t turned = 0;
        for (int i = 0; i < TURN_GROUP; i++) {
            const int lane = group * TURN_GROUP + i;
            uint64_t a, b;
            memcpy(&a, previous + LANE_COUNT + lane, sizeof a);
            memcpy(&b, row + LANE_COUNT + lane, sizeof b);
            turned |= a ^ b;
        }
        groups |= (unsigned)(turned >> 63) << group;
    }
    return groups;
}

unsigned lanes_turning_groups(const double *previous, const double *row)
{
    return turning_groups(previous, row);
}

/* ---- batches of steps in which no lane comes to its end and no window begins ---- */

/* Such a batch of steps. */
struct stretch_watch {
    int64_t first, count;    /* number of steps before it, and of its steps */
    bool alike;              /* all lanes step at the same times */
    double open[LANE_COUNT]; /* not 0 while the lane is in its window */
    double t0[LANE_COUNT], h[LANE_COUNT],
        t_end[LANE_COUNT]; /* [s] start of the lanes, their step, and time after the batch */
};

/* Adds the integral over one step of all lanes to area. */
CLONES static void add_areas(double h, const double *restrict previous, const double *restrict row,
                             double *restrict area)
{
    for (int lane = 0; lane < LANE_COUNT; lane++)
        area[lane] += watch_area(h, previous[lane], previous[LANE_COUNT + lane], row[lane],
                                 row[LANE_COUNT + lane]);
}

/* Adds the integral and the length of step `number` where lanes have their own steps and windows.
 * The `last` step of a batch ends at t_end. */
CLONES static void add_own_areas(const struct stretch_watch *stretch, double number, bool last,
                                 const double *restrict previous, const double *restrict row,
                                 double *restrict area, double *restrict span)
{
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        const double t_begin = stretch->t0[lane] + number * stretch->h[lane],
                     next = stretch->t0[lane] + (number + 1) * stretch->h[lane],
                     h = (last ? stretch->t_end[lane] : next) - t_begin,
                     more = watch_area(h, previous[lane], previous[LANE_COUNT + lane], row[lane],
                                       row[LANE_COUNT + lane]);
        area[lane] += stretch->open[lane] != 0 ? more : 0;
        span[lane] += stretch->open[lane] != 0 ? h : 0;
    }
}

/* Returns true if the lane ends after so many steps, without a shorter one. */
static bool ends_after(const struct lane_clock *clock, int64_t steps)
{
    return clock->whole == steps && clock->rest == 0;
}

/* Watches the rows of a batch of steps: notes extremes where a velocity has changed its sign, and
 * adds up integrals for means. `previous` is the row before the batch. */
static void watch_lanes(struct sweep_worker *worker, const double *previous,
                        const struct stretch_watch *stretch)
{
    double *const row_end = worker->row + 2 * (stretch->count - 1) * LANE_COUNT;
    for (int lane = 0; lane < worker->used; lane++)
        if (worker->system[0].order == 1 &&
            ends_after(
                &worker->clock[lane],
                stretch->first +
                    stretch->count)) { /* the velocity depends on time, and the end's is exact */
            double y[LIMIT_VARIABLES];
            lanes_state(worker->lanes, lane, y);
            row_end[LANE_COUNT + lane] =
                watch_speed(&worker->system[lane], 0, stretch->t_end[lane], y);
        }
    const double *row = worker->row;
    for (int64_t i = 0; i < stretch->count; i++, previous = row, row += 2 * LANE_COUNT) {
        const unsigned groups = turning_groups(previous, row);
        const bool last = i == stretch->count - 1;
        const double number = (double)(stretch->first + i);
        for (int lane = next_turning(groups, 0); lane < worker->used;
             lane = next_turning(groups, lane + 1))
            if (watch_turns(previous[LANE_COUNT + lane], row[LANE_COUNT + lane]) &&
                stretch->first < worker->clock[lane].whole)
                watch_turn(&worker->watch[lane], stretch->t0[lane] + number * stretch->h[lane],
                           previous[lane], previous[LANE_COUNT + lane],
                           last ? stretch->t_end[lane]
                                : stretch->t0[lane] + (number + 1) * stretch->h[lane],
                           row[lane], row[LANE_COUNT + lane]);
        if (!worker->job->means)
            continue;
        if (!stretch->alike) {
            add_own_areas(stretch, number, last, previous, row, worker->area, worker->span);
        } else if (stretch->open[0] != 0) {
            const double t_begin = stretch->t0[0] + number * stretch->h[0],
                         h = (last ? stretch->t_end[0]
                                   : stretch->t0[0] + (number + 1) * stretch->h[0]) -
                             t_begin;
            add_areas(h, previous, row, worker->area);
            worker->span[0] += h;
        }
    }
}

/* Returns the number of steps after which the window is open, computed with the same roundings as
 * in a run. */
static int64_t opening_step(const struct sweep_job *job, double t0, const struct lane_clock *clock)
{
    const double h = clock->h, opens = t0 + job->opens;
    int64_t i = (int64_t)floor(job->opens / h);
    while (i > 0 && t0 + (double)i * h >= opens)
        i--;
    while (t0 + (double)i * h < opens)
        i++;
    return i < clock->whole ? i : clock->whole;
}

/* Prepares clocks and watches of all lanes before the first step, and the times in *stretch. Unused
 * lanes repeat the last used one, so that lanes_march() needs no special case. */
static void begin_watching(struct sweep_worker *worker, struct stretch_watch *stretch)
{
    const struct sweep_job *job = worker->job;
    *stretch = (struct stretch_watch){.alike = true};
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        struct lane_clock *clock = &worker->clock[lane];
        const double t0 = worker->system[lane < worker->used ? lane : worker->used - 1].t0;
        if (lane >= worker->used)
            *clock = worker->clock[worker->used - 1];
        stretch->t0[lane] = t0;
        stretch->h[lane] = clock->h;
        stretch->alike &= t0 == stretch->t0[0] && clock->h == stretch->h[0];
        if (job->clocks || lane == 0)
            clock->opening =
                job->watches && !job->replays ? opening_step(job, t0, clock) : clock->whole;
        else
            clock->opening = worker->clock[0].opening;
        worker->area[lane] = worker->span[lane] = 0;
    }
    for (int lane = 0; lane < worker->used; lane++)
        watch_begin(&worker->watch[lane], worker->system[lane].start[0]);
}

/* Returns the number of steps, greater than i, at which the next lane ends or begins to be measured
 * (its window opens), or INT64_MAX if none does. *open becomes true if a lane is in its window
 * after step i. */
static int64_t next_change(const struct sweep_worker *worker, int64_t i, bool *open)
{
    int64_t next = INT64_MAX;
    *open = false;
    for (int lane = 0; lane < worker->used; lane++) {
        const struct lane_clock *clock = &worker->clock[lane];
        if (clock->opening > i)
            next = int64_min(next, clock->opening);
        if (clock->whole > i)
            next = int64_min(next, clock->whole);
        *open |= clock->opening <= i && clock->whole > i;
    }
    return next;
}

/* Stores the states of lanes that have made their last whole step, i; with `all` those of all lanes
 * that have not ended. */
static void store_ends(struct sweep_worker *worker, int64_t i, bool all)
{
    for (int lane = 0; lane < worker->used; lane++) {
        const struct lane_clock *clock = &worker->clock[lane];
        if (clock->whole == i || (all && clock->whole > i)) {
            lanes_state(worker->lanes, lane, worker->end[lane].y);
            worker->end[lane].evals = lanes_evals(worker->lanes, lane);
        }
    }
}

/* Steps all lanes to their ends, stores the final states, and on the way watches the states for
 * measures or keeps them for a replay. Stops early if all lanes turn out to need a solution one by
 * one. Returns false if cancelled. */
static bool march_lanes(struct sweep_worker *worker)
{
    const struct sweep_job *job = worker->job;
    struct stretch_watch stretch;
    double previous[2 * LANE_COUNT];
    bool open;
    begin_watching(worker, &stretch);
    if (job->replays)
        replay_begin(worker);
    store_ends(worker, 0, false);
    for (int64_t i = 0, next; (next = next_change(worker, i, &open)) != INT64_MAX;) {
        const bool watching = job->replays || job->tops || (job->watches && open);
        const int64_t count =
            int64_min(next - i, watching ? SWEEP_ROWS - i % SWEEP_ROWS : 16 * SWEEP_ROWS);
        if (watching)
            lanes_row(worker->lanes, previous);
        for (int lane = 0; lane < LANE_COUNT; lane++) {
            const struct lane_clock *clock = &worker->clock[lane];
            stretch.open[lane] = clock->opening <= i && i < clock->whole;
            stretch.t_end[lane] = ends_after(clock, i + count)
                                      ? stretch.t0[lane] + job->request->duration
                                      : stretch.t0[lane] + (double)(i + count) * stretch.h[lane];
            if (watching && lane < worker->used && i == clock->opening && i < clock->whole)
                watch_open(&worker->watch[lane], previous[lane]);
        }
        lanes_march(worker->lanes, count, watching ? worker->row : NULL);
        stretch.first = i;
        stretch.count = count;
        if (job->replays)
            replay_keep(worker, i, count);
        else if (watching)
            watch_lanes(worker, previous, &stretch);
        i += count;
        store_ends(worker, i, false);
        if (cancelled(job->request->cancel))
            return false;
        if (all_suspicious(worker)) {
            store_ends(worker, i, true);
            break;
        }
    }
    for (int lane = 1; lane < worker->used && stretch.alike; lane++)
        worker->span[lane] = worker->span[0];
    return true;
}

/* Stores the measures of a lane that has come to its end. */
void sweep_measure_lane(struct sweep_worker *worker, int lane, const double *y, int64_t steps,
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

/* Completes the watch of a lane at the end of its time. `was` is the state after the last equal
 * step and y the state after the shorter step that follows; they are equal if there is none. */
static void finish_watch(struct sweep_worker *worker, int lane, const double *was, const double *y)
{
    const struct lane_clock *clock = &worker->clock[lane];
    const struct system *system = &worker->system[lane];
    struct extremes *watch = &worker->watch[lane];
    const double t_begin = system->t0 + (double)clock->whole * clock->h,
                 end = system->t0 + worker->job->request->duration;
    if (!watch->open && (clock->rest == 0 ? end : t_begin) >= system->t0 + worker->job->opens)
        watch_open(watch, was[0]);
    const bool stepped = clock->rest != 0;
    const double speed0 = stepped ? watch_speed(system, 0, t_begin, was) : 0;
    const double speed1 = stepped ? watch_speed(system, 0, end, y) : 0;
    if (watch_turns(speed0, speed1))
        watch_turn(watch, t_begin, was[0], speed0, end, y[0], speed1);
    watch->area = worker->area[lane];
    watch->span = worker->span[lane];
    if (!watch->open) {
        watch_open(watch, y[0]);
    } else if (stepped) {
        watch->area += watch_area(end - t_begin, was[0], speed0, y[0], speed1);
        watch->span += end - t_begin;
    }
    watch_end(watch, y[0]);
}

/* Measures all lanes at their ends; points with suspicious states run alone. */
static void finish_lanes(struct sweep_worker *worker)
{
    const struct sweep_job *job = worker->job;
    for (int lane = 0; lane < worker->used; lane++) {
        const struct lane_clock *clock = &worker->clock[lane];
        const int n = worker->system[lane].n;
        const struct lane_end *end = &worker->end[lane];
        int64_t evals = end->evals;
        double y[LIMIT_VARIABLES];
        memcpy(y, end->y, (size_t)n * sizeof *y);
        if (lane_suspicious(y, n) || (clock->rest != 0 && !finish_lane(worker, lane, y, &evals))) {
            sweep_alone(worker, worker->point[lane]);
        } else if (job->replays) {
            replay_lane(worker, lane, evals);
        } else {
            if (job->watches)
                finish_watch(worker, lane, end->y, y);
            sweep_measure_lane(worker, lane, y, clock->whole + (clock->rest != 0), evals);
        }
    }
}

/* Returns the number of points that take less time alone than in lanes, as was measured: forces of
 * oscillators fill vectors, sines are computed one by one, and adaptive lanes wait for the
 * slowest. */
static int lanes_points_min(const struct sweep_worker *worker)
{
    const struct model *model = worker->system[0].model;
    int points = model == &oscillator_model ? SWEEP_FEW : 20;
    if (model->typed)
        points = 5;
    return worker->job->adapts ? int_max(points, SWEEP_FEW_ADAPTIVE) : points;
}

/* Computes the points gathered in the lanes, then empties these. Points run alone if there are too
 * few or if out of memory. */
void sweep_flush(struct sweep_worker *worker)
{
    const struct sweep_request *request = worker->job->request;
    const struct system *first = &worker->system[0];
    if (worker->used == 0)
        return;
    const bool begun =
        worker->used > lanes_points_min(worker) &&
        lanes_begin(worker->lanes, request->method, worker->drag, first, worker->clock[0].h);
    for (int lane = 0; begun && lane < LANE_COUNT; lane++) {
        const int source = lane < worker->used ? lane : worker->used - 1;
        lanes_set_step(worker->lanes, lane, &worker->system[source], worker->clock[source].h);
    }
    for (int lane = 0; !begun && lane < worker->used; lane++) /* too few points, or out of memory */
        sweep_alone(worker, worker->point[lane]);
    if (begun && worker->section)
        section_march(worker);
    else if (begun && worker->job->adapts)
        sweep_adapt(worker);
    else if (begun && march_lanes(worker))
        finish_lanes(worker);
    replay_end(worker);
    worker->used = 0;
}

/* Binds the scene of a point. The potential of typed forces, whose search is expensive, is left out
 * unless an energy is measured. Returns false with an error if the scene is refused. */
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

/* Sets *clock for a lane with steps of h [s]. Returns false if its steps are refused, or too many
 * for lanes; the point then runs alone. */
static bool set_clock(const struct sweep_worker *worker, const struct system *system, double h,
                      struct lane_clock *clock)
{
    const struct sweep_job *job = worker->job;
    *clock = (struct lane_clock){.h = h, .rest = job->rest, .whole = job->whole};
    if (!job->clocks || job->adapts)
        return true;
    struct plan plan = {.whole = job->whole, .partial = job->rest};
    struct error ignored;
    const bool fits =
        plan_grid(system, h, job->request->duration, &plan, &ignored) &&
        (!job->watches || plan.steps <= LIMIT_SAMPLES) &&
        (!job->replays || (plan.whole > 0 && (job->in_pieces || plan.whole <= job->room)));
    clock->rest = plan.partial;
    clock->whole = plan.whole;
    return fits;
}

/* Adds point i to the lanes, and computes them when all are used. The lanes are computed before
 * that if point i needs other steps than theirs, and points that fit no lane run alone. A point
 * that the scene or the method refuses is marked as refused. */
void sweep_gather(struct sweep_worker *worker, int64_t i)
{
    struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    struct lane_clock clock;
    struct error error; /* not cleared, as most points set none */
    struct system *system = &worker->system[worker->used];
    enum drag drag = request->settings.drag;
    if (!sweep_point(request, job->sweep, i, &worker->scene, &worker->settings, &error) ||
        !bind_point(request, &worker->scene, system, &error) ||
        !method_applies(request->method, system, &drag, &error) ||
        (!job->adapts &&
         !method_fits(request->method, system, drag, worker->settings.dt, &error))) {
        sweep_refuse(worker, i, &error);
        return;
    }
    const double tol = worker->settings.tol; /* saved, as points that run alone change it */
    if (!sweep_lanes_fit(job, system, drag) ||
        !set_clock(worker, system, worker->settings.dt, &clock)) {
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
    worker->clock[worker->used] = clock;
    worker->point[worker->used++] = i;
    if (worker->used == LANE_COUNT)
        sweep_flush(worker);
}
