/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Work between states one step apart: declarations shared by work.c (any system), work_terms.c
 * (oscillators and the pendulum, faster), work_check.c (where the result is not to be trusted),
 * balance.c (sums of it) and ledger.c (what is kept with the rows). */
#pragma once

#include "run/private.h"

#include <math.h>

#define SQRT_5 2.236067977499789696
/* The first inner point of Lobatto's rule on [0, 1]. */
#define LOBATTO_INNER 0.276393202250021030

/* Returns the time [s] of state k. */
static inline double work_time(const struct work *work, int k)
{
    return work->t ? work->t[k] : work->origin + (double)(work->index + k) * work->h;
}

/* One coordinate between two states, as the polynomial of degree 5 that has the position, velocity
 * and acceleration of both. */
struct quintic {
    double h; /* [s] */
    double q0, v0, a0, q1, v1, a1;
};

/* Limits above which work_coarse() distrusts the quintic, as shares of the velocity: the change of
 * velocity that the accelerations at both ends do not explain, and the change of acceleration times
 * h. In an oscillation that proceeds by the angle theta in a step they are at most theta^2/12 and
 * about theta^2. */
#define WORK_COARSE_CHANGE 1.7e-3
#define WORK_COARSE_BEND 2e-2

/* Returns 1 if the acceleration changes so much in a step that the quintic may not hold, and 0
 * otherwise. The result is as wide as a double, so that loops over many steps vectorise. */
static inline int64_t work_coarse(double h, double v0, double v1, double a0, double a1)
{
    const double velocity = fabs(v0) > fabs(v1) ? fabs(v0) : fabs(v1);
    const double change = fabs(h) * (fabs(a0) > fabs(a1) ? fabs(a0) : fabs(a1));
    const double size = velocity > change ? velocity : change;
    return (fabs(v1 - v0 - h * (a0 + a1) / 2) > WORK_COARSE_CHANGE * size) |
           (fabs(h * (a1 - a0)) > WORK_COARSE_BEND * size);
}

/* Returns true if the force has a kink in the step because the velocity changes its sign from v0 to
 * v1. A body with dry friction that is at rest at one end has one there. */
static inline bool work_turns(const struct system *system, double v0, double v1)
{
    return system->kinks && (v0 * v1 < 0 || (system->dry && v0 * v1 == 0 && v0 != v1));
}

/* Sets the work of all forces and of drag in a step from t on in which the velocity changes its
 * sign, as the sum of the parts before and after that. Returns true if the force jumps there, so
 * that the quintic does not hold. */
bool work_turn(const struct system *system, const struct quintic *p, double t, double *work,
               double *drag);

/* Returns true if the quintic of a step from y0 [n] at t to y1 [n] obeys the equations between the
 * ends, and Lobatto's rule on both halves of the step gives the same work within `allowed`. */
bool work_converges(const struct system *system, double t, double h, const double *y0,
                    const double *y1, double work, double allowed);

/* Computes the work for systems whose terms are those of the oscillator or the pendulum; returns
 * false for others. */
bool work_of_terms(const struct work *work, struct work_done *done);

/* ---- work_check.c ---- */

/* Replaces the work of steps for which the quintic does not hold by that of a solution of the
 * equations from the beginning of the step, or NAN if none is found. `done` is the result of
 * work_between() for `work`. Counts them in balance->solved. */
void work_check(const struct run *run, struct balance *balance, const struct work *work,
                struct work_done *done);

/* ---- balance.c ---- */

/* Returns the energy of a state of the run, in units of factor^2 J. */
double balance_energy(const struct run *run, const struct system *system, const double *state);
/* Extends the balance over a part of a step, to the state y [n] at t. It counts as a step. */
void balance_extend(const struct run *run, struct balance *balance, double t, const double *y);

/* ---- ledger.c ---- */

/* Returns true if the summary of a run shows the balance of that many steps, because it takes
 * little time. */
bool ledger_is_brief(const struct plan *plan, int64_t steps);

/* Returns true if the summary of a longer run shows the energy of LEDGER_SAMPLE of its rows. */
bool ledger_is_sampled(const struct system *system, const struct plan *plan);
enum { LEDGER_SAMPLE = 256 };
