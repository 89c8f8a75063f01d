/* SPDX-License-Identifier: GPL-3.0-or-later */
/* STATEMENT > FILE: the table of what the statement finds goes into a file, or its plot as a
 * picture, and nothing else is said. */
#pragma once

#include <hooke/base/file.h>
#include <hooke/command/handler.h>

struct row;

struct redirect {
    struct text file;     /* as typed, without quotes; empty if there is none */
    bool force;           /* --force stands behind it */
    table_format *format; /* chosen by its ending; NULL for a picture */
    const char *plot;     /* name of the plot that becomes the picture; NULL for a table */
    struct writer writer;
};

/* Takes "> FILE [--force]" off the end of a statement, whose command has COMMAND_TABLES, and a plot
 * of its name if the ending is that of pictures. Another ending is left to the command, which may
 * compare. */
void redirect_take(const struct command *command, struct text *statement,
                   struct redirect *redirect);
/* Opens the file before anything is computed: one that exists is refused. */
bool redirect_open(const struct session *session, struct redirect *redirect, struct arena *arena,
                   struct error *error);
/* Writes the result `table_row` that the statement has found, NULL if there is none, as a table. */
bool redirect_finish(struct session *session, struct redirect *redirect,
                     const struct row *table_row, struct reply *reply, struct error *error);
/* Appends the statement that draws the picture. */
void redirect_put_plot(const struct redirect *redirect, struct buffer *statement);
/* Lists the possible endings if a statement that cannot be read ends in the name of a file with
 * another ending. */
void redirect_explain(const struct command *command, struct text statement, struct error *error);

/* Sets an error with the possible endings of a table's file. Always returns false. */
bool refuse_ending(struct text file, struct error *error);
