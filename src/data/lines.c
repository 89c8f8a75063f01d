/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "table.h"

#include <math.h>
#include <string.h>
#include <strings.h>

#define WINDOW 256 /* [byte] so that neither end-of-line byte is looked for through the whole file */

static size_t line_length(struct text text)
{
    for (size_t from = 0; from < text.len; from += WINDOW) {
        const char *at = text.at + from;
        size_t len = text.len - from < WINDOW ? text.len - from : WINDOW;
        const char *feed = memchr(at, '\n', len);
        if (feed)
            len = (size_t)(feed - at);
        const char *carriage = memchr(at, '\r', len);
        if (carriage || feed)
            return from + (size_t)((carriage ? carriage : feed) - at);
    }
    return text.len;
}

bool table_line(struct text *rest, struct text *line)
{
    if (rest->len == 0)
        return false;
    *line = (struct text){rest->at, line_length(*rest)};
    struct text end = {rest->at + line->len, rest->len - line->len};
    size_t used = text_starts(end, TEXT("\r\r\n")) ? 3 : text_starts(end, TEXT("\r\n")) ? 2 : end.len > 0;
    *rest = (struct text){end.at + used, end.len - used};
    return true;
}

bool table_skipped(struct text line)
{
    line = text_trim(line);
    return line.len == 0 || line.at[0] == '#';
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

/* Where the field ends that starts at text[0] with a quote: behind the closing quote; "" inside stands for ". */
static size_t quoted_length(struct text text)
{
    size_t i = 1;
    for (; i < text.len; i++)
        if (text.at[i] == '"') {
            if (i + 1 >= text.len || text.at[i + 1] != '"')
                return i + 1;
            i++;
        }
    return i;
}

bool table_field(struct text *rest, char separator, struct text *field)
{
    if (rest->at == NULL)
        return false;
    struct text text = separator == ' ' ? text_trim(*rest) : *rest;
    size_t start = 0;
    while (start < text.len && is_blank(text.at[start]) && text.at[start] != separator)
        start++;
    size_t end = start;
    if (start < text.len && text.at[start] == '"')
        end += quoted_length((struct text){text.at + start, text.len - start});
    if (separator == ' ') {
        while (end < text.len && !is_blank(text.at[end]))
            end++;
    } else {
        const char *cut = end < text.len ? memchr(text.at + end, separator, text.len - end) : NULL;
        end = cut ? (size_t)(cut - text.at) : text.len;
    }
    *field = text_trim((struct text){text.at + start, end - start});
    if (field->len >= 2 && field->at[0] == '"' && field->at[field->len - 1] == '"')
        *field = text_trim((struct text){field->at + 1, field->len - 2});
    *rest = end < text.len ? (struct text){text.at + end + 1, text.len - end - 1} : (struct text){NULL, 0};
    return separator != ' ' || field->len > 0;
}

static bool is_word(struct text text, const char *word)
{
    return text.len == strlen(word) && strncasecmp(text.at, word, text.len) == 0;
}

enum cell table_cell(struct text field, char decimal, double *value)
{
    size_t used;
    *value = NAN;
    if (field.len == 0 || is_word(field, "nan"))
        return CELL_EMPTY;
    double number;
    enum real_status status = real_scan(field, decimal, &number, &used);
    if ((status == REAL_OK || status == REAL_UNDERFLOW) && used == field.len) {
        *value = number;
        return CELL_NUMBER;
    }
    const bool negative = field.at[0] == '-';
    struct text word = negative ? (struct text){field.at + 1, field.len - 1} : field;
    if (!is_word(word, "inf") && !is_word(word, "infinity") && !is_word(word, "\xE2\x88\x9E"))
        return CELL_WORD;
    *value = negative ? -HUGE_VAL : HUGE_VAL;
    return CELL_NUMBER;
}

size_t text_fitting(struct text text, size_t most)
{
    size_t len = text.len < most ? text.len : most;
    while (len > 0 && len < text.len && ((unsigned char)text.at[len] & 0xC0) == 0x80)
        len--;
    return len;
}

const char *short_name(struct text text, char out[SHORT_NAME])
{
    struct buffer shown = {0};
    safe_text(&shown, (struct text){text.at, text_fitting(text, SHORT_NAME)}, false);
    const bool cut = shown.len >= SHORT_NAME;
    const size_t len = shown.failed ? 0 : text_fitting(buffer_text(&shown), cut ? SHORT_NAME - 4 : SHORT_NAME - 1);
    if (len > 0)
        memcpy(out, shown.data, len);
    memcpy(out + len, cut ? "..." : "", cut ? 4 : 1);
    buffer_free(&shown);
    return out;
}
