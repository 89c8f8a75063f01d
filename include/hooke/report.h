/* SPDX-License-Identifier: GPL-3.0-or-later */
/* report: tables that are written into files, studies as tables, what the lab hands in. */
#ifndef HOOKE_REPORT_H
#define HOOKE_REPORT_H

#include <hooke/language.h>
#include <hooke/plot.h>
#include <hooke/scene.h>

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
/* Adds NAME_low and NAME_high to the table of one run: the band of the adopted fit about each
 * variable of the state in it. where: the option as typed. */
bool export_band(const struct session *session, const struct argument_value *runs,
                 struct text where, struct export *export, struct error *error);
/* Of a hand-in: t and y of every sample, and used (0, 1) where some are outside the window or
 * masked. */
bool export_recording(const struct session *session, struct export *export, struct error *error);
/* column: t, y, v, energy; none means t and y. */
bool export_recorded(const struct session *session, const struct argument_value *column,
                     const struct argument_value *every, struct export *export,
                     struct error *error);
/* Fills the keys of the table: what made this run. */
bool export_run_keys(const struct session *session, int index, struct export *export,
                     struct error *error);
/* The same: the present scene. */
bool export_scene_keys(const struct session *session, struct export *export, struct error *error);

/* ---- results that are tables (results.c) ---- */

struct result_row {
    struct row row;
    const char *kind; /* of its records; NULL: as the row is called */
    /* of what there is now; NULL: the last that was found */
    bool (*table)(const struct session *session, struct export *export, struct error *error);
    /* records of what there is now; NULL: what was said last */
    void (*say)(const struct session *session, struct reply *reply);
    /* `export FILE table` alone writes it, until there is another run */
    bool study;
    const char *type; /* what makes one */
    bool sceneless;   /* no scene had a part in it */
};

extern const struct catalog result_catalog; /* of struct result_row */

/* The table of a row of that catalog. It lives as long as the session keeps it, or the arena. */
bool export_result(struct session *session, const struct row *of, struct export *export,
                   struct error *error);
/* Whether there is one. */
bool result_is_kept(const struct session *session, const struct row *of);
/* What the last study found; the runs where there were runs since. */
bool export_latest(struct session *session, struct export *export, struct error *error);
/* A row for each run. */
bool export_run_table(const struct session *session, struct export *export, struct error *error);
/* The table of a result whose records say more, or less. method, reference: what is said of it
 * beside duration and scene; NULL: nothing. Without memory it is lost. */
void reply_result(const struct session *session, struct reply *reply, const char *kind,
                  const struct result_columns *columns, const void *rows, size_t count,
                  const char *method, const char *reference);
/* What a statement has said becomes the last result of its kind. Returns which of them the result
 * of that command is; NULL: none is a table. */
const struct row *session_keep_results(struct session *session, struct table_store *said,
                                       const char *command);

/* Which rows of many are written, by `every`: a count of rows, or a time [s]. */
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

/* Where events may have been missed: a warning, once; with `format json` a record of each event,
 * how many were noticed. */
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
    double dt, tol; /* NAN: the other one holds */
    double y, v;    /* NAN: the scene has no such variable, or none of its digits is certain */
    double rest;    /* [s] held by dry friction from then on; NAN */
    double seconds; /* [s] that it took; NAN with 'timing off' */
    struct data_distance data;
    /* Only for records: */
    struct ledger ledger;
    struct run_errors errors;
    double below[LIMIT_VARIABLES];
};

void run_record_init(struct run_record *record, const struct session *session,
                     const struct run *run);
void reply_run_record(struct run_record *record, struct reply *reply);
/* Of the current run, where there is one. */
void reply_current_run(const struct session *session, struct reply *reply);

/* ---- a precision study as tables, figure and records ---- */

#define LEVELS 13
/* One table a method, or that of one method only (NULL: of all); a wide one has more columns. */
void precision_tables(const struct precision *precision, const struct method *only, int width,
                      struct arena *arena, struct buffer *out);
/* One line a method: its slope, and what it costs at best. */
void precision_overview(const struct precision *precision, struct buffer *out);
/* The fastest methods for an error of 1e-3, 1e-6 ..., in lines of that width. */
void precision_winners(const struct precision *precision, int width, struct arena *arena,
                       struct buffer *out);
/* "fastest method for error 1e-k", and where it is an undamped oscillator predicted against
 * measured evaluations. */
void precision_summary(const struct precision *precision, struct arena *arena, struct buffer *out);
/* "a euler  b verlet …", in lines of that width. */
void precision_legend(const struct precision *precision, int width, struct buffer *out);
void reply_precision(const struct session *session, const struct precision *precision,
                     struct arena *arena, struct reply *reply);

/* ---- a sweep as text ---- */

/* What was swept, with the names of its measures. */
struct swept {
    const struct sweep *sweep;
    const struct sweep_measure *measure;
    const struct model *model;
    int measures;
    const struct sweep_section *section;     /* NULL: measured over the duration */
    const struct sweep_attractor *attractor; /* [attractors] where they are measured */
    int attractors;
};

/* rows: what fits into that many lines, figures before tables; 0: everything. */
void sweep_text(const struct session *session, const struct swept *swept, int rows,
                struct arena *arena, struct buffer *text);
/* Columns: point, the axes, the measures, status. False: no memory. */
bool sweep_table(const struct swept *swept, struct arena *arena, struct table *table);

/* At a section: how many points have fewer events than were to be kept is said, too. */
void diagram_text(const struct session *session, const struct swept *swept, int rows,
                  struct arena *arena, struct buffer *text);
/*
 * A row for each event: point, the parameter, event (its number), t, the columns, the first of them
 * at the next event (NAN: the last), repeats (after how many events the point's come again, NAN:
 * not within half of them), status. A point without events has one row of NAN. False: no memory.
 */
bool diagram_table(const struct swept *swept, struct arena *arena, struct table *table);

/* "103 of 103 points in 0.1 s ...", and what went wrong. */
void sweep_summary(const struct sweep *sweep, struct buffer *text);
void sweep_failures(const struct sweep *sweep, struct buffer *text);

#endif
