/* SPDX-License-Identifier: GPL-3.0-or-later */
/* report: tables that are written into files, studies as tables, what the lab hands in. */
#pragma once

#include <hooke/run.h>
#include <hooke/language.h>
#include <hooke/plot.h>
#include <hooke/scene.h>

struct catalog;

/* ---- tables made from a session; all memory from the arena ---- */

struct export
{
    struct arena *arena;
    struct table table;
};

/* runs: none means the current one; column: none means t, y, v, energy; every: a count of rows, or
 * a time. */
bool export_runs(const struct session *session, const struct argument_value *runs,
                 const struct argument_value *column, const struct argument_value *every,
                 struct export *export, struct error *error);
/* Fills the keys of the table: what made this run. */
bool export_run_keys(const struct session *session, int index, struct export *export,
                     struct error *error);
/* The same: the present scene. */
bool export_scene_keys(const struct session *session, struct export *export, struct error *error);

/* ---- coefficients of a method (coefficients.c) ----
 *
 * All return false for methods that have none: those that are algorithms, and external ones.
 */

/* Appends lines of at most max cells, set in by two; also returns false if they would be longer. */
bool coefficients_text(const struct method *method, int max, struct buffer *output);
/* Appends a displayed array. */
bool coefficients_tex(const struct method *method, struct buffer *output);
/* Fills in a row for each stage, and one for each kind of weights; also returns false if out of
 * memory. */
bool coefficients_table(const struct method *method, struct arena *arena, struct table *table);

/* ---- files of tables ---- */

struct table_kind {
    struct row row; /* its name is what files end in */
    table_format *format;
};
extern const struct catalog table_format_catalog; /* rows are struct table_kind */

static inline table_format *format_of_kind(const struct row *kind)
{
    return ((const struct table_kind *)(const void *)kind)->format;
}

/* ---- results that are tables (results.c) ---- */

struct result_row {
    struct row row;
    const char *kind; /* kind of its records; NULL if it is the name of the row */
    /* Makes the table of the present state; NULL for the last table that was found. */
    bool (*table)(const struct session *session, struct export *export, struct error *error);
    /* Replies with records of the present state; NULL for the last ones of a command. */
    void (*say)(const struct session *session, struct reply *reply);
    /* `export FILE table` alone writes it, until there is another run */
    bool study;
    const char *type; /* commands that make one */
    bool sceneless;   /* no scene had a part in it */
};

extern const struct catalog result_catalog; /* rows are struct result_row */

/* The table of a row of that catalog. It lives as long as the session keeps it, or the arena. */
bool export_result(struct session *session, const struct row *result, struct export *export,
                   struct error *error);
/* Returns true if the session has such a result. */
bool result_is_kept(const struct session *session, const struct row *result);
/* Exports the result of the last study, or the runs if there were runs since. */
bool export_latest(struct session *session, struct export *export, struct error *error);
/* A row for each run. */
bool export_run_table(const struct session *session, struct export *export, struct error *error);
/* The table of a result whose records say more, or less. method, reference: what is said of it
 * beside duration and scene; NULL if there is nothing. Without memory it is lost. */
void reply_result(const struct session *session, struct reply *reply, const char *kind,
                  const struct result_columns *columns, const void *rows, size_t count,
                  const char *method, const char *reference);
/* Makes everything that a statement has reported the last result of its kind. Returns the row of
 * the command's result, or NULL if it has no table. */
const struct row *session_keep_results(struct session *session, struct table_store *said,
                                       const char *command);

/* Selection of the rows that are written, by a number of rows or by a time [s]. */
struct thinning {
    double step;
    bool by_time;
    int64_t next;
};

bool thinning_begin(struct thinning *thinning, const struct argument_value *every,
                    struct error *error);
/* Row i, `elapsed` after the first; to be asked of one after another. */
bool thinning_keeps(struct thinning *thinning, size_t i, double elapsed);

/* ---- what the numbers of a table were made with: its `# key = value` lines ---- */

struct keys {
    struct arena *arena;
    struct table_key *key;
    int count;
    bool failed;
};

bool keys_begin(struct keys *keys, struct export *export, struct error *error);
void keys_add(struct keys *keys, const char *name, struct buffer *value); /* frees the value */
void keys_add_text(struct keys *keys, const char *name, const char *text);
void keys_add_scene(struct keys *keys, const struct scene *scene);
void keys_add_runs(struct keys *keys, const struct session *session, const int *index, int count);
/* The table has them. */
bool keys_finish(const struct keys *keys, struct export *export, struct error *error);

/* ---- what events have noticed (event_report.c) ---- */

/* Warns once of events that may have been missed; with `format json` writes a record of each event
 * with the number that were noticed. */
void reply_event_doubts(struct run_slot *slot, struct reply *reply);
/* Lines and records of all that happened in the current run. */
void reply_event_records(const struct session *session, struct reply *reply);
bool export_event_records(const struct session *session, struct export *export,
                          struct error *error);

/* ---- a run as it is now (run_record.c) ---- */

struct run_record {
    const struct run *run;
    int number;
    const char *method, *status;
    double dt, tol; /* NAN if the other one is used */
    /* NAN if the scene has no such variable, or if none of its digits is certain */
    double y, v;
    double rest;    /* [s] held by dry friction from then on; NAN */
    double seconds; /* [s] that it took; NAN with 'timing off' */
    struct data_distance data;
    double t; /* [s] */
    int64_t steps;
    struct cost cost;
    /* Only for records: */
    double kinetic; /* [J] where there is no potential for all of it */
    /* Results of the second solution; NAN if nothing is known. */
    double opinion_error, opinion_max, opinion_t, opinion_lost;
    struct ledger ledger;
    struct run_errors errors;
    double error_floor[LIMIT_VARIABLES];
};

void run_record_init(struct run_record *record, const struct session *session,
                     const struct run *run);
void reply_run_record(struct run_record *record, struct reply *reply);
/* Replies with the current run, if there is one. */
void reply_current_run(const struct session *session, struct reply *reply);
