/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files of the command sweep share. */
#pragma once

#include "modules/sweep/compute/sweep.h"
#include <hooke/command/handler.h>

extern const struct module sweep_module;

/* A sweep that Ctrl-C has stopped. */
struct stopped_sweep {
    char *statement;    /* what stood behind `sweep` */
    struct buffer made; /* session_save_motion() then */
    struct sweep found; /* value NULL where the results are in a file */
};

/* What the module keeps in a session. */
struct sweep_part {
    struct stopped_sweep *stopped; /* NULL if none was, or something else was begun since then */
};

struct sweep_options {
    bool force, dry;
    struct text file; /* of --resume; len 0: none */
};

/* The request as it is before anything of it was typed. */
struct sweep_request sweep_request_begin(struct session *session);
/* rest: what stands behind `sweep`. Without axes only where there is a file. */
bool read_sweep(struct session *session, const struct arguments *args, struct text rest,
                struct sweep_request *request, struct sweep_options *options, struct error *error);
/* before: what was found until it was stopped; NULL if there is nothing. */
bool sweep_statement(struct session *session, const struct arguments *args, struct text statement,
                     const struct sweep *previous, struct reply *reply, struct error *error);
/* stopped.c: the functions of sweep_module. */
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
/* What it would cost, by computing some of it. */
bool sweep_cost(struct session *session, const struct sweep_request *request, struct reply *reply,
                struct error *error);
/* Rows of CSV of these points, below the names of the columns; returns false if out of memory. */
bool sweep_rows(const struct sweep_request *request, const struct sweep *sweep,
                struct buffer *rows);
