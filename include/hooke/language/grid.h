/* SPDX-License-Identifier: GPL-3.0-or-later */
/* grid: values of a parameter in even steps, as sweep and basins read them: FROM:TO[:STEP]. */
#pragma once

#include <hooke/language.h>

/* Values first, …, last of one parameter. */
struct value_grid {
    /* Name of the parameter or setting; set by the caller, as is `quantity`. */
    char name[LIMIT_NAME + 1];
    enum quantity quantity; /* Quantity of the values. */
    double first, last;     /* First and last value [SI]. */
    /* Number of values. */
    int count;
    bool log; /* Values form a geometric sequence, as with xFACTOR. */
};

/* Number of values if no step is given. */
enum { GRID_VALUES_USUAL = 51 };

/* Reads FROM:TO, FROM:TO:STEP or FROM:TO:xFACTOR, after which no text may remain. grid->last
 * becomes the last value that the steps reach, which may be before TO. Returns false with `error`
 * set. */
bool parse_grid(struct parser *parser, struct value_grid *grid, struct error *error);

/* Removes the first argument NAME=… or --option from *rest and returns its text, which ends before
 * the next argument of this form or before the word `at`. */
struct text next_key_argument(struct text *rest);
