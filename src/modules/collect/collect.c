/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The module collect: recordings from sensors, line by line as they come. */
#include "modules/collect/collecting.h"

const struct module collect_module = {
    .row = {"collect", "", "recordings from sensors while they measure", "", NULL},
    .needs = "recording solving",
    .part_size = sizeof(struct collect_part),
    .prompt = {.next = collect_next, .state = collect_state},
};
