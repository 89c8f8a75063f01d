/* SPDX-License-Identifier: GPL-3.0-or-later */
/* even_times: finds the even sampling times behind time stamps that were rounded when they were
 * printed. */
#pragma once

#include <hooke/base/text.h>

struct cancel;

/* Result of the search. */
struct even_times {
    double first, step; /* Sample i was taken at the time first + i step [s]. */
    double pace;        /* Relative standard uncertainty of `step`, due to rounding. */
    double resolution;  /* Coarsest rounding [s] of a time stamp, or 0 if none was rounded. */
    bool even;          /* Every stamp agrees with first + i step within its rounding. */
};

/*
 * Finds the line through n time stamps t [s], which may repeat but not decrease. A stamp may be
 * rounded to a number of decimals or to a number of significant digits. If the stamps are not even,
 * or if the search is cancelled (`cancel` may be NULL), `first` and `step` are the first stamp and
 * the mean step.
 *
 * Stamps 1 ms apart of which every 20th is missing could also be rounded times with a step of 1.053
 * ms. The values y [n], which must be smooth in time, decide between these two cases; if y is NULL
 * or noise hides the difference, the stamps count as rounded.
 */
void even_times_find(const double *t, const double *y, size_t n, const struct cancel *cancel,
                     struct even_times *result);
