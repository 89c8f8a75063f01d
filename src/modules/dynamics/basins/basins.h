/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shared by the files that compute basins of attraction: basins.c (all starts, over threads),
 * attractors.c (recognizing and learning attractors), stepper.c (following motions), one.c (a
 * single start). A motion is checked ("look") at equal times; walker_start(), then
 * stepper_advance() and walker_check() in turn, and walk_learn() if the motion repeats. */
#pragma once

#include "modules/dynamics/chaos.h"

#include "modules/dynamics/orbits/field.h"
#include "modules/lanes/lanes.h"

#define WALK_PAST 9          /* number of states that are remembered: periods of up to one less */
#define WALK_CHECKS_MAX 1000 /* number of checks after which the fate of a motion is undecided */

/* A known attractor: one state, those of a period, a closed line, or cells of a grid. */
struct attractor {
    struct basin basin;
    int points;
    double *point;       /* [points][n] states; for an orbit vertices of a closed line */
    unsigned char *cell; /* cells that it visits and their neighbours, or NULL if it repeats */
};

/* Data that all motions have in common. Threads only read it, except while attractors are
 * learned. */
struct basin_walk {
    struct vector_field field;
    int n;
    double strobe; /* [s] time between checks */
    bool forced;   /* the scene has a drive, whose period is that time */
    int steps;     /* number of steps of rk4 between checks, or 0 for adaptive steps */
    double centre[FIELD_VARIABLES]; /* middle of the grid of starts, SI */
    int attractors;
    struct attractor attractor[BASINS_MOST];
};

/* One motion. */
struct walker {
    double y[FIELD_VARIABLES];               /* SI */
    double past[WALK_PAST][FIELD_VARIABLES]; /* last states, by looks % WALK_PAST */
    /* number of checks; number of successive ones near an attractor, and its index or -1 */
    int checks, near_count, attractor;
    int recurrences, period; /* number of successive recurrences after `period` checks */
    bool found;              /* the motion repeats, but is near no known attractor */
};

/* Prepares the walk for the request. `lanes` says that there are enough starts to fill the lanes.
 * Returns false with `error` filled if the scene is refused or out of memory. */
bool walk_init(struct basin_walk *walk, const struct basins_request *request, bool lanes,
               struct error *error);
/* Frees the attractors. */
void walk_free(struct basin_walk *walk);
/* Begins a motion at the state y [n], SI. */
void walker_start(const struct basin_walk *walk, struct walker *walker, const double *y);
/* Examines the walker after one more look. Returns the index of an attractor, BASIN_ESCAPES,
 * BASIN_UNDECIDED, or BASIN_MISSING if it is still on its way. Sets walker->found if the motion
 * repeats, but is near no known attractor. */
int walker_check(const struct basin_walk *walk, struct walker *walker);
/* Returns the index of the attractor of a motion that repeats, or that has not repeated for long; a
 * new one is added. Returns BASIN_UNDECIDED or BASIN_MISSING if there is none. */
int walk_learn(struct basin_walk *walk, struct walker *walker);

/* Advances motions; each thread has its own. */
struct stepper;
/* Returns a stepper for motions of the walk, or NULL if out of memory. */
struct stepper *stepper_create(const struct basin_walk *walk);
void stepper_free(struct stepper *stepper);
/* Advances walker [count] to the next check, in lanes if possible; count is at most LANE_COUNT. A
 * motion that cannot be followed becomes NAN. */
void stepper_advance(struct stepper *stepper, struct walker *walker, int count);
/* Sets walk->steps to the number of steps that are accurate enough from start [count], or to 0 if
 * steps have to be adaptive, and returns it. */
int stepper_choose(struct basin_walk *walk, double (*start)[FIELD_VARIABLES], int count);
