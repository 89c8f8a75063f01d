/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Arguments that the commands of the module share: noise_setup_read() turns them into a scene with
 * its noise and steps. */
#pragma once

#include "modules/noise/compute/paths.h"

#include <hooke/command/handler.h>

/* A scene with its noise, and how it is stepped. */
struct noise_setup {
    const struct scene *scene;
    struct noise_forcing forcing;
    const struct noise_method *method;
    double span, dt; /* [s] */
    uint64_t seed;
};

/* Reads NOISE_ARGUMENTS of a command. The result is memory of the statement. Returns NULL with
 * *error on failure. */
const struct noise_setup *noise_setup_read(struct session *session, const struct arguments *args,
                                           struct error *error);
/* Appends "gamma = 0.5 1/s, kT = 2 mJ, seed 1". */
void noise_setup_put(const struct noise_setup *setup, struct buffer *text);
/* Returns the quantity of the scene's energies: a number if the scene has no units. */
enum quantity noise_energy_quantity(const struct noise_setup *setup);
/* Adds the same as fields of the open record, with method and steps. */
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
/* Warns if the scene has drag without noise of its own, so that it does not reach the
 * temperature. */
void noise_setup_warn(const struct noise_setup *setup, struct reply *reply);
/* Returns false with *error if a calculation needs too many bytes, or, without --force, if this
 * many steps would take long. */
bool noise_check_cost(struct session *session, const struct arguments *args,
                      const struct noise_setup *setup, double bytes, double steps,
                      struct error *error);
/* Finds the column that the argument `of` names, or the first variable, and sets *shown to its name
 * and quantity. The caller destroys column->run, which may be NULL. Returns false with *error. */
bool noise_column(struct session *session, const struct arguments *args,
                  const struct noise_setup *setup, struct path_column *column,
                  struct variable *shown, struct error *error);
/* Returns the integer argument of that name, or `natural` where it was not given. */
int64_t noise_integer(const struct arguments *args, const char *name, int64_t natural);
/* Returns threads as the arguments say, with the session's cancellation and progress. */
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
