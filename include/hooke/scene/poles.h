/* SPDX-License-Identifier: GPL-3.0-or-later */
/* poles: questions about scenes whose derivatives have poles, or no value in some region of state
 * space, as 1/x and sqrt(x). The search for equilibria asks them. */
#pragma once

#include <hooke/scene/typed.h>

/* Returns true if one of the derivatives is proved to be nonzero in the whole box [n] of states,
 * also where system_bounds() fails because of a pole in the box. False proves nothing. */
bool system_excludes_zero(const struct system *system, const struct interval *box);

/* Binds a scene for a computation that does not use its initial values. If these are at a pole or
 * outside the domain, the initial values of a scene whose equations are all typed are moved to a
 * state in the box [n] where the equations have values; a side of the box that is NAN leaves its
 * variable unchanged. Returns false, with the error of scene_bind() and the scene unchanged, if the
 * scene is of another kind or no such state is found. */
bool scene_bind_inside(struct scene *scene, double (*box)[2], struct system *system,
                       struct error *error);
