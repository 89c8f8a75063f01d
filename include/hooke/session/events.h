/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Events: what is watched for while a run goes on, and what has happened. */
#pragma once

#include <hooke/session.h>

struct event;
struct expr_scope;

enum event_action { EVENT_STOP, EVENT_RECORD, EVENT_COMMANDS };

struct event_line {
    char name[LIMIT_NAME + 1];
    enum event_action action;
    const char *when; /* EXPR [rising|falling|touching], as typed */
    /* Commands of EVENT_COMMANDS, executed where the run has stopped; they may end in `continue`.
     */
    const char *commands;
};

/* List of event lines in the order in which they were typed. */
struct events {
    /* Older lists of the session, none of which changes: set-up, runs and undo share them. */
    struct events *older;
    struct arena arena;
    int count;
    struct event_line line[LIMIT_EVENTS];
};

/* Returns a list with this line, which replaces one of the same name; texts are copied. Returns
 * NULL on error. */
const struct events *events_with(struct session *session, const struct event_line *line,
                                 struct text when, struct text commands, struct error *error);
/* Sets *events to the list without the line of that name, or to NULL if it was the only one.
 * Returns false, with an error, if there is no such line or if out of memory. */
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
/* Compiles the events of a run into a list in the arena, and sets *count. */
bool events_compile(const struct events *events, const struct expr_scope *scope,
                    struct arena *arena, const struct event **event, int *count,
                    struct error *error);
/* The events the run has just stopped at, in order: how many. */
int events_stopped_at(const struct run_slot *slot, const struct event_line *stopped[LIMIT_EVENTS]);
/* Returns the commands to execute, without a `continue` at the end; *passes is set if there was
 * one, which lets the run continue. */
struct text event_commands(struct text commands, bool *passes);
