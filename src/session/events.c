/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Events that the user defines: lists of lines `event NAME when … do …`. A list never changes; each
 * change makes a new one, so that set-up, runs and undo share them. */
#include <hooke/run.h>
#include <hooke/base/statement.h>
#include <hooke/session/events.h>
#include <hooke/session/subject.h>
#include <hooke/scene/typed.h>

#include <stdlib.h>
#include <string.h>

/* ---- lists ---- */

/* Returns a new list with the lines of source except the one of this name; source may be NULL.
 * Returns NULL with the error set if out of memory. */
static struct events *copy_without(const struct events *source, struct text name,
                                   struct error *error)
{
    struct events *events = calloc(1, sizeof *events);
    if (!events) {
        error_memory(error);
        return NULL;
    }
    for (int i = 0; source && i < source->count; i++) {
        if (text_is(name, source->line[i].name))
            continue;
        struct event_line *line = &events->line[events->count++];
        *line = source->line[i];
        line->when = arena_text(&events->arena, text_of(line->when));
        line->commands = arena_text(&events->arena, text_of(line->commands));
        if (!line->when || !line->commands) {
            events_destroy(events);
            error_memory(error);
            return NULL;
        }
    }
    return events;
}

/* Gives the list to the session, which frees it when nothing uses it. */
static void event_list_add(struct session *session, struct events *events)
{
    events->older = session->definitions.events;
    session->definitions.events = events;
    session->definitions.event_lists++;
}

/* Frees the lists of events for which used() returns false, once the number of lists has doubled
 * since the last time, so that the work per list stays constant. */
void events_sweep(struct session *session,
                  bool (*used)(const struct session *session, const struct events *events))
{
    if (session->definitions.event_lists < 2 * session->definitions.event_lists_left + SWEEP_FROM)
        return;
    struct events **list_link = &session->definitions.events;
    while (*list_link) {
        struct events *events = *list_link;
        if (used(session, events)) {
            list_link = &events->older;
        } else {
            *list_link = events->older;
            events->older = NULL;
            events_destroy(events);
            session->definitions.event_lists--;
        }
    }
    session->definitions.event_lists_left = session->definitions.event_lists;
}

/* Returns a copy of the session's list of events with `line` added, whose condition is `when` and
 * whose commands are `commands`; it replaces an event of the same name. The session owns the list.
 * Returns NULL with an error if there are already LIMIT_EVENTS or if out of memory. */
const struct events *events_with(struct session *session, const struct event_line *line,
                                 struct text when, struct text commands, struct error *error)
{
    struct events *events = copy_without(session->setup.events, text_of(line->name), error);
    if (!events)
        return NULL;
    struct event_line *own = &events->line[events->count < LIMIT_EVENTS ? events->count : 0];
    const struct event_line added = {.action = line->action,
                                     .when = arena_text(&events->arena, when),
                                     .commands = arena_text(&events->arena, commands)};
    if (events->count == LIMIT_EVENTS)
        error_set(error, ERROR_COMMAND, "there are already %d events", LIMIT_EVENTS);
    else if (!added.when || !added.commands)
        error_memory(error);
    else {
        *own = added;
        memcpy(own->name, line->name, sizeof own->name);
        events->count++;
        event_list_add(session, events);
        return events;
    }
    events->older = NULL;
    events_destroy(events);
    return NULL;
}

/* Makes a new list without the line; *left is NULL if nothing remains. Returns false with the error
 * set. */
bool events_without(struct session *session, struct text name, const struct events **left,
                    struct error *error)
{
    const struct events *now = session->setup.events;
    struct suggestion suggestion = {.wanted = name};
    struct events *events = copy_without(now, name, error);
    if (!events)
        return false;
    for (int i = 0; now && i < now->count; i++)
        suggestion_offer(&suggestion, now->line[i].name);
    if (!now || events->count == now->count) {
        events_destroy(events);
        error_at(error, name, "there is no event '%.*s'", (int)(name.len < 64 ? name.len : 64),
                 name.data);
        suggestion_hint(&suggestion, error);
        return now ? error_hint(error, "('event' lists them)") : false;
    }
    event_list_add(session, events);
    *left = events->count ? events : NULL;
    return true;
}

/* Frees the list and all older ones. */
void events_destroy(struct events *events)
{
    while (events) {
        struct events *older = events->older;
        arena_reset(&events->arena);
        free(events);
        events = older;
    }
}

/* ---- events as commands ---- */

/* Appends the event as a command. */
void event_describe(const struct event_line *line, struct buffer *text)
{
    static const char *const words[] = {"stop", "record"};
    buffer_format(text, "event %s when %s do ", line->name, line->when);
    if (line->action == EVENT_COMMANDS)
        buffer_quote(text, text_of(line->commands));
    else
        buffer_put(text, text_of(words[line->action == EVENT_RECORD]));
}

/* Appends the events as commands, a line each. */
void events_save(const struct events *events, struct buffer *text)
{
    for (int i = 0; events && i < events->count; i++) {
        event_describe(&events->line[i], text);
        buffer_char(text, '\n');
    }
}

/* Appends the line of `plan` about events. */
void events_plan(const struct events *events, struct buffer *text)
{
    if (!events)
        return;
    buffer_put(text, TEXT("events    "));
    for (int i = 0; i < events->count; i++)
        buffer_format(text, "%s%s", i > 0 ? ", " : "", events->line[i].name);
    buffer_put(
        text,
        TEXT(": searched in every step; bounds of the expression prove that none is missed\n"));
}

/* ---- events of runs ---- */

/* Compiles all events into the arena. Returns false with an error that names the event. */
bool events_compile(const struct events *events, const struct expr_scope *scope,
                    struct arena *arena, const struct event **event, int *count,
                    struct error *error)
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
            return error_hint(error, "in the event %s; 'event %s off' removes it", line->name,
                              line->name);
        }
    }
    *event = list;
    *count = events->count;
    return true;
}

/* Lists in stopped[] the events that have stopped the run at its present time, by the records of
 * its last step, and returns how many there are: 0 if the run stopped for another reason. */
int events_stopped_at(const struct run_slot *slot, const struct event_line *stopped[LIMIT_EVENTS])
{
    const struct run *run = slot->run;
    size_t i = run_event_records(run);
    int count = 0;
    if (run->stop != STOP_CONDITION || !slot->events)
        return 0;
    while (i > 0 && run_event_record(run, i - 1)->step == run->steps)
        i--;
    for (; i < run_event_records(run); i++) {
        const struct event_line *line = &slot->events->line[run_event_record(run, i)->event];
        if (line->action != EVENT_RECORD && run_event_record(run, i)->t == run->t &&
            count < LIMIT_EVENTS)
            stopped[count++] = line;
    }
    return count;
}

/* Cuts a final `continue` off the commands and reports it in *passes. */
struct text event_commands(struct text commands, bool *passes)
{
    struct text rest = commands, statement;
    struct error ignored;
    *passes = false;
    while (rest.len > 0 && next_statement(&rest, &statement, &ignored)) {
        *passes = text_is(text_trim(statement), "continue");
        if (*passes && text_trim(rest).len == 0)
            return (struct text){commands.data, (size_t)(statement.data - commands.data)};
    }
    *passes = false;
    return commands;
}
