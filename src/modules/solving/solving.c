/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module solving: what solves a scene many times, for modules that do. */
#include <hooke/module.h>

const struct module solving_module = {
    .row = {"solving", "",
            "solutions without recording, and their derivatives by initial values and parameters",
            "", NULL},
    .needs = "",
};
