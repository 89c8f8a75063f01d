/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Solves of a scene without recording, for timing and for measuring errors: solver_init(), then
 * solver_run() as often as needed with solver_start() between, then solver_free(). The common grid
 * is t0 + k span/256, k = 0 … 256. With a step of span/2^k every grid time is the end of a step;
 * otherwise the state at a grid time inside a step comes from a shorter step of the method itself,
 * whose cost is not counted, or from its dense output. */
#pragma once

#include <hooke/run.h>

struct cancel;

/* Number of times of the common grid, with both ends. */
#define STUDY_TIMES 257

/* A scene with a method and its work memory. Members may be read after a run. */
struct solver {
    const struct system *system;
    const struct method *method;
    /* [s]; with tol > 0 steps are adaptive and dt is the first step, 0 if it is to be chosen */
    double dt, tol, span;
    bool compensated; /* sums of fixed steps */
    bool turns;       /* fixed steps are divided at turning points and switches */
    /* Kernel for intervals whose intermediate states are not needed: the same steps, to the bit;
     * NULL if there is none. */
    march_function *kernel;
    int64_t max; /* largest sum of evaluations, Jacobians and solves, or 0 for no limit */
    /* number of fixed steps after which it stops as if at the end, 0 for no such limit; for
     * timing */
    int64_t part;
    int64_t steps;    /* number of steps taken */
    struct step step; /* y, work, low and side belong to the solver */
    double *side;     /* work memory of a shorter step */
    /* present state, and low-order digits of compensated sums */
    double y[LIMIT_VARIABLES], low[LIMIT_VARIABLES];
};

/* Prepares solves of `system`, which must outlive the solver, over span [s] from its t0. Returns
 * false if out of memory; nothing is to be freed then. */
bool solver_init(struct solver *solver, const struct system *system, const struct method *method,
                 const struct run_settings *settings, double span);
/* Frees the work memory. */
void solver_free(struct solver *solver);
/* Resets state and counts to those at t0. */
void solver_start(struct solver *solver);
/* Returns the number of evaluations, Jacobians and solves of linear systems so far. */
int64_t solver_cost(const struct solver *solver);
/* Returns evaluations, Jacobians, solves and steps together, which is about proportional to
 * computing time. */
static inline double solve_work(const struct cost *cost, int64_t steps)
{
    return (double)(cost->evals + cost->jacobians + cost->solves + steps);
}
/* Solves from the state y at t0 to the end of the span. Returns STOP_END, or the reason for
 * stopping; STOP_FULL means that `max` is used up. grid [STUDY_TIMES * n] receives the states on
 * the common grid, NAN at times that no step reaches; it may be NULL. */
enum stop solver_run(struct solver *solver, double *grid, const struct cancel *cancel);
/* Returns the reason for stopping that belongs to the status of a step. */
enum stop solver_stop(enum step_status status);

/* Returns the code that a solve runs: KERNEL_SPECIALISED, made for the method and these forces, or
 * KERNEL_GENERAL. It is never the propagator, since methods are compared, not powers of their
 * matrices. Times of different code are not comparable. */
enum kernel study_path(const struct system *system, const struct method *method,
                       const struct run_settings *settings);
