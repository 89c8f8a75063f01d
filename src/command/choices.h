/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Closed lists of words that only commands know; each letter stands at its word's place. */
#ifndef HOOKE_COMMAND_CHOICES_H
#define HOOKE_COMMAND_CHOICES_H

#include "internal.h"

extern const struct catalog separator_catalog, decimal_catalog, quantity_catalog, show_catalog, list_catalog;

static const char separator_letters[] = "\t,; ";
static const char decimal_letters[] = ".,";

/* At their places in quantity_catalog. */
enum measurable {
    MEASURE_PERIOD,
    MEASURE_FREQUENCY,
    MEASURE_AMPLITUDE,
    MEASURE_DECAY,
    MEASURE_ENERGY,
    MEASURE_DRIFT,
    MEASURE_REYNOLDS,
    MEASURE_K,
    MEASURE_SPRING,
    MEASURE_SPECTRUM,
    MEASURE_REPEAT
};

enum shown { SHOW_ALL, SHOW_SCENE, SHOW_RUN, SHOW_DATA, SHOW_PLOT, SHOW_FILES };

enum listed {
    LIST_COMMANDS,
    LIST_SCENES,
    LIST_METHODS,
    LIST_PARAMETERS,
    LIST_DERIVED,
    LIST_OBSERVABLES,
    LIST_SETTINGS,
    LIST_UNITS,
    LIST_FUNCTIONS,
    LIST_FORMATS,
    LIST_LIMITS,
    LIST_MEASUREMENTS,
    LIST_EVENTS,
    LIST_RUNS,
    LIST_RECORDINGS
};

#endif
