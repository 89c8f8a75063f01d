/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Linear systems with constant coefficients that are not one oscillator (exact_linear.c). */
#ifndef HOOKE_SCENE_EXACT_H
#define HOOKE_SCENE_EXACT_H

#include <hooke/scene.h>

bool linear_has_exact(const struct system *system);
void linear_exact(const struct system *system, double t0, const double *start, double t, double *y, double *floor);

#endif
