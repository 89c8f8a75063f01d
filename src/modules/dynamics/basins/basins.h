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
    double strobe; /* [s] */
    bool forced;
    int steps; /* of rk4 */
    double centre[FIELD_VARIABLES];
    int attractors;
    struct attractor attractor[BASINS_MOST];
};

/* One motion. */
struct walker {
    double y[FIELD_VARIABLES]; /* SI */
    double past[WALK_PAST][FIELD_VARIABLES];
    int looks, near_count, attractor; /* number of looks near attractor `at` on end */
    int again, period;                /* how often the same as so many looks before */
    bool found;                       /* repeats, but is none that is known */
};

/* lanes: there are enough starts to fill them. */
bool walk_init(struct basin_walk *walk, const struct basins_request *request, bool lanes,
               struct error *error);
void walk_free(struct basin_walk *walk);
void walker_start(const struct basin_walk *walk, struct walker *walker, const double *y);
/* After one more look: the place of an attractor, BASIN_ESCAPES, BASIN_UNDECIDED; BASIN_MISSING:
 * on its way; found: repeats as none that is known. */
int walker_look(const struct basin_walk *walk, struct walker *walker);
/* The walker has come to what repeats, or has not for long: its attractor, which may be new. */
int walk_learn(struct basin_walk *walk, struct walker *walker);

/* Up to LANE_COUNT states [count] of walkers go on by one look, side by side where that can be. */
struct stepper;
struct stepper *stepper_create(const struct basin_walk *walk);
void stepper_free(struct stepper *stepper);
void stepper_advance(struct stepper *stepper, struct walker *walker, int count);
/* Returns the number of steps that a look needs from these states, or 0 if they go alone, by
 * adaptive steps. */
int stepper_choose(struct basin_walk *walk, double (*start)[FIELD_VARIABLES], int count);
