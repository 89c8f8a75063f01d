/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear algebra of small real matrices, which are arrays [rows][columns], row-major. */
#pragma once

#include <hooke/base/numeric.h>

#define MATRIX_MAX 64 /* largest number of rows of a matrix that is factored */

/* Returns the Euclidean length of x [n]. */
double vector_length(int n, const double *x);
/* Divides x [n] by its length. Returns false if that is 0 or infinite. */
bool vector_normalise(int n, double *x);

/* Solves a x = b for a [n][n]: a is overwritten, b becomes x. Returns false if a is singular or x
 * is not finite. */
bool matrix_solve(int n, double *a, double *b);
/* Returns the determinant of a [n][n], which is overwritten. Its size is limited to the range of
 * doubles, but sign and zeros are right. NAN if an element is not finite. */
double matrix_determinant(int n, double *a);

/* Computes the [n] eigenvalues of a matrix. Returns false if an element is not finite, out of
 * memory, or without convergence. */
bool matrix_eigenvalues(int n, const double *matrix, struct eigenvalue *value);
/* Finds the eigenvector re + i im [n], of length 1, of the eigenvalue nearest to `estimate`.
 * Returns false as matrix_eigenvalues() does. */
bool matrix_eigenvector(int n, const double *matrix, struct eigenvalue estimate, double *re,
                        double *im);
/* Finds the second null vector of a nearly singular matrix a [n - 1][n]: of length 1, orthogonal to
 * the null vector `known` [n]. Returns false if an element is not finite or if out of memory. */
bool matrix_second_null(int n, const double *a, const double *known, double *vector);
