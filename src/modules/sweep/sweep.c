/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The row of the module sweep. */
#include "modules/sweep/file.h"
#include "modules/sweep/handlers.h"

static const struct catalog *const catalogs[] = {&sweep_measure_catalog, NULL};

const struct module sweep_module = {
    .row = {"sweep", "", "varies one or two quantities: tables, maps, orbit diagrams", "", NULL},
    .needs = "lanes",
    .part_size = sizeof(struct sweep_part),
    .part_free = sweep_part_free,
    .stopped = {.waits = sweep_waits, .go_on = sweep_continue, .forget = sweep_forget_stopped},
    .option =
        {
            .word = "check-sweep",
            .shown = " FILES",
            .brief = "check that files of a sweep, or its shards, have each point once",
            .wants = "files",
            .run = sweep_check,
        },
    .catalogs = catalogs,
    .complete = sweep_complete,
};
