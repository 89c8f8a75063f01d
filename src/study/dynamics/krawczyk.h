/* SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef HOOKE_STUDY_DYNAMICS_KRAWCZYK_H
#define HOOKE_STUDY_DYNAMICS_KRAWCZYK_H

#include <hooke/scene/typed.h>

enum verdict { NONE, ONE, SMALLER, UNKNOWN };

/*
 * The operator of Krawczyk (Neumaier 1990, 5.1): K(X) = m - C f(m) + (1 - C J(X)) (X - m), and what
 * it says of the zeros in the box [n], which is cut to it. by [n][n]: bounds of the Jacobian there.
 */
enum verdict krawczyk(const struct system *bounded, struct interval *box,
                      const struct interval *by);

#endif
