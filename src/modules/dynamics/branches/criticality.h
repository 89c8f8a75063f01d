/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The first Lyapunov coefficient. */
#ifndef HOOKE_MODULES_DYNAMICS_BRANCHES_CRITICALITY_H
#define HOOKE_MODULES_DYNAMICS_BRANCHES_CRITICALITY_H

#include "modules/dynamics/orbits/field.h"

/*
 * First Lyapunov coefficient of an equilibrium with eigenvalues +- i omega (Kuznetsov 2004, eq.
 * 5.62, <q, q> = <p, q> = 1, in the scene's own units). < 0: the orbits that are born are stable
 * where everything else is. *error: what differences leave uncertain. NAN: not found.
 */
double lyapunov_coefficient(struct vector_field *field, const double *state, double omega,
                            double *error);

#endif
