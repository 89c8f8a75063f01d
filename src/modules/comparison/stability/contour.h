/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Traces the lines on which a function of two variables changes its sign: fill in a field, zero a
 * contour, call contour_trace(), then contour_free(). */
#pragma once

#include <hooke/base/cancel.h>

#include <stddef.h>

/* Points of polylines. A point of NAN ends each line. */
struct contour {
    double *x, *y;
    size_t n, capacity; /* number of points, and of those that fit */
};

/* A function and the rectangle in which it is examined. */
struct contour_field {
    /* Returns the function's value; NAN counts as positive. */
    double (*value)(const void *context, double x, double y);
    const void *context;
    double lower[2], upper[2]; /* corners of the rectangle (x, y) */
    int cells[2];              /* number of grid cells in x and y */
};

/* Appends the lines on which the field changes its sign, each point found by bisection on an edge
 * of the grid. A line that crosses one edge twice is not found there. Returns false if out of
 * memory or cancelled; the contour must be freed in any case. */
bool contour_trace(const struct contour_field *field, const struct cancel *cancel,
                   struct contour *contour);
/* Frees the points and zeroes the structure. */
void contour_free(struct contour *contour);
