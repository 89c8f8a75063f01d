/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points of a sweep that are measured where an event happens. */
#pragma once

#include <hooke/scene/formula.h>
#include "modules/sweep/compute/worker.h"

/* One point's motion through the section. */
struct crossings {
    struct run *run;
    double period; /* [s] of a strobe */
    bool angle[LIMIT_VARIABLES];
    struct expr_scope scope; /* of the run */
    struct event event;      /* in that scope, parameters of the point are numbers in it */
    /* in lanes: */
    int64_t seen, last; /* events so far; the steps up to the end of that in which the last was */
    int64_t step;       /* strobe: in the step after so many is the next one that is wanted */
    bool done, alone;   /* alone: it is not certain that the same is seen in lanes */
    const struct expr *left, *right; /* of the event, in state variables alone */
};

struct section {
    struct arena arena; /* of the present crossings */
    struct crossings lane[LANE_COUNT];
    struct system bound; /* to look at a drive */
    double *state;       /* [SWEEP_ROWS + 1][n][LANE_COUNT]; NULL: no lanes */
    double (*slope)[LANE_COUNT], offset[LANE_COUNT]; /* [n] where values are linear in the state */
    double value[3][LANE_COUNT];
};

/* The run of point i at its start, and its event. False: refused, which has been said. */
bool crossings_begin(struct sweep_worker *worker, int64_t i, struct crossings *crossings);
/* So many steps, or so long [s] where steps adapt, without an event are the end. */
bool crossings_end(const struct sweep_request *request, const struct run *run, int64_t steps,
                   double time);
/* Returns true if that row of its run is the state after this many periods. */
bool crossings_strobed(const struct crossings *crossings, size_t row, int64_t period);
/* What the run has recorded becomes the point's; `first`: so many of its records are not kept. */
void crossings_take(struct sweep_worker *worker, int64_t i, const struct crossings *crossings,
                    int64_t first, int64_t count);
