/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is measured of solves: their distance from a reference, and their times. */
#pragma once

#include "modules/comparison/compute/compare.h"

struct cancel;

/* False: the solution ends on the way, and the reference is freed. Asked first: two methods that do
 * not get there would take long to find out. */
bool reference_exists(const struct system *system, struct reference *reference,
                      const struct cancel *cancel, struct error *error);

/* Largest |a - b| over the scored variables of one grid time, in units of the amplitudes. */
double grid_distance(const struct reference *reference, const double *a, const double *b);
/* All errors of grid states against the reference. */
void grid_errors(const struct system *system, const struct reference *reference, const double *grid,
                 struct study_errors *errors);

/*
 * Times solvers side by side: round after round, each round in another random order, so that
 * whatever disturbs the machine meets all of them alike. `seconds`: for all samples together, 0: no
 * limit; solves that take long get fewer.
 */
void time_solvers(struct solver *solver, struct timing_result *result, int count,
                  enum timing timing, double seconds, const struct cancel *cancel);

/* How a point is solved. */
struct run_settings precision_settings(const struct precision *precision,
                                       const struct precision_point *point);
/* Times of all points that mean something, in about so many seconds. */
bool precision_time(const struct precision_request *request, struct precision *precision,
                    double seconds, struct error *error);
/* Slope, its R^2 and which points took part, of a finished curve. */
void precision_fit(struct precision *precision, int curve);
