/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "events.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- lists ---- */

/* A new list, that of `from` but for the line of this name; *line is the next free one. */
static struct events *copy_without(const struct events *from, struct text name, struct error *error)
{
    struct events *events = calloc(1, sizeof *events);
    if (!events) {
        error_memory(error);
        return NULL;
    }
    for (int i = 0; from && i < from->count; i++)
        if (!text_is(name, from->line[i].name))
            events->line[events->count++] = from->line[i]; /* its texts live as long */
    return events;
}

static void keep(struct session *session, struct events *events)
{
    events->older = session->events;
    session->events = events;
}

const struct events *events_with(struct session *session, const struct event_line *line, struct text when,
                                 struct text commands, struct error *error)
{
    struct events *events = copy_without(session->setup.events, text_of(line->name), error);
    if (!events)
        return NULL;
    struct event_line *own = &events->line[events->count < LIMIT_EVENTS ? events->count : 0];
    const struct event_line added = {.action = line->action,
                                     .when = arena_text(&events->arena, when),
                                     .commands = arena_text(&events->arena, commands)};
    if (events->count == LIMIT_EVENTS)
        error_set(error, ERROR_COMMAND, "%d events exist already", LIMIT_EVENTS);
    else if (!added.when || !added.commands)
        error_memory(error);
    else {
        *own = added;
        memcpy(own->name, line->name, sizeof own->name);
        events->count++;
        keep(session, events);
        return events;
    }
    events->older = NULL;
    events_destroy(events);
    return NULL;
}

bool events_without(struct session *session, struct text name, const struct events **left, struct error *error)
{
    const struct events *now = session->setup.events;
    struct suggestion near = {.wanted = name};
    struct events *events = copy_without(now, name, error);
    if (!events)
        return false;
    for (int i = 0; now && i < now->count; i++)
        suggestion_offer(&near, now->line[i].name);
    if (!now || events->count == now->count) {
        events_destroy(events);
        error_at(error, name, "there is no event '%.*s'", (int)(name.len < 64 ? name.len : 64), name.at);
        suggestion_hint(&near, error);
        return now ? error_hint(error, "('event' lists them)") : false;
    }
    keep(session, events);
    *left = events->count ? events : NULL;
    return true;
}

void events_destroy(struct events *events)
{
    while (events) {
        struct events *older = events->older;
        arena_reset(&events->arena);
        free(events);
        events = older;
    }
}

/* ---- as commands ---- */

void event_describe(const struct event_line *line, bool as_stop, struct buffer *text)
{
    static const char *const words[] = {"stop", "record"};
    buffer_format(text, "event %s when %s do ", line->name, line->when);
    if (line->action != EVENT_COMMANDS || as_stop) {
        buffer_put(text, text_of(words[line->action == EVENT_RECORD]));
        return;
    }
    const bool raw = !strchr(line->commands, '\'');
    buffer_char(text, raw ? '\'' : '"');
    for (const char *at = line->commands; *at; at++)
        buffer_format(text, !raw && strchr("\"\\", *at) ? "\\%c" : "%c", *at);
    buffer_char(text, raw ? '\'' : '"');
}

void events_save(const struct events *events, bool as_stop, struct buffer *text)
{
    for (int i = 0; events && i < events->count; i++) {
        event_describe(&events->line[i], as_stop, text);
        buffer_char(text, '\n');
    }
}

void events_plan(const struct events *events, struct buffer *text)
{
    if (!events)
        return;
    buffer_put(text, TEXT("events    "));
    for (int i = 0; i < events->count; i++)
        buffer_format(text, "%s%s", i > 0 ? ", " : "", events->line[i].name);
    buffer_put(text, TEXT(": looked for in every step; bounds of the expression there prove that none is missed\n"));
}

/* ---- for runs ---- */

bool events_compile(const struct events *events, const struct expr_scope *scope, struct arena *arena,
                    const struct event **event, int *count, struct error *error)
{
    *event = NULL;
    *count = 0;
    if (!events)
        return true;
    struct event *list = arena_array(arena, (size_t)events->count, sizeof *list);
    if (!list)
        return error_memory(error);
    for (int i = 0; i < events->count; i++) {
        const struct event_line *line = &events->line[i];
        size_t used;
        list[i] = (struct event){.stop = line->action != EVENT_RECORD, .scope = scope};
        memcpy(list[i].name, line->name, sizeof list[i].name);
        if (!event_compile(text_of(line->when), scope, arena, &list[i], &used, error)) {
            error->where = (struct text){NULL, 0};
            return error_hint(error, "in the event %s; 'event %s off' drops it", line->name, line->name);
        }
    }
    *event = list;
    *count = events->count;
    return true;
}

int events_stopped_at(const struct held_run *held, const struct event_line *stopped[LIMIT_EVENTS])
{
    const struct run *run = held->run;
    size_t i = run_happenings(run);
    int count = 0;
    if (run->stop != STOP_CONDITION || !held->events)
        return 0;
    while (i > 0 && run_happening(run, i - 1)->step == run->steps)
        i--;
    for (; i < run_happenings(run); i++) {
        const struct event_line *line = &held->events->line[run_happening(run, i)->event];
        if (line->action != EVENT_RECORD && run_happening(run, i)->t == run->t && count < LIMIT_EVENTS)
            stopped[count++] = line;
    }
    return count;
}

/* An equation there is not the law, but a jump of what moves. */
bool event_executes(const struct command *command)
{
    return (command->flags & COMMAND_ANYTIME) || strcmp(command->row.name, "equation") == 0;
}

bool refuse_in_event(const struct command *command, struct text where, struct error *error)
{
    error_at(error, where, "an event cannot execute %s", command->row.name);
    return error_hint(error, "it sets, prints and notes; 'continue' as the last word lets the run go on");
}

struct text event_commands(struct text commands, bool *passes)
{
    struct text rest = commands, statement;
    struct error ignored;
    *passes = false;
    while (rest.len > 0 && next_statement(&rest, &statement, &ignored)) {
        *passes = text_is(text_trim(statement), "continue");
        if (*passes && text_trim(rest).len == 0)
            return (struct text){commands.at, (size_t)(statement.at - commands.at)};
    }
    *passes = false;
    return commands;
}

/* ---- what has happened ---- */

static const char *event_name(const struct held_run *held, size_t i)
{
    return held->events->line[run_happening(held->run, i)->event].name;
}

/* State variables, then what the scene observes. */
static int columns_of(const struct run *run)
{
    return run->system.n + model_observed(run->system.model);
}

static struct variable column_at(const struct run *run, int column)
{
    const int n = run->system.n;
    return column < n ? system_variable(&run->system, column) : model_observed_variable(run->system.model, column - n);
}

static double column_value(const struct run *run, size_t i, int column)
{
    const double *y = run_happening_state(run, i);
    const int n = run->system.n;
    return column < n ? y[column] : system_observe(&run->system, column - n, run_happening(run, i)->t, y);
}

static void reply_happening(const struct session *session, const struct held_run *held, size_t i, struct reply *reply)
{
    const struct run *run = held->run;
    const struct happening *happening = run_happening(run, i);
    const int digits = session->setup.settings.digits;
    struct buffer text = {0};
    buffer_format(&text, "%4zu  %-10s t = ", i + 1, event_name(held, i));
    buffer_measured(&text, (struct measured){happening->t, 0}, QUANTITY_TIME, digits > 6 ? digits : 6);
    for (int c = 0; c < columns_of(run); c++) {
        const struct variable column = column_at(run, c);
        buffer_format(&text, "  %s = ", column.name);
        buffer_measured(&text, (struct measured){column_value(run, i, c), 0}, column.quantity, digits);
    }
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    reply_begin(reply, "event");
    reply_int(reply, "run", run->number);
    reply_string(reply, "name", event_name(held, i));
    reply_string(reply, "direction",
                 happening->direction > 0 ? "rising" : happening->direction < 0 ? "falling" : "touching");
    reply_real(reply, "t", happening->t);
    reply_object(reply, "state");
    for (int c = 0; c < columns_of(run); c++) {
        const struct variable column = column_at(run, c);
        reply_real(reply, column.name, column_value(run, i, c));
    }
    reply_close(reply);
    reply_end(reply);
}

static void reply_count(const struct held_run *held, int event, const struct event_doubt *doubt, struct reply *reply)
{
    const size_t all = run_happenings(held->run);
    long long count = 0;
    for (size_t i = 0; i < all; i++)
        count += run_happening(held->run, i)->event == event;
    reply_begin(reply, "events");
    reply_int(reply, "run", held->run->number);
    reply_string(reply, "name", held->events->line[event].name);
    reply_int(reply, "count", count);
    reply_bool(reply, "complete", doubt->steps == 0);
    reply_real(reply, "doubt_from", doubt->steps ? doubt->from : NAN);
    reply_real(reply, "doubt_to", doubt->steps ? doubt->to : NAN);
    reply_end(reply);
}

void reply_event_doubts(struct held_run *held, struct reply *reply)
{
    struct run *run = held->run;
    bool said = false;
    for (int i = 0; held->events && i < held->events->count; i++) {
        const struct event_doubt doubt = run_event_doubt(run, i);
        if (reply->format != FORMAT_TEXT)
            reply_count(held, i, &doubt, reply);
        if (doubt.steps == 0 || run->warned_doubt)
            continue;
        reply_warning(reply, "event %s may be incomplete from t = %.6g s to %.6g s (%lld step%s): the step was longer "
                      "than the event's own time scale", held->events->line[i].name, doubt.from, doubt.to,
                      (long long)doubt.steps, doubt.steps == 1 ? "" : "s");
        said = true;
    }
    run->warned_doubt = run->warned_doubt || said;
}

void reply_happenings(const struct session *session, struct reply *reply)
{
    const struct run *run = session_run(session);
    for (size_t i = 0; run && i < run_happenings(run); i++)
        reply_happening(session, session->run[session->current_run], i, reply);
    if (!run || run_happenings(run) == 0)
        reply_line(reply, "no events were noticed; 'event NAME when EXPR do record' watches for one in the next run");
}

bool export_happenings(const struct session *session, struct export *export, struct error *error)
{
    const struct run *run = session_run(session);
    const size_t rows = run ? run_happenings(run) : 0;
    if (rows == 0) {
        error_set(error, ERROR_COMMAND, "no events were noticed");
        return error_hint(error, "type: event NAME when EXPR do record; run");
    }
    const size_t columns = (size_t)columns_of(run);
    struct arena *arena = export->arena;
    struct table_column *out = arena_array(arena, columns + 3, sizeof *out);
    const char **name = arena_array(arena, rows, sizeof *name);
    double *t = arena_array(arena, rows, sizeof *t), *direction = arena_array(arena, rows, sizeof *direction);
    if (!out || !name || !t || !direction)
        return error_memory(error);
    for (size_t i = 0; i < rows; i++) {
        name[i] = event_name(session->run[session->current_run], i);
        t[i] = run_happening(run, i)->t;
        direction[i] = run_happening(run, i)->direction;
    }
    out[0] = (struct table_column){.name = "event", .unit = "", .text = name};
    out[1] = (struct table_column){.name = "t", .unit = "s", .value = t};
    out[2] = (struct table_column){.name = "direction", .unit = "", .value = direction};
    for (int c = 0; c < (int)columns; c++) {
        const struct variable column = column_at(run, c);
        double *value = arena_array(arena, rows, sizeof *value);
        const char *title = arena_text(arena, text_of(column.name));
        if (!value || !title)
            return error_memory(error);
        for (size_t i = 0; i < rows; i++)
            value[i] = column_value(run, i, c);
        out[c + 3] = (struct table_column){.name = title, .unit = quantity_unit(column.quantity), .value = value};
    }
    export->table = (struct table){.column = out, .columns = (int)columns + 3, .rows = rows};
    return export_run_keys(session, session->current_run, export, error);
}
