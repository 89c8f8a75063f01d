/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where derivatives have poles and are not 0 all the same. */
#ifndef HOOKE_SCENE_POLES_H
#define HOOKE_SCENE_POLES_H

#include <hooke/scene/typed.h>

/*
 * Returns true if some derivative is 0 nowhere in a box [n] of states, where system_bounds() may
 * give no bounds because of a pole in it. False says nothing.
 */
bool system_excludes_zero(const struct system *system, const struct interval *box);

#endif
