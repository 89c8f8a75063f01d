/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations that the handlers of commands share. */
#pragma once

#include <hooke/run.h>
#include <hooke/command.h>
#include <hooke/module.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>

struct row;

/* ---- how a command is written ----
 *
 * A file holds, inside `#ifndef COMMAND_ROWS`, functions that begin with HANDLER(name), and
 * below it their rows, COMMAND(name, …). commands.c includes all of them again through commands.def
 * to collect the rows.
 */

#define HANDLER_PARAMETERS                                                                         \
    struct session *session, const struct arguments *args, struct reply *reply, struct error *error
#define HANDLER(name)                                                                              \
    bool command_##name(HANDLER_PARAMETERS);                                                       \
    bool command_##name(HANDLER_PARAMETERS)
#define UNUSED(thing) ((void)(thing))

#define ARGUMENTS(...)                                                                             \
    .argument = (const struct argument[]){__VA_ARGS__},                                            \
    .arguments = (int)COUNT_OF(((const struct argument[]){__VA_ARGS__}))

/* name, type, then what else differs from zero: PLACE("N", TYPE_INTEGER, .flags = ARG_REQUIRED) */
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

/*
 * Finds how a value that is read depends on the state of the run and on time (slope [n + 1]), by
 * reading it beside them. Returns false if it cannot be read there. (scene/slopes.c)
 */
bool find_slopes(const struct parser *value, struct run *run, const char *what,
                 enum quantity quantity, double *slope);
/* Returns true for a value that an event sets, and that depends on the state of the run. */
bool value_depends(struct session *session, const struct parser *value);
/* Marks the run's response to another state as unknown from the present state on. */
void forget_jump_slopes(struct session *session);
/* The argument VALUE of a statement NAME = VALUE, to be read with read_value() (scene/scene.c). */
struct parser value_parser(struct session *session, const struct arguments *args);
bool read_value(struct parser *parser, const char *what, enum quantity quantity, struct item *item,
                struct error *error);

/* '-' is for data where no commands come from there. */
bool check_input(const struct session *session, struct text where, struct error *error);

/* ---- answers in one screen (short_form.c) ---- */

/* Returns true if the statement asks for everything, by --full. */
bool asks_full(const struct arguments *arguments);
/* Text is not left out of less than this: on smaller screens it scrolls. */
enum { ANSWER_ROWS_MIN = 22 /* [row] */, ANSWER_WIDTH_MIN = 80 /* [cell] */ };
/* [row] The length of an answer that fits below the line that was typed. */
int answer_rows(const struct session *session);
/* [row] Rows that a text takes on a screen of this width [cell]. */
int text_rows(struct text text, int width);

/* The line and the record of a table that was written. */
void reply_exported(struct reply *reply, struct text file, const struct table *table);

/* ---- runs in text (run_text.c, run_warnings.c, opinion_text.c) ---- */

/* Returns true if what is predicted to take that long [s] needs --force or a yes. */
bool takes_long(double seconds);
/* A prediction above a minute is refused, or asked about at the prompt, unless --force was given.
 */
bool allow_long(struct session *session, double seconds, double steps, bool force,
                struct error *error);
/* The line and the record of a run as it is now. */
void reply_run(const struct session *session, const struct run *run, struct reply *reply);
/* Warns of what is wrong with a run or its steps, of most things once a run. */
void reply_run_warnings(struct run *run, struct reply *reply);
/* Warns once if a step was nonsense. */
void reply_unsound(struct run *run, struct reply *reply);
void reply_below_tolerance(const struct run *run, struct reply *reply);
/* As `set opinion` says, and as far as the reply shows errors. */
void seek_opinion(const struct session *session, struct run *run, const struct reply *reply);
/* Appends the cost of the opinion on the run that is planned. */
void plan_opinion(const struct session *session, const struct system *system,
                  const struct plan *plan, struct buffer *text);
/* Replies with the opinion's line, and a warning if the error is large. Returns false, with an
 * error, if nothing of the result is right. */
bool reply_opinion(const struct session *session, struct run *run, struct reply *reply,
                   struct error *error);
/* Warns of a state whose squares underflow. */
void reply_tiny(const struct run *run, struct reply *reply);
/* Says once which method a scene of the user's own gets where nobody has chosen one. */
void reply_unchosen(struct session *session, struct reply *reply);
/*
 * Says once of each scene of the user's own which duration, tolerance and first step are taken
 * where nobody has set them: those of the lab. adapts: a step control will use the last two;
 * by_setting: 'duration' will be used.
 */
void reply_assumed(struct session *session, bool adapts, bool by_setting, struct reply *reply);
/* Replies that a study uses the duration that is set, although the present run took longer. */
void reply_shorter(const struct session *session, struct reply *reply);
/* Warns where the scene rules out the method that is set, and says what to do. */
void reply_inapplicable(const struct session *session, struct reply *reply);
/* Warns of a step that is too coarse for the period. */
void reply_coarse(const struct session *session, const struct run *run, struct reply *reply);

/* Progress of a study, whose context is the session's front; fraction 2: it is over. going.c */
void report_fraction(void *context, double fraction);

/* A setting by which a program is run is set neither by files nor by -c, and not with --safe. */
bool check_typed(const struct session *session, const struct setting *setting,
                 const struct source *where, struct error *error);
bool command_set(HANDLER_PARAMETERS);
/* Watches for another event: its name, then "when EXPR do …" (scene/event.c). */
bool event_add(struct session *session, struct arena *arena, struct text name, struct text rule,
               struct error *error);
/* Keeps the present scene, if all of it was typed, so that `scene` finds it by its present name and
 * form. */
bool keep_own_scene(struct session *session, struct error *error);
extern const struct catalog cursor_action_catalog, axis_catalog, unset_catalog, guide_catalog;

/* A row as `list` shows it: a line, and a record of its catalog's kind. */
void reply_listed(const struct catalog *catalog, const struct row *row, struct reply *reply);
