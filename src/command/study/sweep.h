/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files of the command sweep share. */
#ifndef HOOKE_COMMAND_STUDY_SWEEP_H
#define HOOKE_COMMAND_STUDY_SWEEP_H

#include <hooke/study/sweep.h>
#include <hooke/command/handler.h>

struct sweep_options {
    bool force, dry;
    struct text file; /* of --resume; len 0: none */
};

/* The request as it is before anything of it was typed. */
struct sweep_request sweep_request_begin(struct session *session);
/* rest: what stands behind `sweep`. Without axes only where there is a file. */
bool read_sweep(struct session *session, const struct arguments *args, struct text rest,
                struct sweep_request *request, struct sweep_options *options, struct error *error);
/* before: what was found until it was stopped; NULL: nothing. */
bool sweep_statement(struct session *session, const struct arguments *args, struct text statement,
                     const struct sweep *before, struct reply *reply, struct error *error);
/* What `continue` needs. Takes the results out of `sweep`, where it has some. */
void sweep_keep_stopped(struct session *session, struct text statement, struct sweep *sweep);
/* Its points go into the file, those that it has are not computed again. */
bool sweep_into_file(struct session *session, const struct arguments *args,
                     struct sweep_request *request, const struct sweep_options *options,
                     struct reply *reply, struct error *error);
/* What it would cost, by computing some of it. */
bool sweep_cost(struct session *session, const struct sweep_request *request, struct reply *reply,
                struct error *error);
/* Rows of CSV of these points, below the names of the columns; false: no memory. */
bool sweep_rows(const struct sweep_request *request, const struct sweep *sweep,
                struct buffer *rows);

#endif
