/* SPDX-License-Identifier: GPL-3.0-or-later */
/* coefficients: the coefficients of a method for display, row by row: the stages of a tableau, or
 * the weights of its substeps. Call method_coefficients() for i = 0, 1, … until it returns false.
 */
#ifndef HOOKE_METHOD_COEFFICIENTS_H
#define HOOKE_METHOD_COEFFICIENTS_H

#include <hooke/method.h>

enum { COEFFICIENTS_MAX = 40 /* values in a row */ };

/* One row of coefficients. */
struct coefficient_row {
    const char *label; /* Name, such as "b" or "drift"; "" for a stage of a tableau. */
    double time;       /* Node c of a stage; NAN for other rows. */
    int count;         /* Number of values. */
    /* Coefficients of the row. */
    double value[COEFFICIENTS_MAX];
};

/* Fills *row with row i of the coefficients. Returns false if there is no such row, as always for
 * methods that are algorithms and for external ones. */
bool method_coefficients(const struct method *method, int i, struct coefficient_row *row);

#endif
