/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Lessons: .hk files whose comments are steps. `#: TEXT` begins one, `#> COMMANDS` is what to type,
 * `#! TEXT` a hint, `#? done COMMAND` waits for that, `#? measured NAME` and `#? value NAME`
 * for a check of what `measure NAME` gave, `print NAME` gives. `#@ bare` and `#@ disk` generate a
 * recording. $seed, $bare_mass, $bare_file, … stand for values.
 */
#pragma once

#include <hooke/command.h>
#include <hooke/module.h>
#include <hooke/session/names.h>

#define LESSON_DIGITS 0.005 /* tolerance of a value without uncertainty, relative */

/* The module's part of a session: a lesson that waits. */
struct lesson {
    bool waits;         /* false if no lesson is open */
    struct buffer text; /* text of the lesson */
    int step, steps;    /* counted from 0; step == steps: it is over */
    size_t begun;       /* place in the log at which the step began */
    long seed;          /* seed of its recordings */
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
bool report_next(const struct session *session, struct buffer *line, bool *insists);
/* A statement of it succeeded since the step began. */
bool lesson_done(const struct session *session, struct text command);
/* Returns true if the value that the step wants exists and, if required, was measured since the
 * step began. */
bool lesson_found(const struct session *session, const struct lesson_step *step,
                  struct named_value *value);
/* Writes the recording that the present step needs; one that is there already and differs is an
 * error. */
bool lesson_files(struct session *session, struct error *error);
