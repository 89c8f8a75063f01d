/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Splits .ode files into lines: x[1..9]'=… and groups between %[1..9] and % are written out. */
#include <stdio.h>
#include <string.h>

#include "modules/xppaut/ode.h"

/* Lines that were read so far. */
struct ode_lines {
    struct arena *arena;
    struct error *error;
    struct ode_line *line; /* [count] in the arena */
    int count, capacity;
    size_t bytes; /* size of their texts */
};

/* Sets the error "line N: ...". Returns false. */
bool ode_error(struct error *error, int line, const char *format, ...)
{
    char text[sizeof error->text];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    error_set(error, ERROR_IO, "line %d: %s", line, text);
    return false;
}

/* Adds a copy of `text` without blanks at its ends, as line `number` of the file, unless it is
 * empty. Returns false with an error if there are too many lines or bytes, or if out of memory. */
static bool ode_line_add(struct ode_lines *r, struct text text, int number)
{
    text = text_trim(text);
    if (text.len == 0)
        return true;
    r->bytes += text.len;
    if (r->count == ODE_LINES || r->bytes > ODE_TEXT)
        return ode_error(r->error, number, "arrays expand to more than %d lines or %zu bytes",
                         ODE_LINES, ODE_TEXT);
    if (r->count == r->capacity) {
        const int capacity = r->capacity ? 2 * r->capacity : 64;
        struct ode_line *more = arena_array(r->arena, (size_t)capacity, sizeof *more);
        if (!more)
            return error_memory(r->error);
        if (r->count)
            memcpy(more, r->line, (size_t)r->count * sizeof *more);
        r->line = more;
        r->capacity = capacity;
    }
    char *copy = arena_text(r->arena, text);
    if (!copy)
        return error_memory(r->error);
    r->line[r->count++] = (struct ode_line){{copy, text.len}, number};
    return true;
}

/* ---- arrays ---- */

/* Returns the integer at the begin of the text, at most about 1e7, or 0 if there is none. */
static long leading_integer(struct text text)
{
    long value = 0;
    text = text_trim(text);
    const bool negative = text.len > 0 && text.data[0] == '-';
    for (size_t i = negative; i < text.len && text.data[i] >= '0' && text.data[i] <= '9'; i++)
        value = value < 1000000 ? 10 * value + (text.data[i] - '0') : value;
    return negative ? -value : value;
}

/* Returns the first character c of the text, or NULL if there is none. */
static const char *text_find(struct text text, char c)
{
    return text.len > 0 ? memchr(text.data, c, text.len) : NULL;
}

/* Reads an index in brackets, 5, j, j+1, j-1 or j*2, into *value; *j is the index of the array, and
 * j is NULL outside of arrays. `number` is the number of the line, for messages. Returns false with
 * an error. */
static bool read_subscript(struct text inside, const long *j, int number, long *value,
                           struct error *error)
{
    inside = text_trim(inside);
    const bool letter = inside.len > 0 && inside.data[0] == 'j';
    struct text rest = letter ? text_trim(text_after(inside, 1)) : inside;
    const char sign = letter && rest.len > 0 ? rest.data[0] : '+';
    if (letter && !j)
        return ode_error(error, number, "[j] is used outside of an array");
    if (letter && rest.len > 0)
        rest = text_trim(text_after(rest, 1));
    size_t digits = !letter && rest.len > 0 && rest.data[0] == '-';
    while (digits < rest.len && rest.data[digits] >= '0' && rest.data[digits] <= '9')
        digits++;
    if (digits != rest.len || (!letter && rest.len == 0) || !strchr("+-*", sign))
        return ode_error(error, number,
                         "[%.*s] is not an index of an array; use a number, j, j+1 or j*2",
                         (int)(inside.len < 40 ? inside.len : 40), inside.data);
    if (!letter)
        *value = leading_integer(rest);
    else if (sign == '*')
        *value = *j * leading_integer(rest);
    else
        *value = *j + (sign == '-' ? -leading_integer(rest) : leading_integer(rest));
    return true;
}

/* Returns true if the bracket at that position belongs to an integral such as int[.5]. */
static bool is_kernel(const struct text line, size_t index) /* int[.5] */
{
    return index >= 3 && memcmp(line.data + index - 3, "int", 3) == 0;
}

/* Adds the line with its indices replaced by numbers, for index *j of an array (NULL outside).
 * range_begin and range_end are the ends of the text "1..9" in its brackets, or NULL if it has
 * none. Returns false with an error. */
static bool write_out(struct ode_lines *r, struct text line, int number, const long *j,
                      const char *range_begin, const char *range_end)
{
    struct buffer output = {0};
    bool fine = true;
    for (size_t i = 0; fine && i < line.len; i++) {
        const char *end =
            line.data[i] == '[' && !is_kernel(line, i) ? text_find(text_after(line, i), ']') : NULL;
        if (line.data[i] == '[' && !is_kernel(line, i) && !end) {
            fine = ode_error(r->error, number, "a ']' is missing");
        } else if (!end) {
            buffer_char(&output, line.data[i]);
        } else {
            const char *begin = line.data + i + 1;
            long value = j ? *j : 0;
            fine = (begin == range_begin && end == range_end) ||
                   read_subscript((struct text){begin, (size_t)(end - begin)}, j, number, &value,
                                  r->error);
            buffer_format(&output, "%ld", value);
            i = (size_t)(end - line.data);
        }
    }
    fine = fine && (!output.failed || error_memory(r->error)) &&
           ode_line_add(r, buffer_text(&output), number);
    buffer_free(&output);
    return fine;
}

/* Finds the first [a..b] in a line: sets *begin and *end to the ends of the text in its brackets,
 * and *a and *b to both numbers. Returns false if there is none. */
static bool range_of(struct text line, const char **begin, const char **end, long *a, long *b)
{
    for (const char *cursor = line.data;
         (cursor =
              text_find((struct text){cursor, line.len - (size_t)(cursor - line.data)}, '['));) {
        *begin = ++cursor;
        *end = text_find((struct text){cursor, line.len - (size_t)(cursor - line.data)}, ']');
        if (!*end)
            return false;
        for (const char *dots = cursor; dots + 1 < *end; dots++)
            if (dots[0] == '.' && dots[1] == '.') {
                *a = leading_integer((struct text){cursor, (size_t)(dots - cursor)});
                *b = leading_integer((struct text){dots + 2, (size_t)(*end - dots - 2)});
                return true;
            }
    }
    return false;
}

/* Adds a line, once for each index if it has a range; settings (@) have none. Returns false with an
 * error. */
static bool add_array(struct ode_lines *r, struct text line, int number)
{
    const char *begin, *end;
    long first, last;
    if (line.data[0] == '@' || !range_of(line, &begin, &end, &first, &last))
        return line.data[0] == '@' ? ode_line_add(r, line, number)
                                   : write_out(r, line, number, NULL, NULL, NULL);
    const long step = first <= last ? 1 : -1;
    for (long j = first;; j += step) {
        if (!write_out(r, line, number, &j, begin, end))
            return false;
        if (j == last)
            return true;
    }
}

/* Writes out a group of lines, which begins with the line `head` (%[a..b], line `number` of the
 * file): adds its `count` lines for index a, then for the next, and so on up to b, or down to b if
 * it is smaller. Returns false with an error. */
static bool add_group(struct ode_lines *r, struct text head, const struct ode_line *line, int count,
                      int number)
{
    const char *begin, *end;
    long first, last;
    if (!range_of(head, &begin, &end, &first, &last))
        return ode_error(r->error, number, "a group of lines begins with %%[1..9]");
    const long step = first <= last ? 1 : -1;
    for (long j = first;; j += step) {
        for (int i = 0; i < count; i++)
            if (!write_out(r, line[i].text, line[i].number, &j, NULL, NULL))
                return false;
        if (j == last || count == 0)
            return true;
    }
}

/* ---- whole lines ---- */

/* Sets *line to the next line of the file, joined with the lines that continue it (a backslash
 * continues a line; what follows the backslash is dropped), in lower case, with blanks for tabs and
 * zero bytes. Adds to *number the number of lines read. Returns false at the end of the file. */
static bool take_line(struct text *rest, int *number, struct buffer *line)
{
    struct text part;
    buffer_clear(line);
    bool more = true, any = false;
    while (more && text_split(rest, '\n', &part)) {
        ++*number;
        const char *mark = text_find(part, '\\');
        more = mark != NULL;
        buffer_put(line, more ? (struct text){part.data, (size_t)(mark - part.data)} : part);
        any = true;
    }
    for (size_t i = 0; i < line->len; i++) {
        char *c = &line->data[i];
        if (*c >= 'A' && *c <= 'Z')
            *c = (char)(*c - 'A' + 'a');
        else
            *c = *c == '\0' || *c == '\t' ? ' ' : *c;
    }
    return any;
}

/* Returns true if the line is the statement `done`, whose word ends at the first blank, and not
 * a formula. */
static bool is_done(struct text line)
{
    size_t end = 0;
    while (end < line.len && !strchr(" =/'(", line.data[end]))
        end++;
    struct text rest = text_trim(text_after(line, end));
    return line.data[0] == 'd' && (end == line.len || line.data[end] == ' ') &&
           (rest.len == 0 || rest.data[0] != '=');
}

/* A group of lines that is being read. */
struct group {
    struct ode_lines lines;
    struct text head; /* its first line, %[1..9] */
    int number;       /* line of its head, or 0 if no group is open */
};

/* Handles a line after continued lines were joined, which begins at `number` in the file. Comments
 * (# and ") are dropped; a line with % begins or ends a group; lines within a group are collected,
 * others added. Returns false with an error. */
static bool take_whole(struct ode_lines *r, struct group *group, struct text line, int number)
{
    if (line.data[0] == '#' && text_starts(text_after(line, 1), TEXT("include")))
        return ode_error(r->error, number, "included files are not read; insert their lines here");
    if (line.data[0] == '#' || line.data[0] == '"')
        return true;
    if (line.data[0] == '%' && !group->number) {
        char *head = arena_text(r->arena, line);
        *group = (struct group){{.arena = r->arena, .error = r->error}, {head, line.len}, number};
        return head || error_memory(r->error);
    }
    if (line.data[0] == '%') {
        const struct group whole_group = *group;
        group->number = 0;
        return add_group(r, whole_group.head, whole_group.lines.line, whole_group.lines.count,
                         whole_group.number);
    }
    return group->number ? ode_line_add(&group->lines, line, number) : add_array(r, line, number);
}

/* Splits a file into complete lines: continued ones are joined, arrays written out, comments
 * dropped; reading ends at the line `done`. Sets *line and *count, in the arena. Returns false with
 * an error. */
bool ode_lines(struct text file, struct arena *arena, struct ode_line **line, int *count,
               struct error *error)
{
    struct ode_lines r = {.arena = arena, .error = error};
    struct group group = {.number = 0};
    struct buffer text = {0};
    int number = 0;
    bool fine = true;
    for (int begin = 1; fine && take_line(&file, &number, &text); begin = number + 1) {
        const struct text whole_line = text_trim(buffer_text(&text));
        if (text.failed)
            fine = error_memory(error);
        else if (whole_line.len > 0 && is_done(whole_line))
            break;
        else if (begin == 1 && leading_integer(whole_line) > 0)
            fine = ode_error(
                error, 1,
                "this is a file of the old style, which begins with the number of its equations");
        else if (whole_line.len > 0)
            fine = take_whole(&r, &group, whole_line, begin);
    }
    buffer_free(&text);
    if (fine && group.number)
        fine = ode_error(error, group.number, "the group of lines does not end with %%");
    *line = r.line;
    *count = r.count;
    return fine;
}
