/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenes fitted to recordings, and what their uncertainty means. */
#pragma once

#include "modules/recording/fit/fit.h"
#include <hooke/run.h>

struct cancel;

/* ---- fit a scene: its equation of motion to a recording ----
 *
 * Integrated and fitted by sensitivities: y of the series is the first coordinate, its velocity or
 * its acceleration (by quantity), plus an offset. Any parameters may be free, within their ranges.
 */

struct scene_fit_request {
    const struct scene *scene; /* held values, and the start of the search */
    const struct series *series;
    const int *free; /* [frees] indices of the free parameters */
    int frees;
    bool offset;   /* true if the offset of the series is one more unknown */
    bool robust;   /* see struct curve_options */
    int bootstrap; /* number of samples, may be 0 */
    uint64_t seed;
    const struct cancel *cancel;
};

struct scene_fit {
    /* Scene with the fitted values; t0 is the first sample if the whole start was free. */
    struct scene scene;
    /* index among the curve's parameters; -1 is the offset, the last */
    int index[CURVE_PARAMETERS];
    const char *name[CURVE_PARAMETERS]; /* names of the same parameters */
    struct curve_fit curve;             /* uncertainties with those of the held values (the mass) */
    const struct method *method;        /* method that integrated it */
    size_t steps;
};

/* Returns true if there is an answer; curve.converged and curve.said then tell its quality, as with
 * curve_fit(). */
bool study_fit_scene(const struct scene_fit_request *request, struct arena *arena,
                     struct scene_fit *fit, struct error *error);
/*
 * Chooses the free parameters if the user names none: the start, and what a recording can tell of
 * the equation (k, gamma, C of a drag that is there …). Returns their number. Those that the user
 * has given without an uncertainty are held, and listed in `fixed`. Both arrays have [PARAM_MAX].
 */
int scene_fit_usual(const struct scene *scene, int *index, int *fixed, int *fixed_count);

/* ---- values of a scene, a spring with a mass or a pendulum, from the fit of an oscillation
 * ---- */

enum adopted_value {
    ADOPTED_STIFFNESS,
    ADOPTED_CUBIC,
    ADOPTED_LINEAR,
    ADOPTED_QUADRATIC,
    ADOPTED_DRY,
    ADOPTED_POSITION, /* this and the following describe the start */
    ADOPTED_VELOCITY,
    ADOPTED_LENGTH,
    ADOPTED_ANGLE,
    ADOPTED_TURNING,
    ADOPTED_VALUES
};

/*
 * Computes the parameters k, k3, gamma … with which the scene moves as the fit does, at the scene's
 * mass, gravity and air. Uncertainties are those of the fit; those of k and of a length include
 * mass and gravity. The start is that at the fit's t0, or at_rest that at its amplitude. `n` is how
 * often a position was differentiated to give the fitted quantity.
 */
void adopted_values(const struct scene *scene, const struct fit *fit, int n, bool at_rest,
                    struct measured value[ADOPTED_VALUES]);
/* Scales the fit: from a voltage [V] or a force [N] to a position [m, rad]. */
void adopted_scale(struct fit *fit, double scale);
/* Returns the scale at which the fitted motion is as wide as the scene's; it may be 0. */
double adopted_scale_of(const struct scene *scene, const struct fit *fit);

/* Covariances of what is uncertain in a scene. */
struct scene_covariance {
    int index[CURVE_PARAMETERS], count; /* indices of the parameters, and their number */
    double covariance[CURVE_PARAMETERS * CURVE_PARAMETERS]; /* [count][count] SI */
};

/* Sets the covariances from those of the fit. The mass counts as exact, as there is one motion.
 * `starts` is true if the scene starts as the fit does. */
void adopted_motion(const struct scene *scene, const struct fit *fit, int n, bool at_rest,
                    bool starts, struct scene_covariance *adopted);
/* Sets the covariances from those of the parameters that were free in a fit of the scene. */
void adopted_free(const bool *is_free, const struct fit_covariance *covariance,
                  struct scene_covariance *adopted);

/* ---- spread: how uncertain a motion is, for what is known of its parameters ---- */

struct spread_request {
    const struct scene *scene;
    const struct scene_covariance *known; /* covariances of its parameters */
    int variable;                         /* index of the variable in the state */
    const double *t;                      /* [n] [s] ascending, none before the start */
    size_t n;
    const struct cancel *cancel;
};

/*
 * Computes the standard deviation [n] of the variable to first order: sqrt(s^T C s) with the
 * derivatives s by the parameters of the equation of motion, solved to 1e-10 with any method of the
 * run (variational equations; Bock 1981). Where the field jumps, s are differences of two runs.
 */
bool study_spread(const struct spread_request *request, struct arena *arena, double *deviation,
                  struct error *error);

/* Runs the scene from its start to `end` [s] to 1e-10, with rows dense enough for a cubic between
 * them. Returns NULL if it does not reach the end. */
struct run *study_run(const struct scene *scene, double end, const struct cancel *cancel);
