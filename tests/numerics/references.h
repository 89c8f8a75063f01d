/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The table of reference solutions, references.csv beside the recordings. */
#ifndef HOOKE_TESTS_REFERENCES_H
#define HOOKE_TESTS_REFERENCES_H

#include "unit/run_fixture.h"

#include <stdio.h>
#include <stdlib.h>

struct reference {
    char problem[40], parameters[160], component[16];
    double t, value;
};

/* One field, without its quotes; *rest moves past the comma. */
static inline struct text field(struct text *rest)
{
    struct text got;
    if (rest->len > 0 && rest->at[0] == '"') {
        struct text quoted = {rest->at + 1, rest->len - 1};
        text_split(&quoted, '"', &got);
        *rest = quoted;
        struct text nothing;
        text_split(rest, ',', &nothing);
        return got;
    }
    return text_split(rest, ',', &got) ? got : (struct text){NULL, 0};
}

static inline void keep(char *to, size_t size, struct text from)
{
    snprintf(to, size, "%.*s", (int)from.len, from.at);
}

/* NULL: there is none. */
static inline struct reference *read_table(size_t *count)
{
    char path[4096];
    struct buffer content = {0};
    struct error error;
    const char *data = getenv("HOOKE_DATA");
    snprintf(path, sizeof path, "%s/../references.csv", data ? data : "../shared/data");
    if (!file_read(path, 1 << 24, &content, &error)) {
        buffer_free(&content);
        return NULL;
    }
    struct reference *table = calloc(2000, sizeof *table);
    assert_non_null(table);
    struct text rest = buffer_text(&content), line;
    *count = 0;
    for (text_split(&rest, '\n', &line); text_split(&rest, '\n', &line) && *count < 2000;) {
        struct reference *row = &table[*count];
        size_t used;
        keep(row->problem, sizeof row->problem, field(&line));
        keep(row->parameters, sizeof row->parameters, field(&line));
        struct text t = field(&line);
        keep(row->component, sizeof row->component, field(&line));
        struct text value = field(&line);
        if (real_parse(t, &row->t) == REAL_OK && real_scan(value, '.', &row->value, &used) == REAL_OK)
            ++*count;
    }
    buffer_free(&content);
    return table;
}

/* Which variable a component is. */
static inline int place_of(const struct reference *row)
{
    const char *name = row->component;
    if (name[0] == 'y' && name[1])
        return name[1] - '1' + (name[2] ? 9 : 0);
    return text_is(text_of(name), "v") || text_is(text_of(name), "omega");
}

#endif
