/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points of a sweep that are measured at a section, where an event happens: what section.c (a run
 * per point) and section_lanes.c (points side by side in lanes) share. Order of calls for a point:
 * crossings_begin(), advancing crossings->run, crossings_take(), run_destroy(). */
#pragma once

#include <hooke/scene/formula.h>
#include "modules/sweep/compute/worker.h"

/* The run of one point through the section. */
struct crossings {
    struct run *run; /* owned by the caller of crossings_begin(), or NULL */
    double period;   /* [s] period of the drive, 0 if the section is at an event */
    /* true for variables that are angles, which are compared modulo a turn */
    bool angle[LIMIT_VARIABLES];
    struct expr_scope scope; /* names of the run, for the event */
    struct event event;      /* the event, compiled with the point's parameters as numbers */
    /* The following is used by lanes only. */
    /* number of events so far; number of steps up to the end of the step with the last one */
    int64_t seen, last;
    int64_t step; /* number of steps before the one that contains the next period's end */
    /* `alone` means that lanes may not see the same events, so that the point has to run alone */
    bool done, alone;
    const struct expr *left, *right; /* sides of the event as functions of the state variables */
};

/* Memory of a worker for sections. */
struct section {
    struct arena arena; /* memory of the events of the present point or lanes */
    struct crossings lane[LANE_COUNT];
    struct system bound; /* scratch for crossings_begin() */
    double *state; /* [SWEEP_ROWS + 1][n][LANE_COUNT] states after each step; NULL without lanes */
    /* [n] coefficients of the event's value where it is linear in the state */
    double (*slope)[LANE_COUNT], offset[LANE_COUNT];
    /* values of the event before, at the begin and at the end of a step */
    double value[3][LANE_COUNT];
};

/* Creates the run of point i and compiles its event. Returns false if the point is refused, which
 * is recorded in the sweep; no run is to be destroyed then. */
bool crossings_begin(struct sweep_worker *worker, int64_t i, struct crossings *crossings);
/* Returns true if the point ends because no event came for longer than the duration: for `steps`
 * steps, or for `time` [s] with adaptive steps. */
bool crossings_end(const struct sweep_request *request, const struct run *run, int64_t steps,
                   double time);
/* Returns true if that row of the run's trace is the state after `period` periods of the drive. */
bool crossings_strobed(const struct crossings *crossings, size_t row, int64_t period);
/* Stores events of the run as results of point i: those from its record `first` on, at most as many
 * as are to be kept of the `count` that exist. Sets worker->failed if out of memory. */
void crossings_take(struct sweep_worker *worker, int64_t i, const struct crossings *crossings,
                    int64_t first, int64_t count);
