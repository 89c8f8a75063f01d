/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Eigenvectors, null vectors, and the first Lyapunov coefficient. */
#ifndef HOOKE_MODULES_DYNAMICS_BRANCHES_EIGEN_H
#define HOOKE_MODULES_DYNAMICS_BRANCHES_EIGEN_H

#include "modules/dynamics/orbits/field.h"

/* The vector re + i im [n] with A (re + i im) = (at.re + i at.im) (re + i im), of length 1. */
bool matrix_eigenvector(int n, const double *a, struct eigenvalue at, double *re, double *im);
/* Of [rows][columns], rows = columns - 1: a vector of length 1 across `known` that it takes nearly
 * to 0. */
bool matrix_second_null(int columns, const double *a, const double *known, double *vector);
/*
 * First Lyapunov coefficient of an equilibrium with eigenvalues +- i omega (Kuznetsov 2004, eq.
 * 5.62, <q, q> = <p, q> = 1, in the scene's own units). < 0: the orbits that are born are stable
 * where everything else is. *error: what differences leave uncertain. NAN: not found.
 */
double lyapunov_coefficient(struct vector_field *field, const double *state, double omega,
                            double *error);

#endif
