/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The search for a solution that errors are measured against. */
#pragma once

#include "modules/comparison/compute/errors.h"

struct cancel;

/* Methods of one kind err alike: agreement counts between kinds only. */
enum solver_kind { KIND_EXPLICIT, KIND_SPLITTING, KIND_IMPLICIT, KIND_ROSENBROCK, KIND_COUNT };

#define BURSTS_MAX 4096
#define BURST_NODES_MAX 66 /* States between which an interval of the grid is searched. */

struct reference_search {
    const struct system *system;
    struct reference *reference;
    const struct cancel *cancel;
    double *grid;                            /* [KIND_COUNT] solutions, and one to work with */
    const struct method *method[KIND_COUNT]; /* NULL if there is none of this kind yet */
    size_t size;                             /* [double] of one solution */
    bool failed;                             /* no memory */
    int64_t left;                            /* remainder of COST_ALL */
    bool stiff; /* an explicit method became too dear: the others will, too */
    int parts;  /* adaptive steps end at so many parts of each grid interval, */
    struct burst
        *burst; /* [BURSTS_MAX] and at so many parts of each of these, in the order of the way */
    int bursts;
    bool looked; /* bursts were searched for */
    struct reference_node {
        double t, y[LIMIT_VARIABLES];
    } * node; /* [BURST_NODES_MAX] where bursts begin and end in an interval, and its ends */
    int nodes;
};

/* Solves on the grid with `steps` in each interval, or adaptive if 0, at a cost within the rest of
 * COST_ALL. */
enum stop reference_walk(struct reference_search *search, struct solver *s, int64_t steps,
                         double *grid);
