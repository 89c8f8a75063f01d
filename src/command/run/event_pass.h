/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Commands of events. While a run advances, events_pass() executes those that let it continue;
 * event_react() executes those of the last stop. */
#pragma once

#include <hooke/command/handler.h>

#include <hooke/session/events.h>

/* Returns true if the command is allowed among the commands of an event. */
bool event_executes(const struct command *command);
/* Sets the error that an event cannot execute the command. Returns false. */
bool refuse_in_event(const struct command *command, struct text where, struct error *error);

/* The events at which a run has stopped in the present command, to recognise that they repeat
 * without end. */
struct event_pass {
    const struct event_line *stopped[LIMIT_EVENTS]; /* events at which the run is now */
    int count;
    int passed;  /* number of events passed in the present command */
    size_t seen; /* event records of the run */
    struct {
        bool known;
        double last, longest; /* [s] its last time, and the longest time between two */
        int close;            /* number of times in a row that it repeated almost at once */
    } event[LIMIT_EVENTS];
};

/* Executes the commands of an event, without a `continue` at their end. Returns false after an
 * error, which has been reported. */
bool event_react(struct session *session, const struct event_line *event,
                 const struct arguments *args, struct reply *reply, struct error *error);
/* Executes the commands of the events at which the current run has stopped, if they let it
 * continue. Returns false if the run stops here; *ok is false only after an error. */
bool events_pass(struct session *session, const struct run_target *target, struct event_pass *pass,
                 const struct arguments *args, struct reply *reply, bool *ok, struct error *error);
