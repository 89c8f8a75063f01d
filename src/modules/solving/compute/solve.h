/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A solve without recording: what is timed, and what errors are measured on.
 *
 * The common grid is t0 + k span/256, k = 0 … 256. With a step of span/2^k the two grids meet;
 * otherwise a grid time inside a step is reached by a shorter step of the method itself, whose cost
 * is not counted, or by its dense output.
 */
#pragma once

#include <hooke/run.h>

struct cancel;

/* Times of the common grid, both ends among them. */
#define STUDY_TIMES 257

struct solver {
    const struct system *system;
    const struct method *method;
    double dt, tol, span; /* tol > 0: adaptive, dt is the first guess, 0 if there is none */
    bool compensated;     /* sums of fixed steps */
    bool turns;           /* fixed steps are taken in pieces that meet at turning points */
    /* Kernel for intervals whose intermediate states are not needed: the same steps, to the bit;
     * NULL if there is none. */
    march_function *kernel;
    int64_t max; /* largest sum of evaluations, Jacobians and solves, or 0 for no limit */
    /* fixed steps after which it stops, as if at the end; 0 if there is none. For timing */
    int64_t part;
    int64_t steps;    /* taken */
    struct step step; /* y, work, low and side belong to the solver */
    double *side;     /* work of a shorter step */
    double y[LIMIT_VARIABLES], low[LIMIT_VARIABLES];
};

bool solver_init(struct solver *solver, const struct system *system, const struct method *method,
                 const struct run_settings *settings, double span);
void solver_free(struct solver *solver);
/* Resets to the state at t0 and clears the counts. */
void solver_start(struct solver *solver);
int64_t solver_cost(const struct solver *solver);
/* Returns the work of these steps, which is proportional to time. */
static inline double solve_work(const struct cost *cost, int64_t steps)
{
    return (double)(cost->evals + cost->jacobians + cost->solves + steps);
}
/*
 * Solves from y to the end of the span. Returns STOP_END or the reason for stopping; STOP_FULL
 * means that `max` is used up. grid [STUDY_TIMES * n] receives the states on the common grid, NAN
 * at times that no step reaches; it may be NULL.
 */
enum stop solver_run(struct solver *solver, double *grid, const struct cancel *cancel);
enum stop solver_stop(enum step_status status);

/*
 * The code that a study solves and times with: KERNEL_SPECIALISED, made for the method and these
 * forces, or KERNEL_GENERAL. Never the propagator: methods are compared, not powers of their
 * matrices. Times by different code say nothing about the methods, so nothing ranks them against
 * each other.
 */
enum kernel study_path(const struct system *system, const struct method *method,
                       const struct run_settings *settings);
