/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What was asked of a run since its start, so that it can be made again bit for bit: by undo, by a saved session, by
 * `record`. How the work was cut into slices, and where it was paused, leaves no trace in the samples and stands here
 * only as the step at which something else was asked.
 */
#ifndef HOOKE_COMMAND_JOURNAL_H
#define HOOKE_COMMAND_JOURNAL_H

#include "internal.h"

enum leg_kind {
    LEG_GO,   /* towards a time, a step or a condition */
    LEG_SET,  /* a parameter changes */
    LEG_KICK, /* a variable of the state changes, in a step of its own */
    LEG_BACK, /* recorded states are dropped; only of adaptive runs, the others keep no memory of it */
};

struct leg {
    enum leg_kind kind;
    int64_t from;    /* step of the run at which it was asked for */
    double from_t;   /* [s] */
    double t;        /* LEG_GO: the target [s], FAR either way: none */
    int64_t end;     /* LEG_GO: step at which it ends, INT64_MAX: none; LEG_BACK: step it led to */
    char *condition; /* LEG_GO: as typed, NULL: none */
    int64_t met;     /* step at which the condition became true, 0: it did not */
    int param;       /* LEG_SET; LEG_KICK: variable */
    struct measured value;
    bool by_event;   /* asked for by the commands of an event of the run */
    int64_t rows; /* LEG_BACK */
};

bool journal_add(struct held_run *held, struct leg leg, struct text condition, struct error *error);
void journal_free(struct leg *leg, int legs);
/* A copy; *copy NULL where there are none. False: no memory. */
bool journal_copy(const struct leg *leg, int legs, struct leg **copy);
/* What is still to be done after a pause: the last LEG_GO; NULL: nothing. */
struct leg *journal_pending(const struct held_run *held);
/* Where an event has stopped the run: on towards the same. */
bool journal_go_on(struct held_run *held, bool by_event, struct error *error);
/* The run has been taken back by `rows`, from step `before`. */
bool journal_back(struct held_run *held, int64_t before, double before_t, int64_t rows, struct error *error);
/* The parameters in force now: those of the start and what was changed since, by events too or without them. */
void journal_scene(const struct held_run *held, bool by_events, struct scene *scene);
/* Has something been changed since leg `first`, not by an event? */
bool journal_changed(const struct held_run *held, int first);
/*
 * Takes the run to the state at the end of these legs: `steps`, at time `t`. They may share a beginning with the run's
 * own, which they replace; the run keeps its own without memory.
 */
bool journal_restore(struct session *session, struct held_run *held, const struct leg *leg, int legs, int64_t steps,
                     double t);
/* What a LEG_SET or LEG_KICK changed, and to what: "gamma 0.1 1/s". */
void journal_put_change(const struct run *run, const struct leg *leg, struct buffer *text);
/*
 * Appends the commands that do what was done since leg `first` and step `since` (0, -1: all): run, continue, change,
 * back. number: of the run, 0: the next. by_events: also what the run's events did, which does it again where they only
 * stop. False: a condition needs names that no saved session knows; then nothing is appended.
 */
bool journal_write(const struct session *session, const struct held_run *held, int first, int64_t since, int number,
                   bool by_events, struct buffer *text);

#endif
