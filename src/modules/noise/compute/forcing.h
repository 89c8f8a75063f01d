/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A scene with noise, and the methods that step it.
 *
 * Second order:  m v' = F(y, v, t) + sqrt(2 m gamma kB T) xi(t), y' = v (Langevin 1908), or
 *                v' = F/m + strength xi(t).
 * First order:   y' = f(y, t) + strength xi(t).
 * xi is white noise, <xi(t) xi(s)> = delta(t - s), independent for each variable. It does not
 * depend on the state, so that the readings of Ito and Stratonovich agree.
 */
#pragma once

#include <hooke/scene.h>

struct catalog;

/* User's statement about the noise; NAN means that it was not given. */
struct noise_request {
    double energy; /* [J] kB T */
    double gamma;  /* [1/s] linear damping, in place of the scene's own */
    double strength[LIMIT_VARIABLES];
    /* 0 if none was given, 1 if it is the same for every variable, else one for each */
    int strengths;
};

struct noise_forcing {
    struct system system;
    double energy;    /* [J] kB T; NAN means that strengths were given */
    int first, count; /* variables that noise acts on */
    /* [count] of second-order scenes: the whole linear damping, and its part that is not in the
     * scene [1/s] */
    double gamma[LIMIT_VARIABLES], extra[LIMIT_VARIABLES];
    double strength[LIMIT_VARIABLES]; /* [count] */
    /* Some force depends on velocity in another way than linear damping does. */
    bool other_drag;
};

/*
 * Binds the scene and its noise. Returns false with `error` filled where the scene has no velocity
 * for a temperature, no damping of its own and none was stated, or where it cannot be stepped.
 */
bool noise_forcing_bind(const struct scene *scene, const struct noise_request *request,
                        struct noise_forcing *forcing, struct error *error);

struct noise_stepper;

struct noise_method {
    struct row row;
    bool needs_velocity;
    /* Takes y [n] from t to t + h; noise [count] holds the increments of the Wiener processes. */
    void (*step)(struct noise_stepper *stepper, double t, double *y, const double *noise);
};

extern const struct catalog noise_method_catalog; /* rows are struct noise_method */
const struct noise_method *noise_method_at(size_t index);
/* Returns BAOAB for scenes of second order and Heun's method for those of first order. */
const struct noise_method *noise_method_natural(const struct noise_forcing *forcing);

/* Work memory of a path. */
struct noise_stepper {
    const struct noise_forcing *forcing;
    const struct noise_method *method;
    double h;                                            /* [s] */
    double keep[LIMIT_VARIABLES], kick[LIMIT_VARIABLES]; /* exact damping over h, for BAOAB */
    bool warm;                                           /* `slope` is that of the present state */
    double slope[LIMIT_VARIABLES], next[LIMIT_VARIABLES], predicted[LIMIT_VARIABLES];
};

void noise_stepper_begin(struct noise_stepper *stepper, const struct noise_forcing *forcing,
                         const struct noise_method *method, double h);
/* Steps y from t; returns false with y changed where it is no longer finite or out of range. */
bool noise_stepper_step(struct noise_stepper *stepper, double t, double *y, const double *noise);

/* Scenes of more variables have no matrices. */
enum { GROWTH_VARIABLES = 16, GROWTH_MATRIX = GROWTH_VARIABLES * GROWTH_VARIABLES };

/* Fills m [n][n] with what a step of a linear scene does to a difference of two states, and spread
 * [n][n] with the covariance that Wiener increments of variance 1 add, both in natural sizes. */
void noise_step_matrix(struct noise_stepper *stepper, double *m);
void noise_step_spread(struct noise_stepper *stepper, double *spread);

/*
 * Returns by how much a step h of the method makes a linear scene grow beyond what the scene does
 * itself, as the logarithm of the factor; <= 0 where it does not, NAN of scenes that are not linear
 * or have more than 16 variables.
 */
double noise_stepper_excess_growth(const struct noise_forcing *forcing,
                                   const struct noise_method *method, double h);
/* Returns the largest step [s] up to h by which it grows at most at that rate [1/s] beyond the
 * scene; 0 if there is none. */
double noise_stepper_stable_limit(const struct noise_forcing *forcing,
                                  const struct noise_method *method, double h, double rate_max);
