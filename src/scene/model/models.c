/* SPDX-License-Identifier: GPL-3.0-or-later */
/* List of the built-in models. */
#include <hooke/base/catalog.h>
#include "scene/model/model.h"

const struct model *const scene_models[] = {
    &oscillator_model, &pendulum_model,     &elastic_pendulum_model,
    &kepler_model,     &henon_heiles_model, &prothero_robinson_model,
    &robertson_model,  &orego_model,        NULL,
};

const struct catalog no_derived = {"derived quantity",         NULL, 0,
                                   sizeof(struct derived_row), NULL, 0};
