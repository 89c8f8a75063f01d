/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear systems with constant coefficients that are not one oscillator (exact_linear.c). */
#ifndef HOOKE_SCENE_EXACT_H
#define HOOKE_SCENE_EXACT_H

#include <hooke/scene.h>

bool linear_has_exact(const struct system *system);
void linear_exact(const struct system *system, double t0, const double *start, double t, double *y, double *floor);
/* Raises most [n] to what |state| reaches in some hundred time constants, as long as it does not just grow. rate [1/s]:
 * of the fastest motion, 0: none. */
void linear_sizes(const struct system *system, double rate, double *most);

#endif
