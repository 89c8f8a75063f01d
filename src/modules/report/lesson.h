/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lessons: .hk files whose comments are steps. `#: TEXT` begins a step, `#> COMMANDS` is what to
 * type, `#! TEXT` a hint, `#? done COMMAND` waits for that command, `#? measured NAME` and `#?
 * value NAME` wait until the student has given the result of `measure NAME` or `print NAME` to
 * `check`. `#@ bare` and `#@ disk` generate a recording. $seed, $bare_mass, $bare_file, … stand for
 * values, $readings, $window and $span for times of the recording in use. */
#pragma once

#include <hooke/command.h>
#include <hooke/data.h>
#include <hooke/module.h>
#include <hooke/session/names.h>

#define LESSON_DIGITS 0.005  /* tolerance of a value without uncertainty, relative */
#define LESSON_VAGUE 0.02    /* largest relative uncertainty of an accepted answer, or: */
#define LESSON_VAGUE_RATIO 3 /* times the measured uncertainty, whichever is larger */
#define LESSON_STEPS 64      /* most steps of a lesson */

/* The module's part of a session: the open lesson, if there is one. */
struct lesson {
    bool waits;         /* false if no lesson is open */
    struct buffer text; /* text of the lesson file, with $seed and file names filled in */
    int step, steps;    /* current step, counted from 0, and number of steps; equal at the end */
    /* Positions in the log of statements: where the current step began, from where measurements are
     * accepted as answers, and where each step was left. */
    size_t begun;
    size_t counted;
    long seed; /* seed of the generated recordings */
    uint64_t passed[LESSON_STEPS];
    bool asks_mass; /* the mass was asked for and has not been given yet; not stored */
};

/* One step of a lesson as parsed from its text; the parts point into that text. */
struct lesson_step {
    /* wanted is the command to be executed or the name of the value to be checked */
    struct text says, command, hint, wanted;
    /* The step waits for a command (done), for a result of `measure` (measured), or of `print`. */
    bool done, measured;
    bool bare, disk; /* the step needs that generated recording */
};

/* Parses step `number`, counted from 0. Returns false if the lesson has no such step. */
bool lesson_step(const struct lesson *lesson, int number, struct lesson_step *step);
/* Opens the lesson of that name, a built-in one or a file, and ends the one before. Its first step
 * is the current one. Returns false with *error if it cannot be read or has no steps. */
bool lesson_open(struct session *session, struct text name, long seed, const struct arguments *args,
                 struct error *error);
/* Ends the lesson of a session; `part` is the struct lesson. */
void lesson_free(void *part);
/* Returns the session's lesson, or NULL if none waits. */
struct lesson *session_lesson(const struct session *session);
/* Writes the open lesson to the session's file. */
void lesson_put(const void *part, struct buffer *output);
/* Reads it again; a record that does not fit is left out with a note. */
void lesson_read(struct reader *reader);
/* Continues with the next step and prints it, if the last typed line did what the current step
 * waits for. */
void lesson_follow(struct session *session, struct reply *reply);
/* Appends "lab 2/9" for the prompt, or nothing if no step waits. */
void lesson_label(const struct session *session, struct buffer *text);
/* Appends the line that the lesson waits for. Without a lesson, the line that the lab does next
 * with the recording that was loaded last, by what was done with it since: measure, fit, adopt,
 * run, plot, compare. Returns false if nothing is due. */
bool report_next(const struct session *session, struct buffer *line);
/* Returns true if a statement that begins with `command` succeeded since the step began. */
bool lesson_done(const struct session *session, struct text command);
/* Finds the value that the step wants. A measurement counts if it was made after the last step that
 * wanted one of that name, from the recording in use, and with the parameters that are set now. */
bool lesson_found(const struct session *session, const struct lesson_step *step,
                  struct named_value *value);
/* Writes the recording that the current step needs, and tells so, unless the file exists with the
 * same content. Returns false with *error if it exists and differs. */
bool lesson_files(struct session *session, struct reply *reply, struct error *error);

/* ---- what is typed, and what is offered (lesson_offer.c) ---- */

/* Returns true if name and content of the recording's file are those of a generated recording, and
 * sets its seed and whether it has the disk. */
bool lesson_generated(const struct recording *recording, long *seed, bool *is_disk);
/* Returns the mass [g] that the lesson's recordings were generated with. */
double lesson_mass(long seed, bool disk);
/* Appends the step's text or command with its numbers. Without the lesson's own recordings, a mass
 * of a command is MASS, which only the student knows. */
void lesson_expand(const struct session *session, struct text text, bool is_command,
                   struct buffer *output);
/* Returns true if the step's command sets the mass, and the student has given none since the last
 * step that set it: neither by `m = VALUE` nor for the recording in use. */
bool lesson_lacks_mass(const struct session *session, const struct lesson_step *step);
/* Returns true if the current step waits for a mass that only the student knows. */
bool lesson_asks_mass(const struct session *session);
/* Appends what is left to do of a command line: without statements that were done since `begun` and
 * without those that would replace a value that was typed. What `adopt` replaces is set again. */
void lesson_remaining(const struct session *session, struct text command, size_t begun,
                      size_t (*typed_since)(const struct session *session, struct text name),
                      struct buffer *output);
/* Returns the place in the log at which the lesson last left a step that sets `name`. */
size_t lesson_set_since(const struct session *session, struct text name);
/* Appends six times for readings of the amplitude within the recording, with commas between. */
void lesson_readings(const struct recording *recording, struct buffer *output);
