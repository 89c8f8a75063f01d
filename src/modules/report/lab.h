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

/* A number of the session with where it comes from. */
struct report_value {
    const char *name; /* "period", "gamma, first half" */
    struct measured value;
    enum quantity quantity;
    const char *subject; /* "run 1" or "data disk", where the second word is a user's */
    const char *source;  /* "measured", "fit damped" */
    double t;            /* [s] of an amplitude; NAN */
    /* Statement of the log that gave it, counted from 1, or 0 for the scene's own value. */
    size_t statement;
    /* Description of a parameter of a scene other than the lab's, or NULL if the name is enough. */
    const char *brief;
};

/* Numbered like those of the lab sheet; what is left is of no lab. */
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

#define REPORT_FIGURES 1024 /* a session that holds as much as it can has fewer */
#define REPORT_OVERLAY 4    /* runs in one figure: as many as have marks of their own */

struct material; /* defined in material.h */

struct report {
    const struct session *session;
    struct session *view; /* a copy in which other runs and recordings are the current ones */
    struct arena *arena;
    struct folder *folder;
    /* takes the files, with `context`; NULL if they go into the folder */
    bool (*put)(void *context, const char *name, struct text content, struct error *error);
    void *context;
    struct document document;
    struct report_value *value;
    int values;
    int figures;
    struct report_figure {
        enum plot_kind kind;
        enum section section;
    } figure[REPORT_FIGURES];
    /* runs and recordings that appear in a figure */
    bool run_shown[LIMIT_RUNS], recording_shown[LIMIT_RECORDINGS];
    const struct material *material; /* sorted by what it is for */
    int head;                        /* lines of session.hk before the first statement */
    int files;
    bool latex;       /* also report.tex, with the figures as PDF */
    char no_pdf[600]; /* Reason why the figures are text, or "" if they are not. */
};

/* Writes all files into the folder, which is open. */
bool report_write(struct report *report, struct error *error);
/* A name that a report gives to its files. */
bool report_owns(const char *name);

/* ---- what the parts share ---- */

bool report_put(struct report *report, const char *name, const struct buffer *content,
                struct error *error);
bool collect_values(struct report *report, struct error *error);
/* Sorts the values into report->material; call it after the values are added. */
bool sort_material(struct report *report, struct error *error);
/* Values of a run or a recording, all or the measured and fitted ones; nothing where there are
 * none. */
void put_values(struct report *report, const char *subject, bool parameters);
/* All values, with the line of session.hk that each comes from. */
void put_all_values(struct report *report);
/* One that was found, of that ("data disk"); of NULL: of anything. */
const struct report_value *find_value(const struct report *report, const char *name,
                                      const char *subject);
/* "damping gamma", "y0 (y at t0)" */
void say_label(struct document *document, const struct report_value *value);
/* As many digits as its uncertainty gives it; 3 of what has none and was not stated. */
void say_value(struct document *document, const struct report_value *value);
/* Puts a figure of these runs and this recording (indices; -1 for none), with its caption. Puts
 * nothing if there is no such plot. */
bool put_figure(struct report *report, enum section section, enum plot_kind kind, const int *run,
                int runs, int recording, struct error *error);
/* Place of the recording that a run is to be compared with; -1 if there is none. */
int recording_beside(struct report *report, int run, enum plot_kind kind);
/* Puts the runs as a table; with `distance` it has their distances from the recordings compared
 * with them. */
void put_runs(struct report *report, const int *run, int runs, bool distance);
bool write_tables(struct report *report, struct error *error);

/* ---- sections ---- */

/* Those of a section. */
void put_questions(struct report *report, enum section section);
bool write_sections(struct report *report, struct error *error);
/* The session has something of the lab. */
bool report_of_lab(const struct report *report);
/* Calls `say` for each thing that the headings lack, with the command to type for it. */
void report_missing(const struct report *report,
                    void (*say)(void *context, const char *what, const char *type), void *context);
