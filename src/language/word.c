/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads words and quoted strings of a statement, with their escapes. */
#include <hooke/base/statement.h>
#include <hooke/language.h>

#include <string.h>

/* Copies the inside of a "..." string into the arena with its escapes replaced. Returns false with
 * an error for an unknown escape or if out of memory. */
static bool unescape(struct parser *parser, struct text inside, struct text *result,
                     struct error *error)
{
    char *copy = arena_alloc(parser->arena, inside.len + 1);
    if (!copy)
        return error_memory(error);
    size_t n = 0;
    for (size_t i = 0; i < inside.len; i++) {
        char c = inside.data[i];
        if (c == '\\') {
            static const char escape_letters[] = "nt\"\\", escaped[] = "\n\t\"\\";
            const char *known = strchr(escape_letters, inside.data[++i]);
            if (!known) {
                error_at(error, (struct text){inside.data + i - 1, 2},
                         "unknown escape in a string");
                return error_hint(error,
                                  "possible are \\n \\t \\\" \\\\; in '...' nothing is changed");
            }
            c = escaped[known - escape_letters];
        }
        copy[n++] = c;
    }
    *result = (struct text){copy, n};
    return true;
}

/* Copies a word into the arena without the backslashes before blanks. Returns false with an error
 * if out of memory. */
static bool word_unescape(struct parser *parser, struct text word, struct text *result,
                          struct error *error)
{
    char *copy = arena_alloc(parser->arena, word.len + 1);
    if (!copy)
        return error_memory(error);
    size_t n = 0;
    for (size_t i = 0; i < word.len; i++)
        if (word.data[i] != '\\' || i + 1 == word.len || word.data[i + 1] != ' ')
            copy[n++] = word.data[i];
    *result = (struct text){copy, n};
    return true;
}

/* Reads a string, or a word that ends at a blank or at a character of `stops`, into item->text.
 * Returns false with an error if a string is not closed or has an unknown escape. */
bool parse_word(struct parser *parser, const char *stops, struct item *item, struct error *error)
{
    struct text *rest = &parser->rest;
    if (rest->len > 0 && (rest->data[0] == '"' || rest->data[0] == '\'')) {
        const size_t used = text_quoted(*rest);
        if (used == 0)
            return error_at(error, (struct text){rest->data, 1},
                            "the string that begins here is not closed");
        const struct text inside = {rest->data + 1, used - 2};
        item->is_string = true;
        item->text = inside;
        /* The text is copied only if an escape changes it, because errors point into the line. */
        if (rest->data[0] == '"' && inside.len > 0 && memchr(inside.data, '\\', inside.len) &&
            !unescape(parser, inside, &item->text, error))
            return false;
        *rest = (struct text){rest->data + used, rest->len - used};
        return true;
    }
    size_t used = peek_word(*rest, stops).len, blanks = 0;
    /* A backslash takes the blank behind it into the word, as in a shell. */
    while (used > 0 && used < rest->len && rest->data[used - 1] == '\\' &&
           rest->data[used] == ' ') {
        const struct text remainder = {rest->data + used + 1, rest->len - used - 1};
        used += 1 + peek_word(remainder, stops).len;
        blanks++;
    }
    item->text = (struct text){rest->data, used};
    *rest = (struct text){rest->data + used, rest->len - used};
    return blanks == 0 || word_unescape(parser, item->text, &item->text, error);
}
