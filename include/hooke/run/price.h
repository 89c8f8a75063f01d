/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * price: what each part of a run costs, for `plan`. Parts are counted in operations (steps,
 * evaluations, rows), each of which has a price in instructions; no clock is read, so that the
 * same scene always has the same prices.
 */
#pragma once

#include <hooke/run.h>

struct cancel;

/* Work of a run of a scene by a method, as counted or tried. */
struct run_work {
    double steps;
    double evals;       /* evaluations and Jacobians of the whole run, each counted as one */
    double force_evals; /* evaluations alone */
    bool failed;        /* no step could be tried */
    int64_t tried;      /* steps that were tried to find this out; 0 if none were */
    bool whole;         /* the trial went to the end of the run */
    /* evaluations of the second solution, and of those that follow variables at rest; 0 if there
     * are none */
    double second_evals, rest_evals;
    double second_rows; /* rows that are compared with the closed form */
    const struct method *second;
};

struct run_scenario {
    const struct scene *scene;
    const struct system *system;
    const struct method *method;
    const struct run_settings *settings;
    const struct plan *plan;
    double span; /* [s] infinite if the run has no end */
    /* 0 without a second opinion, 1 with one within its budget, 2 with one to the end */
    int opinion;
    bool events;
    const struct cancel *cancel;
};

/* Counts the work of a run: of explicit fixed steps from their number, else by trying the first
 * steps of it, which takes some milliseconds. */
void run_work_count(const struct run_scenario *scenario, struct run_work *work);

/* Appends two lists, what `run` computes and what it leaves out, with the price of each in percent
 * of the run. */
void run_prices_describe(const struct run_scenario *scenario, const struct run_work *work,
                         struct buffer *text);
