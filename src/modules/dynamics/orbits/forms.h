/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types of equilibria: eigenvalues, eigenvectors, type and index of an equilibrium, and systems
 * whose right-hand sides have bounds (interval arithmetic), from which they are computed. */
#pragma once

#include <hooke/scene/typed.h>
#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/orbits/field.h"

/* Converts a built-in scene to a typed one with the same state and values, from the texts of its
 * terms and the forces that the user has added. Natural sizes and energies are those of typed
 * scenes. `models` will own the new model. Returns false with *error on failure. */
bool typed_written(struct typed_models *models, const struct scene *scene, struct scene *written,
                   struct error *error);

/* Converts the system to equations that have bounds. A built-in scene with typed forces becomes a
 * typed one, whose *models must outlive `bounded` and are freed by typed_destroy(); *models is NULL
 * if there are none. Returns false with *error on failure. */
bool scene_with_bounds(const struct scene *scene, const struct system *system,
                       struct typed_models **models, struct system *bounded, struct error *error);

/* Computes the rates at a state, averaged over the drive's period, and their Jacobian [n][n] unless
 * it is NULL. */
void mean_field(const struct system *bounded, const double *y, double *rate, double *jacobian);

/* Determines type, index and eigenvectors of an equilibrium from the bounds of the Jacobian at its
 * state (averaged over the drive's period), and sets its eigenvalues and residual. Returns false if
 * eigenvalues are not found. */
bool equilibrium_form(const struct vector_field *field, const struct system *bounded,
                      bool conservative, struct solution *solution, struct equilibrium_form *form);
