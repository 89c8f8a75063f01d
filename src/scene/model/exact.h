/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Exact solutions by kinds of systems: the oscillator (exact.c), with dry friction (exact_dry.c),
 * other linear systems with constant coefficients (exact_linear.c). */
#pragma once

#include <hooke/scene.h>

/* Computes the exact state, leaving out quadratic drag and friction, whatever they are. */
void oscillator_exact(const struct oscillator *o, double t0, const double *start, double t,
                      double *y, double *floor);

bool dry_has_exact(const struct system *system);
void dry_exact(const struct system *system, double t0, const double *start, double t, double *y,
               double *floor);

bool linear_has_exact(const struct system *system);
void linear_exact(const struct system *system, double t0, const double *start, double t, double *y,
                  double *floor);
/* A motion whose size grows by more than this factor in one time constant counts as growing. */
#define TRANSIENT_GROWTH_MAX 32

/* Raises most [n] to what |state| reaches in some hundred time constants, as long as it does not
 * just grow. rate [1/s]: of the fastest motion, 0 if there is none. */
void linear_sizes(const struct system *system, double rate, double *max);
