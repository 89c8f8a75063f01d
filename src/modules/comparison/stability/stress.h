/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Cases that `stress scene` makes of the caller's scene: stress_scene_cases() lists them,
 * stress_scene_set() makes the scene of one, stress_limit() the unit of its step. */
#pragma once

#include "modules/comparison/compute/verify.h"

/* Appends the cases of a scene to stress->cases. Returns false if out of memory, or if there are
 * more than STRESS_MAX (stress->count is STRESS_MAX then). */
bool stress_scene_cases(struct stress *stress, const struct stress_scene *source);
/* Makes *scene the caller's scene with the change of the case. Returns false with an error if a
 * parameter cannot have the value. */
bool stress_scene_set(const struct stress_case *what, struct scene *scene, struct error *error);
/* Returns the largest stable step [s] of the method for the fastest mode of the states y
 * [states][n], of which each `every`-th is examined. Returns the time constant of that mode if no
 * step is stable or all are, and HUGE_VAL if no state has a mode. */
double stress_limit(const struct system *system, const double *y, int states, int every,
                    const struct method *method);
