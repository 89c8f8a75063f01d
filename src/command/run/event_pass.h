/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What events do where a run has stopped because of them. */
#ifndef HOOKE_COMMAND_RUN_EVENT_PASS_H
#define HOOKE_COMMAND_RUN_EVENT_PASS_H

#include <hooke/command/handler.h>

#include <hooke/session/events.h>

/* What may stand in its commands. */
bool event_executes(const struct command *command);
/* false, always */
bool refuse_in_event(const struct command *command, struct text where, struct error *error);

/* Events at which a run stops only for what they change. */
struct event_pass {
    const struct event_line *stopped[LIMIT_EVENTS]; /* where it is now */
    int count;
    int passed;  /* in the present command */
    size_t seen; /* event records of the run */
    struct {
        bool known;
        double last, longest; /* [s] when it was, and the longest time between two */
        int close;            /* how often in a row it has come at once */
    } event[LIMIT_EVENTS];
};

/* The commands of an event, without `continue`. */
bool event_react(struct session *session, const struct event_line *event,
                 const struct arguments *args, struct reply *reply, struct error *error);
/* The commands of events that pass, where the current run is at some. False: it is where it stops,
 * *ok unless because of an error. */
bool events_pass(struct session *session, const struct run_target *target, struct event_pass *pass,
                 const struct arguments *args, struct reply *reply, bool *ok, struct error *error);

#endif
