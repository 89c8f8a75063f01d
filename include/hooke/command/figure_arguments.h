/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The arguments of commands that draw or describe a figure. */
#pragma once

#include <hooke/command/handler.h>

#include <hooke/plot.h>

/* A kind of plot, or columns of runs or of a result: over time, or against another. */
bool choose_figure(const struct arguments *args, struct figure_request *request,
                   struct error *error);

/* The figure of the runs, recordings, window and ranges that were named; kind, width and charset
 * are chosen before. Methods behind the name of a study's plot are studied first, which adds notes
 * to the reply. Memory from the arena of the statement. */
bool make_figure(struct session *session, const struct arguments *args,
                 struct figure_request *request, struct figure *figure, struct reply *reply,
                 struct error *error);

/* Puts the legend below a text figure into the figure itself, where there is room for it. */
bool label_curves(const struct session *session, const struct figure_request *request,
                  struct arena *arena, struct figure *figure, struct error *error);

/* Arguments that both commands take; WHAT and special arguments are placed before and behind. */
#define FIGURE_ARGUMENTS                                                                           \
    WORD("against", TYPE_COLUMN, .flags = ARG_OF), WORD("at", TYPE_EVENT),                         \
        WORD("of", TYPE_CHOICE, .choices = &result_catalog),                                       \
        WORD("run", TYPE_RUN, .flags = ARG_MANY | ARG_ALL), WORD("data", TYPE_RECORDING),          \
        KEY("window", TYPE_RANGE, .quantity = QUANTITY_TIME),                                      \
        KEY("x", TYPE_RANGE, .quantity = QUANTITY_OTHER),                                          \
        KEY("y", TYPE_RANGE, .quantity = QUANTITY_OTHER),                                          \
        KEY("NAME", TYPE_SIDE, .flags = ARG_MANY), OPTION("full", TYPE_NONE),                      \
        OPTION("log", TYPE_NONE), OPTION("band", TYPE_NONE), OPTION("next", TYPE_NONE)
