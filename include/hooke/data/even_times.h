/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Even sampling behind time stamps that were rounded when they were printed. */
#pragma once

#include <hooke/base/text.h>

struct cancel;

struct even_times {
    double first, step; /* [s] sample i was taken at first + i step */
    double pace;        /* relative standard uncertainty of step: what the rounding leaves open */
    double resolution;  /* [s] the coarsest rounding of a time stamp, or 0 if none was rounded */
    bool even;          /* every stamp lies within its rounding of that line */
};

/*
 * Finds the line through all n stamps, which may repeat but do not fall. A stamp may be rounded to
 * a number of decimals or to a number of significant digits. Where the stamps are not even, first
 * and step are the first stamp and the mean step. A cancelled search finds that they are not even.
 *
 * Stamps 1 ms apart of which every 20th row is lost are also those of a step of 1.053 ms, rounded.
 * The values y [n] tell which of the two it is; with NULL, or where noise hides it, the stamps
 * count as rounded.
 */
void even_times_find(const double *t, const double *y, size_t n, const struct cancel *cancel,
                     struct even_times *result);
