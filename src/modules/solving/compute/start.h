/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scene that is let start at a given state. */
#ifndef HOOKE_MODULES_SOLVING_COMPUTE_START_H
#define HOOKE_MODULES_SOLVING_COMPUTE_START_H

#include <hooke/scene/model.h>

/* Gives a parameter a value without an uncertainty; one that has it already stays as it is. */
void scene_take_value(struct scene *scene, int i, double value);
/* Lets the scene start at that state [n]. Returns false if it cannot, or the value is out of its
 * range. */
bool scene_start_at(struct scene *scene, const double *state, struct error *error);

#endif
