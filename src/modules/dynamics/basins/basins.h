/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Attractors in which motions end, and motions on their way there. */
#pragma once

#include "modules/dynamics/chaos.h"

#include "modules/dynamics/orbits/field.h"
#include "modules/lanes/lanes.h"

#define WALK_PAST 9     /* looks that are remembered: periods up to one less */
#define WALK_LOOKS 1000 /* then it is not decided */

/* Known part of an attractor: one state, those of a period, a closed line, or cells. */
struct attractor {
    struct basin basin;
    int points;
    double *point;       /* [points][n] a closed line where it is an orbit */
    unsigned char *cell; /* cells that it visits and their neighbours, or NULL if it repeats */
};

/* Motions are looked at in units of sizes, angles in their first turn. */
struct basin_walk {
    struct vector_field field;
    int n;
    double strobe; /* [s] time between looks */
    bool forced;
    int steps; /* steps of rk4 from look to look, or 0 for adaptive steps */
    double centre[FIELD_VARIABLES];
    int attractors;
    struct attractor attractor[BASINS_MOST];
};

/* One motion. */
struct walker {
    double y[FIELD_VARIABLES]; /* SI */
    double past[WALK_PAST][FIELD_VARIABLES];
    int looks, near_count, attractor; /* `near_count` counts successive looks near `attractor`. */
    int again, period; /* `again` counts successive recurrences after `period` looks. */
    bool found;        /* It repeats, but is near no known attractor. */
};

/* Prepares the walk for the request. `lanes` says that there are enough starts to fill the lanes.
 * Returns false with `error` filled if the scene is refused or out of memory. */
bool walk_init(struct basin_walk *walk, const struct basins_request *request, bool lanes,
               struct error *error);
void walk_free(struct basin_walk *walk);
void walker_start(const struct basin_walk *walk, struct walker *walker, const double *y);
/* Examines the walker after one more look. Returns the index of an attractor, BASIN_ESCAPES,
 * BASIN_UNDECIDED, or BASIN_MISSING if it is still on its way. Sets walker->found if the motion
 * repeats, but is near no known attractor. */
int walker_look(const struct basin_walk *walk, struct walker *walker);
/* Returns the attractor of a walker that repeats, or that has not repeated for long; it is added if
 * it is new. Returns BASIN_UNDECIDED or BASIN_MISSING if there is none. */
int walk_learn(struct basin_walk *walk, struct walker *walker);

struct stepper;
/* Returns a stepper for motions of the walk, or NULL if out of memory. */
struct stepper *stepper_create(const struct basin_walk *walk);
void stepper_free(struct stepper *stepper);
/* Advances walker [count] by one look, side by side where possible; count is at most LANE_COUNT. */
void stepper_advance(struct stepper *stepper, struct walker *walker, int count);
/* Returns the number of steps that a look needs from these states, or 0 if they go alone, by
 * adaptive steps. */
int stepper_choose(struct basin_walk *walk, double (*start)[FIELD_VARIABLES], int count);
