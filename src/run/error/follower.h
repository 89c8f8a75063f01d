/* SPDX-License-Identifier: GPL-3.0-or-later */
/* follower: another adaptive solution beside a run, from one of its rows, within a limit of work.
 * Used for the second solution (opinion.c) and for the growth of small errors (regrowth.c).
 * follower_begin(), follower_go() to each time, follower_end(). */
#pragma once

#include "run/private.h"

struct cancel;

struct follower {
    const struct method *method; /* NULL before follower_begin() and after follower_end() */
    struct step step;            /* step.t is the time [s] reached; it owns the method's memory */
    struct controller controller;
    double y[LIMIT_VARIABLES]; /* state at step.t */
};

enum follower_end {
    FOLLOWER_ARRIVED, /* it is at the time */
    FOLLOWER_SPENT,   /* the work is above its limit, or the user cancelled */
    FOLLOWER_FAILED   /* a step failed */
};

/* Begins at a row of the run, with the tolerance tol. The caller keeps the system unchanged until
 * follower_end(). Returns false if `method` is NULL, if out of memory, or if the method cannot
 * begin; then follower_end() does nothing. */
bool follower_begin(struct follower *follower, const struct run *run, size_t row,
                    const struct method *method, const struct system *system, double tol);
void follower_end(struct follower *follower);
/* Returns the evaluations and Jacobians of the follower so far. */
double follower_work(const struct follower *follower);
/* Returns the evaluations and Jacobians of the run itself. */
double run_evaluations(const struct run *run);
/* Advances to time t [s], or not as far if the result is not FOLLOWER_ARRIVED. max_work limits
 * follower_work(). */
enum follower_end follower_go(struct follower *follower, double t, double max_work,
                              const struct cancel *cancel);
/* Tells the method that the state was changed from outside. */
void follower_state_changed(struct follower *follower);

/* Raises size [n] to the largest magnitudes in the rows `first` … end - 1, of which it examines at
 * most some 512. */
void run_sizes_add(const struct run *run, size_t first, size_t end, double *size);

/* Returns true if an absolute tolerance is set of a variable whose present value is small compared
 * with its largest ones, so that it may be nothing but their errors. */
bool run_asks_small_values(const struct run *run);
