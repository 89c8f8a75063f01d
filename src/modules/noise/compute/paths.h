/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Paths of a scene with noise: one, and many with their statistics. */
#pragma once

#include "modules/noise/compute/forcing.h"
#include <hooke/run/parallel.h>

#include <hooke/run.h>

struct cancel;

/* Steps of one size that end on time, each so many of which are recorded. */
struct path_grid {
    double t0, span, h; /* [s] */
    int64_t steps, stride;
    size_t rows; /* the start, each so many steps, and the end */
};

enum { PATH_STEPS_MAX = 2000000000, PATH_ROWS_MAX = 1000000 };

/*
 * Makes steps of at most dt > 0 to the end of span > 0, and at most `intervals` + 1 rows. Returns
 * false with `error` filled if the method needs a velocity that is not there, or a step makes the
 * motion grow that should not.
 */
bool noise_path_grid_make(const struct noise_forcing *forcing, const struct noise_method *method,
                          double span, double dt, size_t intervals, struct path_grid *grid,
                          struct error *error);
double noise_path_time(const struct path_grid *grid, size_t row); /* [s] */

/* Quantity computed from a state. */
struct path_column {
    /* observable, or NULL for number `variable` of the state or of what a typed scene observes
     * after it */
    const struct observable *observable;
    int variable;
    struct run *run; /* run of the same scene, at its start, or NULL if no observable needs one */
};

double noise_path_value(const struct noise_forcing *forcing, const struct path_column *column,
                        double t, const double *y);

struct path_request {
    const struct noise_forcing *forcing;
    const struct noise_method *method;
    struct path_grid grid;
    uint64_t seed;
    const struct cancel *cancel;
};

/*
 * Follows path number `path`; calls row() for the start and each recorded state. y [n] is the state
 * at the end. Returns the number of steps taken, less than grid.steps if it diverged or was
 * cancelled.
 */
int64_t noise_path_follow(const struct path_request *request, uint64_t path, double *y,
                          void (*row)(void *context, size_t row, double t, const double *y),
                          void *context);

/*
 * Follows `paths` paths, whose ends are end [paths][n], again with half of each step on the same
 * Wiener path. distance [n] is the root mean square of how far apart the two end. Returns false if
 * one diverges or it was cancelled.
 */
bool noise_path_half_step(const struct path_request *request, const double *end, int64_t paths,
                          double *distance);

struct ensemble_row {
    double t, mean, sd, low, lower, median, upper, high; /* SI; low, high: 5 % and 95 % */
    int64_t paths;                                       /* that got there */
    enum quantity quantity;                              /* quantity of the values, for tables */
};

struct ensemble {
    int64_t paths, diverged;
    size_t rows;
    double *value; /* [rows][paths] SI; NAN beyond divergence */
    double *end;   /* [paths][n] states at the end; NAN where it diverged */
};

/* Size of what an ensemble holds [byte]. */
double noise_ensemble_bytes(const struct path_request *request, int64_t paths);
/* Follows all paths. The same bytes for any number of threads. Returns false with `error` filled if
 * out of memory or cancelled. noise_ensemble_free() in every case. */
bool noise_ensemble_follow(const struct path_request *request, const struct path_column *column,
                           int64_t paths, struct parallel parallel, struct ensemble *ensemble,
                           struct error *error);
void noise_ensemble_free(struct ensemble *ensemble);
/* Statistics of a row over the paths that got there, in the order of paths; scratch [2 paths]. */
struct ensemble_row noise_ensemble_statistics(const struct ensemble *ensemble,
                                              const struct path_grid *grid, size_t row,
                                              double *scratch);
/* The mean of values [n] without NAN and its standard error. */
struct measured noise_mean_of(const double *value, size_t n);
