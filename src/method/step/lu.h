/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Small dense linear systems: factor once, solve many. Gaussian elimination with partial pivoting;
 * sizes up to 3 are the same code with n known to the compiler, so that all loops are gone.
 *
 * A matrix is [n + 1][n] row-major: n rows, then a row that takes the pivots (LU_ROOM doubles). A
 * complex one is two of these, the real parts, then the imaginary ones.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#define LU_ROOM(n) ((size_t)(n) * (size_t)((n) + 1))

/* Replaces a by its factors. Returns false if a is singular or not finite; its contents are then
 * undefined. */
bool lu_factor(int n, double *a);
void lu_solve(int n, const double *a, double *b); /* b [n] becomes the solution of a x = b */

bool lu_factor_complex(int n, double *a);
void lu_solve_complex(int n, const double *a, double *re, double *im); /* the same, b = re + i im */
