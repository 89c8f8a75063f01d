/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * command: the language that changes a session.
 *
 * A session changes only by executing command lines: scripts, keys, options, saved sessions and
 * tests all go through command_exec(). Handlers never print: they speak through a struct reply,
 * which the front end connects to streams, a log pane or a buffer.
 */
#pragma once

#include <hooke/language.h>

struct catalog;

/* ---- executing ---- */

/*
 * Executes one line, which may hold several statements. Each statement is atomic: everything is
 * checked before the session changes. The first error ends the line: it is written to the reply,
 * session->execution.status is set, and the result is false. May be called again from inside
 * front.slice; what would disturb the run that goes on is then refused. A run that was paused ends
 * the line too, with a note if something stands after it.
 */
bool command_exec(struct session *session, struct text line, const struct source *where,
                  struct reply *reply);

/* A script that arrives line by line: joins lines that end in a backslash, counts, stops at the
 * first error unless keep_going. */
struct script {
    struct source where;
    struct buffer pending;
    /* pieces of the joined line; if there are more, they count as the last */
    struct source_piece piece[64];
    int pieces;
    int commands; /* session->history.done at the start */
    bool ok, stopped;
};

void script_begin(struct script *script, struct session *session, const char *name,
                  const struct source *parent);
/* Executes one line, given without its newline. Returns false if the script has stopped (error,
 * quit); then further lines are ignored. */
bool script_feed(struct script *script, struct session *session, struct text line,
                 struct reply *reply);
/* End of the input: executes what is pending, says where it stopped. True if every command
 * succeeded. */
bool script_end(struct script *script, struct session *session, struct reply *reply);
/* A whole file, "-" is not special here. ERROR_USAGE if it cannot be read or holds a NUL byte. */
bool script_file(struct session *session, const char *path, const struct source *parent,
                 struct reply *reply);

/*
 * Returns the path of a file that the line at `where` names: unchanged or, if there is no such
 * file, relative to the folder of the command file that the line is in, if it exists there. Lives
 * in the arena. Returns NULL if out of memory.
 */
char *script_path(const struct source *where, struct text name, struct arena *arena);

/* ---- completion ---- */

/*
 * Candidates for the word that ends at `cursor`, by the type of the argument that stands there.
 * *start: where that word begins [byte]. `offer` gets each candidate with a line of explanation (""
 * if none). Where a file name is wanted, which the front end completes, it returns how such a
 * file's name ends, "" where it may have any; else NULL.
 */
const char *command_complete(struct session *session, struct text line, size_t cursor,
                             size_t *start,
                             void (*offer)(void *context, const char *candidate, const char *brief),
                             void *context);

/*
 * Appends the line that explains what stands at the cursor: "help compare dt=" inside of dt=5ms,
 * "help measure period", "help k" in an expression, "help run" at a number, "help" without a word.
 */
void help_line(struct text line, size_t cursor, struct buffer *text);

/* ---- the catalog of commands: the man page and the README are made from it ---- */

extern const struct catalog command_catalog;
/* The command that has this flag, which one has. */
const struct command *command_with(enum command_flag flag);
