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
 * A file of commands is compiled by itself and is also included twice by src/command/commands.c,
 * through src/command/commands.def (files of modules through lists/commands.def). It contains the
 * handlers, functions that begin with HANDLER(name), inside `#ifndef COMMAND_ROWS`, and below them
 * a row COMMAND(name, members of struct command) for each. When the file is compiled by itself,
 * COMMAND is empty, so that only the handlers remain. commands.c defines COMMAND_ROWS and COMMAND:
 * the first time to declare the handlers, the second time to make the table of all commands
 * (command_catalog). A command is thus written in one place.
 */

/* Parameters of a handler, see struct command. */
#define HANDLER_PARAMETERS                                                                         \
    struct session *session, const struct arguments *args, struct reply *reply, struct error *error
/* Begins the definition of the handler of a command, which returns false with `error` set. */
#define HANDLER(name)                                                                              \
    bool command_##name(HANDLER_PARAMETERS);                                                       \
    bool command_##name(HANDLER_PARAMETERS)
/* Marks a parameter as unused. */
#define UNUSED(thing) ((void)(thing))

/* The arguments of a command, as members of its row; the parameters are made by the macros below.
 */
#define ARGUMENTS(...)                                                                             \
    .argument = (const struct argument[]){__VA_ARGS__},                                            \
    .arguments = (int)COUNT_OF(((const struct argument[]){__VA_ARGS__}))

/* Arguments of the forms of enum argument_form: a positional one (PLACE), NAME item (WORD),
 * NAME=item (KEY) and --NAME [item] (OPTION). The parameters are the name, the type, then other
 * members of struct argument that differ from zero, as in PLACE("N", TYPE_INTEGER, .flags =
 * ARG_REQUIRED). */
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

/* Computes the derivatives of an expression's value with respect to each of the n variables of the
 * run and to time, by finite differences, and sets slope [n + 1] to them. `value` is a parser at
 * the beginning of the expression, `what` the name of the value in messages, `quantity` the
 * quantity that the value must have. Returns false if the expression cannot be evaluated near the
 * current state of the run. */
bool find_slopes(const struct parser *value, struct run *run, const char *what,
                 enum quantity quantity, double *slope);
/* Returns true if commands of an event are being executed in an adaptive run and the expression at
 * `value` depends on the state of the run or on time. */
bool value_depends(struct session *session, const struct parser *value);
/* Marks the derivatives of the last jump of the current run (run_set_jump_slopes()) as unknown, so
 * that no error is estimated beyond the jump. */
void forget_jump_slopes(struct session *session);
/* Returns a parser for the argument VALUE of a statement NAME = VALUE, for read_value(). */
struct parser value_parser(struct session *session, const struct arguments *args);
/* Reads a value of this quantity into *item by parse_value(). `what` is the name of the value in
 * messages. Returns false, with `error` set, if there is no value or if text follows it. */
bool read_value(struct parser *parser, const char *what, enum quantity quantity, struct item *item,
                struct error *error);

/* Returns false, with `error` set, if the file name `where` is "-" (standard input) and commands
 * are read from there, so that it cannot contain data; else true. */
bool check_input(const struct session *session, struct text where, struct error *error);

/* ---- replies that fit on one screen ---- */

/* Returns true if the statement has the option --full. */
bool asks_full(const struct arguments *arguments);
/* Returns the number of rows of a reply that fits below the line that was typed, at least 10: on
 * smaller screens it scrolls. */
int answer_rows(const struct session *session);
/* Returns the number of rows to which text is shortened: answer_rows(), but at least 22 if the
 * output is no terminal, whatever size its plots have. */
int short_answer_rows(const struct session *session);
/* Returns the number of rows of a text on a screen of this width [cell]. */
int text_rows(struct text text, int width);
/* Appends the lines of `lines` to `text`, those wider than `width` [cells] broken into several, and
 * empties `lines`. Empty lines are dropped. */
void put_folded_lines(struct buffer *lines, int width, struct buffer *text);

/* Replies, with a line and a record, that the table was written to `file`. */
void reply_exported(struct reply *reply, struct text file, const struct table *table);

/* ---- replies about runs ---- */

/* Returns true if a task with this predicted time [s] needs --force or a confirmation. */
bool takes_long(double seconds);
/* Returns true if a task with this predicted time [s] may start, because it is short, --force was
 * given (`force`), or the user at the prompt has confirmed it. Otherwise returns false with `error`
 * set. `steps` is the predicted number of steps, for the message. */
bool allow_long(struct session *session, double seconds, double steps, bool force,
                struct error *error);
/* Replies with the line and the record of a run's current state. */
void reply_run(const struct session *session, const struct run *run, struct reply *reply);
/* Warns of problems of a run and its steps; most warnings are given once per run. */
void reply_run_warnings(struct run *run, struct reply *reply);
/* Warns once per run if the result of a step has little to do with the solution (struct
 * unsound_step). */
void reply_unsound(struct run *run, struct reply *reply);
/* Adds a note about variables that are so small that none of their digits is reliable. */
void reply_below_tolerance(const struct run *run, struct reply *reply);
/* Computes the estimate of the error of a run, also called its opinion (run_second_opinion() in
 * <hooke/run.h>), with the effort that the setting `opinion` allows, if the reply will show it. */
void seek_opinion(const struct session *session, struct run *run, const struct reply *reply);
/* Appends a line about the cost of the error estimate to the text of `plan`. */
void plan_opinion(const struct session *session, const struct system *system,
                  const struct plan *plan, struct buffer *text);
/* Replies with a line about the estimated error, and a warning if it is large. Returns false, with
 * `error` set, if no digit of the result is correct. */
bool reply_opinion(const struct session *session, struct run *run, struct reply *reply,
                   struct error *error);
/* Warns if variables are so small that their squares, and so the energy, underflow to 0. */
void reply_tiny(const struct run *run, struct reply *reply);
/* Warns once per session that a typed scene is integrated by the default method because the user
 * has not chosen one. */
void reply_unchosen(struct session *session, struct reply *reply);
/* Replies once for each typed scene with the values of those settings that the user has not set:
 * the duration if `by_setting` (the statement uses the setting and gives none itself), and the
 * tolerance and first step if `adapts` (the method adapts its steps). */
void reply_assumed(struct session *session, bool adapts, bool by_setting, struct reply *reply);
/* Adds a note that a study uses the setting duration although the current run is longer. */
void reply_shorter(const struct session *session, struct reply *reply);
/* Warns if the method that is set cannot be applied to the scene, with advice. */
void reply_inapplicable(const struct session *session, struct reply *reply);
/* Warns if the steps of a run are too long to resolve the period of its scene. */
void reply_coarse(const struct session *session, const struct run *run, struct reply *reply);

/* Shows the progress of a study by the front end. `fraction` is the completed fraction, or 2 when
 * the study has ended; `context` is the session's struct front. */
void report_fraction(void *context, double fraction);

/* Returns true if the statement at `where` may change the setting. Returns false, with `error` set,
 * for a setting that starts another program if the statement was not typed at a prompt, or if the
 * option --safe is given. */
bool check_typed(const struct session *session, const struct setting *setting,
                 const struct source *where, struct error *error);
/* Handler of `set`, which other commands call. */
bool command_set(HANDLER_PARAMETERS);
/* Adds an event with this name and rule, such as "when EXPR do …", to the set-up. Returns false
 * with `error` set. */
bool event_add(struct session *session, struct arena *arena, struct text name, struct text rule,
               struct error *error);
/* Stores the current scene in setup.own if all of its equations were typed, so that `scene NAME`
 * finds it. Returns false, with `error` set, if too many scenes are stored. */
bool keep_own_scene(struct session *session, struct error *error);
/* Choices of arguments: actions of `cursor`, names of axes, names for `unset`, topics of guides. */
extern const struct catalog cursor_action_catalog, axis_catalog, unset_catalog, guide_catalog;

/* Replies with a row as `list` shows it: a line, and a record of its catalog's kind. */
void reply_listed(const struct catalog *catalog, const struct row *row, struct reply *reply);
