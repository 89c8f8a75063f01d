/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads sampling rates and other numbers from the lines above a table. */
#include <hooke/base/number.h>
#include "modules/recording/table/table.h"

#include <string.h>
#include <strings.h>

/* Lines that are examined. */
#define LINES_MAX 64

/* Returns the text after the key in a line, in any case, or NULL. */
static const char *find_key(struct text line, const char *key)
{
    const size_t len = strlen(key);
    for (size_t i = 0; i + len <= line.len; i++)
        if (strncasecmp(line.data + i, key, len) == 0)
            return line.data + i + len;
    return NULL;
}

/* Finds the key in the first lines of the text and reads the number after it into *value; *rest is
 * what follows. Returns false if there is none. */
bool head_number(const struct table_text *text, const char *key, double *value, struct text *rest)
{
    for (size_t i = 0; i < text->heads && i < LINES_MAX; i++) {
        const struct text line = text->head[i].text;
        const char *cursor = find_key(line, key), *end = line.data + line.len;
        size_t used = 0;
        while (cursor && cursor < end && (*cursor == '\0' || strchr(" \t:=,;\"", *cursor)))
            cursor++;
        if (!cursor || cursor == end)
            continue;
        const enum real_status status =
            real_scan((struct text){cursor, (size_t)(end - cursor)}, '.', value, &used);
        if (status == REAL_OK && used > 0) {
            *rest = text_trim((struct text){cursor + used, (size_t)(end - cursor) - used});
            return true;
        }
    }
    return false;
}

/* Returns the sampling rate [Hz] that the header states, as a sample interval or as a rate with a
 * unit, or 0 if none. */
double table_rate(const struct table_text *text)
{
    static const struct {
        const char *unit;
        double factor;
    } units[] = {{"MHz", 1e6}, {"kHz", 1e3}, {"mHz", 1e-3}, {"Hz", 1}, {"S/s", 1}, {"samples", 1}};
    double value;
    struct text rest;
    if (head_number(text, "sample interval", &value, &rest) && value > 0)
        return 1 / value;
    if (!head_number(text, "rate", &value, &rest) || !(value > 0))
        return 0;
    for (size_t i = 0; i < COUNT_OF(units); i++)
        if (text_starts(rest, text_of(units[i].unit)))
            return value * units[i].factor;
    return rest.len == 0 ? value : 0;
}
