/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes whose derivatives have poles or no value at all in places. */
#ifndef HOOKE_SCENE_POLES_H
#define HOOKE_SCENE_POLES_H

#include <hooke/scene/typed.h>

/*
 * Returns true if some derivative is 0 nowhere in a box [n] of states, where system_bounds() may
 * give no bounds because of a pole in it. False says nothing.
 */
bool system_excludes_zero(const struct system *system, const struct interval *box);

/*
 * Moves the initial values of a scene that is all typed into a box [n] of states, to where its
 * equations have values, and binds it. For what needs no start, where the scene's own is on a pole
 * or outside of the domain. Returns false if the scene is of another kind or no such state is
 * found.
 */
bool scene_bind_inside(struct scene *scene, double (*box)[2], struct system *system);

#endif
