/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Short answers: holds the text of a statement until its length is known, and leaves out the middle
 * if it does not fit on a screen. */
#include <hooke/base/safe_text.h>
#include "command/short_form.h"
#include <hooke/base/numeric.h>

#include <string.h>

/* Returns true if the command has --full for its text. Figures fill the screen whose size was asked
 * for, and their --full changes what they draw. */
static bool has_short_form(const struct command *command)
{
    bool full = false, figure = false;
    for (int i = 0; i < command->arguments; i++)
        if (command->argument[i].form == FORM_OPTION) {
            full |= strcmp(command->argument[i].name, "full") == 0;
            figure |= strcmp(command->argument[i].name, "log") == 0;
        }
    return full && !figure;
}

/* Returns true if --full stands in an argument that its command reads itself. */
static bool rest_has_full(const struct argument_value *value)
{
    struct text rest = value->count ? value->item->text : TEXT(""), word;
    while (text_split(&rest, ' ', &word))
        if (text_is(word, "--full"))
            return true;
    return false;
}

/* Returns true if --full was given, as an option or in the rest of the line. */
bool asks_full(const struct arguments *arguments)
{
    const struct command *command = arguments->command;
    for (int i = 0; i < command->arguments; i++) {
        const struct argument *argument = &command->argument[i];
        if (argument->form == FORM_OPTION && strcmp(argument->name, "full") == 0 &&
            has_argument_at(arguments, i))
            return true;
        if (type_is(argument, TYPE_TAKES_REST) && rest_has_full(&arguments->value[i]))
            return true;
    }
    return false;
}

/* Returns the rows [row] of an answer that fits below the typed line. */
int answer_rows(const struct session *session)
{
    enum { BESIDE = 2 /* the prompt, and the line that was typed */, MIN = 10 };
    int width, height;
    session_size(session, &width, &height);
    return height - BESIDE > MIN ? height - BESIDE : MIN;
}

int short_answer_rows(const struct session *session)
{
    enum { FILE_ROWS = 22 /* rows where nobody has to scroll back */ };
    return session->front.is_terminal ? answer_rows(session)
                                      : int_max(answer_rows(session), FILE_ROWS);
}

/* Returns the rows that the text takes on a screen of this width [cell]. */
int text_rows(struct text text, int width)
{
    struct text line;
    int rows = 0;
    while (text.len > 0 && text_split(&text, '\n', &line)) {
        const int cells = text_width(line);
        rows += cells > width ? (cells + width - 1) / width : 1;
    }
    return rows;
}

/* Appends a line without its newline, in several lines if it is wider than `width` [cell]. */
static void put_folded_line(struct text line, int width, struct buffer *text)
{
    enum { HANGING = 2 /* [cell] that what is continued begins further right */ };
    int indent = (int)(text_trim(line).data - line.data);
    if (indent > width / 2)
        indent = 0;
    const int room = width - indent - HANGING;
    struct buffer folded = {0};
    if (text_width(line) <= width) {
        buffer_format(text, "%.*s\n", (int)line.len, line.data);
        return;
    }
    buffer_folded(&folded, text_trim(line), room);
    struct text parts = buffer_text(&folded), part;
    for (int k = 0; text_split(&parts, '\n', &part); k++)
        buffer_format(text, "%*s%.*s\n", indent + (k ? HANGING : 0), "", (int)part.len, part.data);
    text->failed |= folded.failed;
    buffer_free(&folded);
}

void put_folded_lines(struct buffer *lines, int width, struct buffer *text)
{
    struct text rest = buffer_text(lines), line;
    while (text_split(&rest, '\n', &line))
        if (line.len > 0)
            put_folded_line(line, width, text);
    buffer_clear(lines);
}

/* Sink for results: keeps them in the form (context). */
static bool hold_result(void *context, struct text text)
{
    buffer_put(&((struct short_form *)context)->text, text);
    return true;
}

/* Sink for messages while the short form is active; context is the struct short_form. Appends the
 * message to the held text and notes its position, so that it appears in order among the results.
 * Messages before the first result, and those beyond SHORT_FORM_MESSAGES, go directly to the outer
 * sink. Returns false if that fails. */
static bool hold_message(void *context, struct text text)
{
    struct short_form *form = context;
    if (form->text.len == 0 || form->messages == SHORT_FORM_MESSAGES) {
        form->rows_max -= text_rows(text, form->width);
        return form->outer.err(form->outer.context, text);
    }
    form->message[form->messages].begin = form->text.len;
    form->message[form->messages++].len = text.len;
    buffer_put(&form->text, text);
    return true;
}

/* Begins to hold the output, by replacing the sinks of the reply, if the command has a short form
 * and --full was not given. */
void short_form_begin(struct short_form *form, const struct session *session,
                      const struct arguments *arguments, struct reply *reply)
{
    enum { WIDTH_MIN = 80 /* [cell] of lines that are no terminal's */ };
    int height;
    *form = (struct short_form){.outer = reply->sink,
                                .rows_max = short_answer_rows(session),
                                .folds = session->front.is_terminal};
    session_size(session, &form->width, &height);
    if (!session->front.is_terminal && form->width < WIDTH_MIN)
        form->width = WIDTH_MIN;
    form->active =
        has_short_form(arguments->command) && reply_wants_text(reply) && !asks_full(arguments);
    if (form->active)
        reply->sink = (struct sink){hold_result, hold_message, form};
}

/* ---- writing with rows left out ---- */

/* Returns the line at *position with its newline, and moves *position behind it; *message becomes
 * the message at or behind that position. */
static struct text form_next_line(const struct short_form *form, size_t *position, int *message)
{
    const struct text all = buffer_text(&form->text);
    size_t end = *position;
    while (*message < form->messages &&
           *position >= form->message[*message].begin + form->message[*message].len)
        ++*message;
    while (end < all.len && all.data[end] != '\n')
        end++;
    end += end < all.len;
    const struct text line = {all.data + *position, end - *position};
    *position = end;
    return line;
}

/* Returns true if the line belongs to that message. */
static bool is_message(const struct short_form *form, int message, struct text line)
{
    return message < form->messages && line.data >= form->text.data + form->message[message].begin;
}

/* Writes a line to the sink of messages or of results. Returns false if that fails. */
static bool write_line(const struct short_form *form, bool message, struct text line)
{
    return (message ? form->outer.err : form->outer.output)(form->outer.context, line);
}

/* Breaks the lines of results that are wider than the screen. */
static void fold_results(struct short_form *form)
{
    struct buffer folded = {0};
    size_t new_begin[SHORT_FORM_MESSAGES] = {0};
    int at_message = 0;
    for (size_t position = 0; position < form->text.len;) {
        const struct text line = form_next_line(form, &position, &at_message);
        const bool message = is_message(form, at_message, line),
                   whole = line.data[line.len - 1] == '\n';
        if (message && line.data == form->text.data + form->message[at_message].begin)
            new_begin[at_message] = folded.len;
        if (message || !whole)
            buffer_put(&folded, line);
        else
            put_folded_line((struct text){line.data, line.len - 1}, form->width, &folded);
    }
    for (int i = 0; i < form->messages; i++)
        form->message[i].begin = new_begin[i];
    folded.failed |= form->text.failed;
    buffer_free(&form->text);
    form->text = folded;
}

/* Ends the short form: writes all held messages, and the first and last rows of the held results
 * with a line "... n more rows: --full" between them, so that about form->rows_max rows appear in
 * all. Rows of the terminal are counted first, then the lines are written to the outer sink. Frees
 * the held text; sets reply->failed if writing fails. */
void short_form_end(struct short_form *form, struct reply *reply)
{
    if (!form->active)
        return;
    reply->sink = form->outer;
    if (form->folds)
        fold_results(form);
    int total = 0, said = 0, rows_before = 0, at_message = 0, left_out = 0;
    for (size_t position = 0; position < form->text.len;) {
        const struct text line = form_next_line(form, &position, &at_message);
        *(is_message(form, at_message, line) ? &said : &total) += text_rows(line, form->width);
    }
    enum { RESULT_ROWS_MIN = 6 };
    int room = form->rows_max - said;
    room = room > RESULT_ROWS_MIN ? room : RESULT_ROWS_MIN;
    const int tail = room / 3, head = total <= room ? total : room - 1 - tail;
    bool ok = !form->text.failed;
    at_message = 0;
    for (size_t position = 0; position < form->text.len && ok;) {
        const struct text line = form_next_line(form, &position, &at_message);
        const bool message = is_message(form, at_message, line);
        const int rows = text_rows(line, form->width);
        const bool cut = !message && rows_before + rows > head && total - rows_before > tail;
        rows_before += message ? 0 : rows;
        left_out += cut;
        if (left_out > 0 && !message && (!cut || total - rows_before <= 0)) {
            struct buffer words = {0};
            buffer_format(&words, "... %d more row%s: --full\n", left_out, plural_s(left_out));
            ok = write_line(form, false, buffer_text(&words));
            buffer_free(&words);
            left_out = 0;
        }
        ok = ok && (cut || write_line(form, message, line));
    }
    reply->failed |= !ok;
    buffer_free(&form->text);
}
