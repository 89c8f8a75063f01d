/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Changes a scene so that it starts at a given state. */
#pragma once

#include <hooke/scene/model.h>

/* Sets parameter i to a value without an uncertainty. A parameter that has the value already keeps
 * its uncertainty. */
void scene_take_value(struct scene *scene, int i, double value);
/* Sets the parameters that are initial values so that the scene starts at that state [n]. Returns
 * false with an error if a variable has no such parameter or a value is out of range. */
bool scene_start_at(struct scene *scene, const double *state, struct error *error);
