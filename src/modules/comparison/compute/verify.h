/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that order, stability, stress and selftest share: sweeps of fixed steps, growth
 * measured by running, modes. */
#pragma once

#include <hooke/base/numeric.h>
#include "modules/solving/compute/algebra.h"
#include "modules/comparison/compute/errors.h"
#include "modules/comparison/compute/stability.h"

struct cancel;

/* Grid times between two at which a sweep looks for its error: a quarter of the span. */
#define SWEEP_STRIDE ((STUDY_TIMES - 1) / 4)

/* A sweep of fixed steps against states that are known. */
struct sweep_target {
    const struct system *system;
    double span;         /* [s] from system->t0 */
    const double *state; /* [STUDY_TIMES][n] on the common grid; used are each SWEEP_STRIDE-th */
    double size[LIMIT_VARIABLES]; /* unit of each variable's error */
    double dt[2];                 /* [s] ends of the sweep, or NAN to choose them */
    int64_t max;                  /* evaluations, Jacobians and solves of one solve */
    const struct cancel *cancel;
};

/* Fills points, slope, guard, r2, fitted and verdict; choice, claimed and floor are given. Returns
 * false with the error if out of memory or cancelled. */
bool order_sweep(const struct sweep_target *target, struct order *order, struct error *error);

/* Largest asymptotic error. */
#define ORDER_ERROR_MAX 0.1
/* Errors below this include rounding, with compensated sums or without. */
#define ORDER_ROUNDING 2e-14
/* Ratio to the accuracy of the reference above which slopes of errors are reliable. */
#define ORDER_ACCURACIES 30

/* Writes into order->words why the scene spoils the order. `rests` is true if the body is at rest
 * at the end. */
void order_explain(const struct system *system, bool rests, struct order *order);

/* The scene's eigenvalues at one state, appended as modes; returns how many of them grow by
 * themselves. */
int modes_at(const struct system *system, double t, const double *y, struct mode *mode, int *count,
             int max);
double mode_growth(const struct method_choice *choice, const struct mode *mode, double dt);
/* Returns the longest stable step [s], as in struct stability. */
double mode_limit(const struct method_choice *choice, const struct mode *mode);
/* Returns the relative distance from the limit at which runs distinguish the two sides. */
double mode_aside(const struct method_choice *choice, const struct mode *mode, double limit);
/* Runs the oscillator of this mode. */
void mode_check(const struct method_choice *choice, const struct mode *mode, double dt,
                struct stability_check *check);
