/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Measurements of solves: their distance from a reference, and their times. */
#pragma once

#include "modules/comparison/compute/compare.h"

struct cancel;

/* Returns false with the error, and frees the reference, if the solution ends before the span does.
 * This is tested first, because two methods that do not get there would take long to show it. */
bool reference_exists(const struct system *system, struct reference *reference,
                      const struct cancel *cancel, struct error *error);

/* Returns the largest |a - b| over the scored variables of one grid time, in units of the
 * amplitudes. */
double grid_distance(const struct reference *reference, const double *a, const double *b);
/* Computes all errors of grid states against the reference. */
void grid_errors(const struct system *system, const struct reference *reference, const double *grid,
                 struct study_errors *errors);

/*
 * Times solvers side by side, in rounds of random order, so that disturbances of the machine affect
 * all of them alike. `seconds` is for all samples together, 0 for no limit; long solves get fewer
 * samples.
 */
void time_solvers(struct solver *solver, struct timing_result *result, int count,
                  enum timing timing, double seconds, const struct cancel *cancel);

/* Returns the settings with which a point is solved. */
struct run_settings precision_settings(const struct precision *precision,
                                       const struct precision_point *point);
/* Times all meaningful points, in about `seconds`. Returns false with the error if out of memory or
 * cancelled. */
bool precision_time(const struct precision_request *request, struct precision *precision,
                    double seconds, struct error *error);
/* Computes the slope of a finished curve, its R^2, and which points took part. */
void precision_fit(struct precision *precision, int curve);
