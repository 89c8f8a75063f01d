/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Lessons: .hk files whose comments are steps. `#: TEXT` begins one, `#> COMMANDS` is what to type,
 * `#! TEXT` a hint, `#? done COMMAND` waits for that, `#? measured NAME` and `#? value NAME`
 * for a check of what `measure NAME` gave, `print NAME` gives. `#@ bare` and `#@ disk` generate a
 * recording. $seed, $bare_mass, $bare_file, … stand for values.
 */
#ifndef HOOKE_COMMAND_LESSON_H
#define HOOKE_COMMAND_LESSON_H

#include <hooke/command.h>
#include <hooke/session/names.h>

#define LESSON_DIGITS 0.005 /* relative: what a value without uncertainty may be off */

struct lesson_step {
    struct text says, command, hint, wanted; /* wanted: a command, or a name */
    bool done, measured;                     /* it is a command; what is measured */
    bool bare, disk;                         /* it needs that recording */
};

/* Steps are counted from 0. False: it has no such step. */
bool lesson_step(const struct lesson *lesson, int number, struct lesson_step *step);
bool lesson_open(struct session *session, struct text name, long seed, const struct arguments *args,
                 struct error *error);
void lesson_free(struct session *session);
/* A statement of it succeeded since the step began. */
bool lesson_done(const struct session *session, struct text command);
/* What the step wants has a value; measured since it began, if it is to be. */
bool lesson_found(const struct session *session, const struct lesson_step *step,
                  struct named_value *value);
/* Writes the recording that the present step needs; one that is there already and differs is an
 * error. */
bool lesson_files(struct session *session, struct error *error);

#endif
