/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Diagnosis of why a run failed, or why its result is not a solution. run_diagnose() in diagnose.c
 * finds out, with accurate solutions beside the run (follow.c) and checks of fixed steps
 * (strange.c); run_explain() in explain.c puts it into words. */
#pragma once

#include <hooke/run.h>

struct cancel;

/* Behaviour of an accurate solution that is followed from a state of a run. */
enum solution_fate {
    SOLUTION_UNKNOWN, /* it was not followed, or that took too long */
    SOLUTION_ENDS,    /* it, or its slope, goes to infinity at a finite time */
    SOLUTION_GROWS,   /* it grows beyond run_bound(), without such a time */
    SOLUTION_GOES_ON  /* it reached the end */
};

/* ---- follow.c ---- */

/* Solves the equations from y [n] at t to `end` by an accurate method with tolerance tol, into
 * y_end [n]. Returns false if it does not get there, would take too long, or is cancelled. */
bool run_solve_cheaply(const struct system *system, double t, const double *y, double end,
                       double tol, double *y_end, const struct cancel *cancel);
/* State and time that an accurate solution reached. */
struct followed {
    enum solution_fate fate;
    double t, y[LIMIT_VARIABLES];
    /* only the slope is infinite, the solution stays finite; valid with SOLUTION_ENDS */
    bool finite;
};

#define FOLLOW_STEPS_MAX 20000
/* Follows the solution from y [n] at t to `end` in at most steps_max steps. */
void run_follow(const struct system *system, double t, const double *y, double end,
                int64_t steps_max, const struct cancel *cancel, struct followed *followed);
/* Does the same with the tolerance tol, and within the work of run_solve_cheaply(). */
void run_follow_cheaply(const struct system *system, double t, const double *y, double end,
                        double tol, const struct cancel *cancel, struct followed *followed);
/* Returns true if the solution ends before `end`, as far as some 100 steps show. */
bool run_seems_to_end(const struct system *system, double t, const double *y, double end,
                      const struct cancel *cancel);
/* Returns true for linear equations whose drive, if there is one, is a cosine: their solutions
 * exist at all times. */
bool run_is_never_singular(const struct system *system);

/* ---- diagnose.c ---- */

/* Returns true if adaptive steps make no more progress because the solution ends; then run->stop is
 * STOP_SINGULAR. Looks when the number of steps has doubled since its last look, so that it takes a
 * small share of the run's work. */
bool run_creeps(struct run *run);
/* Returns the first recorded row since the equations or the state were last changed from outside.
 */
size_t run_own_start(const struct run *run);
/* Follows the solution of a run to `end` in at most steps_max steps: from run_own_start(), because
 * errors may have led later states away from it, or from `row` if that takes too long. */
void run_follow_from(const struct run *run, size_t row, double end, int64_t steps_max,
                     struct followed *followed);
/* Returns steps_max for a run of `evals` evaluations: a share of its work. */
int64_t run_follow_steps(double evals);
/* If the followed solution ends, makes that the reason why the run stopped. Returns false if it
 * does not end. */
bool run_end_singular(struct run *run, const struct followed *followed);

/* ---- strange.c ---- */

/* Examines fixed steps since the last call for some that have little to do with the solution. Sets
 * run->unsound to the worst, and run->stop to STOP_SINGULAR if the solution ends in one of them. */
void run_find_strange_steps(struct run *run);
/* Compares the first steps of an implicit method with the solution, as run_find_strange_steps()
 * does: a method that is stable at any step also damps a solution that grows. */
void run_check_first_steps(struct run *run);
/* Returns the largest number of rows that run_find_strange_steps() examines; sets *picks if it
 * chooses those that stand out, instead of rows at even distances. */
size_t run_rows_looked_max(const struct system *system, const struct method *method, double evals,
                           double rows, bool *picks);
