/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Form of an equilibrium: eigenvalues, eigenvectors, type, index. */
#pragma once

#include <hooke/scene/typed.h>
#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/orbits/field.h"

/*
 * Writes a built-in scene as one that is all typed, with the same state and values: of the texts in
 * the rows of its terms (those that are there), and what was typed on top of it. Natural sizes and
 * energies are those of typed scenes. Returns false with `error` filled if it fails.
 */
bool typed_written(struct typed_models *models, const struct scene *scene, struct scene *written,
                   struct error *error);

/* Writes the system as equations that have bounds. A built-in scene becomes the equations of its
 * terms, whose models must outlive `bounded`; *models is NULL if there are none. Returns false with
 * `error` filled if out of memory. */
bool scene_with_bounds(const struct scene *scene, const struct system *system,
                       struct typed_models **models, struct system *bounded, struct error *error);

/* The field at a state, of a drive its mean over a period, and its Jacobian [n][n], or NULL if not
 * wanted. */
void mean_field(const struct system *bounded, const double *y, double *rate, double *jacobian);

/* Determines the type of an equilibrium from the bounds of the Jacobian at its state (averaged
 * over the drive's period), and sets its eigenvalues and residual. Returns false if they are not
 * found. */
bool equilibrium_form(const struct vector_field *field, const struct system *bounded,
                      bool conservative, struct solution *solution, struct equilibrium_form *form);
