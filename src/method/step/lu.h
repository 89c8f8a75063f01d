/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Small dense linear systems: call lu_factor() once and lu_solve() for each right-hand side.
 * Gaussian elimination with partial pivoting; sizes up to 3 use the same code with n known to the
 * compiler, so that loops vanish.
 *
 * A matrix is [n + 1][n] row-major: n rows, then a row for the pivots (LU_ROOM doubles). A complex
 * one is two of these, first the real and then the imaginary parts.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#define LU_ROOM(n) ((size_t)(n) * (size_t)((n) + 1))

/* Replaces a by its factors. Returns false if a is singular or not finite; its contents are then
 * undefined. */
bool lu_factor(int n, double *a);
/* Replaces b [n] by the solution x of a x = b; a holds the factors. */
void lu_solve(int n, const double *a, double *b);

/* Do the same for a complex matrix, with re + i im as b. */
bool lu_factor_complex(int n, double *a);
void lu_solve_complex(int n, const double *a, double *re, double *im);
