/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Coefficients of methods, for programs that contain the method's steps. */
#pragma once

#include <hooke/method.h>

/* A Runge-Kutta method k_i = f(t + c_i h, y + sum_j (h a_ij) k_j), y' = y + sum_i (h b_i) k_i, with
 * sums over the weights that are not 0. With `fsal` the last stage is at y' and is the first one of
 * the next step. Arrays are constants. */
struct runge_kutta {
    int stages;
    bool fsal;
    const double *c, *b; /* [stages] */
    const double *a;     /* a21, a31 a32, ... */
    const double *b_hat; /* [stages] weights of the embedded method, or NULL */
    /* [stages] weights of the bend of a cubic Hermite interpolant, see src/method/step/step.h, or
     * NULL if the method has another interpolant or none */
    const double *bend;
};

/* Fills in the table of an explicit Runge-Kutta method. Returns false for other methods. */
bool method_runge_kutta(const struct method *method, struct runge_kutta *table);

/*
 * Describes how its steps follow the error e = h sum_i (b_i - b_hat_i) k_i: *most is the largest
 * accepted root of the mean square, in units of the state's size, and *order is the power of h in
 * e. Returns false if steps do not follow that error, or if the last stage is not the first one of
 * the next step.
 */
bool method_error_control(const struct method *method, double tol, double *most, int *order);

#define SPLITTING_WEIGHTS 40 /* largest number of weights of a splitting */

/* Stores the weights of drifts q += (w h) v and kicks v += (w h) a in turn. Returns their
 * number, or 0 if the method is not a splitting. */
int method_splitting(const struct method *method, double weight[SPLITTING_WEIGHTS],
                     bool *kick_first);

/* Returns true for backward Euler, y' = y + h f(t + h, y'). */
bool method_is_backward_euler(const struct method *method);
