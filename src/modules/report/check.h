/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Checks hand-ins: hand_ins_check() is the entry; the rest is shared by check.c, check_tables.c and
 * check_answers.c. */
#pragma once

#include "modules/report/lab.h"
#include <hooke/command.h>

/* The check of one folder, and what it has found so far. */
struct check {
    struct report report;                    /* the report that the session of the folder gives */
    struct arena arena;                      /* memory of the check, freed with it */
    const char *folder;                      /* path of the hand-in */
    struct reply *reply;                     /* takes the findings */
    struct buffer failure;                   /* the first error of the session */
    int values, figures, files, differences; /* number of those compared, and of differences */
    int wrong_values, wrong_figures, changed_lines, missing_files;
    struct buffer repeated;     /* report.md as the session gives it; empty if it gives none */
    int answers, empty_answers; /* questions of report.md with and without an answer */
    struct buffer empty;        /* questions without an answer: "Q1 Q3" */
    struct buffer name;         /* text behind "Name:" */
    uint64_t sum;     /* checksum of report.md without name, date and answers; 0 if it is missing */
    const char *copy; /* folder before this one with the same report, or NULL */
};

/* A hand-in that was checked before; another with the same sum is reported as a copy of it. */
struct checked {
    const char *folder;
    uint64_t sum;
};

/*
 * Runs session.hk of each folder that `report` wrote, in a session of its own and writing nothing,
 * and reports which values, figures and files of the folder are not what it gives. Values are
 * compared within their uncertainty (those without one in six digits), data number by number,
 * figures byte by byte, and of documents the lines that hold digits. Adds the record `check` of
 * each: differences [{file, what, detail}], folder, agrees, values, figures, files, moved, name,
 * complete, values_right, figures_agree, changed, answers, empty, copy. In CSV it is one row for
 * each folder. Returns the exit status: how many differ, at most CHECK_STATUS_MAX, above which
 * shells report signals; ERROR_USAGE if the only folder has no session to run.
 */
#define CHECK_STATUS_MAX 125
int hand_ins_check(struct session *session, const char *const *folder, int folders,
                   struct reply *reply);

/* Finds the student's name, the empty answers and the checksum of the report in report.md and
 * report.html (empty text if a file is missing), and stores them in *check. */
void check_answers(struct check *check, struct text report, struct text page);

/* Returns true if a line of the text, without blanks around it, is `wanted`. */
bool check_has_line(struct text text, struct text wanted);
/* Returns true if the line describes a recording that was read from recording-N.csv of the folder:
 * number of rows and separator differ from those of its file. */
bool check_describes_recording(const struct session *session, struct text line);
/* Reports one difference: the file, what is wrong with it, and a detail that is cut where it is
 * long. */
void check_differs(struct check *check, const char *file, const char *what, struct text detail);

/* Compares values.csv of the folder with the one that the session gives: each value within its
 * uncertainty. */
void check_values(struct check *check, struct text handed_text, struct text repeated_text);

/* Compares two tables of data number by number, to `data_tolerance_relative` of the largest number
 * of the column. Comments say where a file was and are not compared. */
void check_data(struct check *check, const char *file, struct text handed_text,
                struct text repeated_text);
