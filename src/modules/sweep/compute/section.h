/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points of a sweep that are measured where an event happens. */
#pragma once

#include <hooke/scene/formula.h>
#include "modules/sweep/compute/worker.h"

/* One point's motion through the section. */
struct crossings {
    struct run *run;
    double period; /* [s] period of the strobe */
    bool angle[LIMIT_VARIABLES];
    struct expr_scope scope; /* scope of the run */
    struct event event;      /* event in that scope, with the point's parameters as numbers */
    /* The following is used in lanes. */
    int64_t seen, last; /* number of events; steps up to the end of the step with the last one */
    int64_t step;       /* number of steps before the next event of a strobe */
    bool done, alone;   /* Lanes may not see the same events if `alone`. */
    const struct expr *left, *right; /* sides of the event in state variables alone */
};

struct section {
    struct arena arena; /* memory of the present crossings */
    struct crossings lane[LANE_COUNT];
    struct system bound; /* system for values of the drive */
    double *state;       /* [SWEEP_ROWS + 1][n][LANE_COUNT] NULL without lanes */
    double (*slope)[LANE_COUNT], offset[LANE_COUNT]; /* [n] where values are linear in the state */
    double value[3][LANE_COUNT];
};

/* Begins the run of point i with its event. Returns false if it is refused, which is recorded. */
bool crossings_begin(struct sweep_worker *worker, int64_t i, struct crossings *crossings);
/* Returns true if the run ends because no event came for `steps`, or for `time` [s] with adaptive
 * steps. */
bool crossings_end(const struct sweep_request *request, const struct run *run, int64_t steps,
                   double time);
/* Returns true if that row of its run is the state after this many periods. */
bool crossings_strobed(const struct crossings *crossings, size_t row, int64_t period);
/* Stores the events that the run has recorded as results of the point, without its first `first`
 * records. */
void crossings_take(struct sweep_worker *worker, int64_t i, const struct crossings *crossings,
                    int64_t first, int64_t count);
