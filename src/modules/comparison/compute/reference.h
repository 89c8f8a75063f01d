/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The search for a reference solution (reference.c), and one solution on its grid
 * (reference_walk.c). */
#pragma once

#include "modules/comparison/compute/errors.h"

struct cancel;

/* Methods of one kind make similar errors, so that only agreement between two kinds confirms a
 * solution. */
enum solver_kind { KIND_EXPLICIT, KIND_SPLITTING, KIND_IMPLICIT, KIND_ROSENBROCK, KIND_COUNT };

#define BURSTS_MAX 4096 /* largest number of bursts in a search */
#define BURST_NODES_MAX                                                                            \
    66 /* largest number of states between which an interval of the grid is searched */

/* State of a search. */
struct reference_search {
    const struct system *system;
    struct reference *reference; /* result, filled in step by step */
    const struct cancel *cancel;
    double *grid; /* [KIND_COUNT + 1] solutions of `size` each, one per kind and one to work with */
    /* method that solved, or NULL if none of this kind has yet */
    const struct method *method[KIND_COUNT];
    size_t size;  /* [double] of one solution */
    bool failed;  /* true if out of memory */
    int64_t left; /* remainder of the cost that all solutions together may have */
    /* an explicit method exceeded its cost, so that other explicit ones are not tried */
    bool stiff;
    int parts;           /* adaptive steps end at this many equal parts of each grid interval */
    struct burst *burst; /* [BURSTS_MAX] short changes of the forces, in the order in which they are
                            passed; steps also end at parts of each */
    int bursts;
    bool looked; /* the first adaptive solution has searched for bursts */
    struct reference_node {
        double t, y[LIMIT_VARIABLES];
    } * node; /* [BURST_NODES_MAX] states of the interval that was crossed last: at its ends, and
                 where bursts begin, end and are divided */
    int nodes;
};

/* Solves from start to end and stores the states at all grid times in grid [STUDY_TIMES][n]. Each
 * grid interval takes `steps` fixed steps, or adaptive ones if 0. Spends at most what is left of
 * search->left. Returns STOP_END if the end was reached, otherwise why not. */
enum stop reference_walk(struct reference_search *search, struct solver *s, int64_t steps,
                         double *grid);
