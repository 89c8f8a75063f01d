/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * catalog: everything that can be chosen by name is a row in a table.
 *
 * Every row struct starts with a struct row; find, completion, help and suggestions are written
 * once, here.
 */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/row.h>

struct catalog {
    const char *kind; /* "parameter", "method", …: used in messages */
    const void *rows;
    size_t count, stride;
    const struct row
        *absent; /* names that this build was made without; the brief says why and what to do */
    size_t absences;
};

#define CATALOG(kind_name, array)                                                                  \
    {                                                                                              \
        (kind_name), (array), COUNT_OF(array), sizeof((array)[0]), NULL, 0                         \
    }

const struct row *catalog_row(const struct catalog *catalog, size_t i);
/* the row has to be one of the catalog's */
int catalog_index(const struct catalog *catalog, const struct row *row);
/* Returns the row with this name or alias, or NULL. */
const struct row *catalog_find(const struct catalog *catalog, struct text name);
/* Returns the row with this name, else the only one whose name starts with it if it has at least
 * `min` letters; NULL if there is none or there are several. */
const struct row *catalog_prefix(const struct catalog *catalog, struct text name, size_t min);
/* Sets the error and returns true if this build was made without the row of this name. */
bool catalog_absent(const struct catalog *catalog, struct text name, struct error *error);
/* Sets the error "unknown KIND 'name'" with up to three similar names in its hint. Returns false.
 */
bool catalog_unknown(const struct catalog *catalog, struct text name, struct error *error);

/* Returns the optimal string alignment distance [byte] (Damerau–Levenshtein with adjacent
 * transpositions), or the larger length if one is longer than LIMIT_NAME. */
int text_distance(struct text a, struct text b);

/* The three names most similar to `wanted`: they are offered one by one. */
struct suggestion {
    struct text wanted;
    int distance[3];
    char name[3][64];
    int count;
};

void suggestion_offer(struct suggestion *suggestion, const char *name);
/* Appends "did you mean …?" to the error's hint, or nothing if no name is similar. */
void suggestion_hint(const struct suggestion *suggestion, struct error *error);

/* ---- limits ---- */

struct limit {
    struct row row; /* name, unit, brief */
    double value;
};

extern const struct catalog limit_catalog;
