/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Execution of the commands of events that have stopped a run. */
#pragma once

#include <hooke/command/handler.h>

#include <hooke/session/events.h>

/* Returns true if the command is allowed among the commands of an event. */
bool event_executes(const struct command *command);
/* false, always */
bool refuse_in_event(const struct command *command, struct text where, struct error *error);

/* Events at which a run stops only for what they change. */
struct event_pass {
    const struct event_line *stopped[LIMIT_EVENTS]; /* events at which the run is now */
    int count;
    int passed;  /* number of events passed in the present command */
    size_t seen; /* event records of the run */
    struct {
        bool known;
        double last, longest; /* [s] when it was, and the longest time between two */
        int close;            /* number of times in a row that it came at once */
    } event[LIMIT_EVENTS];
};

/* The commands of an event, without `continue`. */
bool event_react(struct session *session, const struct event_line *event,
                 const struct arguments *args, struct reply *reply, struct error *error);
/* Executes the commands of the events at which the current run has stopped, if they let it
 * continue. Returns false if the run stops here; *ok is false only after an error. */
bool events_pass(struct session *session, const struct run_target *target, struct event_pass *pass,
                 const struct arguments *args, struct reply *reply, bool *ok, struct error *error);
