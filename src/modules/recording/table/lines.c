/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lines, fields and cells of tables: cuts lines and fields off a text, and reads numbers, stamps
 * and words. */
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include "modules/recording/table/stamp.h"
#include "modules/recording/table/table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* [byte] Length of text that is searched at once for either line end, so that a missing one is not
 * searched through the whole file. */
#define WINDOW_BYTES 256

/* Returns the number of bytes before the line's end (CR or LF), or all if it has none. */
static size_t line_length(struct text text)
{
    for (size_t offset = 0; offset < text.len; offset += WINDOW_BYTES) {
        const char *cursor = text.data + offset;
        size_t len = text.len - offset < WINDOW_BYTES ? text.len - offset : WINDOW_BYTES;
        const char *feed = memchr(cursor, '\n', len);
        if (feed)
            len = (size_t)(feed - cursor);
        const char *carriage = memchr(cursor, '\r', len);
        if (carriage || feed)
            return offset + (size_t)((carriage ? carriage : feed) - cursor);
    }
    return text.len;
}

/* Splits the next line off *rest, at a line end of any kind (LF, CR, CR LF, CR CR LF). Returns
 * false at the end. */
bool table_line(struct text *rest, struct text *line)
{
    if (rest->len == 0)
        return false;
    *line = (struct text){rest->data, line_length(*rest)};
    struct text end = {rest->data + line->len, rest->len - line->len};
    size_t used = end.len > 0;
    if (text_starts(end, TEXT("\r\r\n")))
        used = 3;
    else if (text_starts(end, TEXT("\r\n")))
        used = 2;
    *rest = text_after(end, used);
    return true;
}

/* Returns true for lines that begin with #, %, or sigrok's "; word". */
bool table_comment(struct text line)
{
    line = text_trim(line);
    return line.len > 0 && (line.data[0] == '#' || line.data[0] == '%' ||
                            (line.len > 2 && line.data[0] == ';' && line.data[1] == ' ' &&
                             ((line.data[2] | 32) >= 'a' && (line.data[2] | 32) <= 'z')));
}

/* Returns true for a rule drawn below the names, such as "-----|----". */
static bool is_rule(struct text line)
{
    size_t strokes = 0;
    for (size_t i = 0; i < line.len; i++) {
        if (!strchr("-=_+|\t ", line.data[i]) || !line.data[i])
            return false;
        strokes += strchr("-=_", line.data[i]) != NULL;
    }
    return strokes >= 3;
}

bool table_skipped(struct text line)
{
    line = text_trim(line);
    return line.len == 0 || table_comment(line) || is_rule(line);
}

static bool is_blank(char c)
{
    return c == ' ' || c == '\t';
}

/* Returns the length of the field that starts at text[0] with a quote, including the closing quote;
 * "" inside represents ". */
static size_t quoted_length(struct text text)
{
    size_t i = 1;
    for (; i < text.len; i++)
        if (text.data[i] == '"') {
            if (i + 1 >= text.len || text.data[i + 1] != '"')
                return i + 1;
            i++;
        }
    return i;
}

/* Returns the end of the text before the first "->", or NULL. */
static const char *find_arrow(struct text text)
{
    for (size_t i = 0; i + 1 < text.len; i++)
        if (text.data[i] == '-' && text.data[i + 1] == '>')
            return text.data + i;
    return NULL;
}

/* Splits off a time stamp in brackets, which terminal programs put before each line: "[2024-01-05
 * 12:30:45.000] 27.00". The bracket ends the field, whatever the separator is; so does, unless
 * blanks separate, the arrow in "12:30:45.123 -> 27.00,3.1". Returns false if there is none. */
static bool stamp_before_line(struct text *rest, char separator, struct text *field)
{
    const struct text text = text_trim(*rest);
    struct stamp stamp;
    const bool bracket = text.len > 0 && text.data[0] == '[';
    const char *close = NULL;
    if (bracket)
        close = memchr(text.data, ']', text.len);
    else if (separator != ' ' && text.len > 4 && (text.data[1] == ':' || text.data[2] == ':'))
        close = find_arrow(text);
    if (!close)
        return false;
    const char *end = bracket ? close + 1 : close + 2;
    const struct text inside = text_trim((struct text){text.data + bracket,
                                                       (size_t)(close - text.data) - bracket}),
                      tail = text_trim((struct text){end, (size_t)(text.data + text.len - end)});
    if (!stamp_parse(inside, &stamp))
        return false;
    const bool marked = tail.len > 0 && strchr(",;", tail.data[0]);
    *field = inside;
    *rest = tail.len > 0 ? text_after(tail, marked) : (struct text){NULL, 0};
    return true;
}

/* Splits the next field off *rest: a stamp in brackets, a quoted text, or the text up to the
 * separator, without quotes and blanks around it. Returns false if none is left. */
bool table_field(struct text *rest, char separator, struct text *field)
{
    if (rest->data == NULL)
        return false;
    struct text text = separator == ' ' ? text_trim(*rest) : *rest;
    size_t start = 0;
    if (stamp_before_line(rest, separator, field))
        return true;
    while (start < text.len && is_blank(text.data[start]) && text.data[start] != separator)
        start++;
    size_t end = start;
    if (start < text.len && text.data[start] == '"')
        end += quoted_length(text_after(text, start));
    if (separator == ' ') {
        while (end < text.len && !is_blank(text.data[end]))
            end++;
    } else {
        const char *cut =
            end < text.len ? memchr(text.data + end, separator, text.len - end) : NULL;
        end = cut ? (size_t)(cut - text.data) : text.len;
    }
    *field = text_trim((struct text){text.data + start, end - start});
    if (field->len >= 2 && field->data[0] == '"' && field->data[field->len - 1] == '"')
        *field = text_trim((struct text){field->data + 1, field->len - 2});
    *rest = end < text.len ? text_after(text, end + 1) : (struct text){NULL, 0};
    return separator != ' ' || field->len > 0;
}

static bool is_word(struct text text, const char *word)
{
    return text.len == strlen(word) && strncasecmp(text.data, word, text.len) == 0;
}

/* Returns true for an empty field and for words that programs write in place of a number. */
static bool is_missing(struct text field)
{
    static const char *const words[] = {
        "nan", "-nan", "na",  "n/a",          "#n/a",   "#nv",     "null",    "none",
        "-",   "--",   "---", "\xE2\x80\x93", "1.#ind", "-1.#ind", "#div/0!", "#value!"};
    for (size_t i = 0; i < COUNT_OF(words); i++)
        if (is_word(field, words[i]))
            return true;
    return field.len == 0;
}

/* Returns the length of a blank or apostrophe between groups of digits at the start of the text, or
 * 0. */
static size_t group_blank(struct text rest)
{
    static const char *const blanks[] = {"\xE2\x80\xAF", "\xE2\x80\x89", "\xC2\xA0", "\xE2\x80\x99",
                                         "'"};
    for (size_t i = 0; i < COUNT_OF(blanks); i++)
        if (text_starts(rest, text_of(blanks[i])))
            return strlen(blanks[i]);
    return 0;
}

/* Longest number in an unusual spelling. */
enum { ODD_MAX = 48 };

/* Rewrites a number in an unusual spelling (Unicode's minus, Fortran's D, marks between groups of
 * three digits) to a plain one in `output`. `decimal` is the decimal mark; the other of point and
 * comma marks groups. A single group without decimals, such as 16,500, is ambiguous and counts as a
 * group only if `single` is set. Returns the length of the output, or 0 if it is too long,
 * malformed or not unusual. */
static size_t plain_digits(struct text field, char decimal, bool single, char output[ODD_MAX])
{
    const char group = decimal == '.' ? ',' : '.';
    size_t len = 0, group_digits = 0, groups = 0, blanks = 0;
    bool point = false, odd = false;
    for (size_t i = 0; i < field.len;) {
        const struct text rest = {field.data + i, field.len - i};
        const size_t blank = len > 0 && is_digit_char(output[len - 1]) ? group_blank(rest) : 0;
        char c = field.data[i];
        if (len + 1 >= ODD_MAX)
            return 0;
        if (blank > 0 || (c == group && !point && group_digits >= 1 && group_digits <= 3 &&
                          (groups == 0 || group_digits == 3))) {
            groups += blank == 0;
            blanks += blank > 0;
            if ((groups + blanks > 1 && group_digits != 3) || point)
                return 0;
            group_digits = 0;
            odd = true;
            i += blank > 0 ? blank : 1;
            continue;
        }
        if (text_starts(rest, TEXT("\xE2\x88\x92"))) {
            c = '-';
            i += 2;
            odd = true;
        } else if ((c == 'D' || c == 'd') && len > 0 &&
                   (is_digit_char(output[len - 1]) || output[len - 1] == decimal)) {
            c = 'E';
            odd = true;
        }
        if ((c == decimal || c == 'E') && groups + blanks > 0 && group_digits != 3 && !point)
            return 0;
        point |= c == decimal || c == 'E';
        group_digits = is_digit_char(c) ? group_digits + 1 : 0;
        output[len++] = c;
        i++;
    }
    const bool whole_groups = groups + blanks == 0 || point || group_digits == 3;
    return odd && whole_groups && (groups != 1 || blanks > 0 || point || single) ? len : 0;
}

/* Reads a number in an unusual spelling into *value; the parameters are those of plain_digits().
 * Returns false, with *value unchanged, if the field is not such a number. */
static bool odd_number(struct text field, char decimal, bool single, double *value)
{
    char digits[ODD_MAX];
    size_t used;
    double number;
    const struct text plain = {digits, plain_digits(field, decimal, single, digits)};
    if (plain.len == 0 || real_scan(plain, decimal, &number, &used) != REAL_OK || used != plain.len)
        return false;
    *value = number;
    return true;
}

bool table_grouped(struct text field, char decimal, double *value)
{
    return odd_number(field, decimal, true, value);
}

/* Reads a cell as a number, an empty cell, an unusual number, a time stamp, a number with a unit,
 * or infinity, in that order. Sets *value (NAN if it has none; of stamps in seconds) and returns
 * the kind. */
enum cell_kind table_cell(struct text field, char decimal, double *value)
{
    size_t used;
    double number;
    struct stamp stamp;
    *value = NAN;
    if (field.len == 0)
        return CELL_EMPTY;
    enum real_status status = real_scan(field, decimal, &number, &used);
    if ((status == REAL_OK || status == REAL_UNDERFLOW) && used == field.len) {
        *value = number;
        return CELL_NUMBER;
    }
    if (is_missing(field))
        return CELL_EMPTY;
    if (odd_number(field, decimal, false, value))
        return CELL_NUMBER;
    if (stamp_parse(field, &stamp)) {
        *value = (double)stamp.day * 86400 + stamp.second;
        return CELL_STAMP;
    }
    struct text unit;
    if (number_with_unit(field, decimal, value, &unit))
        return CELL_NUMBER;
    const bool negative = field.data[0] == '-';
    struct text word = negative ? text_after(field, 1) : field;
    if (!is_word(word, "inf") && !is_word(word, "infinity") && !is_word(word, "\xE2\x88\x9E"))
        return CELL_WORD;
    *value = negative ? -HUGE_VAL : HUGE_VAL;
    return CELL_NUMBER;
}

/* Steps back from a cut within a character of UTF-8. */
size_t text_fitting(struct text text, size_t max)
{
    size_t len = text.len < max ? text.len : max;
    while (len > 0 && len < text.len && ((unsigned char)text.data[len] & 0xC0) == 0x80)
        len--;
    return len;
}

/* Makes the text safe first, then cuts it so that the dots fit. */
const char *short_name(struct text text, char output[SHORT_NAME])
{
    struct buffer shown = {0};
    safe_text(&shown, (struct text){text.data, text_fitting(text, SHORT_NAME)}, false);
    const bool cut = shown.len >= SHORT_NAME;
    const size_t max = cut ? SHORT_NAME - 4 : SHORT_NAME - 1;
    const size_t len = shown.failed ? 0 : text_fitting(buffer_text(&shown), max);
    snprintf(output, SHORT_NAME, "%.*s%s", (int)len, buffer_view(&shown), cut ? "..." : "");
    buffer_free(&shown);
    return output;
}
