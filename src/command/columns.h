/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a run has to show over its rows: a state variable, what its scene observes, or an observable. */
#ifndef HOOKE_COMMAND_COLUMNS_H
#define HOOKE_COMMAND_COLUMNS_H

#include "internal.h"

struct chosen_column {
    const struct observable *observable; /* NULL: number `variable` of the state, or of what is observed behind it */
    int variable;
};

/* Whether both have the same things to show, in the same order: models may be typed anew with other laws. */
bool models_alike(const struct model *a, const struct model *b);
/* A user's names come before those of observables. Error: the model has nothing of that name. */
bool chosen_find(const struct model *model, struct text name, struct chosen_column *column, struct error *error);
/* Its name and quantity. */
struct variable chosen_variable(const struct system *system, const struct chosen_column *column);
/* SI, as in files. */
const char *chosen_unit(const struct system *system, const struct chosen_column *column);
/* Over all rows of the trace, into out [trace_count]. */
bool chosen_values(const struct run *run, const struct chosen_column *column, double *out, struct error *error);

#endif
