/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Events: what is watched for while a run goes on, and what has happened. */
#ifndef HOOKE_SESSION_EVENTS_H
#define HOOKE_SESSION_EVENTS_H

#include <hooke/session.h>

struct event;
struct expr_scope;

enum event_action { EVENT_STOP, EVENT_RECORD, EVENT_COMMANDS };

struct event_line {
    char name[LIMIT_NAME + 1];
    enum event_action action;
    const char *when; /* EXPR [rising|falling|touching], as typed */
    const char
        *commands; /* EVENT_COMMANDS: executed where the run has stopped; may end in `continue` */
};

/* In the order in which they were typed. */
struct events {
    struct events
        *older; /* of the session, none of which changes: set-up, runs and undo share them */
    struct arena arena;
    int count;
    struct event_line line[LIMIT_EVENTS];
};

/* A list with this line, which takes the place of one of the same name; texts are copied. NULL:
 * error. */
const struct events *events_with(struct session *session, const struct event_line *line,
                                 struct text when, struct text commands, struct error *error);
/* Without the line of that name. */
bool events_without(struct session *session, struct text name, const struct events **events,
                    struct error *error);
void events_destroy(struct events *events); /* and all older ones */
/* As typed_sweep(), the session's lists. */
void events_sweep(struct session *session,
                  bool (*used)(const struct session *session, const struct events *events));

/* "event top when x*y - beta*z falling do record"; as_stop: without what would be executed. */
void event_describe(const struct event_line *line, bool as_stop, struct buffer *text);
void events_save(const struct events *events, bool as_stop, struct buffer *text);
void events_plan(const struct events *events, struct buffer *text); /* a line of `plan` */
/* For a run: the list in the arena, *count of them. */
bool events_compile(const struct events *events, const struct expr_scope *scope,
                    struct arena *arena, const struct event **event, int *count,
                    struct error *error);
/* The events the run has just stopped at, in order: how many. */
int events_stopped_at(const struct run_slot *slot, const struct event_line *stopped[LIMIT_EVENTS]);
/* What is to be executed; *passes: a `continue` at its end, which is not part of it, lets the run
 * go on. */
struct text event_commands(struct text commands, bool *passes);

#endif
