/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Coefficients of a method, row by row: a tableau, or the weights of its steps. */
#ifndef HOOKE_METHOD_COEFFICIENTS_H
#define HOOKE_METHOD_COEFFICIENTS_H

#include <hooke/method.h>

enum { COEFFICIENTS_MAX = 40 /* values in a row */ };

struct coefficient_row {
    const char *label; /* "b", "drift"; "" for a stage of a tableau */
    double time;       /* c of a stage; NAN for other rows */
    int count;         /* values that it has */
    double value[COEFFICIENTS_MAX];
};

/* Fills in row i of the method's coefficients. Returns false if there is none, or none at all: of
 * methods that are algorithms, and of external ones. */
bool method_coefficients(const struct method *method, int i, struct coefficient_row *row);

#endif
