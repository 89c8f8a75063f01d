/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points of a sweep in lanes with adaptive steps, each lane with its own step-size control. */
#include "modules/sweep/compute/worker.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <string.h>

/* The windows of all lanes. */
struct adaptive_watch {
    double open[LANE_COUNT]; /* not 0 if the window has begun */
    int closed;              /* number of windows that have not begun */
};

/* Adds the integral and the length of an attempted step to those of lanes in their window; both are
 * 0 if the step was rejected. */
CLONES static void add_own_areas(const double *restrict previous, const double *restrict row,
                                 const double *restrict open, double *restrict area,
                                 double *restrict span)
{
    for (int lane = 0; lane < LANE_COUNT; lane++) {
        const double h = row[lane] - previous[lane];
        const double more =
            watch_area(h, previous[LANE_COUNT + lane], previous[2 * LANE_COUNT + lane],
                       row[LANE_COUNT + lane], row[2 * LANE_COUNT + lane]);
        area[lane] += open[lane] != 0 ? more : 0;
        span[lane] += open[lane] != 0 ? h : 0;
    }
}

/* Watches `count` rows after attempted steps, each with time, position and velocity of all lanes:
 * extremes, integrals, and windows that begin. `previous` is the row before them. A rejected step
 * repeats the row of its lane. */
static void watch_attempts(struct sweep_worker *worker, const double *previous, int64_t count,
                           struct adaptive_watch *adaptive)
{
    const double opens = worker->system[0].t0 + worker->job->opens;
    const double *row = worker->row;
    for (int64_t i = 0; i < count; i++, previous = row, row += 3 * LANE_COUNT) {
        const unsigned groups = lanes_turning_groups(previous + LANE_COUNT, row + LANE_COUNT);
        for (int lane = next_turning(groups, 0); lane < worker->used;
             lane = next_turning(groups, lane + 1))
            if (watch_turns(previous[2 * LANE_COUNT + lane], row[2 * LANE_COUNT + lane]))
                watch_turn(&worker->watch[lane], previous[lane], previous[LANE_COUNT + lane],
                           previous[2 * LANE_COUNT + lane], row[lane], row[LANE_COUNT + lane],
                           row[2 * LANE_COUNT + lane]);
        if (worker->job->means)
            add_own_areas(previous, row, adaptive->open, worker->area, worker->span);
        for (int lane = 0; lane < worker->used && adaptive->closed > 0; lane++)
            if (adaptive->open[lane] == 0 && row[lane] >= opens) {
                watch_open(&worker->watch[lane], row[LANE_COUNT + lane]);
                adaptive->open[lane] = 1;
                adaptive->closed--;
            }
    }
}

/* Steps and watches all lanes, each with steps and tolerance of its own, until they have ended.
 * Returns false if cancelled. */
static bool march_adaptive(struct sweep_worker *worker, struct adaptive_watch *adaptive)
{
    const struct sweep_job *job = worker->job;
    const struct sweep_request *request = job->request;
    const double t0 = worker->system[0].t0;
    double previous[3 * LANE_COUNT] = {0};
    *adaptive = (struct adaptive_watch){.closed = worker->used};
    memset(worker->area, 0, sizeof worker->area);
    memset(worker->span, 0, sizeof worker->span);
    for (int lane = 0; lane < worker->used; lane++) {
        const double *start = worker->system[lane].start;
        watch_begin(&worker->watch[lane], start[0]);
        previous[lane] = t0;
        previous[LANE_COUNT + lane] = start[0];
        previous[2 * LANE_COUNT + lane] = start[1];
    }
    lanes_control(worker->lanes, worker->used, worker->tol, t0 + request->duration, RUN_CREEP);
    lanes_adapted_row(worker->lanes, worker->row);
    for (int64_t count = 1, more = 1; more; count = SWEEP_ROWS) {
        if (count > 1)
            more = lanes_adapt(worker->lanes, count, job->watches ? worker->row : NULL);
        if (job->watches) {
            watch_attempts(worker, previous, count, adaptive);
            memcpy(previous, worker->row + 3 * (count - 1) * LANE_COUNT, sizeof previous);
        }
        if (cancelled(request->cancel))
            return false;
    }
    return true;
}

/* Measures all lanes; points that did not come to their end, or with suspicious states, run
 * alone. */
static void finish_adaptive(struct sweep_worker *worker)
{
    for (int lane = 0; lane < worker->used; lane++) {
        struct extremes *watch = &worker->watch[lane];
        int64_t steps, evals;
        double y[LIMIT_VARIABLES];
        lanes_state(worker->lanes, lane, y);
        if (!lanes_adapted(worker->lanes, lane, &steps, &evals) ||
            lane_suspicious(y, worker->system[lane].n) ||
            (worker->job->watches && steps >= LIMIT_SAMPLES - 1)) {
            sweep_alone(worker, worker->point[lane]);
            continue;
        }
        watch->area = worker->area[lane];
        watch->span = worker->span[lane];
        watch_end(watch, y[0]);
        sweep_measure_lane(worker, lane, y, steps, evals);
    }
}

void sweep_adapt(struct sweep_worker *worker)
{
    struct adaptive_watch watch;
    if (march_adaptive(worker, &watch))
        finish_adaptive(worker);
}
