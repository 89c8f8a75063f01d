/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Why a run failed, or why what it gives is no solution. */
#ifndef HOOKE_RUN_FAILURE_H
#define HOOKE_RUN_FAILURE_H

#include <hooke/run.h>

/* What an accurate solution from the start does at the time where a run failed. */
enum solution_fate {
    SOLUTION_UNKNOWN, /* nobody looked, or it took too long */
    SOLUTION_ENDS,    /* it goes to infinity, or its slope does */
    SOLUTION_GROWS,   /* it grows beyond what counts as diverged, at no finite time of its own */
    SOLUTION_GOES_ON  /* it gets past that time */
};

/* singular.c: adaptive steps that no longer get on, because the solution ends: then stop is
 * STOP_SINGULAR. Looks at twice the step of its last look, so that it costs a share of the run. */
bool run_creeps(struct run *run);
/* Returns true for linear equations whose drive, if there is one, is a cosine: their solutions
 * exist at all times. */
bool run_is_never_singular(const struct system *system);
/* The first recorded row since the equations or the state were last changed from outside. */
size_t run_own_start(const struct run *run);
/*
 * Looks for the end of the solution before `end`, in at most so many steps of an accurate method:
 * from the run's own start, whose solution it is about, and where that is too far away from shortly
 * before t. NAN where there is none; run_private.fate is what was found.
 */
struct singularity run_singular_before(struct run *run, double t, double end, int64_t max);
/* Makes a singularity the reason why the run stopped. Returns false if there is none. */
bool run_end_singular(struct run *run, struct singularity found);
/* across.c: whether steps since the last call look strange and the solution ends there: then stop
 * is STOP_SINGULAR. */
bool run_went_across(struct run *run);
/* Returns true if the rows that run_went_across() compares with their slopes are picked: those of
 * the largest changes among all. */
bool run_picks_rows(const struct system *system, const struct method *method, double rows);
/* Returns how many they are at most. */
size_t run_rows_looked_max(const struct method *method, double evals, double rows, bool picks);

/* sound.c: from y [n] at t to `end` by an accurate method, into `to` [n] or NULL. Returns false if
 * it does not get there, would take too long, or is cancelled. */
#define RUN_SOLVE_TOL 1e-7
#define RUN_SOLVE_STIFF "radau5"
#define RUN_SOLVE_SMOOTH "dop853" /* in a few steps, or not at all */
bool run_solve(const struct system *system, double t, const double *y, double end, const char *by,
               double tol, double *to, const struct cancel *cancel);
/* The same by RUN_SOLVE_SMOOTH, or where that does not get there by RUN_SOLVE_STIFF, whose linear
 * equations are far dearer in many variables. */
bool run_solve_cheaply(const struct system *system, double t, const double *y, double end,
                       double tol, double *to, const struct cancel *cancel);
/* Compares the step from recorded row i to the next with the solution from there: run->unsound. */
void run_check_step(struct run *run, size_t i);
/* Compares the first steps of a method that is stable at any step with a solution that grows: what
 * damps everything damps that, too. */
void run_check_first_steps(struct run *run);

#endif
