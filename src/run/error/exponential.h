/* SPDX-License-Identifier: GPL-3.0-or-later */
/* exponential: the action of a matrix exponential that may be far out of the range of numbers. */
#ifndef RUN_ERROR_EXPONENTIAL_H
#define RUN_ERROR_EXPONENTIAL_H

/* Replaces v [n] by the direction of exp(a) v, for a [n][n] row-major, by scaling and squaring
 * (Moler, Van Loan 2003, SIAM Rev. 45:3). Returns log |exp(a) v| / |v|, in the maximum norm, or
 * -HUGE_VAL where nothing is left. Destroys a; work has 2 n^2 doubles. */
double exponential_apply(int n, double *a, double *v, double *work);

/* Returns the largest sum of magnitudes in a row of a [n][n]. */
double matrix_norm(int n, const double *a);

#endif
