/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions of the studies in this folder: errors of a solve against a reference, times of solves,
 * and the stages of a precision study. */
#pragma once

#include "modules/comparison/compute/compare.h"

struct cancel;

/* Returns false with an error, and frees the reference, if the solution becomes infinite or ends
 * before the span does. Called before any method runs, because two methods that cannot reach the
 * end would take long to show it. */
bool reference_exists(const struct system *system, struct reference *reference,
                      const struct cancel *cancel, struct error *error);

/* Returns the largest |a - b| over the scored variables of two states at one grid time, in units of
 * the amplitudes; NAN if one of them is. */
double grid_distance(const struct reference *reference, const double *a, const double *b);
/* Computes all errors of a solve, given as its states on the grid [STUDY_TIMES][n], against the
 * reference. Rows of NAN, which were not reached, are left out of the maxima. */
void grid_errors(const struct system *system, const struct reference *reference, const double *grid,
                 struct study_errors *errors);

/* Times solvers side by side, in rounds of random order, so that disturbances of the machine affect
 * all of them alike. `seconds` limits the time of all samples together, and 0 means no limit; long
 * solves get fewer samples. A result has NAN times if its solve fails or if cancelled. */
void time_solvers(struct solver *solver, struct timing_result *result, int count,
                  enum timing timing, double seconds, const struct cancel *cancel);

/* Returns the settings with which a point is solved and timed. */
struct run_settings precision_settings(const struct precision *precision,
                                       const struct precision_point *point);
/* Times all meaningful points, in about `seconds`. Returns false with an error if out of memory; if
 * cancelled some times are missing. */
bool precision_time(const struct precision_request *request, struct precision *precision,
                    double seconds, struct error *error);
/* Fits the slope of a finished curve and its R^2, and marks the points that took part as
 * asymptotic. */
void precision_fit(struct precision *precision, int curve);
