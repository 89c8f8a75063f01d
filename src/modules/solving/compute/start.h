/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scene that is let start at a given state. */
#pragma once

#include <hooke/scene/model.h>

/* Gives a parameter a value without an uncertainty; one that has it already stays as it is. */
void scene_take_value(struct scene *scene, int i, double value);
/* Lets the scene start at that state [n]. Returns false if it cannot, or the value is out of its
 * range. */
bool scene_start_at(struct scene *scene, const double *state, struct error *error);
