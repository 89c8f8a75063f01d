/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module solving: solves of scenes that other modules share. It has no commands. */
#include <hooke/module.h>

const struct module solving_module = {
    .row = {"solving", "",
            "solutions without recording, and their derivatives by initial values and parameters",
            "", NULL},
    .needs = "",
};
