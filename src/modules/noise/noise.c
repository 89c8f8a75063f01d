/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module noise: scenes in a heat bath or with noise of a stated strength. Its commands are
 * langevin, ensemble and noiseorder. */
#include "modules/noise/compute/forcing.h"

#include <hooke/module.h>

static const struct catalog *const catalogs[] = {&noise_method_catalog, NULL};

const struct module noise_module = {
    .row = {"noise", "", "scenes with noise: heat baths, ensembles, measured orders", "", NULL},
    .needs = "",
    .catalogs = catalogs,
};
