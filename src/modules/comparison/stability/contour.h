/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The line on which a function of two variables changes its sign. */
#pragma once

#include <hooke/base/cancel.h>

#include <stddef.h>

/* Points of polylines, with a point of NAN behind each. Zeroed at first; contour_free(). */
struct contour {
    double *x, *y;
    size_t n, capacity;
};

struct contour_field {
    /* NAN counts as positive. */
    double (*value)(const void *context, double x, double y);
    const void *context;
    double lower[2], upper[2]; /* the box: x, y */
    int cells[2];              /* grid on which the line is looked for */
};

/* Appends the lines on which the field changes its sign, each point found by bisection on an edge
 * of the grid. Lines that pass twice between two neighbours of the grid are not found. Returns
 * false if out of memory or cancelled. */
bool contour_trace(const struct contour_field *field, const struct cancel *cancel,
                   struct contour *contour);
void contour_free(struct contour *contour);
