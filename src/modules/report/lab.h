/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The report of a session: what the lab asks to hand in, as far as the session has it. Nothing is
 * computed here that the session does not hold: runs, recordings, measurements, fits. What it says
 * depends on nothing else, so that the session's script gives the same bytes.
 */
#pragma once

#include "modules/documents/documents.h"
#include <hooke/report.h>
#include <hooke/plot.h>

struct folder;

/* A number of the session with its origin. */
struct report_value {
    const char *name; /* "period", "gamma of the first half" */
    struct measured value;
    enum quantity quantity;
    const char *subject; /* "run 1" or "data disk", where the second word is a user's */
    const char *source;  /* "measured", "fit damped" */
    double t;            /* [s] time of a measured amplitude; NAN for other values */
    /* Statement of the log that gave it, counted from 1, or 0 for the scene's own value. */
    size_t statement;
    /* Description of a parameter of a scene other than the lab's, or NULL if the name is enough. */
    const char *brief;
};

/* Sections of the report, numbered like the parts of the lab sheet. SECTION_OTHER holds runs of
 * scenes that are not of the lab. */
enum section {
    SECTION_RECORDING = 1,
    SECTION_SIMULATION,
    SECTION_ENERGY,
    SECTION_SCHEMES,
    SECTION_DRAG,
    SECTION_DAMPED_RECORDING,
    SECTION_DAMPED_SIMULATION,
    SECTION_OTHER,
    SECTION_COUNT
};

#define REPORT_FIGURES 1024 /* most figures of a report; a full session has fewer */
#define REPORT_OVERLAY 4    /* most runs in one figure, so that each has distinct marks */

struct material; /* defined in material.h */

/* A report that is being written. The caller sets session, view, arena and either folder or put
 * with context, may set latex, and calls report_write(), then document_free(). */
struct report {
    const struct session *session;
    struct session *view; /* copy of the session; figures switch its current run and recording */
    struct arena *arena;
    struct folder *folder;
    /* Takes each file instead of the folder, or is NULL. */
    bool (*put)(void *context, const char *name, struct text content, struct error *error);
    void *context;
    struct document document;
    struct report_value *value; /* filled by collect_values() */
    int values;
    int figures; /* number of figures so far; the captions count from 1 */
    struct report_figure {
        enum plot_kind kind;
        enum section section;
    } figure[REPORT_FIGURES];
    /* runs and recordings that appear in a figure */
    bool run_shown[LIMIT_RUNS], recording_shown[LIMIT_RECORDINGS];
    const struct material *material; /* runs and recordings by section, see sort_material() */
    int head;                        /* lines of session.hk before the first statement */
    int files;                       /* number of files written so far */
    bool latex;                      /* report.tex is written, too, with the figures as PDF */
    char no_pdf[600];                /* Reason why the figures are text, or "" if they are not. */
};

/* Appends the commands that draw the figures of a question of the lab sheet, a line each, into
 * files named after `file` unless that is empty; is_forced replaces such files. report->material
 * must be sorted. Returns false with the error if there is no such figure, or if the session has no
 * run or recording for it. */
bool question_figures(const struct report *report, int number, struct text file, bool is_forced,
                      struct buffer *lines, struct error *error);
/* Writes all files of the report. Returns false with *error if out of memory, if a file cannot be
 * written, or after Ctrl-C; the caller then abandons the folder. */
bool report_write(struct report *report, struct error *error);
/* Returns true if a report writes a file of this name, so that it may be replaced. */
bool report_owns(const char *name);

/* ---- shared by the files of the report, in the order of their use ---- */

/* Writes one file of the report and counts it. Returns false with *error if `content` ran out of
 * memory or the file cannot be written. */
bool report_put(struct report *report, const char *name, const struct buffer *content,
                struct error *error);
/* Fills report->value from measurements, fits and runs. Returns false with *error if out of
 * memory. */
bool collect_values(struct report *report, struct error *error);
/* Sorts runs and recordings by section into report->material; needs the values. Returns false with
 * *error if out of memory. */
bool sort_material(struct report *report, struct error *error);
/* Writes a table of the values of a run or recording ("run 1", "data disk"): its parameters and
 * settings, or the measured and fitted ones. Writes nothing if there are none. */
void put_values(struct report *report, const char *subject, bool parameters);
/* Writes the table of all values, with the line of session.hk that each comes from. */
void put_all_values(struct report *report);
/* Returns the first value of that name and subject ("data disk"; NULL matches any) that is not a
 * parameter, or NULL if there is none. */
const struct report_value *find_value(const struct report *report, const char *name,
                                      const char *subject);
/* Writes the name of a value in words: "damping gamma", "y0 (y at t0)". */
void say_label(struct document *document, const struct report_value *value);
/* Writes a value with its unit, in as many digits as its uncertainty justifies, or few if it has
 * none and was not stated. */
void say_value(struct document *document, const struct report_value *value);
/* Adds a figure of these runs and this recording (indices in the session; recording -1 for none)
 * with its caption. Adds nothing if the model has no such plot. Returns false with *error. */
bool put_figure(struct report *report, enum section section, enum plot_kind kind, const int *run,
                int runs, int recording, struct error *error);
/* Returns the index of the recording that a run is compared with in a plot of that kind, or -1 if
 * there is none. Changes which run and recording are current in report->view. */
int recording_beside(struct report *report, int run, enum plot_kind kind);
/* Writes a table of these runs (indices in the session). With `distance` it has the rms distance of
 * each from the recording that it is compared with. */
void put_runs(struct report *report, const int *run, int runs, bool distance);
/* Writes values.csv, runs.csv and the data of runs and recordings that have a figure. */
bool write_tables(struct report *report, struct error *error);

/* ---- sections ---- */

/* Writes the questions of the lab sheet that belong to a section. */
void put_questions(struct report *report, enum section section);
/* Writes all sections that the session has something for. Returns false with *error. */
bool write_sections(struct report *report, struct error *error);
/* Returns true if the session has a recording, or a run of the lab's scene. */
bool report_of_lab(const struct report *report);
/* Calls `say` for each thing that the headings lack, with the command to type for it. */
void report_missing(const struct report *report,
                    void (*say)(void *context, const char *what, const char *type), void *context);
