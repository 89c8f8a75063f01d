/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that order, stability, stress and selftest share: sweeps of fixed steps, modes of a
 * scene, and growth measured by running. */
#pragma once

#include <hooke/base/numeric.h>
#include "modules/solving/compute/algebra.h"
#include "modules/comparison/compute/errors.h"
#include "modules/comparison/compute/stability.h"

struct cancel;

/* Number of grid times between two at which a sweep measures its error: a quarter of the span. */
#define SWEEP_STRIDE ((STUDY_TIMES - 1) / 4)

/* Input of a sweep of fixed steps against known states. */
struct sweep_target {
    const struct system *system;
    double span;         /* [s] from system->t0 */
    const double *state; /* [STUDY_TIMES][n] known states; only each SWEEP_STRIDE-th is used */
    double size[LIMIT_VARIABLES]; /* unit of each variable's error */
    double dt[2];                 /* [s] ends of the sweep, or NAN to choose them */
    /* largest cost of one solve: evaluations, Jacobians and solves of linear systems */
    int64_t max;
    const struct cancel *cancel;
};

/* Solves with ever smaller steps and fits the order. order->choice, claimed and floor must be set;
 * fills in points, slope, guard, r2, fitted and verdict. Returns false with an error if out of
 * memory or cancelled. */
bool order_sweep(const struct sweep_target *target, struct order *order, struct error *error);

/* Largest error that takes part in the fit of an order; above it steps are too coarse. */
#define ORDER_ERROR_MAX 0.1
/* Errors below this are affected by rounding, with compensated sums or without. */
#define ORDER_ROUNDING 2e-14
/* Errors must exceed the accuracy of the reference by this factor for their slopes to be
 * reliable. */
#define ORDER_ACCURACIES 30

/* Writes into order->words why the scene spoils the order, or leaves them empty. `rests` is true if
 * the body is at rest at the end. */
void order_explain(const struct system *system, bool rests, struct order *order);

/* Appends the modes of the scene at one state to mode [*count], at most up to `max`. Returns how
 * many of them grow by themselves. */
int modes_at(const struct system *system, double t, const double *y, struct mode *mode, int *count,
             int max);
/* Returns the largest |eigenvalue| of the Jacobian [1/s] at a state, or 0 if all are 0. */
double system_fastest_rate(const struct system *system, double t, const double *y);
/* Returns the factor per step of dt [s] by which the method multiplies the mode's amplitude,
 * HUGE_VAL if it overflows, or NAN if the method does not apply. */
double mode_growth(const struct method_choice *choice, const struct mode *mode, double dt);
/* Returns the longest stable step [s] for the mode, as dt_max in struct stability. */
double mode_limit(const struct method_choice *choice, const struct mode *mode);
/* Returns the relative distance from `limit` [s] at which runs can distinguish stable from unstable
 * steps. */
double mode_aside(const struct method_choice *choice, const struct mode *mode, double limit);
/* Runs the oscillator of this mode with steps of dt [s] and compares the measured growth with the
 * predicted one. check->measured is NAN if out of memory. */
void mode_check(const struct method_choice *choice, const struct mode *mode, double dt,
                struct stability_check *check);
