/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear algebra of small real matrices, row-major. */
#pragma once

#include <hooke/base/numeric.h>

#define MATRIX_MAX 64 /* rows at most of what is factored */

double vector_length(int n, const double *x);
/* Makes x [n] of length 1; returns false if it has no length, or an infinite one. */
bool vector_normalise(int n, double *x);

/* Solves a [n][n] x = b: a is spoilt, b becomes x. Returns false if a is singular, or if x is not
 * finite. */
bool matrix_solve(int n, double *a, double *b);
/* Returns the determinant of a, which is spoilt, as a number whose sign and zeros are right: its
 * size is kept in the range of numbers. NAN if an element is not finite. */
double matrix_determinant(int n, double *a);

/* Computes the [n] eigenvalues of a matrix. Returns false if an element is not finite, out of
 * memory, or without convergence. */
bool matrix_eigenvalues(int n, const double *matrix, struct eigenvalue *value);
/* Finds the eigenvector re + i im [n], of length 1, of the eigenvalue nearest to `estimate`; false
 * as matrix_eigenvalues(). */
bool matrix_eigenvector(int n, const double *matrix, struct eigenvalue estimate, double *re,
                        double *im);
/* Finds the vector of length 1 across `known`, both [n], that a [n - 1][n] takes nearest to 0, as
 * it takes `known`. Returns false if an element is not finite, or out of memory. */
bool matrix_second_null(int n, const double *a, const double *known, double *vector);
