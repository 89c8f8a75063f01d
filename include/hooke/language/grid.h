/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Values that a statement asks for in steps: FROM:TO[:STEP]. */
#pragma once

#include <hooke/language.h>

struct value_grid {
    /* name of the parameter or setting with these values, for messages */
    char name[LIMIT_NAME + 1];
    enum quantity quantity;
    double first, last; /* SI, both included */
    int count;
    bool log; /* each is a multiple of the one before */
};

/* The number of values where no step is given. */
enum { GRID_VALUES_USUAL = 51 };

/*
 * Reads FROM:TO, FROM:TO:STEP or FROM:TO:xFACTOR, and nothing behind it, for a grid that has a name
 * and a quantity. `last` becomes the last value that the steps reach. Returns false with `error`
 * filled.
 */
bool parse_grid(struct parser *parser, struct value_grid *grid, struct error *error);

/* Takes the next of NAME=... or --option from the rest: up to a blank with another, or with 'at',
 * behind it. */
struct text next_key_argument(struct text *rest);
