/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Catalogs: finding rows by name, alias or unique prefix, and suggestions for misspelled names. */
#include <hooke/base/catalog.h>
#include <hooke/base/limit.h>
#include <hooke/base/safe_text.h>
#include "base/internal.h"

#include <stdio.h>
#include <string.h>

const struct row *catalog_row(const struct catalog *catalog, size_t i)
{
    return (const struct row *)(const void *)((const char *)catalog->rows + i * catalog->stride);
}

/* Takes the next of the aliases, which are separated by spaces. Returns false at the end. */
static bool next_alias(struct text *rest, struct text *alias)
{
    while (text_split(rest, ' ', alias))
        if (alias->len > 0)
            return true;
    return false;
}

/* Returns true if name is the name of the row or one of its aliases. */
static bool row_is(const struct row *row, struct text name)
{
    if (text_is(name, row->name))
        return true;
    struct text rest = text_of(row->alias), alias;
    while (rest.len > 0 && next_alias(&rest, &alias))
        if (text_equal(alias, name))
            return true;
    return false;
}

/* Returns the row with that name or alias, or NULL. */
const struct row *catalog_find(const struct catalog *catalog, struct text name)
{
    for (size_t i = 0; i < catalog->count; i++)
        if (row_is(catalog_row(catalog, i), name))
            return catalog_row(catalog, i);
    return NULL;
}

/* Returns the row with that name, or else the only one whose name begins with it. Returns NULL if
 * there is none, if several begin with it, or if name has fewer than min characters. */
const struct row *catalog_prefix(const struct catalog *catalog, struct text name, size_t min)
{
    const struct row *found = catalog_find(catalog, name);
    if (found || name.len == 0 || name.len < min)
        return found;
    for (size_t i = 0; i < catalog->count; i++) {
        const struct row *row = catalog_row(catalog, i);
        if (!text_starts(text_of(row->name), name))
            continue;
        if (found)
            return NULL;
        found = row;
    }
    return found;
}

/* Returns true, with an error that gives the reason, if the name is that of a row which this build
 * lacks. */
bool catalog_absent(const struct catalog *catalog, struct text name, struct error *error)
{
    for (size_t i = 0; i < catalog->absences; i++) {
        if (!row_is(&catalog->absent[i], name))
            continue;
        error_at(error, name, "the %s %s is not available: %s", catalog->kind,
                 catalog->absent[i].name, catalog->absent[i].brief);
        return true;
    }
    return false;
}

/* Sets the error for a name that the catalog does not have: why its row is absent from this build,
 * or names that are spelled like it. Returns false. */
bool catalog_unknown(const struct catalog *catalog, struct text name, struct error *error)
{
    char shown[SAFE_NAME_SIZE];
    if (catalog_absent(catalog, name, error))
        return false;
    error_at(error, name, "unknown %s '%s'", catalog->kind, safe_name(name, shown));
    error->unknown = catalog->kind;
    struct suggestion suggestion = {.wanted = name};
    for (size_t i = 0; i < catalog->count; i++) {
        const struct row *row = catalog_row(catalog, i);
        suggestion_offer(&suggestion, row->name);
        struct text rest = text_of(row->alias), alias;
        while (next_alias(&rest, &alias)) {
            char z[LIMIT_NAME + 1];
            if (alias.len < sizeof z) {
                snprintf(z, sizeof z, "%.*s", (int)alias.len, alias.data);
                suggestion_offer(&suggestion, z);
            }
        }
    }
    suggestion_hint(&suggestion, error);
    return false;
}

static char lower(char c)
{
    return c >= 'A' && c <= 'Z' ? (char)(c - 'A' + 'a') : c;
}

/* Returns true if a and b differ at most in ASCII case. */
static bool same_but_case(struct text a, struct text b)
{
    if (a.len != b.len)
        return false;
    for (size_t i = 0; i < a.len; i++)
        if (lower(a.data[i]) != lower(b.data[i]))
            return false;
    return true;
}

/* Returns the largest distance of a misspelling of this length from the name that was meant. */
static int misspelling_distance(size_t len)
{
    if (len <= 3)
        return 1;
    return len <= 7 ? 2 : (int)(len / 3);
}

/* Inserts name into the best few candidates, ordered by distance, if it is near enough to the name
 * that was wanted and not yet among them. */
void suggestion_offer(struct suggestion *suggestion, const char *name)
{
    struct text wanted = suggestion->wanted, candidate = text_of(name);
    if (wanted.len == 0 || wanted.len > LIMIT_NAME || candidate.len >= sizeof suggestion->name[0])
        return;
    const int max_distance = misspelling_distance(wanted.len);
    int distance = text_distance(wanted, candidate);
    /* The beginning of a long name counts as near; a name that shares no letter never does. */
    if (same_but_case(wanted, candidate))
        distance = 0;
    else if (wanted.len >= 3 && distance > max_distance && text_starts(candidate, wanted))
        distance = max_distance;
    else if ((size_t)distance >= (wanted.len > candidate.len ? wanted.len : candidate.len))
        return;
    if (distance > max_distance)
        return;

    const int max = (int)COUNT_OF(suggestion->name);
    int index = suggestion->count;
    for (int i = 0; i < suggestion->count; i++)
        if (text_is(candidate, suggestion->name[i]))
            return;
    while (index > 0 && distance < suggestion->distance[index - 1])
        index--;
    if (index == max)
        return;
    for (int i = suggestion->count < max ? suggestion->count : max - 1; i > index; i--) {
        suggestion->distance[i] = suggestion->distance[i - 1];
        memcpy(suggestion->name[i], suggestion->name[i - 1], sizeof suggestion->name[i]);
    }
    suggestion->distance[index] = distance;
    memcpy(suggestion->name[index], name, candidate.len + 1);
    suggestion->count += suggestion->count < max;
}

/* Adds the candidates to the error as a question, if there are any. */
void suggestion_hint(const struct suggestion *suggestion, struct error *error)
{
    const char(*name)[sizeof suggestion->name[0]] = suggestion->name;
    if (suggestion->count == 1)
        error_hint(error, "did you mean '%s'?", name[0]);
    else if (suggestion->count == 2)
        error_hint(error, "did you mean '%s' or '%s'?", name[0], name[1]);
    else if (suggestion->count == 3)
        error_hint(error, "did you mean '%s', '%s' or '%s'?", name[0], name[1], name[2]);
    if (suggestion->count > 0)
        error->hint_kind = HINT_GUESS;
}

int catalog_index(const struct catalog *catalog, const struct row *row)
{
    return (int)((size_t)((const char *)row - (const char *)catalog->rows) / catalog->stride);
}
