/* SPDX-License-Identifier: GPL-3.0-or-later */
/* report: results as tables (struct export): of runs, events, studies and methods, with the facts
 * about their origin as keys, for `export`, `> FILE` and documents. Functions return false with
 * `error` set; memory of tables is the arena's of their struct export. */
#pragma once

#include <hooke/run.h>
#include <hooke/language.h>
#include <hooke/plot.h>
#include <hooke/scene.h>

struct catalog;

/* ---- tables made from a session; all memory from the arena ---- */

/* A table in the making. */
struct export
{
    struct arena *arena;
    struct table table;
};

/* Makes the table of runs (by default the current one) with columns (by default t, y, v, energy);
 * `every` thins the rows by a count or a time. Each argument may be without items. */
bool export_runs(const struct session *session, const struct argument_value *runs,
                 const struct argument_value *column, const struct argument_value *every,
                 struct export *export, struct error *error);
/* Sets the keys of the table: scene, method and settings of a run by its index. */
bool export_run_keys(const struct session *session, int index, struct export *export,
                     struct error *error);
/* Sets the keys of the table: the current scene. */
bool export_scene_keys(const struct session *session, struct export *export, struct error *error);

/*
 * ---- coefficients of a method ----
 *
 * The functions return false for methods without coefficients: those that are algorithms, and
 * external ones.
 */

/* Appends lines of at most `max` cells, indented by two; also returns false if they would be
 * longer. */
bool coefficients_text(const struct method *method, int max, struct buffer *output);
/* Appends an array for LaTeX. */
bool coefficients_tex(const struct method *method, struct buffer *output);
/* Makes a table with a row for each stage and one for each kind of weights; also returns false if
 * out of memory. */
bool coefficients_table(const struct method *method, struct arena *arena, struct table *table);

/* ---- files of tables ---- */

/* A format of tables in files. */
struct table_kind {
    struct row row; /* Its name is the ending of the files, such as "csv". */
    /* Writes the table. */
    table_format *format;
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
    const char *kind; /* Kind of its records; NULL if it is the name of the row. */
    /* Makes the table from the current state of the session; NULL if the last table of this kind is
     * stored. */
    bool (*table)(const struct session *session, struct export *export, struct error *error);
    /* Replies with records of the current state; NULL if the records are those of the last command.
     */
    void (*say)(const struct session *session, struct reply *reply);
    /* `export FILE table` writes it if no run has been made since. */
    bool study;
    const char *type; /* Commands that make one, for messages. */
    bool sceneless;   /* It does not depend on the scene. */
};

extern const struct catalog result_catalog; /* Kinds of results, struct result_row. */

/* Makes, or finds, the table of a result. It lives as long as the session stores it, or as the
 * arena. */
bool export_result(struct session *session, const struct row *result, struct export *export,
                   struct error *error);
/* Returns true if the session has such a result. */
bool result_is_kept(const struct session *session, const struct row *result);
/* Makes the table of the last study, or of the runs if a run was made since. */
bool export_latest(struct session *session, struct export *export, struct error *error);
/* Makes a table with a row for each run. */
bool export_run_table(const struct session *session, struct export *export, struct error *error);
/* Stores the table of a result whose records have other fields. `method` and `reference` are keys
 * beside duration and scene, or NULL. The table is lost if out of memory. */
void reply_result(const struct session *session, struct reply *reply, const char *kind,
                  const struct result_columns *columns, const void *rows, size_t count,
                  const char *method, const char *reference);
/* Stores the tables of a statement's records as the last results of their kinds. Returns the row of
 * the command's result, or NULL if it has no table. */
const struct row *session_keep_results(struct session *session, struct table_store *said,
                                       const char *command);

/* Selection of the rows that are written, by the option every=. */
struct thinning {
    /* Number of rows, or time [s] if by_time, between two rows that are written. */
    double step;
    bool by_time;
    /* Number of the next one in units of `step`; private. */
    int64_t next;
};

/* Initialises the selection from every=, which may be without items. Returns false with `error`
 * set. */
bool thinning_begin(struct thinning *thinning, const struct argument_value *every,
                    struct error *error);
/* Returns true if row i, `elapsed` [s] after the first one, is written. Call it for one row after
 * the other. */
bool thinning_keeps(struct thinning *thinning, size_t i, double elapsed);

/* ---- keys: the facts about the origin of a table, its lines `# key = value` ---- */

/* Keys in the making: keys_begin(), keys_add…(), keys_finish(). */
struct keys {
    struct arena *arena;
    struct table_key *key;
    int count;
    bool failed;
};

/* Begins the keys of a table. */
bool keys_begin(struct keys *keys, struct export *export, struct error *error);
/* Adds a key with the content of a buffer, which is freed. */
void keys_add(struct keys *keys, const char *name, struct buffer *value);
/* Adds a key with a text. */
void keys_add_text(struct keys *keys, const char *name, const char *text);
/* Adds the scene and its parameters. */
void keys_add_scene(struct keys *keys, const struct scene *scene);
/* Adds scene, method and settings of runs by their indices. */
void keys_add_runs(struct keys *keys, const struct session *session, const int *index, int count);
/* Sets the keys of the table. Returns false, with `error` set, if out of memory. */
bool keys_finish(const struct keys *keys, struct export *export, struct error *error);

/* ---- events of a run ---- */

/* Warns once of events that may have been missed; in JSON writes a record of each event with its
 * number of times. */
void reply_event_doubts(struct run_slot *slot, struct reply *reply);
/* Replies with lines and records of all events of the current run. */
void reply_event_records(const struct session *session, struct reply *reply);
/* Makes the table of these events. */
bool export_event_records(const struct session *session, struct export *export,
                          struct error *error);

/* ---- the state of a run, as a record ---- */

/* The current state of a run with its errors, as `run` reports it. */
struct run_record {
    const struct run *run;
    /* Number of the run. */
    int number;
    /* Name of the method, and run_status(). */
    const char *method, *status;
    double dt, tol; /* Fixed step [s] or tolerance; NAN if the other one is used. */
    /* First position and velocity [SI]; NAN if the scene has no such variable, or if no digit is
     * reliable. */
    double y, v;
    double rest;    /* [s] time since which dry friction has held it at rest, or NAN */
    double seconds; /* [s] wall time of the run; NAN with 'timing off' */
    /* Distance from the current recording. */
    struct data_distance data;
    double t; /* Current time [s]. */
    int64_t steps;
    struct cost cost;
    double kinetic; /* [J] kinetic energy if no total energy is known */
    /* Estimated error (struct opinion); NAN if unknown. */
    double opinion_error, opinion_max, opinion_t, opinion_lost;
    struct ledger ledger;
    struct run_errors errors;
    /* [n] magnitudes below which variables have no reliable digit, see run_below_tolerance(). */
    double error_floor[LIMIT_VARIABLES];
};

/* Fills *record with the current state of a run. */
void run_record_init(struct run_record *record, const struct session *session,
                     const struct run *run);
/* Replies with the record. */
void reply_run_record(struct run_record *record, struct reply *reply);
/* Replies with the record of the current run, if there is one. */
void reply_current_run(const struct session *session, struct reply *reply);
