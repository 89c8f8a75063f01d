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
    /* Number of evaluations of the equations and of Jacobians in the whole run, each counted as
     * one. */
    double evals;
    double force_evals; /* Number of evaluations of the equations alone, without Jacobians. */
    bool failed;        /* No step of the trial succeeded. */
    int64_t tried;      /* Number of steps of the trial, 0 if none was made. */
    /* The trial reached the end of the run, or stopped by itself, so that its counts are those of
     * the run. */
    bool whole;
    /* Numbers of evaluations for the estimated error: those of the second solution, and those of
     * further solutions that find how errors of variables that have decayed to values below the
     * tolerance grow again. */
    double second_evals, rest_evals;
    /* Number of rows that are compared with the closed form in place of a second solution. */
    double second_rows;
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
    double span; /* Duration [s] of the run; infinite if it has no end. */
    /* Effort for the estimated error, also called opinion (struct opinion in <hooke/run.h>): 0 for
     * none, 1 for a second solution within its budget, 2 for one to the end of the run. */
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
