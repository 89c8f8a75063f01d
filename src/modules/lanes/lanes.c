/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module lanes: it has no commands; other modules step their trajectories with it. */
#include <hooke/module.h>

extern const struct module lanes_module;

const struct module lanes_module = {
    .row = {"lanes", "", "many trajectories at once, in vectors, for other modules", "", NULL},
    .needs = "",
};
