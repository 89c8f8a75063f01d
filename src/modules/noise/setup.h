/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Setup that the commands of the module share: the scene with its noise and its stepping. */
#pragma once

#include "modules/noise/compute/paths.h"

#include <hooke/command/handler.h>

struct noise_setup {
    const struct scene *scene;
    struct noise_forcing forcing;
    const struct noise_method *method;
    double span, dt; /* [s] */
    uint64_t seed;
};

/* Reads these arguments of the command. NULL with `error` filled; memory of the statement. */
const struct noise_setup *noise_setup_read(struct session *session, const struct arguments *args,
                                           struct error *error);
/* Appends "gamma = 0.5 1/s, kT = 2 mJ, seed 1". */
void noise_setup_put(const struct noise_setup *setup, struct buffer *text);
/* That of energies of the scene: a number where it has no units. */
enum quantity noise_energy_quantity(const struct noise_setup *setup);
/* The same as fields of the open record, with the method and the grid. */
void noise_setup_reply(const struct noise_setup *setup, const struct path_grid *grid,
                       struct reply *reply);
/*
 * Stores a table of that kind for `export` and `> FILE`, with keys that say how it was made. Takes
 * over the table's arena. If out of memory the table is dropped. dt is 0 if there are several;
 * subject is the observed quantity, or NULL.
 */
void noise_keep_table(const struct noise_setup *setup, double dt, const char *kind,
                      const char *subject, struct arena *arena, const struct table *table,
                      struct reply *reply);
/* Warns of drag that has no noise of its own. */
void noise_setup_warn(const struct noise_setup *setup, struct reply *reply);
/* Refuses what would take more than this many bytes, or long without --force. */
bool noise_check_cost(struct session *session, const struct arguments *args,
                      const struct noise_setup *setup, double bytes, double steps,
                      struct error *error);
/* Finds the column `of` of the arguments, else the first variable. *shown: its name and quantity.
 * column->run is to be destroyed. */
bool noise_column(struct session *session, const struct arguments *args,
                  const struct noise_setup *setup, struct path_column *column,
                  struct variable *shown, struct error *error);
/* Returns the integer argument of that name, or `natural` where it was not given. */
int64_t noise_integer(const struct arguments *args, const char *name, int64_t natural);
/* Threads, cancellation and progress of the session. */
struct parallel noise_parallel(struct session *session, const struct arguments *args);

#define NOISE_ARGUMENTS                                                                            \
    KEY("kT", TYPE_VALUE, .quantity = QUANTITY_ENERGY, .group = 1),                                \
        KEY("temperature", TYPE_VALUE, .quantity = QUANTITY_NUMBER, .group = 1),                   \
        KEY("noise", TYPE_VALUE, .quantity = QUANTITY_NUMBER, .flags = ARG_MANY | ARG_NEGATIVE,    \
            .group = 1),                                                                           \
        KEY("gamma", TYPE_VALUE, .quantity = QUANTITY_RATE),                                       \
        KEY("dt", TYPE_VALUE, .quantity = QUANTITY_TIME),                                          \
        KEY("seed", TYPE_INTEGER, .flags = ARG_NEGATIVE), OPTION("force", TYPE_NONE)
#define NOISE_METHOD KEY("method", TYPE_CHOICE, .choices = &noise_method_catalog)
