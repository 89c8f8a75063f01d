/* SPDX-License-Identifier: GPL-3.0-or-later */
/* events: the user's events: conditions that a run searches for, and what happens then. Lists of
 * them are compiled for a run by events_compile() into struct event (<hooke/run.h>). */
#pragma once

#include <hooke/session.h>

struct event;
struct expr_scope;

/* Action at an event. The run stops, the event is recorded, or the run stops and commands are
 * executed. */
enum event_action { EVENT_STOP, EVENT_RECORD, EVENT_COMMANDS };

/* A line `event NAME when WHEN do ACTION`; texts belong to the list. */
struct event_line {
    char name[LIMIT_NAME + 1];
    enum event_action action;
    const char *when; /* EXPR [rising|falling|touching], as typed. */
    /* Commands of EVENT_COMMANDS, executed at the event; they may end in `continue`. */
    const char *commands;
};

/* An immutable list of events in the order in which they were typed. */
struct events {
    /* Next list of the session, an older one; set-up, runs and undo share the lists. */
    struct events *older;
    /* Owner of the texts. */
    struct arena arena;
    int count;
    struct event_line line[LIMIT_EVENTS];
};

/* Returns a list of the set-up's events and this one, which replaces one of the same name; texts
 * are copied. Returns NULL with `error` set. The session owns the list. */
const struct events *events_with(struct session *session, const struct event_line *line,
                                 struct text when, struct text commands, struct error *error);
/* Sets *events to the list without the line of this name, or to NULL if it was the only one.
 * Returns false, with `error` set, if there is no such line or if out of memory. */
bool events_without(struct session *session, struct text name, const struct events **events,
                    struct error *error);
void events_destroy(struct events *events); /* Frees a list and all older ones. */
/* Frees lists for which used() returns false, once there are many, as typed_sweep() does for
 * models. */
void events_sweep(struct session *session,
                  bool (*used)(const struct session *session, const struct events *events));

/* Appends the line: "event top when x*y - beta*z falling do record"; with as_stop, "do stop" in
 * place of commands. */
void event_describe(const struct event_line *line, bool as_stop, struct buffer *text);
/* Appends all lines of a list, which may be NULL. */
void events_save(const struct events *events, bool as_stop, struct buffer *text);
/* Appends a line about the events for the command `plan`; `events` may be NULL. */
void events_plan(const struct events *events, struct buffer *text);
/* Compiles a list, which may be NULL, into an array in the arena, and sets *event and *count.
 * Returns false with `error` set. */
bool events_compile(const struct events *events, const struct expr_scope *scope,
                    struct arena *arena, const struct event **event, int *count,
                    struct error *error);
/* Fills `stopped` with the events at which the run has just stopped, in order, and returns their
 * number. */
int events_stopped_at(const struct run_slot *slot, const struct event_line *stopped[LIMIT_EVENTS]);
/* Returns the commands without a `continue` at their end; *passes is true if there was one, which
 * lets the run continue. */
struct text event_commands(struct text commands, bool *passes);
