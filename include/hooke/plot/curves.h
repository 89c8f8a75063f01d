/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The numbers behind the curves of a session's figures: rows of a run, values there. */
#pragma once

#include <hooke/plot.h>
#include <hooke/session/subject.h>

/* The rows of a run from time to time: all of them; or for a screen, which is drawn often, those
 * that look the same on so many columns. */
struct row_request {
    double t_begin, t_end; /* [s] */
    int columns;
    double period; /* [s] NAN: not known */
    bool screen;   /* then with the neighbours on both sides, so that a line reaches the ends */
    /* The state variables [first, first + count) that are drawn against the time: of many rows only
     * those where one of them is least or largest in its share of the time. A count of 0 takes all
     * rows. */
    int first, count;
};

struct chosen_rows {
    size_t *row; /* ascending */
    size_t n;
};

bool choose_rows(const struct run *run, const struct row_request *request, struct arena *arena,
                 struct chosen_rows *rows, struct error *error);
/* Returns true if the initial scene was in force during the whole run, as far as can be
 * determined afterwards. */
bool run_never_changed(const struct run *run);

/* The observable at these rows; one that sums up over the run, and a run whose parameters were
 * changed, are walked through as a whole. */
bool values_at_rows(const struct run *run, const struct observable *observable,
                    const struct chosen_rows *rows, struct arena *arena, double *values,
                    struct error *error);
/* Likewise of a column. */
bool chosen_at_rows(const struct run *run, const struct chosen_column *column,
                    const struct chosen_rows *rows, struct arena *arena, double *values,
                    struct error *error);
/* State variable i at these rows. */
void state_at_rows(const struct run *run, int i, const struct chosen_rows *rows, double *values);
/* Finds an observable of the catalog; returns NULL if there is none. */
const struct observable *observable_named(const char *name);
/* Returns the first variable at t, interpolated between recorded rows, or NAN outside the run. */
double run_position(const struct run *run, double t);
/* Returns the first coordinate (derivative 0), its velocity (1) or acceleration (2) at t,
 * interpolated between rows by Hermite polynomials. Returns NAN outside of the run and if a
 * scene of first order has no such derivative. */
double run_motion(const struct run *run, double t, int derivative);
