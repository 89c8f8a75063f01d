/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * catalog: tables whose rows users choose by name, such as methods, units and settings.
 *
 * A row is a struct that begins with a struct row (name, unit, one-line description). A catalog
 * describes an array of such structs; lookup, completion, lists and spelling suggestions work on
 * any catalog. Catalogs are constants of the program: nothing is owned or freed.
 */
#pragma once

#include <hooke/base/error.h>
#include <hooke/base/row.h>

/* A table of rows of one kind, initialised by CATALOG(). */
struct catalog {
    const char *kind; /* Kind of the rows in messages, such as "parameter" or "method". */
    /* Array of `count` structs, `stride` bytes apart, each of which begins with a struct row. */
    const void *rows;
    size_t count, stride;
    /* Array of `absences` rows of names that this build leaves out; each row's brief says why
     * it is missing and what to do. */
    const struct row *absent;
    size_t absences;
};

/* Initialiser of a struct catalog for a whole array; `absent` is empty. */
#define CATALOG(kind_name, array)                                                                  \
    {                                                                                              \
        (kind_name), (array), COUNT_OF(array), sizeof((array)[0]), NULL, 0                         \
    }

/* Returns row i, 0 <= i < count, which is not checked. */
const struct row *catalog_row(const struct catalog *catalog, size_t i);
/* Returns the index of a row, which must point into the catalog's array. */
int catalog_index(const struct catalog *catalog, const struct row *row);
/* Returns the row with this name or alias, or NULL if there is none. */
const struct row *catalog_find(const struct catalog *catalog, struct text name);
/* Returns the row with this name or alias; else, if `name` has at least `min` bytes, the only row
 * whose name begins with it. Returns NULL if no row or several rows match. */
const struct row *catalog_prefix(const struct catalog *catalog, struct text name, size_t min);
/* Returns true, with `error` set, if this name is one of the rows that this build leaves out. */
bool catalog_absent(const struct catalog *catalog, struct text name, struct error *error);
/* Sets the error "unknown KIND 'name'" with up to three similar names in its hint, or the error of
 * catalog_absent() if that applies. Always returns false. */
bool catalog_unknown(const struct catalog *catalog, struct text name, struct error *error);

/* Returns the optimal string alignment distance [byte] (Damerau–Levenshtein with adjacent
 * transpositions), or the larger length if one is longer than LIMIT_NAME. */
int text_distance(struct text a, struct text b);

/* Collects the three names that are most similar to `wanted`: initialise it with `wanted` alone,
 * call suggestion_offer() for each candidate, then suggestion_hint(). */
struct suggestion {
    /* The name that was typed, owned by the caller. */
    struct text wanted;
    /* [count] distance of each name by text_distance(), ascending; 0 if only upper and lower case
     * differ. */
    int distance[3];
    /* [count] copies of the names. */
    char name[3][64];
    /* Number of names collected so far, at most 3. */
    int count;
};

/* Offers a candidate, which is copied if it is similar enough and among the three best; otherwise
 * nothing changes. */
void suggestion_offer(struct suggestion *suggestion, const char *name);
/* Appends "did you mean …?" with the collected names to the error's hint, or nothing if there are
 * none. */
void suggestion_hint(const struct suggestion *suggestion, struct error *error);

/* ---- limits of the program that are shown to users ---- */

/* One limit of <hooke/base/limit.h> as a row for `list limits` and the manual. */
struct limit {
    struct row row; /* Name, unit and description. */
    double value;
};

extern const struct catalog limit_catalog;
