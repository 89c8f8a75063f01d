/* SPDX-License-Identifier: GPL-3.0-or-later */
/* price: what each kind of work of a run costs, for the command `plan`. Work is counted in
 * operations (steps, evaluations, rows), each of which has a price in instructions; no clock is
 * read, so that the same scene always has the same prices. Call run_work_count(), then
 * run_prices_describe(). */
#pragma once

#include <hooke/run.h>

struct cancel;

/* Work of a run, counted from its plan or estimated from a trial. */
struct run_work {
    /* Number of steps. */
    double steps;
    double evals; /* Number of evaluations and Jacobians of the whole run, each counted as one. */
    double force_evals; /* Number of evaluations alone. */
    bool failed;        /* No step of the trial succeeded. */
    int64_t tried;      /* Number of steps of the trial, 0 if none was made. */
    bool whole;         /* The trial reached the end of the run. */
    /* Number of evaluations of the second solution, and of solutions that follow variables at rest.
     */
    double second_evals, rest_evals;
    double second_rows; /* Number of rows that are compared with the closed form. */
    /* Method of the second solution, or NULL. */
    const struct method *second;
};

/* Description of a run that may be made, owned by the caller. */
struct run_scenario {
    const struct scene *scene;
    const struct system *system;
    const struct method *method;
    const struct run_settings *settings;
    const struct plan *plan;
    double span; /* [s] infinite if the run has no end */
    /* 0 without a second solution, 1 with one within its budget, 2 with one to the end. */
    int opinion;
    /* Events are searched for. */
    bool events;
    const struct cancel *cancel;
};

/* Fills *work: for explicit methods with fixed steps from the number of steps, else from a trial of
 * the first steps, which takes some milliseconds. */
void run_work_count(const struct run_scenario *scenario, struct run_work *work);

/* Appends a list of what `run` computes and one of what it leaves out, with prices in percent of
 * the run. */
void run_prices_describe(const struct run_scenario *scenario, const struct run_work *work,
                         struct buffer *text);
