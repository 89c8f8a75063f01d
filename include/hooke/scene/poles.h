/* SPDX-License-Identifier: GPL-3.0-or-later */
/* poles: functions for scenes whose derivatives have poles, as 1/x, or no value in some region of
 * state space, as sqrt(x). The search for equilibria calls them. */
#pragma once

#include <hooke/scene/typed.h>

/* Returns true if one of the derivatives is proved to be nonzero for all states in box [n], so that
 * the box contains no equilibrium. This also works where system_bounds() (<hooke/scene/typed.h>),
 * which computes bounds of all derivatives, fails because of a pole in the box. False proves
 * nothing. */
bool system_excludes_zero(const struct system *system, const struct interval *box);

/* Makes *system the system of a scene, as scene_bind() does, for a computation that does not use
 * the scene's initial values. If these are at a pole or where the equations have no value, the
 * initial values of a scene whose equations are all typed are moved to a state in the box where the
 * equations have values. box [n] holds the ends of the range of each variable; a variable with an
 * end that is NAN keeps its initial value. Returns false, with the error of scene_bind() and the
 * scene unchanged, if not all equations are typed or no such state is found. */
bool scene_bind_inside(struct scene *scene, double (*box)[2], struct system *system,
                       struct error *error);
