/* SPDX-License-Identifier: GPL-3.0-or-later */
/* STATEMENT > FILE: the table that the statement makes, or its plot as a picture, goes to a file,
 * and nothing else is printed. redirect_take() reads the file name; redirect_open() opens it before
 * the statement is executed; redirect_finish() writes a table, or redirect_put_plot() gives the
 * statement that draws. */
#pragma once

#include <hooke/base/file.h>
#include <hooke/command/handler.h>

struct row;

/* The file behind a statement. */
struct redirect {
    struct text file;     /* as typed, without quotes; empty if there is none */
    bool force;           /* --force stands behind it */
    table_format *format; /* chosen by its ending; NULL for a picture */
    const char *plot;     /* name of the plot that becomes the picture; NULL for a table */
    struct writer writer;
};

/* Shortens *statement by "> FILE [--force]" at its end, and fills *redirect with the file and what
 * it receives. It does so only for a command with COMMAND_TABLES and a file whose ending is that of
 * a table or of a picture; otherwise > may be a comparison, *statement is unchanged and
 * redirect->file is empty. */
void redirect_take(const struct command *command, struct text *statement,
                   struct redirect *redirect);
/* Opens the file before anything is computed. Returns false with the error set, also if it exists
 * and --force was not given. */
bool redirect_open(const struct session *session, struct redirect *redirect, struct arena *arena,
                   struct error *error);
/* Writes the result table_row of the statement as a table and closes the file. Returns false with
 * the error set, also if table_row is NULL. */
bool redirect_finish(struct session *session, struct redirect *redirect,
                     const struct row *table_row, struct reply *reply, struct error *error);
/* Appends the statement that draws the picture into the file. */
void redirect_put_plot(const struct redirect *redirect, struct buffer *statement);
/* Lists the possible endings if a statement that cannot be read ends in the name of a file with
 * another ending. */
void redirect_explain(const struct command *command, struct text statement, struct error *error);

/* Sets an error with the possible endings of a table's file. Always returns false. */
bool refuse_ending(struct text file, struct error *error);
