/* SPDX-License-Identifier: GPL-3.0-or-later */
/* handler: how commands are written (HANDLER, COMMAND and the macros of arguments), and the
 * functions that handlers of several files share. */
#pragma once

#include <hooke/run.h>
#include <hooke/command.h>
#include <hooke/module.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>

struct row;

/*
 * ---- how a command is written ----
 *
 * A file contains, inside `#ifndef COMMAND_ROWS`, functions that begin with HANDLER(name), and
 * below it their rows, COMMAND(name, …). commands.c includes all of them again by commands.def to
 * collect the rows.
 */

/* Parameters of a handler, see struct command. */
#define HANDLER_PARAMETERS                                                                         \
    struct session *session, const struct arguments *args, struct reply *reply, struct error *error
/* Begins the definition of the handler of a command. It returns false with `error` set. */
#define HANDLER(name)                                                                              \
    bool command_##name(HANDLER_PARAMETERS);                                                       \
    bool command_##name(HANDLER_PARAMETERS)
/* Marks a parameter as unused. */
#define UNUSED(thing) ((void)(thing))

/* The arguments of a command in its row, made by the macros below. */
#define ARGUMENTS(...)                                                                             \
    .argument = (const struct argument[]){__VA_ARGS__},                                            \
    .arguments = (int)COUNT_OF(((const struct argument[]){__VA_ARGS__}))

/* An argument of each form: name, type, then other members that differ from zero, as in PLACE("N",
 * TYPE_INTEGER, .flags = ARG_REQUIRED). */
#define PLACE(...)                                                                                 \
    {                                                                                              \
        .form = FORM_PLACE, .name = __VA_ARGS__                                                    \
    }
#define WORD(...)                                                                                  \
    {                                                                                              \
        .form = FORM_WORD, .name = __VA_ARGS__                                                     \
    }
#define KEY(...)                                                                                   \
    {                                                                                              \
        .form = FORM_KEY, .name = __VA_ARGS__                                                      \
    }
#define OPTION(...)                                                                                \
    {                                                                                              \
        .form = FORM_OPTION, .name = __VA_ARGS__                                                   \
    }

#ifndef COMMAND_ROWS
#define COMMAND(...)
#endif

/* Computes slope [n + 1], the derivatives of the value of an expression by the state of the run and
 * by time, by finite differences. Returns false if the expression cannot be evaluated near the
 * current state. */
bool find_slopes(const struct parser *value, struct run *run, const char *what,
                 enum quantity quantity, double *slope);
/* Returns true for a value that commands of an event set and that depends on the state of the run.
 */
bool value_depends(struct session *session, const struct parser *value);
/* Marks the derivatives of the last jump of the current run as unknown. */
void forget_jump_slopes(struct session *session);
/* Returns a parser for the argument VALUE of a statement NAME = VALUE, for read_value(). */
struct parser value_parser(struct session *session, const struct arguments *args);
/* Reads a value and refuses remaining text. Returns false with `error` set. */
bool read_value(struct parser *parser, const char *what, enum quantity quantity, struct item *item,
                struct error *error);

/* Returns false, with `error` set, if standard input ('-') is not free for data because commands
 * come from it. */
bool check_input(const struct session *session, struct text where, struct error *error);

/* ---- replies that fit on one screen ---- */

/* Returns true if the statement has the option --full. */
bool asks_full(const struct arguments *arguments);
/* Smallest size of a screen [row, cell] for which text is shortened: on smaller screens it scrolls.
 */
enum { ANSWER_ROWS_MIN = 22 /* [row] */, ANSWER_WIDTH_MIN = 80 /* [cell] */ };
/* Returns the number of rows of a reply that fits below the line that was typed. */
int answer_rows(const struct session *session);
/* Returns the number of rows of a text on a screen of this width [cell]. */
int text_rows(struct text text, int width);

/* Replies with the line and the record of a table that was written to a file. */
void reply_exported(struct reply *reply, struct text file, const struct table *table);

/* ---- replies about runs ---- */

/* Returns true if a task with this predicted time [s] needs --force or a confirmation. */
bool takes_long(double seconds);
/* Returns true if a task with this predicted time [s] may start: it is short, --force was given, or
 * the user at the prompt has confirmed it. Otherwise returns false with `error` set. */
bool allow_long(struct session *session, double seconds, double steps, bool force,
                struct error *error);
/* Replies with the line and the record of a run's current state. */
void reply_run(const struct session *session, const struct run *run, struct reply *reply);
/* Warns of what is wrong with a run or its steps, of most things once per run. */
void reply_run_warnings(struct run *run, struct reply *reply);
/* Warns once if a step had little to do with the solution (struct unsound_step). */
void reply_unsound(struct run *run, struct reply *reply);
/* Notes variables that are so small that no digit is reliable. */
void reply_below_tolerance(const struct run *run, struct reply *reply);
/* Computes the estimated error of a run with the effort of `set opinion`, if the reply shows it. */
void seek_opinion(const struct session *session, struct run *run, const struct reply *reply);
/* Appends the cost of the estimated error to the text of `plan`. */
void plan_opinion(const struct session *session, const struct system *system,
                  const struct plan *plan, struct buffer *text);
/* Replies with a line about the estimated error, and a warning if it is large. Returns false, with
 * `error` set, if no digit of the result is correct. */
bool reply_opinion(const struct session *session, struct run *run, struct reply *reply,
                   struct error *error);
/* Warns of a state whose squares underflow. */
void reply_tiny(const struct run *run, struct reply *reply);
/* Notes once which method is used for a typed scene while the user has not set one. */
void reply_unchosen(struct session *session, struct reply *reply);
/* Notes once for each typed scene which duration, tolerance and first step are used while the user
 * has not set them. `adapts` if step-size control uses the last two; by_setting if the setting
 * duration is used. */
void reply_assumed(struct session *session, bool adapts, bool by_setting, struct reply *reply);
/* Notes that a study uses the duration that is set although the current run was longer. */
void reply_shorter(const struct session *session, struct reply *reply);
/* Warns if the method that is set cannot be applied to the scene, with advice. */
void reply_inapplicable(const struct session *session, struct reply *reply);
/* Warns of a step that is too long for the period. */
void reply_coarse(const struct session *session, const struct run *run, struct reply *reply);

/* Shows the progress of a study, a fraction, or 2 when it has ended; `context` is the session's
 * struct front. */
void report_fraction(void *context, double fraction);

/* Returns false, with `error` set, if the setting starts a program and the statement does not come
 * from a prompt, or with --safe. */
bool check_typed(const struct session *session, const struct setting *setting,
                 const struct source *where, struct error *error);
/* Handler of `set`, which other commands call. */
bool command_set(HANDLER_PARAMETERS);
/* Adds an event with this name and the rule "when EXPR do …" to the set-up. Returns false with
 * `error` set. */
bool event_add(struct session *session, struct arena *arena, struct text name, struct text rule,
               struct error *error);
/* Stores the current scene, if all of it was typed, so that `scene NAME` finds it. Returns false,
 * with `error` set, if there are too many. */
bool keep_own_scene(struct session *session, struct error *error);
/* Choices of arguments. */
extern const struct catalog cursor_action_catalog, axis_catalog, unset_catalog, guide_catalog;

/* Replies with a row as `list` shows it: a line, and a record of its catalog's kind. */
void reply_listed(const struct catalog *catalog, const struct row *row, struct reply *reply);
