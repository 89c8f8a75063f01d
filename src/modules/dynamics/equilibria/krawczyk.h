/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOOKE_MODULES_DYNAMICS_EQUILIBRIA_KRAWCZYK_H
#define HOOKE_MODULES_DYNAMICS_EQUILIBRIA_KRAWCZYK_H

#include <hooke/scene/typed.h>

enum verdict { NONE, ONE, SMALLER, UNKNOWN };

/*
 * Applies the operator of Krawczyk (Neumaier 1990, 5.1), K(X) = m - C f(m) + (1 - C J(X)) (X - m),
 * to the box [n] and intersects the box with the result. by [n][n] are bounds of the Jacobian on
 * the box. NONE: the box has no zero. ONE: the box as it was before has exactly one, which lies in
 * the intersection. rounding [n], or NULL, becomes what rounding of f(m) adds to each side of K.
 */
enum verdict krawczyk(const struct system *bounded, struct interval *box, const struct interval *by,
                      double *rounding);

#endif
