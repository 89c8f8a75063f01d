/* SPDX-License-Identifier: GPL-3.0-or-later */
/* events: the user's events, each of which is a condition that a run searches for and an action.
 * events_compile() compiles a list of them for a run into an array of struct event (<hooke/run.h>).
 */
#pragma once

#include <hooke/session.h>

struct event;
struct expr_scope;

/* Action at an event: EVENT_STOP stops the run, EVENT_RECORD only records the event, EVENT_COMMANDS
 * stops the run and executes commands. */
enum event_action { EVENT_STOP, EVENT_RECORD, EVENT_COMMANDS };

/* A line `event NAME when WHEN do ACTION`; texts belong to the list. */
struct event_line {
    char name[LIMIT_NAME + 1];
    enum event_action action;
    const char *when; /* Condition as typed: EXPR [rising|falling|touching]. */
    /* Commands of EVENT_COMMANDS, executed at the event; they may end in `continue`. */
    const char *commands;
};

/* An immutable list of events in the order in which they were typed. */
struct events {
    /* Next, older list of the session, which owns all lists; set-up, runs and undo point to them.
     */
    struct events *older;
    /* Owner of the texts. */
    struct arena arena;
    int count;
    struct event_line line[LIMIT_EVENTS];
};

/* Makes a new list: the events of the current set-up without the one that has the name of `line`,
 * if there is one, followed by an event with the name and action of `line`, the condition `when`
 * and the commands `commands`. Texts are copied. Returns the list, which the session owns, or NULL
 * with `error` set. The set-up is not changed. */
const struct events *events_with(struct session *session, const struct event_line *line,
                                 struct text when, struct text commands, struct error *error);
/* Sets *events to a list of the events of the current set-up without the one of this name, or to
 * NULL if it was the only one. Returns false, with `error` set, if there is no such event or if out
 * of memory. */
bool events_without(struct session *session, struct text name, const struct events **events,
                    struct error *error);
void events_destroy(struct events *events); /* Frees a list and all older ones. */
/* Frees the lists for which used(session, events) returns false. So that each call is cheap, it
 * does nothing until the session has SWEEP_FROM (<hooke/scene/typed.h>) more lists than twice the
 * number that the last sweep left. */
void events_sweep(struct session *session,
                  bool (*used)(const struct session *session, const struct events *events));

/* Appends the command that defines the event: "event top when x*y - beta*z falling do record". */
void event_describe(const struct event_line *line, struct buffer *text);
/* Appends the commands that define all events of a list, which may be NULL, one per line. */
void events_save(const struct events *events, struct buffer *text);
/* Appends a line about the events for the command `plan`; `events` may be NULL. */
void events_plan(const struct events *events, struct buffer *text);
/* Compiles a list, which may be NULL, in a scope of names: sets *event to an array in the arena
 * with an item for each event of the list, and *count to its length. Returns false with `error`
 * set. */
bool events_compile(const struct events *events, const struct expr_scope *scope,
                    struct arena *arena, const struct event **event, int *count,
                    struct error *error);
/* Fills `stopped` with those events at the current time of the run whose action stops it, in the
 * order in which they happened, and returns their number; 0 unless the last stop of the run was by
 * an event. */
int events_stopped_at(const struct run_slot *slot, const struct event_line *stopped[LIMIT_EVENTS]);
/* Returns `commands` without a `continue` at their end, as a slice. Sets *passes to true if there
 * was one, so that the run continues after the commands. */
struct text event_commands(struct text commands, bool *passes);
