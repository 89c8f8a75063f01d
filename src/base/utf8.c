/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Decodes UTF-8, and folds and shortens texts to widths in columns. */
#include <hooke/base/safe_text.h>

#include <string.h>

/* Decodes the first character of *used bytes. Returns CODEPOINT_INVALID for bytes that are not
 * UTF-8 (wrong lengths, surrogates, numbers beyond Unicode). */
uint32_t text_codepoint(struct text text, size_t *used)
{
    static const uint32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};
    *used = text.len > 0;
    if (text.len == 0)
        return 0;
    const unsigned char first = (unsigned char)text.data[0];
    if (first < 0x80)
        return first;
    size_t len;
    if (first >= 0xF8)
        len = 0;
    else if (first >= 0xF0)
        len = 4;
    else if (first >= 0xE0)
        len = 3;
    else
        len = first >= 0xC0 ? 2 : 0;
    if (len == 0 || len > text.len)
        return CODEPOINT_INVALID;
    uint32_t codepoint = first & (0x7Fu >> len);
    for (size_t i = 1; i < len; i++) {
        const unsigned char next = (unsigned char)text.data[i];
        if ((next & 0xC0) != 0x80)
            return CODEPOINT_INVALID;
        codepoint = codepoint << 6 | (next & 0x3F);
    }
    if (codepoint < smallest[len] || codepoint > 0x10FFFF ||
        (codepoint >= 0xD800 && codepoint <= 0xDFFF))
        return CODEPOINT_INVALID;
    *used = len;
    return codepoint;
}

/* Returns the number of columns that the text takes. */
int text_width(struct text text)
{
    int width = 0;
    for (size_t used; text.len > 0; text.data += used, text.len -= used)
        width += codepoint_width(text_codepoint(text, &used));
    return width;
}

/* Appends words separated by blanks, or by newlines where a line would exceed the width. */
void buffer_folded(struct buffer *buffer, struct text text, int width)
{
    struct text word;
    int column = 0;
    while (text_split(&text, ' ', &word)) {
        const int columns = text_width(word);
        const bool fits = column > 0 && column + 1 + columns <= width;
        if (column > 0)
            buffer_char(buffer, fits ? ' ' : '\n');
        column = fits ? column + 1 + columns : columns;
        buffer_put(buffer, word);
    }
}

/* Returns the length [byte] of the separator between items that begins there, or 0 if there is
 * none; separators inside parentheses (depth > 0) do not count. */
static size_t separator_length(struct text rest, int depth)
{
    static const char *const separators[] = {"  ", ", ", "; ", ": ", " | ", " ("};
    for (size_t i = 0; i < COUNT_OF(separators) && depth == 0; i++)
        if (text_starts(rest, text_of(separators[i])))
            return strlen(separators[i]);
    return 0;
}

/* Returns as much of the text as fits into width columns. It ends at an item, without a loss that
 * *cut reports, if items fill half of the width; else at a word, else at a letter. */
struct text text_in_room(struct text text, int width, bool *cut)
{
    size_t items = 0, words = 0, letters = 0;
    int column = 0, depth = 0, item_columns = 0;
    *cut = false;
    if (text_width(text) <= width)
        return text;
    for (size_t position = 0, used; position < text.len && column <= width; position += used) {
        const struct text rest = {text.data + position, text.len - position};
        if (position > 0 && rest.data[-1] != ' ' && separator_length(rest, depth)) {
            items = position;
            item_columns = column;
        }
        if (position > 0 && rest.data[0] == ' ' && column <= width - 2)
            words = position;
        if (column <= width - 1)
            letters = position;
        depth += rest.data[0] == '(' || rest.data[0] == '[';
        depth -= depth > 0 && (rest.data[0] == ')' || rest.data[0] == ']');
        column += codepoint_width(text_codepoint(rest, &used));
    }
    if (items > 0 && 2 * item_columns >= width)
        return (struct text){text.data, items};
    *cut = true;
    return (struct text){text.data, words ? words : letters};
}
