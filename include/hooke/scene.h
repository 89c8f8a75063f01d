/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * scene: the equation of motion that users set up: expressions, force terms, parameters, presets,
 * typed equations, exact solutions. This header includes all of the layer.
 *
 * A struct scene holds what the user sets: a model and the values of its parameters. scene_bind()
 * makes a struct system from it, which is all that integrators see: the force terms with their
 * coefficients, without those whose coefficient is 0.
 *
 * A state of n variables is an array of n doubles in SI units: in a second-order scene n/2
 * positions, then their n/2 velocities; in a first-order scene n values. The spring has n = 2: y
 * [m], v [m/s].
 */
#pragma once

#include <hooke/scene/formula.h>
#include <hooke/scene/model.h>
#include <hooke/scene/typed.h>
