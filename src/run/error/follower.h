/* SPDX-License-Identifier: GPL-3.0-or-later */
/* follower: another adaptive solution beside a run, from one of its rows, within a budget. */
#pragma once

#include "run/private.h"

struct cancel;

struct follower {
    const struct method *method; /* NULL before follower_begin() */
    struct step step;
    struct controller controller;
    double y[LIMIT_VARIABLES];
};

enum follower_end { FOLLOWER_ARRIVED, FOLLOWER_SPENT, FOLLOWER_FAILED };

/* Begins at a row of the run. The system is kept by the caller. Returns false if out of memory or
 * if the method cannot begin; there is nothing to end then. */
bool follower_begin(struct follower *follower, const struct run *run, size_t row,
                    const struct method *method, const struct system *system, double tol);
void follower_end(struct follower *follower);
/* Return evaluations and Jacobians so far: of the follower, of the run itself. */
double follower_work(const struct follower *follower);
double run_evaluations(const struct run *run);
/* Goes to time t [s]. Returns FOLLOWER_SPENT where its work exceeds max_work or the user cancels,
 * FOLLOWER_FAILED where a step fails; it is short of t then. */
enum follower_end follower_go(struct follower *follower, double t, double max_work,
                              const struct cancel *cancel);
/* Tells the method that the state was changed from outside. */
void follower_state_changed(struct follower *follower);

/* Raises size [n] to the largest values in at most some 512 rows from `first` up to `end`, without
 * it. */
void run_sizes_add(const struct run *run, size_t first, size_t end, double *size);

/* Returns true if an absolute tolerance is set of a variable that is now small next to its largest
 * values: their errors may be all that is left of it. */
bool run_asks_small_values(const struct run *run);
