/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits of a scene's equation of motion to a recording; a scene's parameters from the fit of an
 * oscillation; and the uncertainty of a motion that follows from that of its parameters. */
#pragma once

#include "modules/recording/fit/fit.h"
#include <hooke/run.h>

struct cancel;

/* ---- fit a scene: its equation of motion to a recording ----
 *
 * Integrated and fitted by sensitivities: y of the series is the first coordinate, its velocity or
 * its acceleration (by quantity), plus an offset. Any parameters may be free, within their ranges.
 */

/* A fit of a scene that is asked for. */
struct scene_fit_request {
    const struct scene *scene; /* held values, and the start of the search */
    const struct series *series;
    const int *free; /* [frees] indices of the free parameters */
    int frees;
    bool offset;   /* the offset of the series is a further unknown */
    bool robust;   /* see struct curve_options */
    int bootstrap; /* number of bootstrap samples, may be 0 */
    uint64_t seed; /* start of the bootstrap's random numbers */
    const struct cancel *cancel;
};

/* Result of a fit of a scene. */
struct scene_fit {
    /* Scene with the fitted values; t0 is the first sample if the whole start was free. */
    struct scene scene;
    /* Index in the scene of each parameter of the curve; -1 for the offset, the last one. */
    int index[CURVE_PARAMETERS];
    const char *name[CURVE_PARAMETERS]; /* names of these parameters */
    /* Its uncertainties include those of held values such as the mass. */
    struct curve_fit curve;
    const struct method *method; /* method that integrated the motion */
    size_t steps;                /* number of its steps */
};

/* Fits the scene with memory of the arena. Returns true if there is an answer; curve.converged and
 * curve.said then tell its quality, as with curve_fit(). Returns false with the error. */
bool study_fit_scene(const struct scene_fit_request *request, struct arena *arena,
                     struct scene_fit *fit, struct error *error);
/* Chooses the free parameters if the user names none: the start, and what a recording can determine
 * of the equation (k, gamma, C if there is such drag …). Returns their number. Parameters that the
 * user has given without an uncertainty are held, and listed in `fixed`. Both arrays have
 * [PARAM_MAX] elements. */
int scene_fit_usual(const struct scene *scene, int *index, int *fixed, int *fixed_count);

/* ---- values of a scene, a spring with a mass or a pendulum, from the fit of an oscillation
 * ---- */

/* Parameters of a scene that follow from a fit. */
enum adopted_value {
    ADOPTED_STIFFNESS,
    ADOPTED_CUBIC,
    ADOPTED_LINEAR,
    ADOPTED_QUADRATIC,
    ADOPTED_DRY,
    ADOPTED_POSITION, /* this and the following ones, except the length, describe the start */
    ADOPTED_VELOCITY,
    ADOPTED_LENGTH,
    ADOPTED_ANGLE,
    ADOPTED_TURNING,
    ADOPTED_VALUES
};

/* Computes the parameters k, k3, gamma … with which the scene moves as the fit does, at the scene's
 * mass, gravity and air. Uncertainties are those of the fit; those of k and of a length include
 * mass and gravity. The start is the state at the fit's t0 or, if at_rest, its amplitude at rest.
 * `n` is how often a position was differentiated to give the fitted quantity. */
void adopted_values(const struct scene *scene, const struct fit *fit, int n, bool at_rest,
                    struct measured value[ADOPTED_VALUES]);
/* Multiplies the fitted motion by a scale: converts a voltage [V] or a force [N] to a position [m,
 * rad]. */
void adopted_scale(struct fit *fit, double scale);
/* Returns the scale at which the fitted motion has the amplitude of the scene's; it may be 0. */
double adopted_scale_of(const struct scene *scene, const struct fit *fit);

/* Covariances of the uncertain parameters of a scene. */
struct scene_covariance {
    int index[CURVE_PARAMETERS], count; /* indices of the parameters, and their number */
    double covariance[CURVE_PARAMETERS * CURVE_PARAMETERS]; /* [count][count] SI */
};

/* Sets the covariances of the adopted values from those of the fit. The mass counts as exact,
 * because there is only one motion. `starts` is true if the scene also takes the start of the
 * fit. */
void adopted_motion(const struct scene *scene, const struct fit *fit, int n, bool at_rest,
                    bool starts, struct scene_covariance *adopted);
/* Sets the covariances of the scene from those of the parameters that were free in a fit of it. */
void adopted_free(const bool *is_free, const struct fit_covariance *covariance,
                  struct scene_covariance *adopted);

/* ---- spread: how uncertain a motion is, for what is known of its parameters ---- */

/* The motion whose uncertainty is asked for. */
struct spread_request {
    const struct scene *scene;
    const struct scene_covariance *known; /* covariances of its parameters */
    int variable;                         /* index of the variable in the state */
    const double *t;                      /* [n] [s] ascending, none before the start */
    size_t n;
    const struct cancel *cancel;
};

/* Computes the standard deviation [n] of the variable to first order: sqrt(s^T C s) with the
 * derivatives s by the parameters of the equation of motion, from variational equations (Bock
 * 1981), or from differences of two runs if the field jumps. The tolerance is 1e-10. Returns false
 * with the error. */
bool study_spread(const struct spread_request *request, struct arena *arena, double *deviation,
                  struct error *error);

/* Runs the scene from its start to `end` [s] with tolerance 1e-10, with rows dense enough for cubic
 * interpolation. Returns NULL if it does not reach the end. The caller destroys the run. */
struct run *study_run(const struct scene *scene, double end, const struct cancel *cancel);
