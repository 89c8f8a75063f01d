/* SPDX-License-Identifier: GPL-3.0-or-later */
/* report: tables that are written into files, studies as tables, what the lab hands in. */
#ifndef HOOKE_REPORT_H
#define HOOKE_REPORT_H

#include <hooke/plot.h>

/* ---- tables made from a session; all memory from the arena ---- */

struct export
{
    struct arena *arena;
    struct table table;
};

/* runs: none means the current one; column: none means t, y, v, energy; every: a count of rows, or
 * a time. */
bool export_runs(const struct session *session, const struct given_argument *runs,
                 const struct given_argument *column, const struct given_argument *every,
                 struct export *export, struct error *error);
/* Adds NAME_low and NAME_high to the table of one run: the band of the adopted fit about each
 * variable of the state in it. where: the option as typed. */
bool export_band(const struct session *session, const struct given_argument *runs,
                 struct text where, struct export *export, struct error *error);
bool export_recording(const struct session *session, struct export *export, struct error *error);
/* column: t, y, v, energy; none means t and y. */
bool export_recorded(const struct session *session, const struct given_argument *column,
                     const struct given_argument *every, struct export *export,
                     struct error *error);
bool export_measurements(const struct session *session, struct export *export, struct error *error);
/* The result of a study is what export_study() writes, until there is another run; without memory
 * what was there stays. method, reference: what is said of it beside duration and scene, NULL:
 * nothing. */
void keep_study(struct session *session, const struct result_columns *columns, const void *rows,
                size_t count, const char *method, const char *reference);
/* What the last study found; the runs where there were runs since. */
bool export_study(const struct session *session, struct export *export, struct error *error);
/* Fills the keys of the table: what made this run. */
bool export_run_keys(const struct session *session, int index, struct export *export,
                     struct error *error);
/* A row for each run. */
bool export_run_table(const struct session *session, struct export *export, struct error *error);

/* Which rows of many are written, by `every`: a count of rows, or a time [s]. */
struct thinning {
    double step;
    bool by_time;
    int64_t next;
};

bool thinning_begin(struct thinning *thinning, const struct given_argument *every,
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

/* Where events may have been missed: a warning, once; with `format json` a record of each event,
 * how many were noticed. */
void reply_event_doubts(struct run_slot *slot, struct reply *reply);
/* Lines and records of all that happened in the current run. */
void reply_event_records(const struct session *session, struct reply *reply);
bool export_event_records(const struct session *session, struct export *export,
                          struct error *error);

/* ---- a precision study as tables, figure and records ---- */

#define LEVELS 13
/* One table a method; a wide one has more columns. */
void precision_tables(const struct precision *precision, int width, struct arena *arena,
                      struct buffer *out);
/* "fastest method for error 1e-k", and where it is an undamped oscillator predicted against
 * measured evaluations. */
void precision_summary(const struct precision *precision, struct arena *arena, struct buffer *out);
/* "a euler  b verlet …", in lines of that width. */
void precision_legend(const struct precision *precision, int width, struct buffer *out);
void reply_precision(const struct precision *precision, struct arena *arena, struct reply *reply);

/* ---- a sweep as text ---- */

/* What was swept, with the names of its measures. */
struct swept {
    const struct sweep *sweep;
    const struct sweep_measure *measure;
    const struct model *model;
};

void sweep_text(const struct session *session, const struct swept *swept, struct arena *arena,
                struct buffer *text);
/* Columns: point, the axes, the measures, status. */
bool sweep_table(const struct swept *swept, struct export *export, struct error *error);

#endif
