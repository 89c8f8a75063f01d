/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear scenes with constant coefficients: the exact motion at given times, with its derivatives
 * by parameters. */
#pragma once

#include "modules/solving/compute/variation.h"
#include "modules/recording/scene/scene_fit.h"

/*
 * y' = A y + b and S_j' = A S_j + B_j y + c_j advance by a time dt as y E + e and E S_j + F_j y +
 * f_j, prepared once for each dt. Recordings have few: times that were rounded, and gaps.
 */
struct linear_motion;

/* NULL: the times need too many different steps, or no memory. t [n] ascending, from t0 on. free()
 * it. */
struct linear_motion *linear_motion_create(double t0, const double *t, size_t n);
/* For the present values of the scene; directions 0: base alone, else all of the variation's. */
void linear_motion_bind(struct linear_motion *motion, const struct variation *variation,
                        int directions);
/* The state [n (1 + directions)] from the time it is at to `t`; returns the time that it is at
 * then, within 1e-9 steps of t: what is off is made up for by the next step. */
double linear_motion_advance(struct linear_motion *motion, double t_begin, double t, double *state);
