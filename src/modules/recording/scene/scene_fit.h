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
    const struct scene *scene; /* held values, and where the search begins */
    const struct series *series;
    const int *free; /* [frees] places of the parameters */
    int frees;
    bool offset;   /* of the series: one more unknown */
    bool robust;   /* see struct curve_options */
    int bootstrap; /* number of samples, may be 0 */
    uint64_t seed;
    const struct cancel *cancel;
};

struct scene_fit {
    /* with what was fitted; t0 is the first sample where the whole start was free */
    struct scene scene;
    /* index among the curve's parameters; -1 is the offset, the last */
    int index[CURVE_PARAMETERS];
    const char *name[CURVE_PARAMETERS]; /* of the same */
    struct curve_fit curve;             /* uncertainties with those of the held values (the mass) */
    const struct method *method;        /* that integrated it */
    size_t steps;
};

/* Returns true if there is an answer; curve.converged and curve.said then tell its quality, as with
 * curve_fit(). */
bool study_fit_scene(const struct scene_fit_request *request, struct arena *arena,
                     struct scene_fit *fit, struct error *error);
/*
 * What is free unless somebody says so: the start, and what a recording can tell of the equation
 * (k, gamma, C of a drag that is there …). Returns how many; those of them that the user has given
 * without an uncertainty are held instead. Both arrays [PARAM_MAX].
 */
int scene_fit_usual(const struct scene *scene, int *index, int *fixed, int *fixed_count);

/* ---- what the fit of an oscillation makes of a scene: a spring and a mass, or a pendulum ---- */

enum adopted_value {
    ADOPTED_STIFFNESS,
    ADOPTED_CUBIC,
    ADOPTED_LINEAR,
    ADOPTED_QUADRATIC,
    ADOPTED_DRY,
    ADOPTED_POSITION, /* from here on: how it starts */
    ADOPTED_VELOCITY,
    ADOPTED_LENGTH,
    ADOPTED_ANGLE,
    ADOPTED_TURNING,
    ADOPTED_VALUES
};

/*
 * The parameters k, k3, gamma … that move as the fit does, with the mass, gravity and air of the
 * scene; uncertainties are those of the fit, of k and of a length also those of mass and gravity.
 * At its t0, or at_rest at its amplitude; n: how often a position was differentiated to give what
 * was fitted.
 */
void adopted_values(const struct scene *scene, const struct fit *fit, int n, bool at_rest,
                    struct measured value[ADOPTED_VALUES]);
/* The fit of what is `scale` times as large: of a position [m, rad] from a voltage [V] or a force
 * [N]; and the scale with which its motion is as wide as the scene's, which may be 0. */
void adopted_scale(struct fit *fit, double scale);
double adopted_scale_of(const struct scene *scene, const struct fit *fit);

/* Covariances of what is uncertain in a scene. */
struct scene_covariance {
    int index[CURVE_PARAMETERS], count;                     /* of the parameters */
    double covariance[CURVE_PARAMETERS * CURVE_PARAMETERS]; /* [count][count] SI */
};

/* From those of the fit; the mass counts as exact, as it is one motion. starts: it starts as the
 * fit does. */
void adopted_motion(const struct scene *scene, const struct fit *fit, int n, bool at_rest,
                    bool starts, struct scene_covariance *adopted);
/* Sets the covariance of those that were free in a fit of the scene. */
void adopted_free(const bool *is_free, const struct fit_covariance *covariance,
                  struct scene_covariance *adopted);

/* ---- spread: how uncertain a motion is, for what is known of its parameters ---- */

struct spread_request {
    const struct scene *scene;
    const struct scene_covariance *known; /* of its parameters */
    int variable;                         /* of the state */
    const double *t;                      /* [n] [s] ascending, none before the start */
    size_t n;
    const struct cancel *cancel;
};

/*
 * Standard deviation [n] of the variable to first order: sqrt(s^T C s) with the derivatives s by
 * the parameters of the equation of motion, solved to 1e-10 whatever method a run has (variational
 * equations; Bock 1981). Where its field jumps they are differences of two runs.
 */
bool study_spread(const struct spread_request *request, struct arena *arena, double *deviation,
                  struct error *error);

/* The scene from its start to `end` [s] to 1e-10, in rows so dense that a cubic between them is as
 * good; NULL: it does not get there. */
struct run *study_run(const struct scene *scene, double end, const struct cancel *cancel);
