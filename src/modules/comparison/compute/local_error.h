/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The local error of a method: what one step from a state of the solution adds, u1 - u(t + dt).
 *
 * Its leading term is c dt^q. For many methods and scenes c is a simple fraction of the solution's
 * derivative u^(q) at t, the term at which the Taylor expansions of method and solution part.
 */
#pragma once

#include "modules/comparison/compute/compare.h"

#define LOCAL_ERROR_POINTS 6

/* The leading error of one variable. */
struct leading_error {
    int exponent;       /* q, or 0 if the error is rounding only, or -1 if it follows no power */
    double coefficient; /* c, in units of the variable per s^q; NAN unless q > 0 */
    double derivative;  /* u^(q) [unit/s^q] at t; NAN if it is not known well enough */
    /* c = numerator/denominator u^(q) at several states of the solution; denominator 0 if c is no
     * such multiple, or a different one at each. */
    int numerator, denominator;
};

struct local_error {
    struct method_choice choice;
    int n;
    double t;                                  /* [s] time of the state from which the step goes */
    double state[LIMIT_VARIABLES];             /* [n] */
    struct variable variable[LIMIT_VARIABLES]; /* [n] names and quantities */
    struct leading_error leading[LIMIT_VARIABLES]; /* [n] */
    int points;
    double dt[LOCAL_ERROR_POINTS];                     /* [s] from long to short */
    double error[LOCAL_ERROR_POINTS][LIMIT_VARIABLES]; /* u1 - u(t + dt); NAN if the step failed */
};

struct local_error_request {
    const struct scene *scene;
    struct method_choice choice;
    double t; /* [s] time at which the step begins, or NAN for an eighth of the period after the
                 start */
    const struct cancel *cancel; /* NULL if nobody can cancel */
};

/*
 * Measures the local error of a method on the solution of the scene. Returns false with the error
 * if the method does not apply, takes no single steps (multistep methods, external ones), or if the
 * solution does not reach t, or if it is cancelled.
 */
bool study_local_error(const struct local_error_request *request, struct local_error *result,
                       struct error *error);

/* One variable at one step: a row of the study's table. */
struct local_error_row {
    const struct method *method;
    struct variable variable;     /* name and quantity */
    struct leading_error leading; /* the variable's, the same in each of its rows */
    double dt, error;             /* [s], and unit of the variable */
    double slope; /* log(error ratio)/log(dt ratio) to the longer step; NAN for the first */
};

/* Fills in a row for each variable and step, variable by variable; returns how many. rows has room
 * for n times points of them. */
size_t local_error_rows(const struct local_error *result, struct local_error_row *rows);

/* Columns for rows of struct local_error_row. */
extern const struct result_columns local_error_columns;
