/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The check of a hand-in: what its files share. */
#ifndef HOOKE_COMMAND_CHECK_H
#define HOOKE_COMMAND_CHECK_H

#include <hooke/report/lab.h>

struct check {
    struct report report;
    struct arena arena;
    const char *folder;
    struct reply *reply;
    struct buffer failure; /* the first error of the session */
    int values, figures, files, differences;
};

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

#endif
