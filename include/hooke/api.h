/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * api: hooke inside another program. A session, lines in the language of the prompt, and their
 * results as arrays of doubles. The interface changes only by additions (symbol version HOOKE_0).
 *
 *     struct hooke *lab = hooke_open(0);
 *     if (hooke_run(lab, "scene pendulum; method rk4 dt=1ms; run 10 s") != 0)
 *         fprintf(stderr, "%s\n", hooke_error(lab)->message);
 *     struct hooke_table *run = hooke_table(lab, "t theta energy");
 *     const double *theta = hooke_column(run, "theta");        ... hooke_rows(run) of them
 *     hooke_table_free(run);
 *     hooke_close(lab);
 *
 * Sessions are independent: each may be used by a different thread, but only by one thread at a
 * time (any thread may call hooke_cancel()). Nothing is printed, no signal is touched, no locale is
 * set; files are read and written only where the lines ask for it. Texts are UTF-8, values in SI
 * units. Texts and errors that a session returns stay valid until its next hooke_run() or
 * hooke_table().
 *
 * Functions that take an object which another function may return as NULL accept NULL, too; they
 * then return an empty result.
 */
#pragma once

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define HOOKE_PUBLIC __attribute__((visibility("default")))
#else
#define HOOKE_PUBLIC
#endif

struct hooke;       /* A session. */
struct hooke_table; /* Columns of values or texts, owned by the caller. */

/* Flags of hooke_open(). */
enum hooke_open_flag {
    HOOKE_SAFE =
        1, /* Allows writing only below the current directory, as the option --safe does. */
};

/* An error; texts belong to the session. */
struct hooke_error {
    /* Exit status that the program would have: 1 a command failed, 2 wrong usage, 3 numerical
     * failure, 4 reading or writing failed, 130 stopped. */
    int status;
    /* Position in the text given to hooke_run() or in `file`, counted from 1, or 0 if unknown. */
    int line, column;
    /* File in which the error occurred, or NULL for the text given to hooke_run(). */
    const char *file;
    /* Name of the status ("usage"), the message as a sentence, and advice or "". */
    const char *code, *message, *hint;
};

/* Returns the version, such as "0.1.0". */
HOOKE_PUBLIC const char *hooke_version(void);

/* Creates a session with the defaults of the lab. The flags are those of enum hooke_open_flag.
 * Returns NULL if out of memory. */
HOOKE_PUBLIC struct hooke *hooke_open(unsigned flags);
/* Frees a session; NULL is allowed. */
HOOKE_PUBLIC void hooke_close(struct hooke *hooke);

/* Executes one or more lines like a file of commands; the first error ends them. Returns 0, or the
 * status of the error. */
HOOKE_PUBLIC int hooke_run(struct hooke *hooke, const char *lines);
/* Stops the current hooke_run() or hooke_table() as Ctrl-C does; may be called by any thread or a
 * signal handler. That call then returns status 130. Without effect if nothing is executed. */
HOOKE_PUBLIC void hooke_cancel(struct hooke *hooke);

/* Return the text that the prompt would have shown for the last hooke_run(): its results, and its
 * warnings, notes and errors. Never return NULL. */
HOOKE_PUBLIC const char *hooke_output(const struct hooke *hooke);
HOOKE_PUBLIC const char *hooke_messages(const struct hooke *hooke);
/* Returns the error of the last hooke_run() or hooke_table(), or NULL if it succeeded. */
HOOKE_PUBLIC const struct hooke_error *hooke_error(const struct hooke *hooke);

/* Sets *value to the value [SI] that has this name: a parameter, a derived quantity, a variable of
 * the current run, a result such as measured_period. Sets *uncertainty to the standard uncertainty
 * [SI], 0 if none is known. Either pointer may be NULL. Returns 1, or 0 with nothing set if the
 * name is unknown or has no value. */
HOOKE_PUBLIC int hooke_value(const struct hooke *hooke, const char *name, double *value,
                             double *uncertainty);

/* Returns the name of result number `place`, from 0, that the session has stored, such as "compare"
 * or "sweep", or NULL if there are no more. Its table is hooke_table(hooke, "table of NAME"). */
HOOKE_PUBLIC const char *hooke_result(const struct hooke *hooke, size_t place);

/* Returns what `export FILE WHAT` would write. WHAT is "" for the current run, "t y energy" for
 * columns of it, or "run 1 y", "data", "events", "measurements", "table of sweep". The table is
 * a copy that stays valid after the session is closed; free it with hooke_table_free(). Returns
 * NULL on failure, which hooke_error() explains. */
HOOKE_PUBLIC struct hooke_table *hooke_table(struct hooke *hooke, const char *what);
/* Frees a table; NULL is allowed. */
HOOKE_PUBLIC void hooke_table_free(struct hooke_table *table);
/* Return the number of rows, and of columns. */
HOOKE_PUBLIC size_t hooke_rows(const struct hooke_table *table);
HOOKE_PUBLIC size_t hooke_columns(const struct hooke_table *table);
/* Return name and unit of column number `place`, from 0, or NULL if there is none. A unit is "" if
 * the column has none. */
HOOKE_PUBLIC const char *hooke_column_name(const struct hooke_table *table, size_t place);
HOOKE_PUBLIC const char *hooke_column_unit(const struct hooke_table *table, size_t place);
/* Returns the values [hooke_rows] of the first column of this name, NAN for missing ones, or NULL
 * if there is no such column or if it has texts. The array belongs to the table. */
HOOKE_PUBLIC const double *hooke_column(const struct hooke_table *table, const char *name);
/* Returns the text in row `row`, from 0, of a column of texts, or NULL if there is none. */
HOOKE_PUBLIC const char *hooke_text(const struct hooke_table *table, const char *name, size_t row);

#ifdef __cplusplus
}
#endif
