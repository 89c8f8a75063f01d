/* SPDX-License-Identifier: GPL-3.0-or-later */
/* figure_arguments: the arguments that `plot`, which draws a figure, and `say`, which describes it
 * in words, have in common, and the figure that these arguments describe. Call choose_figure(),
 * then make_figure(). */
#pragma once

#include <hooke/command/handler.h>

#include <hooke/plot.h>

/* Sets kind, columns and table of *request from the arguments: a plot of the catalog, or columns of
 * runs or of a result, over time or against another column. Returns false with `error` set. */
bool choose_figure(const struct arguments *args, struct figure_request *request,
                   struct error *error);

/* Makes the figure for the runs, recordings, window and ranges of the arguments; kind, width and
 * charset of *request must be set. If methods follow the name of a study's plot, these
 * methods are studied first, which may add notes to the reply. Memory is the statement's arena.
 * Returns false with `error` set.
 */
bool make_figure(struct session *session, const struct arguments *args,
                 struct figure_request *request, struct figure *figure, struct reply *reply,
                 struct error *error);

/* Replaces the legend below a text figure by labels in the figure itself, if there is room. Returns
 * false, with `error` set, if out of memory. */
bool label_curves(const struct session *session, const struct figure_request *request,
                  struct arena *arena, struct figure *figure, struct error *error);

/* Arguments of `plot` and `say`, for the list ARGUMENTS(…) of their rows, made by the macros of
 * <hooke/command/handler.h>: WORD is an argument `NAME item`, such as `run 2`; KEY one NAME=item,
 * such as window=0:5s; OPTION one --NAME. The name is followed by the type of the items and by
 * members of struct argument. ARG_OF allows the columns of a table (`against error of compare`),
 * ARG_MANY several items, ARG_ALL the word `all`. KEY("NAME", TYPE_SIDE) accepts NAME=FROM:TO with
 * the name of any variable. In the list the positional argument WHAT is before this macro, and the
 * arguments that only one of the commands has are after it. */
#define FIGURE_ARGUMENTS                                                                           \
    WORD("against", TYPE_COLUMN, .flags = ARG_OF), WORD("at", TYPE_EVENT),                         \
        WORD("of", TYPE_CHOICE, .choices = &result_catalog),                                       \
        WORD("run", TYPE_RUN, .flags = ARG_MANY | ARG_ALL), WORD("data", TYPE_RECORDING),          \
        KEY("window", TYPE_RANGE, .quantity = QUANTITY_TIME),                                      \
        KEY("x", TYPE_RANGE, .quantity = QUANTITY_OTHER),                                          \
        KEY("y", TYPE_RANGE, .quantity = QUANTITY_OTHER),                                          \
        KEY("NAME", TYPE_SIDE, .flags = ARG_MANY), OPTION("full", TYPE_NONE),                      \
        OPTION("log", TYPE_NONE), OPTION("band", TYPE_NONE), OPTION("next", TYPE_NONE)
