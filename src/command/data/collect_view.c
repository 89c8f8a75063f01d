/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is seen of lines while they come: the last ones, so that the last costs as much as the
 * first. */
#include "command/data/collect.h"

#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define TAIL_BYTES 131072    /* of the file that are read: some thousand lines */
#define LOOK_NS 100000000    /* between looks */
#define SHARE 40             /* the looks take that part of the time */
#define TRIGGER_GLITCH 1e-12 /* [s] of rounding in times */

/* The last bytes of the file, from a beginning of a line on. */
static bool read_tail(struct collect_view *view, struct buffer *text)
{
    struct stat st;
    if (view->fd < 0)
        view->fd = open(view->path, O_RDONLY | O_CLOEXEC);
    if (view->fd < 0 || fstat(view->fd, &st) != 0)
        return false;
    const bool all = st.st_size <= TAIL_BYTES || view->head.len == 0;
    const off_t from = all ? 0 : st.st_size - TAIL_BYTES;
    char piece[4096];
    bool in_line = !all;
    if (!all)
        buffer_put(text, buffer_text(&view->head));
    for (off_t at = from; at < from + (all ? 4 : 1) * TAIL_BYTES;) {
        const ssize_t got = pread(view->fd, piece, sizeof piece, at);
        if (got <= 0)
            break;
        const char *begin = in_line ? memchr(piece, '\n', (size_t)got) : piece - 1;
        if (begin)
            buffer_put(text, (struct text){begin + 1, (size_t)(piece + got - begin - 1)});
        in_line = in_line && !begin;
        at += got;
    }
    return text->len > 0 && !text->failed;
}

/* What stands before the first sample: the heading and whatever else. */
static void keep_head(struct collect_view *view, struct text file,
                      const struct recording *recording)
{
    struct text rest = file, line;
    uint32_t lines = 0;
    while (text_split(&rest, '\n', &line)) {
        const bool remark = line.len > 0 && line.at[0] == '#';
        lines += !remark;
        if (!remark && lines >= recording->line[0])
            break;
        buffer_put(&view->head, line);
        buffer_char(&view->head, '\n');
    }
}

struct recording *collect_view_read(struct collect_view *view, uint64_t lines)
{
    const int64_t begun = clock_ns();
    struct buffer text = {0};
    struct recording *recording = NULL;
    if (lines < 3 || lines == view->lines || begun < view->due)
        return NULL;
    view->lines = lines;
    if (read_tail(view, &text)) {
        recording = collected_read(buffer_text(&text), view->options, &view->problem);
        if (recording && view->head.len == 0)
            keep_head(view, buffer_text(&text), recording);
        if (recording)
            recording->path = arena_text(&recording->arena, text_of(view->path));
    }
    if (recording && !recording->path) {
        recording_destroy(recording);
        recording = NULL;
    }
    buffer_free(&text);
    const int64_t spent = SHARE * (clock_ns() - begun);
    view->due = begun + (spent > LOOK_NS ? spent : LOOK_NS);
    return recording;
}

void collect_view_free(struct collect_view *view)
{
    if (view->fd >= 0)
        close(view->fd);
    buffer_free(&view->head);
}

/* ---- what is waited for ---- */

bool trigger_read(struct parser *parser, struct trigger *trigger, struct error *error)
{
    const struct text all = parser->rest;
    struct item item = {0};
    trigger->name = peek_word(parser->rest, "");
    parser->rest = (struct text){trigger->name.at + trigger->name.len,
                                 (size_t)(all.at + all.len - trigger->name.at) - trigger->name.len};
    text_skip_blanks(&parser->rest);
    const struct text way = peek_word(parser->rest, "");
    parser->rest = (struct text){way.at + way.len, parser->rest.len - way.len};
    trigger->direction = text_is(way, "rising") ? 1 : text_is(way, "falling") ? -1 : 0;
    text_skip_blanks(&parser->rest);
    if (trigger->name.len == 0 || trigger->direction == 0)
        return error_at(error, all, "trigger= is NAME rising or falling VALUE: \"y rising 22 cm\"");
    if (!parse_value(parser, "the trigger", QUANTITY_OTHER, &item, error) ||
        !refuse_rest(parser, &item, error))
        return false;
    trigger->wanted = true;
    trigger->level = item.value.value;
    trigger->unit = item.unit;
    trigger->said = all;
    trigger->after = -HUGE_VAL;
    trigger->t = NAN;
    return true;
}

/* NULL: there is none of that name. */
static const struct column *trigger_column(const struct trigger *trigger,
                                           const struct recording *recording)
{
    for (int i = 0; i < recording->columns; i++)
        if (text_is(trigger->name, recording->column[i].name))
            return &recording->column[i];
    return text_is(trigger->name, "y") ? &recording->column[recording->value] : NULL;
}

/* What the column's numbers are multiplied with; those without a unit are in that of the level. */
static double trigger_factor(const struct trigger *trigger, const struct column *column)
{
    if (!trigger->unit)
        return 1;
    return column->quantity == QUANTITY_OTHER ? trigger->unit->factor : column->factor;
}

static bool refuse_trigger(const struct trigger *trigger, const struct recording *recording,
                           const struct column *column, struct error *error)
{
    char name[SAFE_NAME_SIZE];
    struct buffer names = {0};
    if (column)
        return error_set(error, ERROR_COMMAND, "the trigger cannot come: %s is %s %s, %s is none",
                         safe_name(text_of(column->name), name), quantity_article(column->quantity),
                         quantity_name(column->quantity), trigger->unit->row.name);
    error_set(error, ERROR_COMMAND, "the trigger cannot come: no column is called '%s'",
              safe_name(trigger->name, name));
    for (int i = 0; i < recording->columns && names.len < 100; i++)
        buffer_format(&names, ", %s", safe_name(text_of(recording->column[i].name), name));
    error_hint(error, "trigger=\"y ...\" is the value; the columns are %s",
               buffer_view(&names) + (names.len > 2 ? 2 : 0));
    buffer_free(&names);
    return false;
}

bool trigger_look(struct trigger *trigger, const struct recording *recording, struct error *error)
{
    const struct column *column = trigger_column(trigger, recording);
    if (!column || (trigger->unit && column->quantity != QUANTITY_OTHER &&
                    column->quantity != trigger->unit->quantity))
        return refuse_trigger(trigger, recording, column, error);
    const double factor = trigger_factor(trigger, column);
    double before = NAN;
    for (size_t i = 0; i < recording->rows; i++) {
        const double value = column->value[i] * factor - trigger->level;
        if (!isfinite(value))
            continue;
        if (before * trigger->direction < 0 && value * trigger->direction >= 0 &&
            recording->t[i] > trigger->after + TRIGGER_GLITCH) {
            trigger->t = recording->t[i];
            return true;
        }
        before = value;
    }
    return false;
}

void trigger_missed(const struct trigger *trigger, const struct recording *recording,
                    struct buffer *out)
{
    char name[SAFE_NAME_SIZE];
    const struct column *column = trigger_column(trigger, recording);
    double low = HUGE_VAL, high = -HUGE_VAL;
    size_t n = 0;
    for (size_t i = 0; column && i < recording->rows; i++)
        if (isfinite(column->value[i]) && recording->t[i] > trigger->after + TRIGGER_GLITCH) {
            low = fmin(low, column->value[i]);
            high = fmax(high, column->value[i]);
            n++;
        }
    buffer_format(out, "the trigger never came: %s", safe_name(trigger->said, name));
    if (n > 0)
        buffer_format(out, "; %s was %.6g to %.6g%s%s in %zu samples",
                      safe_name(trigger->name, name), low, high, column->unit[0] ? " " : "",
                      column->unit, n);
}
