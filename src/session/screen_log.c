/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The log pane: a ring of the last lines that commands printed, and how a line is broken into rows
 * of the pane. */
#include <hooke/base/safe_text.h>
#include <hooke/session/subject.h>

#include <stdlib.h>

#define INDENT_CELLS 2 /* [cell] indentation of the second and later rows of a line */
#define INDENT_MIN 8   /* [cell] width below which rows are not indented */

/* Adds a line, made safe for terminals, and drops the oldest if the ring is full. A line for which
 * there is no memory is lost. */
static void add_line(struct log *log, struct text line)
{
    struct buffer safe = {0};
    safe_text(&safe, line, false);
    buffer_put(&safe, TEXT("")); /* a string also where the line is empty */
    if (safe.failed) {
        buffer_free(&safe);
        return;
    }
    const int index = (log->first + log->count) % LIMIT_LOG;
    if (log->count == LIMIT_LOG) {
        free(log->line[index]);
        log->first = (log->first + 1) % LIMIT_LOG;
    } else {
        log->count++;
    }
    log->line[index] = safe.data;
    log->said++;
}

/* Removes all but the last LIMIT_LOG lines from *text, and counts the removed ones as said. */
static void skip_lines(struct log *log, struct text *text)
{
    size_t begin = text->len;
    for (int lines = 0; begin > 0; begin--)
        if (text->data[begin - 1] == '\n' && ++lines == LIMIT_LOG)
            break;
    for (size_t i = 0; i < begin; i++)
        log->said += text->data[i] == '\n';
    *text = (struct text){text->data + begin, text->len - begin};
}

/* Adds the lines of the text, of which only the last LIMIT_LOG are stored. */
void log_add(struct log *log, struct text text)
{
    struct text line;
    if (!log->line && !(log->line = calloc(LIMIT_LOG, sizeof *log->line)))
        return;
    if (text.len > 0 && text.data[text.len - 1] == '\n')
        text.len--;
    skip_lines(log, &text);
    do {
        if (!text_split(&text, '\n', &line))
            line = TEXT("");
        add_line(log, line);
    } while (text.data);
}

const char *log_line(const struct log *log, int i)
{
    return i >= 0 && i < log->count ? log->line[(log->first + log->count - 1 - i) % LIMIT_LOG]
                                    : NULL;
}

/* Returns the part of a line that the next row of a pane shows, broken at the last space that fits,
 * else within a word; moves *offset behind it. */
struct text log_row(struct text line, size_t *offset, int width, int *indent)
{
    const struct text rest = {line.data + *offset, line.len - *offset};
    *indent = *offset > 0 && width >= INDENT_MIN ? INDENT_CELLS : 0;
    int left = width - *indent;
    size_t position = 0, end = 0; /* bytes examined so far; the end of the last word that fits */
    while (position < rest.len) {
        size_t used;
        left -= codepoint_width(text_codepoint(text_after(rest, position), &used));
        if (rest.data[position] == ' ' && position > 0 && rest.data[position - 1] != ' ')
            end = position;
        if (left < 0 && (end > 0 || position > 0))
            break;
        position += used; /* something at least, however narrow the pane */
    }
    if (position == rest.len || end == 0)
        end = position;
    size_t next = end;
    while (next < rest.len && rest.data[next] == ' ')
        next++;
    *offset += next;
    return (struct text){rest.data, end};
}

/* Returns the number of rows [row] that the line takes at that width. */
int log_rows(struct text line, int width)
{
    int rows = 0, indent;
    size_t offset = 0;
    do {
        log_row(line, &offset, width, &indent);
        rows++;
    } while (offset < line.len);
    return rows;
}

int log_rows_newest(const struct log *log, int lines, int width)
{
    int rows = 0;
    for (int i = 0; i < lines && i < log->count; i++)
        rows += log_rows(text_of(log_line(log, i)), width);
    return rows;
}

/* Frees all lines. */
void log_clear(struct log *log)
{
    for (int i = 0; i < log->count; i++)
        free(log->line[(log->first + i) % LIMIT_LOG]);
    free(log->line);
    *log = (struct log){0};
}
