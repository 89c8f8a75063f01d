/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types and functions that the files of the command `sweep` share: reading of the statement
 * (command.c), results in memory or in a file (resume.c), `--dry-run` (cost.c), and `continue`
 * (stopped.c). */
#pragma once

#include "modules/sweep/compute/sweep.h"
#include <hooke/command/handler.h>

extern const struct module sweep_module; /* row of the module (sweep.c) */

/* A sweep that Ctrl-C has stopped and that `continue` can complete. */
struct stopped_sweep {
    char *statement; /* text of the statement after the word `sweep`, owned */
    /* set-up when it was stopped, as session_save_motion() writes it, to see that it is
     * unchanged */
    struct buffer made;
    struct sweep found; /* results so far; value is NULL if they are in a file */
};

/* State of the module in a session. */
struct sweep_part {
    /* owned; NULL if none was stopped, or if something else was begun since then */
    struct stopped_sweep *stopped;
};

/* Options of the statement that are not part of the request. */
struct sweep_options {
    bool force, dry;  /* --force and --dry-run */
    struct text file; /* file of --resume; empty if there is none */
};

/* Returns the request before its statement is read: scene, method and settings of the session,
 * amplitude as measure, no axes. */
struct sweep_request sweep_request_begin(struct session *session);
/* Reads a statement into request and options. `rest` is the text after `sweep`, which may lack axes
 * only if a file is named. Returns false with an error, which points into the text. */
bool read_sweep(struct session *session, const struct arguments *args, struct text rest,
                struct sweep_request *request, struct sweep_options *options, struct error *error);
/* Reads, computes and answers a sweep. `previous` holds the points that were finished before it was
 * stopped, or is NULL. Returns false with an error; if stopped, finished points are kept for
 * `continue`. */
bool sweep_statement(struct session *session, const struct arguments *args, struct text statement,
                     const struct sweep *previous, struct reply *reply, struct error *error);
/* Functions of sweep_module (stopped.c). sweep_part_free() frees the part of a session;
 * sweep_waits() returns true if there is a stopped sweep, which sweep_continue() completes and
 * sweep_forget_stopped() frees. */
void sweep_part_free(void *part);
bool sweep_waits(const struct session *session);
bool sweep_continue(HANDLER_PARAMETERS);
void sweep_forget_stopped(struct session *session);
/* Offers completions of `sweep` (complete.c): events after `at`, measures after `measure=`. Returns
 * false for everything else. */
bool sweep_complete(struct completion *c, const struct command *command, struct text prefix);

/* Keeps a stopped sweep for `continue`, and moves its results out of `sweep`. Without memory it
 * cannot be continued. */
void sweep_keep_stopped(struct session *session, struct text statement, struct sweep *sweep);
/* Computes those points of the sweep that the file does not have yet and completes the file.
 * Returns false with an error; what was computed is then in the file. */
bool sweep_into_file(struct session *session, const struct arguments *args,
                     struct sweep_request *request, const struct sweep_options *options,
                     struct reply *reply, struct error *error);
/* Answers `sweep ... --dry-run`: estimates time and size by computing some of the points. Returns
 * false with an error if that fails or if cancelled. */
bool sweep_cost(struct session *session, const struct sweep_request *request, struct reply *reply,
                struct error *error);
/* Appends the points as CSV, below a line of column names. Returns false if out of memory. */
bool sweep_rows(const struct sweep_request *request, const struct sweep *sweep,
                struct buffer *rows);
