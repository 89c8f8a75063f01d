/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads the collected file while lines arrive: only new lines and some before them, so that late
 * lines cost as much as early ones; and finds the trigger in them. */
#include <hooke/base/cancel.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include "modules/collect/handlers.h"

#include <fcntl.h>
#include <math.h>
#include <sys/stat.h>
#include <unistd.h>

#define FIRST_BYTES 524288 /* [byte] largest part of the file that is read at once */
/* [byte] lines read again if times come from arrivals, enough for a line through some thousand of
 * them */
#define TAIL_BYTES 32768
/* [byte] lines read again if times are in a column, enough to recognize the columns */
#define OVERLAP_BYTES 4096
#define LOOK_NS 50000000 /* [ns] least interval between two readings */
#define DRAWING_SHARE 40 /* Reading and drawing take at most one part in this many of the time. */

/* Returns true for lines of the sensor, false for comments. */
static bool is_counted(struct text line)
{
    return line.len > 0 && line.data[0] != '#';
}

/* Reads the file from view->offset on, behind its head, into text: at most FIRST_BYTES, whole lines
 * only. Sets *all if the end was reached. Returns false if there is nothing or out of memory. */
static bool read_new_text(struct collect_view *view, struct buffer *text, bool *all)
{
    char piece[4096];
    *all = false;
    if (view->fd < 0)
        view->fd = open(view->path, O_RDONLY | O_CLOEXEC);
    if (view->fd < 0)
        return false;
    buffer_put(text, buffer_text(&view->head));
    for (off_t offset = view->offset; offset < view->offset + FIRST_BYTES;) {
        const ssize_t got = pread(view->fd, piece, sizeof piece, offset);
        *all = got <= 0;
        if (*all)
            break;
        buffer_put(text, (struct text){piece, (size_t)got});
        offset += got;
    }
    while (text->len > 0 && text->data[text->len - 1] != '\n')
        text->len--; /* the last line is incomplete */
    return text->len > 0 && !text->failed;
}

/* Stores the lines before the first sample, including the heading, which are read again with each
 * part. */
static void keep_head(struct collect_view *view, struct text file,
                      const struct recording *recording)
{
    struct text rest = file, line;
    uint32_t lines = 0;
    while (text_split(&rest, '\n', &line)) {
        lines += is_counted(line);
        if (is_counted(line) && lines >= recording->line[0])
            break;
        buffer_put(&view->head, line);
        buffer_char(&view->head, '\n');
        view->head_lines += is_counted(line);
    }
    view->offset = (off_t)view->head.len;
    view->lines_before = view->head_lines;
}

/* Moves view->offset, where the next reading begins, to the first line that begins at most
 * `overlap` bytes before the end of `seen`, the file's head with the text that was read from that
 * offset on. Adds the skipped lines to view->lines_before. */
static void advance_offset(struct collect_view *view, struct text seen, size_t overlap)
{
    struct text rest = {seen.data + view->head.len, seen.len - view->head.len}, line;
    while (rest.len > overlap && text_split(&rest, '\n', &line)) {
        view->offset += (off_t)line.len + 1;
        view->lines_before += is_counted(line);
    }
}

/* Reads the rows of a part of the file, with line numbers and times that continue those of earlier
 * parts. Returns NULL if they cannot be read. */
static struct recording *read_rows(struct collect_view *view, struct text text)
{
    struct recording *recording = collected_read(text, view->options, &view->problem);
    if (!recording)
        return NULL;
    if (view->head.len == 0)
        keep_head(view, text, recording);
    else
        for (size_t i = 0; i < recording->rows; i++)
            recording->line[i] += view->lines_before - view->head_lines;
    if (view->newest > 0) /* a clock may count from the first line of the part */
        recording_join_clock(recording, view->newest, view->t);
    view->newest = recording->line[recording->rows - 1];
    view->t = recording->t[recording->rows - 1];
    recording->path = arena_text(&recording->arena, text_of(view->path));
    if (recording->path)
        return recording;
    recording_destroy(recording);
    return NULL;
}

/* Returns a recording of the newest rows and some before them, which the caller frees. Returns NULL
 * if nothing is new, if it is too early, or if the lines cannot be read. */
struct recording *collect_view_read(struct collect_view *view, uint64_t lines)
{
    const int64_t begun = clock_ns();
    struct buffer text = {0};
    struct recording *recording = NULL;
    bool all;
    if (lines < 3 || lines == view->lines || begun < view->due)
        return NULL;
    if (read_new_text(view, &text, &all))
        recording = read_rows(view, buffer_text(&text));
    if (recording)
        advance_offset(view, buffer_text(&text),
                       recording->collected->clock == CLOCK_DEVICE ? OVERLAP_BYTES : TAIL_BYTES);
    buffer_free(&text);
    view->lines = all || !recording ? lines : 0;
    const int64_t spent = DRAWING_SHARE * (clock_ns() - begun);
    view->due = begun + (spent > LOOK_NS ? spent : LOOK_NS);
    return recording;
}

/* Lets the next reading begin at the start of the file. */
void collect_view_restart(struct collect_view *view)
{
    buffer_clear(&view->head);
    view->head_lines = view->lines_before = 0;
    view->offset = 0;
    view->lines = 0;
    view->newest = 0;
    view->due = 0;
}

void collect_view_free(struct collect_view *view)
{
    if (view->fd >= 0)
        close(view->fd);
    buffer_free(&view->head);
}

/* ---- the trigger ---- */

/* Reads "NAME rising|falling VALUE". Returns false with an error if it is malformed. */
bool trigger_read(struct parser *parser, struct trigger *trigger, struct error *error)
{
    const struct text all = parser->rest;
    struct item item = {0};
    trigger->name = peek_word(parser->rest, "");
    parser->rest =
        (struct text){trigger->name.data + trigger->name.len,
                      (size_t)(all.data + all.len - trigger->name.data) - trigger->name.len};
    text_skip_blanks(&parser->rest);
    const struct text way = peek_word(parser->rest, "");
    parser->rest = (struct text){way.data + way.len, parser->rest.len - way.len};
    if (text_is(way, "rising"))
        trigger->direction = 1;
    else
        trigger->direction = text_is(way, "falling") ? -1 : 0;
    text_skip_blanks(&parser->rest);
    if (trigger->name.len == 0 || trigger->direction == 0)
        return error_at(
            error, all,
            "trigger= needs NAME rising VALUE or NAME falling VALUE, as in \"y rising 22 cm\"");
    if (!parse_value(parser, "the trigger", QUANTITY_OTHER, &item, error) ||
        !refuse_rest(parser, &item, error))
        return false;
    trigger->wanted = true;
    trigger->level = item.value.value;
    trigger->unit = item.unit;
    trigger->said = all;
    trigger->after_line = 0;
    trigger->t = trigger->arrival = NAN;
    return true;
}

/* Returns the column of the trigger, or NULL if no column has its name. */
static const struct column *trigger_column(const struct trigger *trigger,
                                           const struct recording *recording)
{
    for (int i = 0; i < recording->columns; i++)
        if (text_is(trigger->name, recording->column[i].name))
            return &recording->column[i];
    return text_is(trigger->name, "y") ? &recording->column[recording->value] : NULL;
}

/* Returns the factor from the column's numbers to SI; numbers without a unit are in the unit of
 * the level. */
static double trigger_factor(const struct trigger *trigger, const struct column *column)
{
    if (!trigger->unit)
        return 1;
    return column->quantity == QUANTITY_OTHER ? trigger->unit->factor : column->factor;
}

/* Fills `error` for a trigger that can never come: its column does not exist or has another
 * quantity. Returns false. */
static bool refuse_trigger(const struct trigger *trigger, const struct recording *recording,
                           const struct column *column, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct buffer names = {0};
    if (column)
        return error_set(error, ERROR_COMMAND,
                         "the trigger cannot happen: %s is %s %s, but %s is not",
                         safe_name(text_of(column->name), name), quantity_article(column->quantity),
                         quantity_name(column->quantity), trigger->unit->row.name);
    error_set(error, ERROR_COMMAND, "the trigger cannot happen because no column is called '%s'",
              safe_name(trigger->name, name));
    for (int i = 0; i < recording->columns && names.len < 100; i++)
        buffer_format(&names, ", %s", safe_name(text_of(recording->column[i].name), name));
    error_hint(error, "in trigger=\"y ...\", y is the measured value; the columns are called %s",
               buffer_view(&names) + (names.len > 2 ? 2 : 0));
    buffer_free(&names);
    return false;
}

/* Looks for the first passage of the level after trigger->after_line and stores its time. Returns
 * false if there is none yet, or with an error if it can never come. */
bool trigger_look(struct trigger *trigger, const struct recording *recording, struct error *error)
{
    const struct column *column = trigger_column(trigger, recording);
    if (!column || (trigger->unit && column->quantity != QUANTITY_OTHER &&
                    column->quantity != trigger->unit->quantity))
        return refuse_trigger(trigger, recording, column, error);
    const double factor = trigger_factor(trigger, column);
    double previous = NAN;
    for (size_t i = 0; i < recording->rows; i++) {
        const double value = column->value[i] * factor - trigger->level;
        if (!isfinite(value))
            continue;
        if (previous * trigger->direction < 0 && value * trigger->direction >= 0 &&
            recording->line[i] > trigger->after_line) {
            trigger->t = recording->t[i];
            trigger->line = recording->line[i];
            trigger->arrival =
                recording->collected->last - (recording->t[recording->rows - 1] - trigger->t);
            return true;
        }
        previous = value;
    }
    return false;
}

/* Appends that the trigger never came, with the range of its column. */
void trigger_missed(const struct trigger *trigger, const struct recording *recording,
                    struct buffer *output)
{
    char name[SAFE_NAME_SIZE];
    const struct column *column = trigger_column(trigger, recording);
    double low = HUGE_VAL, high = -HUGE_VAL;
    size_t n = 0;
    for (size_t i = 0; column && i < recording->rows; i++)
        if (isfinite(column->value[i]) && recording->line[i] > trigger->after_line) {
            low = fmin(low, column->value[i]);
            high = fmax(high, column->value[i]);
            n++;
        }
    buffer_format(output, "the trigger never happened: %s", safe_name(trigger->said, name));
    if (n > 0)
        buffer_format(output, "; %s was %.6g to %.6g%s%s in %zu samples",
                      safe_name(trigger->name, name), low, high, column->unit[0] ? " " : "",
                      column->unit, n);
}
