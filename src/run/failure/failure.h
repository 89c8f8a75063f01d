/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Diagnosis of why a run failed, or why its result is no solution. */
#pragma once

#include <hooke/run.h>

struct cancel;

/* Behaviour of an accurate solution. */
enum solution_fate {
    SOLUTION_UNKNOWN, /* nobody looked, or it took too long */
    SOLUTION_ENDS,    /* it goes to infinity, or its slope does */
    SOLUTION_GROWS,   /* it grows beyond what counts as diverged, at no finite time of its own */
    SOLUTION_GOES_ON
};

/* ---- follow.c ---- */

/* Goes from y [n] at t to `end` by an accurate method, into `y_end` [n]. Returns false if it does
 * not get there, would take too long, or is cancelled. */
bool run_solve_cheaply(const struct system *system, double t, const double *y, double end,
                       double tol, double *y_end, const struct cancel *cancel);
/* State and time that an accurate solution reached. */
struct followed {
    enum solution_fate fate;
    double t, y[LIMIT_VARIABLES];
    /* valid with SOLUTION_ENDS: the solution stays finite, and only its slope does not */
    bool finite;
};

#define FOLLOW_STEPS_MAX 20000
/* Follows the solution from y [n] at t to `end` in at most that many steps. */
void run_follow(const struct system *system, double t, const double *y, double end,
                int64_t steps_max, const struct cancel *cancel, struct followed *followed);
/* The same at the accuracy, and within the work, of run_solve_cheaply(). */
void run_follow_cheaply(const struct system *system, double t, const double *y, double end,
                        double tol, const struct cancel *cancel, struct followed *followed);
/* Returns true if the solution ends before `end`, as far as some 100 steps show. */
bool run_seems_to_end(const struct system *system, double t, const double *y, double end,
                      const struct cancel *cancel);
/* Returns true for linear equations whose drive, if there is one, is a cosine: their solutions
 * exist at all times. */
bool run_is_never_singular(const struct system *system);

/* ---- diagnose.c ---- */

/* Returns true if adaptive steps no longer get on, because the solution ends: stop is STOP_SINGULAR
 * then. Looks at twice the step of its last look, so that it costs a share of the run. */
bool run_creeps(struct run *run);
/* Returns the first recorded row since the equations or the state were last changed from outside.
 */
size_t run_own_start(const struct run *run);
/* Follows the solution of a run to `end` in at most so many steps: from its own start, as errors
 * may have led away from it; if that takes too long, from a row. */
void run_follow_from(const struct run *run, size_t row, double end, int64_t steps_max,
                     struct followed *followed);
/* Returns how many steps that may take, a share of the run's work. */
int64_t run_follow_steps(double evals);
/* Makes the end of a solution the reason why the run stopped. Returns false if it does not end. */
bool run_end_singular(struct run *run, const struct followed *followed);

/* ---- strange.c ---- */

/* Looks for fixed steps since the last call that have little to do with the solution: the worst is
 * run->unsound, and stop is STOP_SINGULAR where the solution ends in one of them. */
void run_find_strange_steps(struct run *run);
/* Compares the first steps of an implicit method with the solution: what is stable at any step
 * damps a solution that grows, too. */
void run_check_first_steps(struct run *run);
/* Returns how many rows run_find_strange_steps() looks at, at most, and whether it picks those that
 * stand out. */
size_t run_rows_looked_max(const struct system *system, const struct method *method, double evals,
                           double rows, bool *picks);
