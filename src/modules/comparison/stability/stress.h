/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The cases that stress makes of a scene. */
#pragma once

#include "modules/comparison/compute/verify.h"

/* Appends them. False: no memory, or more than STRESS_MAX. */
bool stress_scene_cases(struct stress *stress, const struct stress_scene *source);
/* The scene as the case has it; false: a parameter cannot be that. */
bool stress_scene_set(const struct stress_case *what, struct scene *scene, struct error *error);
/* [s] largest stable step of the fastest of these states [states][n], else its time constant;
 * infinite: they have none.
 */
double stress_limit(const struct system *system, const double *y, int states, int every,
                    const struct method *method);
