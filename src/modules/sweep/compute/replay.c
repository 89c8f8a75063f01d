/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points whose measures need a whole run: the run is given the states that its lane has computed.
 * Short runs get all of them at once, one run after another. Of long ones there is one for each
 * lane, which advances by as many steps as are stored. */
#include <hooke/base/numeric.h>
#include "modules/sweep/compute/worker.h"

#include <string.h>

/* Creates the runs of long replays, one for each lane with a point. */
void replay_begin(struct sweep_worker *worker)
{
    for (int lane = 0; lane < worker->used && worker->job->in_pieces; lane++)
        worker->run[lane] = sweep_run(worker, worker->point[lane]);
}

/* Hands `count` stored states of a lane (in worker->replay, after steps first + 1 and on) to the
 * lane's run and advances it by them, but not beyond the last step of the lane. */
static void replay_feed(struct sweep_worker *worker, int lane, int64_t first, int64_t count)
{
    const struct sweep_request *request = worker->job->request;
    struct run *run = worker->run[lane];
    const struct run_target target = {.t = worker->system[lane].t0 + request->duration,
                                      .steps = int64_min(count, worker->clock[lane].whole - first)};
    if (!run || run->steps != first ||
        target.steps <= 0) /* the run was refused or has ended before */
        return;
    run_give(run, worker->replay + lane * worker->job->room * 2, target.steps);
    while (run_advance(run, &target, 0, request->cancel)) {
    }
}

/* Copies `count` rows of worker->row, the states after the steps from `first` on, to the part of
 * worker->replay that each lane has; a lane whose `whole` steps are done gets no more. The part has
 * `room` steps and is filled from its beginning again when it is full; runs that are longer
 * (in_pieces) are therefore given its content whenever it is full or their lane has ended. A lane's
 * rows are copied AT_ONCE together, which fill a cache line. */
void replay_keep(struct sweep_worker *worker, int64_t first, int64_t count)
{
    enum { AT_ONCE = 4 };
    const int64_t room = worker->job->room, place = first % room, end = first + count;
    for (int64_t begin = 0; begin < count; begin += AT_ONCE)
        for (int lane = 0; lane < worker->used; lane++) {
            double *kept = worker->replay + (lane * room + place) * 2;
            for (int64_t i = begin;
                 i < count && i < begin + AT_ONCE && first + i < worker->clock[lane].whole; i++) {
                kept[2 * i] = worker->row[i * 2 * LANE_COUNT + lane];
                kept[2 * i + 1] = worker->row[(i * 2 + 1) * LANE_COUNT + lane];
            }
        }
    for (int lane = 0; lane < worker->used && worker->job->in_pieces; lane++)
        if (end % room == 0 || end == worker->clock[lane].whole)
            replay_feed(worker, lane, first - place, end - (first - place));
}

/* Measures the point of a lane that has made all its steps, by a run that is given the lane's
 * states. `evals` is the number of evaluations that the lane has needed. */
void replay_lane(struct sweep_worker *worker, int lane, int64_t evals)
{
    const struct sweep_job *job = worker->job;
    struct run *run = worker->run[lane];
    if (job->in_pieces) {
        worker->run[lane] = NULL;
    } else if ((run = sweep_run(worker, worker->point[lane]))) {
        run_give(run, worker->replay + lane * job->room * 2, worker->clock[lane].whole);
    }
    if (run)
        sweep_measure_run(worker, worker->point[lane], run, evals);
    worker->side_by_side += run != NULL;
}

/* Destroys runs of lanes that have not come to their end, as after a cancellation. */
void replay_end(struct sweep_worker *worker)
{
    for (int lane = 0; lane < LANE_COUNT; lane++)
        if (worker->run[lane])
            run_destroy(worker->run[lane]);
    memset(worker->run, 0, sizeof worker->run);
}
