/* SPDX-License-Identifier: GPL-3.0-or-later */
/* report: runs, events, results of studies and coefficients of methods as tables (struct export),
 * for `export`, `> FILE` and documents. A study is a command that computes a table from the scene,
 * such as compare or sweep. The keys of a table are the facts about its origin. Functions that
 * return bool set `error` when they return false; the memory of a table belongs to the arena of its
 * struct export. */
#pragma once

#include <hooke/run.h>
#include <hooke/language.h>
#include <hooke/plot.h>
#include <hooke/scene.h>

struct catalog;

/* ---- tables made from a session; all memory from the arena ---- */

/* A table that is being made. */
struct export
{
    struct arena *arena; /* Owner of the table's memory. */
    struct table table;
};

/* Makes the table of the runs that `runs` lists (the current one if it has no items), with the
 * columns that `column` lists (t, y, v and energy if none). `every` is the number of rows or the
 * time between two rows that are written (every row if it has no items). */
bool export_runs(const struct session *session, const struct argument_value *runs,
                 const struct argument_value *column, const struct argument_value *every,
                 struct export *export, struct error *error);
/* Sets the keys of the table to the scene, method and settings of the run at this index. */
bool export_run_keys(const struct session *session, int index, struct export *export,
                     struct error *error);
/* Sets the keys of the table to the current scene and its parameters. */
bool export_scene_keys(const struct session *session, struct export *export, struct error *error);

/*
 * ---- coefficients of a method ----
 *
 * The functions return false for methods without coefficients: those that are algorithms, and
 * external ones.
 */

/* Appends the coefficients as lines of text, indented by two blanks. Also returns false if a line
 * would be wider than `max` [cell]. */
bool coefficients_text(const struct method *method, int max, struct buffer *output);
/* Appends the coefficients as an array for LaTeX. */
bool coefficients_tex(const struct method *method, struct buffer *output);
/* Makes a table with a row for each stage and one for each kind of weights; also returns false if
 * out of memory. */
bool coefficients_table(const struct method *method, struct arena *arena, struct table *table);

/* ---- files of tables ---- */

/* A format of tables in files. */
struct table_kind {
    struct row row;       /* The name is the ending of the files, such as "csv". */
    table_format *format; /* Function that writes a table in this format. */
};
extern const struct catalog table_format_catalog; /* Formats, struct table_kind. */

/* Returns the function of a format's row. */
static inline table_format *format_of_kind(const struct row *kind)
{
    return ((const struct table_kind *)(const void *)kind)->format;
}

/* ---- results that are tables (results.c) ---- */

/* A kind of result that is a table: a row of result_catalog. */
struct result_row {
    struct row row;
    const char *kind; /* Kind of the records of the result; NULL stands for the name of the row. */
    /* Makes the table from the current state of the session. NULL if the table is instead the last
     * one of this kind that a command has stored in the session. */
    bool (*table)(const struct session *session, struct export *export, struct error *error);
    /* Replies with the records from which the stored table is computed again each time it is used,
     * so that it always describes the current state; NULL if the table remains that of the last
     * command. */
    void (*say)(const struct session *session, struct reply *reply);
    /* The result is that of a study, a command that computes a table, such as compare. `export FILE
     * table` writes the result of the last study unless a run has been made since. */
    bool study;
    const char *type; /* Command that users are told to type if there is no result yet. */
    bool sceneless; /* The result does not depend on the scene, so that its keys omit the scene. */
};

extern const struct catalog result_catalog; /* Kinds of results, struct result_row. */

/* Makes or finds the table of a result (a row of result_catalog). A table that was found is valid
 * as long as the session stores it; one that was made belongs to the arena. */
bool export_result(struct session *session, const struct row *result, struct export *export,
                   struct error *error);
/* Returns true if the session has stored a table for this row of result_catalog. */
bool result_is_kept(const struct session *session, const struct row *result);
/* Makes the table of the last study, or of the runs if a run was made since. */
bool export_latest(struct session *session, struct export *export, struct error *error);
/* Makes a table with a row for each run. */
bool export_run_table(const struct session *session, struct export *export, struct error *error);
/* Stores `count` rows with these columns in the reply, as the statement's table of kind `kind`; for
 * results whose records have other fields than the table. `method` and `reference` become keys of
 * the table beside duration and scene; each may be NULL. If out of memory, the table is not stored.
 */
void reply_result(const struct session *session, struct reply *reply, const char *kind,
                  const struct result_columns *columns, const void *rows, size_t count,
                  const char *method, const char *reference);
/* Moves the tables that a statement has made of the records of its reply from *said to the session,
 * as the last results of their kinds. `command` is the name of the statement's command. Returns the
 * row of the command's result, or NULL if the statement made no table of it. */
const struct row *session_keep_results(struct session *session, struct table_store *said,
                                       const char *command);

/* Selection of the rows that are written, by the option every=. */
struct thinning {
    /* Distance of two rows that are written: a number of rows, or a time [s] if by_time. */
    double step;
    bool by_time; /* `step` is a time. */
    /* The next row that is written lies at or after `next` times `step`; private. */
    int64_t next;
};

/* Initialises the selection from the argument every=; without items all rows are written. Returns
 * false with `error` set. */
bool thinning_begin(struct thinning *thinning, const struct argument_value *every,
                    struct error *error);
/* Returns true if row i, `elapsed` [s] after the first row, is written. Call it for all rows in
 * order. */
bool thinning_keeps(struct thinning *thinning, size_t i, double elapsed);

/* ---- keys: the facts about the origin of a table, its lines `# key = value` ---- */

/* Keys that are being made: call keys_begin(), the functions keys_add…(), then keys_finish(). */
struct keys {
    struct arena *arena;   /* Owner of the keys. */
    struct table_key *key; /* [count] keys so far, in the arena. */
    int count;
    bool failed; /* Memory ran out; keys_finish() returns false. */
};

/* Begins the keys of a table. Returns false, with `error` set, if out of memory. */
bool keys_begin(struct keys *keys, struct export *export, struct error *error);
/* Adds a key with the content of a buffer, which is freed. */
void keys_add(struct keys *keys, const char *name, struct buffer *value);
/* Adds a key with a text. */
void keys_add_text(struct keys *keys, const char *name, const char *text);
/* Adds the scene and its parameters. */
void keys_add_scene(struct keys *keys, const struct scene *scene);
/* Adds scene, method and settings of the runs at index [count] in the session. */
void keys_add_runs(struct keys *keys, const struct session *session, const int *index, int count);
/* Sets the keys of the table. Returns false, with `error` set, if out of memory. */
bool keys_finish(const struct keys *keys, struct export *export, struct error *error);

/* ---- events of a run ---- */

/* Warns once per run of events that may have been missed. If records are wanted, also writes one
 * for each event with the number of times that it happened. */
void reply_event_doubts(struct run_slot *slot, struct reply *reply);
/* Replies with lines and records of all events of the current run. */
void reply_event_records(const struct session *session, struct reply *reply);
/* Makes the table of all events of the current run. */
bool export_event_records(const struct session *session, struct export *export,
                          struct error *error);

/* ---- the state of a run, as a record ---- */

/* The current state of a run with its errors, as the command `run` reports it. */
struct run_record {
    const struct run *run; /* The run. */
    /* Number of the run. */
    int number;
    /* Name of the method, and status as run_status() returns it. */
    const char *method, *status;
    double dt, tol; /* Fixed step [s], or NAN if steps are adaptive; tolerance, or NAN if fixed. */
    /* First position and velocity [SI]; NAN if the scene has no such variable, or if no digit is
     * reliable. */
    double y, v;
    double rest;    /* Time [s] since which dry friction has held the body at rest, or NAN. */
    double seconds; /* Wall time [s] of the run; NAN with 'set timing off'. */
    /* Distance of the run from the current recording. */
    struct data_distance data;
    double t; /* Current time [s]. */
    int64_t steps;
    struct cost cost; /* Work of the steps. */
    double kinetic;   /* Kinetic energy [J] if no total energy is known; else NAN. */
    /* Members `error`, `max`, `t` and `lost` of run->opinion, the estimate of the error of an
     * adaptive run (struct opinion in <hooke/run.h>); NAN if unknown. */
    double opinion_error, opinion_max, opinion_t, opinion_lost;
    struct ledger ledger;     /* Energy balance. */
    struct run_errors errors; /* Errors against the exact solution, if it is known. */
    /* [n] magnitudes [SI] below which variables have no reliable digit (run_below_tolerance()). */
    double error_floor[LIMIT_VARIABLES];
};

/* Fills *record with the current state of a run. */
void run_record_init(struct run_record *record, const struct session *session,
                     const struct run *run);
/* Replies with this record. */
void reply_run_record(struct run_record *record, struct reply *reply);
/* Replies with the record of the current run, if there is one. */
void reply_current_run(const struct session *session, struct reply *reply);
