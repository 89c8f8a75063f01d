/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Lessons: .hk files whose comments are steps. `#: TEXT` begins one, `#> COMMANDS` is what to type,
 * `#! TEXT` a hint, `#? done COMMAND` waits for that, `#? measured NAME` and `#? value NAME`
 * for a check of what `measure NAME` gave, `print NAME` gives. `#@ bare` and `#@ disk` generate a
 * recording. $seed, $bare_mass, $bare_file, … stand for values, $readings, $window and $span for
 * times of the recording in use.
 */
#pragma once

#include <hooke/command.h>
#include <hooke/data.h>
#include <hooke/module.h>
#include <hooke/session/names.h>

#define LESSON_DIGITS 0.005 /* tolerance of a value without uncertainty, relative */
#define LESSON_VAGUE 0.1    /* largest uncertainty of a value that is checked, relative */
#define LESSON_STEPS 64     /* most steps of a lesson */

/* The module's part of a session: a lesson that waits. */
struct lesson {
    bool waits;                    /* false if no lesson is open */
    struct buffer text;            /* text of the lesson */
    int step, steps;               /* counted from 0; step == steps: it is over */
    size_t begun;                  /* place in the log at which the step began */
    size_t counted;                /* place in the log from which measurements count */
    long seed;                     /* seed of its recordings */
    uint64_t passed[LESSON_STEPS]; /* place in the log at which each step was left */
};

struct lesson_step {
    struct text says, command, hint, wanted; /* wanted is a command or a name */
    bool done, measured;                     /* it is a command; what is measured */
    bool bare, disk;                         /* it needs that recording */
};

/* Steps are counted from 0. Returns false if it has no such step. */
bool lesson_step(const struct lesson *lesson, int number, struct lesson_step *step);
bool lesson_open(struct session *session, struct text name, long seed, const struct arguments *args,
                 struct error *error);
/* Ends the lesson; of the module's part of a session. */
void lesson_free(void *part);
/* Returns the session's lesson, or NULL if none waits. */
struct lesson *session_lesson(const struct session *session);
/* The lesson in a session's file. */
void lesson_put(const void *part, struct buffer *output);
void lesson_read(struct reader *reader);
/* Continues with the next step and prints it, if the last typed line did what the current step
 * waits for. */
void lesson_follow(struct session *session, struct reply *reply);
/* "lab 2/9", for the prompt; nothing without a lesson. */
void lesson_label(const struct session *session, struct buffer *text);
/* Appends the line that the lesson waits for. Without a lesson, the line that the lab does next
 * with the recording that was loaded last, by what was done with it since: measure it, fit it, take
 * the fit into the scene, run, plot, compare. */
bool report_next(const struct session *session, struct buffer *line);
/* A statement of it succeeded since the step began. */
bool lesson_done(const struct session *session, struct text command);
/* Finds the value that the step wants. A measurement counts if it was made after the last step that
 * wanted one of that name, from the recording in use, and with the parameters that are set now. */
bool lesson_found(const struct session *session, const struct lesson_step *step,
                  struct named_value *value);
/* Writes the recording that the present step needs, and says so; one that is there already and
 * differs is an error. */
bool lesson_files(struct session *session, struct reply *reply, struct error *error);

/* ---- what is typed, and what is offered (lesson_offer.c) ---- */

/* Returns the mass [g] that the lesson's recordings were generated with. */
double lesson_mass(long seed, bool disk);
/* Appends the step's text or command with its numbers. Without the lesson's own recordings, a mass
 * of a command is MASS, which only the student knows. */
void lesson_expand(const struct session *session, struct text text, bool is_command,
                   struct buffer *output);
/* Appends what is left to do of a command line: without statements that were done since `begun` and
 * without those that would replace a value that was typed. What `adopt` replaces is set again. */
void lesson_remaining(const struct session *session, struct text command, size_t begun,
                      size_t (*typed_since)(const struct session *session, struct text name),
                      struct buffer *output);
/* Returns the place in the log at which the lesson last left a step that sets `name`. */
size_t lesson_set_since(const struct session *session, struct text name);
/* Appends six times for readings of the amplitude within the recording, with commas between. */
void lesson_readings(const struct recording *recording, struct buffer *output);
