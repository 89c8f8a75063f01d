/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Exact solutions by kinds of systems: the linear oscillator (exact.c), also with dry friction
 * (exact_dry.c), and other linear systems with constant coefficients (exact_linear.c).
 * system_exact() chooses. In all of them the state start [n] at t0 [s] leads to y [n] at t [s], and
 * floor [n], unless NULL, is the error that rounding of the parameters and of t may cause. */
#pragma once

#include <hooke/scene.h>

/* Computes the exact state of a linear oscillator; ignores its quadratic drag and dry friction. */
void oscillator_exact(const struct oscillator *o, double t0, const double *start, double t,
                      double *y, double *floor);

/* Returns true if dry_exact() applies: an oscillator with dry friction and without a drive. */
bool dry_has_exact(const struct system *system);
void dry_exact(const struct system *system, double t0, const double *start, double t, double *y,
               double *floor);

/* Returns true if linear_exact() applies: linear, no time, few variables, finite coefficients. */
bool linear_has_exact(const struct system *system);
void linear_exact(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor);
/* A motion whose size grows by more than this factor in one time constant counts as growing. */
#define TRANSIENT_GROWTH_MAX 32

/* Raises max [n] to the largest magnitudes of the exact solution in some hundred time constants,
 * or in the first one if the motion grows without limit. `rate` [1/s] is that of the fastest
 * motion, or 0 if nothing moves. */
void linear_sizes(const struct system *system, double rate, double *max);
