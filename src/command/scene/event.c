/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command event: what a run watches for, and what happens then. */
#ifndef COMMAND_ROWS
#include <hooke/base/statement.h>
#include <hooke/scene/formula.h>
#include <hooke/scene/unit_word.h>
#include <hooke/command/handler.h>
#include "command/run/event_pass.h"

#include <string.h>

static void reply_line_of(const struct event_line *line, struct reply *reply)
{
    event_describe(line, reply_buffer(reply));
}

/* Lists the events of the next run. */
static void reply_events(const struct session *session, struct reply *reply)
{
    const struct events *events = session->setup.events;
    for (int i = 0; events && i < events->count; i++)
        reply_line_of(&events->line[i], reply);
    if (!events)
        reply_line(reply, "no events");
}

/* Removes all events. */
static void drop_all(struct session *session, struct reply *reply)
{
    const int count = session->setup.events ? session->setup.events->count : 0;
    session->setup.events = NULL;
    if (count > 0)
        reply_line(reply, "%d event%s removed", count, plural_s(count));
    else
        reply_line(reply, "no events");
}

/* Sets an error with an example. Returns false. */
static bool event_usage(struct text where, const char *what, struct error *error)
{
    error_at(error, where, "%s", what);
    return error_hint(error, "for example: event top when y' falling do record");
}

/* Refuses commands that an event cannot execute; their arguments are checked when they are
 * executed. Returns false with the error set. */
static bool check_commands(struct text commands, struct error *error)
{
    bool passes;
    struct text rest = event_commands(commands, &passes), statement;
    while (rest.len > 0) {
        if (!next_statement(&rest, &statement, error))
            return false;
        const struct text word = peek_word(statement, "=");
        const struct row *row = catalog_find(&command_catalog, word);
        const struct text after_word = text_behind(statement, word.len);
        const bool sets = after_word.len > 0 && after_word.data[0] == '=';
        if (row && !sets && !event_executes(command_at(row)))
            return refuse_in_event(command_at(row), word, error);
    }
    return true;
}

/* Reads the end of an event's definition: do stop|record|COMMANDS. Sets line->action; *commands is
 * the word or string behind `do`. Commands in a string are checked for syntax. Returns false with
 * the error set if anything is malformed, too long or follows the action. */
static bool read_action(struct parser *parser, struct event_line *line, struct item *commands,
                        struct error *error)
{
    if (!text_is(peek_word(parser->rest, ""), "do"))
        return event_usage(peek_word(parser->rest, ""), "'do' must follow the expression", error);
    parser->rest = text_behind(parser->rest, 2);
    if (!parse_word(parser, "", commands, error))
        return false;
    if (commands->is_string)
        line->action = EVENT_COMMANDS;
    else if (text_is(commands->text, "stop") || text_is(commands->text, "record"))
        line->action = text_is(commands->text, "stop") ? EVENT_STOP : EVENT_RECORD;
    else
        return event_usage(commands->text, "'do' takes stop, record or a string of commands",
                           error);
    if (commands->text.len > LIMIT_EVENT_TEXT)
        return error_at(error, commands->text, "the commands are longer than %d bytes",
                        LIMIT_EVENT_TEXT);
    return refuse_rest(parser, NULL, error) &&
           (line->action != EVENT_COMMANDS || check_commands(commands->text, error));
}

/* Reads the rule of an event and adds it to the events of the next run. Returns false with the
 * error set. */
bool event_add(struct session *session, struct arena *arena, struct text name, struct text rule,
               struct error *error)
{
    /* variables and results are excluded, so that the meaning never changes */
    const struct names names = {.session = session, .expects_run = true, .saved_only = true};
    const struct expr_scope scope = names_scope(&names);
    struct event_line line = {.action = EVENT_STOP};
    struct item commands = {0};
    struct event event = {.stop = false};
    size_t used;
    if (name.len > LIMIT_NAME)
        return error_at(error, name, "the name has more than %d letters", LIMIT_NAME);
    memcpy(line.name, name.data, name.len);
    if (!text_is(peek_word(rule, ""), "when"))
        return event_usage(peek_word(rule, ""), "'when' must follow the name", error);
    const struct text when = text_behind(rule, 4);
    if (!event_compile(when, &scope, arena, &event, &used, error))
        return names_explain(session, error);
    if (used > LIMIT_EVENT_TEXT)
        return error_at(error, (struct text){when.data, used},
                        "the expression is longer than %d bytes", LIMIT_EVENT_TEXT);
    struct parser parser = {session, &scope, arena, text_behind(when, used)};
    const char last = used > 0 ? when.data[used - 1] : ' ';
    if (last >= '0' && last <= '9' && used < when.len && is_name_start(when.data[used]))
        return refuse_unit_word(&scope, unit_word(parser.rest), (struct text){when.data, used},
                                QUANTITY_OTHER, error);
    if (!read_action(&parser, &line, &commands, error))
        return false;
    const struct events *events = events_with(
        session, &line, text_trim((struct text){when.data, used}), commands.text, error);
    if (events)
        session->setup.events = events;
    return events != NULL;
}

/* Lists, removes or defines events. */
HANDLER(event)
{
    const struct argument_value *name = argument_value(args, "NAME"),
                                *rule = argument_value(args, "when EXPR do stop|record|COMMANDS");
    const struct text end =
        name->count ? text_behind(name->item->text, name->item->text.len) : TEXT("");
    const struct text rest = rule->count ? rule->item->text : end;
    if (name->count == 0) {
        reply_events(session, reply);
        return true;
    }
    if (rule->count == 0 && text_is(name->item->text, "off")) {
        drop_all(session, reply);
    } else if (text_is(rest, "off")) {
        if (!events_without(session, name->item->text, &session->setup.events, error))
            return false;
        reply_line(reply, "event %.*s is removed", (int)name->item->text.len,
                   name->item->text.data);
    } else {
        if (!event_add(session, args->arena, name->item->text, rest, error))
            return false;
        const struct events *events = session->setup.events; /* the new one comes last */
        reply_line_of(&events->line[events->count - 1], reply);
    }
    session_changed(session);
    return true;
}
#endif

COMMAND(event, .group = "EQUATIONS", .flags = COMMAND_CHANGES, .completes = COMPLETES_EVENT,
        ARGUMENTS(PLACE("NAME", TYPE_NAME),
                  PLACE("when EXPR do stop|record|COMMANDS", TYPE_FORMULA)))
