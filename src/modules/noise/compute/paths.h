/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Paths of a scene with noise: a single one, and ensembles of them with statistics.
 * noise_path_grid_make(), then noise_path_follow() or noise_ensemble_follow(). */
#pragma once

#include "modules/noise/compute/forcing.h"
#include <hooke/run/parallel.h>

#include <hooke/run.h>

struct cancel;

/* The times of a path: equal steps that end exactly at the end of the span, of which every
 * stride-th is recorded. */
struct path_grid {
    double t0, span, h; /* [s] */
    int64_t steps, stride;
    size_t rows; /* number of recorded states, with the start and the end */
};

enum { PATH_STEPS_MAX = 2000000000, PATH_ROWS_MAX = 1000000 };

/* Chooses steps of at most dt > 0 [s] over span > 0 [s], and at most `intervals` + 1 rows. Returns
 * false with *error if the method needs velocities that the scene does not have, if there are too
 * many steps, or if a step of a linear scene is unstable. */
bool noise_path_grid_make(const struct noise_forcing *forcing, const struct noise_method *method,
                          double span, double dt, size_t intervals, struct path_grid *grid,
                          struct error *error);
/* Returns the time [s] of a row. */
double noise_path_time(const struct path_grid *grid, size_t row);

/* Quantity computed from a state. */
struct path_column {
    /* The observable, or NULL for variable number `variable`; numbers from n on are quantities that
     * a typed scene observes. */
    const struct observable *observable;
    int variable;
    struct run *run; /* run of the same scene, at its start, or NULL if no observable needs one */
};

/* Returns the value of a column [SI] at time t [s] and state y. */
double noise_path_value(const struct noise_forcing *forcing, const struct path_column *column,
                        double t, const double *y);

/* Paths that are to be followed. */
struct path_request {
    const struct noise_forcing *forcing;
    const struct noise_method *method;
    struct path_grid grid;
    uint64_t seed;
    const struct cancel *cancel;
};

/* Follows path number `path`, which with the seed determines its noise, and calls row(), unless
 * NULL, for each row. y [n] becomes the state at the end. Returns the number of steps taken, less
 * than grid.steps if the path diverged or if cancelled. */
int64_t noise_path_follow(const struct path_request *request, uint64_t path, double *y,
                          void (*row)(void *context, size_t row, double t, const double *y),
                          void *context);

/* Follows paths 0 to paths - 1, whose ends are end [paths][n], again with half of each step on the
 * same Wiener path. distance [n] becomes the root mean square distance of both ends, in SI units.
 * Returns false if a path diverges or if cancelled. */
bool noise_path_half_step(const struct path_request *request, const double *end, int64_t paths,
                          double *distance);

/* Statistics of an ensemble at one time. */
struct ensemble_row {
    double t, mean, sd, low, lower, median, upper, high; /* SI; low, high: 5 % and 95 % */
    int64_t paths;                                       /* number of paths that reach this time */
    enum quantity quantity;                              /* quantity of the values, for tables */
};

/* The values of one column on many paths, freed by noise_ensemble_free(). */
struct ensemble {
    int64_t paths, diverged;
    size_t rows;
    double *value; /* [rows][paths] SI; NAN beyond divergence */
    double *end;   /* [paths][n] states at the end; NAN where it diverged */
};

/* Returns the memory that an ensemble takes [byte]. */
double noise_ensemble_bytes(const struct path_request *request, int64_t paths);
/* Follows all paths, over threads; the result does not depend on their number. Returns false with
 * *error if out of memory or cancelled. noise_ensemble_free() must be called in all cases. */
bool noise_ensemble_follow(const struct path_request *request, const struct path_column *column,
                           int64_t paths, struct parallel parallel, struct ensemble *ensemble,
                           struct error *error);
void noise_ensemble_free(struct ensemble *ensemble);
/* Returns the statistics of a row over the paths that reach it. scratch [2 paths] is
 * overwritten. */
struct ensemble_row noise_ensemble_statistics(const struct ensemble *ensemble,
                                              const struct path_grid *grid, size_t row,
                                              double *scratch);
/* Returns the mean of value [n], which must not contain NAN, with its standard error, NAN if n <
 * 2. */
struct measured noise_mean_of(const double *value, size_t n);
