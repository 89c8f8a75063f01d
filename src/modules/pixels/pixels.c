/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module pixels: figures as pictures in terminals that show them. */
#include <hooke/module.h>

const struct module pixels_module = {
    .row = {"pixels", "", "pictures in terminals: kitty, iTerm2, sixel", "", NULL},
    .needs = "pictures",
};
