/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The cases that stress makes of a scene. */
#pragma once

#include "modules/comparison/compute/verify.h"

/* Appends the cases of a typed scene. Returns false if out of memory, or if there are more than
 * STRESS_MAX. */
bool stress_scene_cases(struct stress *stress, const struct stress_scene *source);
/* Sets the scene of the case. Returns false with the error if a parameter cannot have the value. */
bool stress_scene_set(const struct stress_case *what, struct scene *scene, struct error *error);
/* Returns the largest stable step [s] of the fastest of these states [states][n], or its time
 * constant if no step is stable or all are; infinite if they have none. */
double stress_limit(const struct system *system, const double *y, int states, int every,
                    const struct method *method);
