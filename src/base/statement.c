/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Splits lines into statements and words: the part of the grammar that needs no knowledge of
 * commands. */
#include <hooke/base/statement.h>

#include <string.h>

bool is_name_start(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

bool is_name_char(char c)
{
    return is_name_start(c) || (c >= '0' && c <= '9');
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* Returns the text without its first count bytes and the blanks that follow. */
struct text text_behind(struct text text, size_t count)
{
    struct text rest = {text.data + count, text.len - count};
    text_skip_blanks(&rest);
    return rest;
}

void text_skip_blanks(struct text *text)
{
    while (text->len > 0 && is_blank(text->data[0])) {
        text->data++;
        text->len--;
    }
}

void buffer_quote(struct buffer *output, struct text text)
{
    const bool raw = !memchr(text.data, '\'', text.len);
    buffer_char(output, raw ? '\'' : '"');
    for (size_t i = 0; i < text.len; i++)
        buffer_format(output, !raw && strchr("\"\\", text.data[i]) ? "\\%c" : "%c", text.data[i]);
    buffer_char(output, raw ? '\'' : '"');
}

/* Returns the number of bytes of the string that text starts with, including both quotes, or 0 if
 * it is not closed. */
size_t text_quoted(struct text text)
{
    const char quote = text.data[0];
    for (size_t i = 1; i < text.len; i++) {
        if (quote == '"' && text.data[i] == '\\')
            i++;
        else if (text.data[i] == quote)
            return i + 1;
    }
    return 0;
}

/* Returns true if a string begins at index i. A ' directly behind a name is a derivative mark or an
 * apostrophe. */
static bool opens_string(struct text text, size_t i)
{
    return text.data[i] == '"' ||
           (text.data[i] == '\'' &&
            (i == 0 || !(is_name_char(text.data[i - 1]) || text.data[i - 1] == '\'')));
}

/* Takes the next statement off the line, which ends at `;` or at a comment outside of strings.
 * Returns false with the error set if a string is not closed. */
bool next_statement(struct text *line, struct text *statement, struct error *error)
{
    size_t i = 0;
    const struct text all = *line;
    while (i < all.len && all.data[i] != ';') {
        if (opens_string(all, i)) {
            const struct text rest = {all.data + i, all.len - i};
            const size_t used = text_quoted(rest);
            if (used == 0) {
                error_at(error, (struct text){rest.data, 1},
                         "the string that begins here is not closed");
                error_hint(error, "close it with %c", rest.data[0]);
                return false;
            }
            i += used;
        } else if (all.data[i] == '#' && (i == 0 || is_blank(all.data[i - 1]))) {
            break;
        } else {
            i++;
        }
    }
    *statement = (struct text){all.data, i};
    if (i < all.len && all.data[i] == '#')
        i = all.len;
    *line = text_after(all, i < all.len ? i + 1 : i);
    text_skip_blanks(statement);
    while (statement->len > 0 && is_blank(statement->data[statement->len - 1]))
        statement->len--;
    return true;
}

/* Returns the word at the start of text, which ends at a blank, ';', a string or one of stops. */
struct text peek_word(struct text text, const char *stops)
{
    size_t i = 0;
    while (i < text.len && !is_blank(text.data[i]) && text.data[i] != ';' &&
           !opens_string(text, i) && !strchr(stops, text.data[i]))
        i++;
    return (struct text){text.data, i};
}

/* Returns the name at the start of text; a hyphen belongs to it if a letter follows. */
struct text peek_name(struct text text)
{
    size_t i = 0;
    if (text.len > 0 && is_name_start(text.data[0]))
        while (i < text.len &&
               (is_name_char(text.data[i]) ||
                (text.data[i] == '-' && i + 1 < text.len && is_name_start(text.data[i + 1]))))
            i++;
    return (struct text){text.data, i};
}
