/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Parameters of the oscillator: their indices P_m, P_k, ... in scene.value, in the order of
 * terms.def. */
#pragma once

#include "scene/model/model.h"

enum param {
#define PARAM(name, ...) P_##name,
#include "scene/model/terms.def"
    P_COUNT
};

_Static_assert(P_COUNT <= PARAM_MAX, "scene.value holds every parameter");

/* Returns true if k/m and the mass are usable numbers; otherwise sets an error with the values. */
bool params_coherent(const double *param, struct error *error);
/* Sets system->term to the terms of term_catalog whose coefficients are not 0, in their order. */
void terms_bind(const double *param, struct system *system);
