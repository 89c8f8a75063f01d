/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Types and functions that the files of the command sweep share. */
#pragma once

#include "modules/sweep/compute/sweep.h"
#include <hooke/command/handler.h>

extern const struct module sweep_module;

/* A sweep that Ctrl-C has stopped. */
struct stopped_sweep {
    char *statement;    /* statement after `sweep` */
    struct buffer made; /* set-up at that time, by session_save_motion() */
    struct sweep found; /* value is NULL if the results are in a file. */
};

/* State of the module in a session. */
struct sweep_part {
    /* NULL if none was stopped, or if something else was begun since then. */
    struct stopped_sweep *stopped;
};

struct sweep_options {
    bool force, dry;
    struct text file; /* file of --resume; empty if there is none */
};

/* The request as it is before anything of it was typed. */
struct sweep_request sweep_request_begin(struct session *session);
/* Reads a statement. `rest` is the text after `sweep`, in which axes may only be missing if there
 * is a file. Returns false with `error` filled. */
bool read_sweep(struct session *session, const struct arguments *args, struct text rest,
                struct sweep_request *request, struct sweep_options *options, struct error *error);
/* Computes a sweep. `previous` holds the points that were finished before it was stopped, or is
 * NULL. Returns false with `error` filled. */
bool sweep_statement(struct session *session, const struct arguments *args, struct text statement,
                     const struct sweep *previous, struct reply *reply, struct error *error);
/* Functions of sweep_module (stopped.c). */
void sweep_part_free(void *part);
bool sweep_waits(const struct session *session);
bool sweep_continue(HANDLER_PARAMETERS);
void sweep_forget_stopped(struct session *session);
/* complete.c: NAME=FROM:TO with the unit behind a number, and what is measured. */
bool sweep_complete(struct completion *c, const struct command *command, struct text prefix);

/* Keeps what `continue` needs. Takes the results out of `sweep`, where it has some. */
void sweep_keep_stopped(struct session *session, struct text statement, struct sweep *sweep);
/* Its points go into the file, those that it has are not computed again. */
bool sweep_into_file(struct session *session, const struct arguments *args,
                     struct sweep_request *request, const struct sweep_options *options,
                     struct reply *reply, struct error *error);
/* Estimates the cost by computing some of the points. Returns false with `error` filled. */
bool sweep_cost(struct session *session, const struct sweep_request *request, struct reply *reply,
                struct error *error);
/* Rows of CSV of these points, below the names of the columns; returns false if out of memory. */
bool sweep_rows(const struct sweep_request *request, const struct sweep *sweep,
                struct buffer *rows);
