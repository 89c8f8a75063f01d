/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear scenes with constant coefficients: the exact motion at given times, with its derivatives
 * by parameters. Create once for the times, bind for each set of parameters, then advance. */
#pragma once

#include "modules/solving/compute/variation.h"
#include "modules/recording/scene/scene_fit.h"

/* y' = A y + b and S_j' = A S_j + B_j y + c_j advance by a time dt as y E + e and E S_j + F_j y +
 * f_j; these are computed once for each dt. Recordings have few different dt, from rounded times
 * and gaps. */
struct linear_motion;

/* Creates a motion for samples at t [n], ascending, from t0 on. Returns NULL if the times need too
 * many different steps or if out of memory. Release with free(). */
struct linear_motion *linear_motion_create(double t0, const double *t, size_t n);
/* Binds the motion to the present values of the scene: without derivatives if directions is 0, else
 * with all directions of the variation. */
void linear_motion_bind(struct linear_motion *motion, const struct variation *variation,
                        int directions);
/* Advances the state [n (1 + directions)] from t_begin to `t`. Returns the time reached, within
 * 1e-9 steps of t: the next step makes up for the difference. */
double linear_motion_advance(struct linear_motion *motion, double t_begin, double t, double *state);
