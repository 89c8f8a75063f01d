/* SPDX-License-Identifier: GPL-3.0-or-later */
/* curves: the numbers that curves show: which rows of a run are drawn, and the values of a column
 * of the run (a state variable, an observed quantity or an observable) at these rows. */
#pragma once

#include <hooke/plot.h>
#include <hooke/session/subject.h>

/* Rows of a run that a curve needs: all rows in an interval or, for a screen, which is drawn often,
 * a selection that looks the same. */
struct row_request {
    double t_begin, t_end; /* Interval [s]. */
    /* Width [screen cell] on which the curve is drawn. */
    int columns;
    double period; /* Period [s] of the motion, NAN if unknown. */
    /* The curve is for a screen. Rows next to the interval are added, so that lines reach the ends.
     */
    bool screen;
    /* State variables from `first` to first + count - 1 are drawn against the time: if there are
     * many rows, only those with extremes of one of them in each short interval. A count of 0
     * selects all rows. */
    int first, count;
};

/* Selected rows of a run. */
struct chosen_rows {
    size_t *row; /* [n] indices of rows, ascending. */
    size_t n;
};

/* Selects the rows for a curve, in the arena. Returns false, with `error` set, if out of memory. */
bool choose_rows(const struct run *run, const struct row_request *request, struct arena *arena,
                 struct chosen_rows *rows, struct error *error);
/* Returns true if the forces of the run's system are those of its start: no parameter has been
 * changed, or all were set back. Returns false for a conservative scene whose run sums up work
 * (plan.ledger), as after a change of a parameter. */
bool run_never_changed(const struct run *run);

/* Sets values [rows->n] to an observable at these rows. Computes all rows of the run for it if the
 * observable is a sum over the run or if parameters have changed. Returns false, with `error` set,
 * if it is not defined, if cancelled or if out of memory. */
bool values_at_rows(const struct run *run, const struct observable *observable,
                    const struct chosen_rows *rows, struct arena *arena, double *values,
                    struct error *error);
/* Does the same for any column: a state variable, an observed quantity or an observable. */
bool chosen_at_rows(const struct run *run, const struct chosen_column *column,
                    const struct chosen_rows *rows, struct arena *arena, double *values,
                    struct error *error);
/* Copies state variable i at these rows to values [rows->n]. */
void state_at_rows(const struct run *run, int i, const struct chosen_rows *rows, double *values);
/* Returns the observable of this name, or NULL if there is none. */
const struct observable *observable_named(const char *name);
/* Returns run_motion() of derivative 0, the first variable at t [s]. */
double run_position(const struct run *run, double t);
/* Returns the first coordinate (derivative 0), its velocity (1) or acceleration (2) at t [s],
 * interpolated by Hermite polynomials. Returns NAN outside the run and if a first-order scene has
 * no such derivative. */
double run_motion(const struct run *run, double t, int derivative);
