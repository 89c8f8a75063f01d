/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The check of a hand-in: what its files share. */
#pragma once

#include "modules/report/lab.h"
#include <hooke/command.h>

struct check {
    struct report report;
    struct arena arena;
    const char *folder;
    struct reply *reply;
    struct buffer failure; /* the first error of the session */
    int values, figures, files, differences;
};

/*
 * Runs session.hk of each folder that `report` wrote, in a session of its own and writing nothing,
 * and reports which values, figures and files of the folder are not what it gives. Values are
 * compared within their uncertainty (those without one in six digits), data number by number,
 * figures byte by byte, and of documents the lines that hold digits. Adds the record `check` of
 * each: differences [{file, what, detail}], folder, agrees, values, figures, files, moved. Returns
 * the largest exit status: 0 if all agree, ERROR_COMMAND if some differ, ERROR_USAGE if a folder
 * has no session to run.
 */
int hand_ins_check(struct session *session, const char *const *folder, int folders,
                   struct reply *reply);

/* Reports one difference: the file, what is wrong with it, and a detail that is cut where it is
 * long. */
void check_differs(struct check *check, const char *file, const char *what, struct text detail);

/* Compares values.csv of the folder with the one that the session gives: each value within its
 * uncertainty. */
void check_values(struct check *check, struct text handed_text, struct text again_text);

/* Compares two tables of data number by number, to `data_tolerance_relative` of the largest number
 * of the column. Comments say where a file was and are not compared. */
void check_data(struct check *check, const char *file, struct text handed_text,
                struct text again_text);
