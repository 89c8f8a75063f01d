/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes lines, notes, warnings and errors of a reply. An error is shown with its place in the
 * line, a caret and a hint, or as one JSON object. Control characters from the user's input are
 * made visible, so that they cannot command the terminal. */
#include <hooke/base/safe_text.h>
#include <hooke/result.h>

#define SHOWN_WIDTH 100 /* [column] part of a long line that is shown around the caret */

static void put_safely(struct buffer *output, const char *format, va_list args) PRINTF_LIKE(2, 0);

/* Appends a formatted text with its control characters made visible. */
static void put_safely(struct buffer *output, const char *format, va_list args)
{
    struct buffer raw = {0};
    buffer_vformat(&raw, format, args);
    safe_text(output, buffer_text(&raw), true);
    output->failed |= raw.failed;
    buffer_free(&raw);
}

/* Adds a formatted line to the reply. */
void reply_line(struct reply *reply, const char *format, ...)
{
    struct buffer line = {0};
    va_list args;
    va_start(args, format);
    put_safely(&line, format, args);
    va_end(args);
    if (line.failed)
        reply->failed = true;
    else
        reply_text(reply, buffer_text(&line));
    buffer_free(&line);
}

/* Writes a message to the error stream, after the lines written before. A message that ran out of
 * memory is lost. */
static void write_message(struct reply *reply, const struct buffer *text)
{
    reply_flush(reply);
    if (!text->failed)
        reply->sink.err(reply->sink.context, buffer_text(text));
}

/* Writes a formatted note to the error stream. */
void reply_note(struct reply *reply, const char *format, ...)
{
    struct buffer line = {0};
    va_list args;
    va_start(args, format);
    put_safely(&line, format, args);
    va_end(args);
    buffer_char(&line, '\n');
    write_message(reply, &line);
    buffer_free(&line);
}

/* Returns a reply that writes JSON records to the error stream. */
static struct reply message_record(const struct reply *reply)
{
    return (struct reply){.sink = {.output = reply->sink.err, .context = reply->sink.context},
                          .format = FORMAT_JSON};
}

/* Writes a warning as a JSON record. */
static void write_warning(struct reply *reply, const char *text)
{
    struct reply record = message_record(reply);
    reply_begin(&record, "warning");
    reply_string(&record, "text", text);
    reply_end(&record);
    reply_free(&record);
}

/* Writes a warning to the error stream, as a line or as a JSON record. */
void reply_warning(struct reply *reply, const char *format, ...)
{
    struct buffer line = {0}, output = {0};
    va_list args;
    va_start(args, format);
    put_safely(&line, format, args);
    va_end(args);
    if (reply->format == FORMAT_JSON) {
        write_warning(reply, buffer_view(&line));
    } else {
        buffer_format(&output, "warning: %s\n", buffer_view(&line));
        output.failed |= line.failed;
        write_message(reply, &output);
    }
    buffer_free(&line);
    buffer_free(&output);
}

/* ---- errors ---- */

/* Returns the column of the place in the line, in characters from 1, or 0 if it is not in the line.
 */
static size_t place_column(struct text line, struct text where)
{
    if (!where.data || !line.data || where.data < line.data || where.data > line.data + line.len)
        return 0;
    size_t column = 1;
    for (struct text rest = {line.data, (size_t)(where.data - line.data)}; rest.len > 0; column++) {
        size_t used;
        text_codepoint(rest, &used);
        rest = text_after(rest, used);
    }
    return column;
}

/* Appends a text as it appears on the screen: tabs become one blank, control characters become
 * visible. */
static void put_visible(struct buffer *output, struct text text)
{
    for (struct text piece; text_split(&text, '\t', &piece);) {
        safe_text(output, piece, false);
        if (text.data)
            buffer_char(output, ' ');
    }
}

/* Returns the end of a text that is at most `width` columns wide. */
static struct text clip_start(struct text text, size_t width)
{
    while ((size_t)text_width(text) > width && text.len > 0) {
        size_t used;
        text_codepoint(text, &used);
        text = text_after(text, used);
    }
    return text;
}

/* Returns the beginning of a text that is at most `width` columns wide. */
static struct text clip_end(struct text text, size_t width)
{
    size_t len = 0, columns = 0;
    while (len < text.len) {
        size_t used;
        const int w = codepoint_width(text_codepoint(text_after(text, len), &used));
        if (columns + (size_t)w > width)
            break;
        columns += (size_t)w;
        len += used;
    }
    return (struct text){text.data, len};
}

/* Appends the part of the line around the place of an error, and below it a caret with tildes under
 * the whole place. */
static void put_caret(struct buffer *output, struct text line, struct text where)
{
    const struct text whole_head = {line.data, (size_t)(where.data - line.data)};
    /* A line of a megabyte is only scanned near the caret. */
    const size_t context_bytes = 4 * SHOWN_WIDTH;
    const struct text head_near = whole_head.len > context_bytes
                                      ? (struct text){where.data - context_bytes, context_bytes}
                                      : whole_head;
    const struct text head = clip_start(head_near, SHOWN_WIDTH / 2);
    const struct text tail = {where.data, line.len - whole_head.len};
    const struct text shown = clip_end(
        (struct text){tail.data, tail.len < context_bytes ? tail.len : context_bytes}, SHOWN_WIDTH);
    struct buffer visible_head = {0}, visible_mark = {0};
    put_visible(&visible_head, head);
    put_visible(&visible_mark,
                (struct text){where.data, where.len < shown.len ? where.len : shown.len});
    const bool cut = head.data != line.data;
    buffer_put(output, cut ? TEXT("    ...") : TEXT("    "));
    buffer_put(output, buffer_text(&visible_head));
    put_visible(output, shown);
    buffer_put(output, shown.len < tail.len ? TEXT("...\n    ") : TEXT("\n    "));
    for (int i = text_width(buffer_text(&visible_head)) + (cut ? 3 : 0); i > 0; i--)
        buffer_char(output, ' ');
    buffer_char(output, '^');
    for (int i = text_width(buffer_text(&visible_mark)); i > 1; i--)
        buffer_char(output, '~');
    buffer_char(output, '\n');
    output->failed |= visible_head.failed || visible_mark.failed;
    buffer_free(&visible_head);
    buffer_free(&visible_mark);
}

/* Writes an error as a JSON record to the error stream. */
static void write_error_record(struct reply *reply, const struct error *error,
                               const struct source *where, size_t column)
{
    struct reply record = message_record(reply);
    const bool is_placed = where && where->name;
    reply_begin(&record, "error");
    reply_string(&record, "code", error_name(error->code));
    reply_string(&record, "file", is_placed ? where->name : NULL);
    reply_real(&record, "line", is_placed ? where->line : NAN);
    reply_real(&record, "column", column > 0 ? (double)column : NAN);
    reply_string(&record, "text", error->text);
    reply_string(&record, "hint", error->hint[0] ? error->hint : NULL);
    reply_end(&record);
    if (record.failed)
        reply->sink.err(reply->sink.context, TEXT("error: out of memory\n"));
    reply_free(&record);
}

/* Appends an error for people: "FILE:LINE:COLUMN: error: TEXT", the line with a caret, the hint,
 * and the scripts that sourced the file. */
static void put_error_text(struct buffer *output, const struct error *error,
                           const struct source *where, struct text line, size_t column)
{
    if (where && where->name) {
        safe_text(output, text_of(where->name), false);
        buffer_format(output, ":%d:", where->line);
        if (column > 0)
            buffer_format(output, "%zu:", column);
        buffer_char(output, ' ');
    }
    buffer_put(output, TEXT("error: "));
    safe_text(output, text_of(error->text), false);
    buffer_char(output, '\n');
    if (column > 0)
        put_caret(output, line, error->where);
    if (error->hint[0]) {
        buffer_put(output, TEXT("  "));
        safe_text(output, text_of(error->hint), false);
        buffer_char(output, '\n');
    }
    for (const struct source *parent = where ? where->parent : NULL; parent;
         parent = parent->parent)
        if (parent->name) {
            buffer_put(output, TEXT("  sourced at "));
            safe_text(output, text_of(parent->name), false);
            buffer_format(output, ":%d\n", parent->line);
        }
}

/* Narrows a statement that was joined from several lines of a file down to the line with the error:
 * *line is in and out, its text; *where is in and out, the source, which becomes `own`, a copy with
 * that line's number. Returns the column of the error, or 0 if it is unknown. */
static size_t find_error_line(const struct error *error, const struct source **where,
                              struct source *own, struct text *line)
{
    size_t column = place_column(*line, error->where);
    if (column == 0 || !*where || (*where)->pieces == 0)
        return column;
    const struct source_piece *piece = (*where)->piece, *end = piece + (*where)->pieces;
    const size_t offset = (size_t)(error->where.data - line->data);
    while (piece + 1 < end && piece[1].position <= offset)
        piece++;
    const size_t piece_end = piece + 1 < end ? piece[1].position : line->len;
    *own = **where;
    own->line = piece->line;
    *where = own;
    *line = (struct text){line->data + piece->position, piece_end - piece->position};
    return place_column(*line, error->where) + (size_t)piece->indent;
}

/* Writes an error to the error stream, and reports it to reply->error if that is set. */
void reply_error(struct reply *reply, const struct error *error, const struct source *where,
                 struct text line)
{
    struct buffer output = {0};
    struct source own;
    const size_t column = find_error_line(error, &where, &own, &line);
    reply_flush(reply);
    if (reply->error)
        reply->error(reply->sink.context, error, where, column);
    if (reply->format == FORMAT_JSON) {
        write_error_record(reply, error, where, column);
        return;
    }
    put_error_text(&output, error, where, line, column);
    reply->sink.err(reply->sink.context,
                    output.failed ? TEXT("error: out of memory\n") : buffer_text(&output));
    buffer_free(&output);
}
