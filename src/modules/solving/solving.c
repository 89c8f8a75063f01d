/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module solving: what solves a scene many times, for modules that do. */
#include <hooke/module.h>

const struct module solving_module = {
    .row = {"solving", "", "solves without recording, and how they vary with start and parameters",
            "", NULL},
    .needs = "",
};
