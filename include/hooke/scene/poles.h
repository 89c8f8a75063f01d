/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes whose derivatives have poles or no value at all in places. */
#pragma once

#include <hooke/scene/typed.h>

/*
 * Returns true if some derivative is 0 nowhere in a box [n] of states, where system_bounds() may
 * give no bounds because of a pole in it. False says nothing.
 */
bool system_excludes_zero(const struct system *system, const struct interval *box);

/*
 * Binds a scene for what needs no start. Where its own start is on a pole or outside of the domain,
 * moves the initial values of a scene that is all typed into a box [n] of states, to where its
 * equations have values; sides that are NAN leave theirs unchanged. Returns false with the scene's
 * own error if it is of another kind or no such state is found.
 */
bool scene_bind_inside(struct scene *scene, double (*box)[2], struct system *system,
                       struct error *error);
