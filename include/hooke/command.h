/* SPDX-License-Identifier: GPL-3.0-or-later */
/* command: the execution of command lines, the only way in which users change a session. Scripts,
 * keys, options, saved sessions and tests all call command_exec(). Handlers of commands never
 * print: they write to a struct reply, which the front end connects to streams, the log pane or a
 * buffer. */
#pragma once

#include <hooke/language.h>

struct catalog;

/* ---- executing ---- */

/* Executes one line, which may contain several statements. Each statement is atomic: everything is
 * checked before the session changes. The first error ends the line: it is written to the reply,
 * session->execution.status is set, and the result is false. `where` is the line's origin, or NULL
 * if it has none. front.slice() may call the function again while a statement advances a run;
 * commands that would disturb that run are then refused. If a run is paused the remaining
 * statements of the line are skipped, with a note. */
bool command_exec(struct session *session, struct text line, const struct source *where,
                  struct reply *reply);

/* A script that arrives line by line: joins lines that end in a backslash, counts lines, and stops
 * at the first error unless session->options.keep_going. Use script_begin(), script_feed() for each
 * line, script_end(). */
struct script {
    /* Position of the current line. */
    struct source where;
    /* Text of lines that ended in a backslash, to which the next line is joined. */
    struct buffer pending;
    /* [pieces] positions of the lines in `pending`. If there are more than 64 lines, the last piece
     * also covers the further ones. */
    struct source_piece piece[64];
    int pieces;   /* Number of elements of `piece`. */
    size_t first; /* Value of session->history.count at the start. */
    int commands; /* Value of session->history.done at the start, to count the script's commands. */
    bool ok,      /* All commands have succeeded so far. */
        stopped;  /* An error or a paused run has ended the script. */
};

/* Begins a script with this name for messages; `parent` is the line that executes it, or NULL. */
void script_begin(struct script *script, struct session *session, const char *name,
                  const struct source *parent);
/* Executes one line, given without its newline. Returns false if the script has stopped because of
 * an error or `quit`; further lines are then ignored. */
bool script_feed(struct script *script, struct session *session, struct text line,
                 struct reply *reply);
/* Ends a script: executes a pending line and reports where it stopped. Returns true if every
 * command succeeded. */
bool script_end(struct script *script, struct session *session, struct reply *reply);
/* Executes a file of commands; "-" has no special meaning. Returns false, with ERROR_USAGE
 * reported, if it cannot be read or contains a NUL byte, or if a command failed. */
bool script_file(struct session *session, const char *path, const struct source *parent,
                 struct reply *reply);

/* Returns the path of the file `name` in the line at `where`. If no file has this path, but one has
 * the path relative to the folder of the script that contains the line, returns the latter; else
 * `name` unchanged. The path is the arena's. Returns NULL if out of memory. */
char *script_path(const struct source *where, struct text name, struct arena *arena);

/* ---- completion ---- */

/* Completes the word of the line that ends at byte `cursor`: calls offer(context, candidate, brief)
 * for each candidate, where `brief` is a line of explanation or "", and sets *start to the offset
 * [byte] of the word. If a file name is possible, which the front end completes, returns the ending
 * of such files ("" for any file); else returns NULL. */
const char *command_complete(struct session *session, struct text line, size_t cursor,
                             size_t *start,
                             void (*offer)(void *context, const char *candidate, const char *brief),
                             void *context);

/* Appends the command that explains the word of the line at byte `cursor`, such as "help compare
 * dt=" inside dt=5ms, "help k" in an expression, "help run" at a number of that command, or "help"
 * if there is no word. */
void help_line(struct text line, size_t cursor, struct buffer *text);

/* ---- the catalog of commands, from which the manual and completion are made ---- */

/* All commands, struct command. */
extern const struct catalog command_catalog;
/* Returns the only command that has this flag; it must be a flag that exactly one command has. */
const struct command *command_with(enum command_flag flag);
