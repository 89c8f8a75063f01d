/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * scene: expressions, force terms, parameters, presets, exact solutions.
 *
 * A scene is what the user sets (parameters by name, in lab notation). scene_bind() turns it into a
 * system: the terms that are really there with their coefficients, which is all that integrators
 * see. A term whose coefficient is zero is not in the system and costs nothing.
 *
 * State vector of n variables: a second-order scene holds n/2 positions, then n/2 velocities; a
 * first-order scene holds n values. The spring is n = 2: y [m], v [m/s].
 */
#pragma once

#include <hooke/scene/formula.h>
#include <hooke/scene/model.h>
#include <hooke/scene/typed.h>
