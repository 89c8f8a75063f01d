/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the two ways to the work between states share. */
#ifndef HOOKE_RUN_ENERGY_WORK_H
#define HOOKE_RUN_ENERGY_WORK_H

#include "run/private.h"

#define SQRT5 2.236067977499789696
#define INNER 0.276393202250021030 /* the first inner point of Lobatto's rule on [0, 1] */

/* Of state k. */
static inline double work_time(const struct work *work, int k)
{
    return work->t ? work->t[k] : work->origin + (double)(work->index + k) * work->h;
}

/* One coordinate between two states. */
struct quintic {
    double h, q0, v0, a0, q1, v1, a1;
};

/* Is there a kink in the step? A body with dry friction that is at rest at one end has one there.
 */
static inline bool work_turns(const struct system *system, double v0, double v1)
{
    return system->kinks && (v0 * v1 < 0 || (system->dry && v0 * v1 == 0 && v0 != v1));
}

/* The work of a step from t on in which the velocity changes its sign, in parts. */
void work_across(const struct system *system, const struct quintic *p, double t, double *work,
                 double *drag);

/* Systems whose terms are those of the oscillator or the pendulum; false: it is something else. */
bool work_of_terms(const struct work *work, struct work_done *done);

/* ---- balance.c ---- */

/* Of the run's state, in units of factor^2 J. */
double balance_energy(const struct run *run, const struct system *system, const double *state);
/* A part of a step, from the balance to (t, y). */
void balance_extend(const struct run *run, struct balance *balance, double t, const double *y);

#endif
