/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Places of the parameters in scene.value: P_m, P_k, ... in the order of terms.def. */
#pragma once

#include "scene/model/model.h"

enum param {
#define PARAM(name, ...) P_##name,
#include "scene/model/terms.def"
    P_COUNT
};

_Static_assert(P_COUNT <= PARAM_MAX, "scene.value holds every parameter");

/* k/m and the mass itself must be usable numbers: refused otherwise, with the values. */
bool params_coherent(const double *param, struct error *error);
/* Binds the terms of term_catalog whose coefficients are not 0. */
void terms_bind(const double *param, struct system *system);
