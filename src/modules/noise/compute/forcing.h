/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scene with noise, and the methods that step it: noise_forcing_bind(), noise_stepper_begin(),
 * then noise_stepper_step() for each step.
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

/* The noise as the user has stated it; NAN stands for what was not given. */
struct noise_request {
    double energy; /* [J] kB T */
    double gamma;  /* [1/s] linear damping, in place of the scene's own */
    double strength[LIMIT_VARIABLES];
    /* 0 if none was given, 1 if it is the same for every variable, else one for each */
    int strengths;
};

/* A bound scene with its noise. */
struct noise_forcing {
    struct system system;
    double energy;    /* [J] kB T; NAN means that strengths were given */
    int first, count; /* variables that noise acts on */
    /* [count] of second-order scenes: the whole linear damping, and its part that is not in the
     * scene [1/s] */
    double gamma[LIMIT_VARIABLES], extra[LIMIT_VARIABLES];
    double strength[LIMIT_VARIABLES]; /* [count] */
    /* True if some force depends on the velocity in another way than linear damping. */
    bool other_drag;
};

/*
 * Binds the scene and its noise. Returns false with `error` filled where the scene has no velocity
 * for a temperature, no damping of its own and none was stated, or where it cannot be stepped.
 */
bool noise_forcing_bind(const struct scene *scene, const struct noise_request *request,
                        struct noise_forcing *forcing, struct error *error);

struct noise_stepper;

/* A row of noise_method_catalog. */
struct noise_method {
    struct row row;
    bool needs_velocity;
    /* Takes y [n] from t to t + h; noise [count] holds the increments of the Wiener processes. */
    void (*step)(struct noise_stepper *stepper, double t, double *y, const double *noise);
};

extern const struct catalog noise_method_catalog; /* rows are struct noise_method */
/* Returns the method with that index in the catalog. */
const struct noise_method *noise_method_at(size_t index);
/* Returns BAOAB for scenes of second order and Heun's method for those of first order. */
const struct noise_method *noise_method_natural(const struct noise_forcing *forcing);

/* State of the method along one path. */
struct noise_stepper {
    const struct noise_forcing *forcing;
    const struct noise_method *method;
    double h;                                            /* [s] */
    double keep[LIMIT_VARIABLES], kick[LIMIT_VARIABLES]; /* exact damping over h, for BAOAB */
    bool warm;                                           /* `slope` belongs to the present state */
    double slope[LIMIT_VARIABLES], next[LIMIT_VARIABLES], predicted[LIMIT_VARIABLES];
};

/* Prepares steps of size h [s] with a method. */
void noise_stepper_begin(struct noise_stepper *stepper, const struct noise_forcing *forcing,
                         const struct noise_method *method, double h);
/* Advances y [n] from t by one step; noise [count] holds the increments of the Wiener processes.
 * Returns false if y is then not finite or out of range. */
bool noise_stepper_step(struct noise_stepper *stepper, double t, double *y, const double *noise);

/* Scenes with more variables than this have no step matrix. */
enum { GROWTH_VARIABLES = 16, GROWTH_MATRIX = GROWTH_VARIABLES * GROWTH_VARIABLES };

/* Computes the matrix m [n][n] of a step of a linear scene, which maps differences of states, in
 * natural sizes. */
void noise_step_matrix(struct noise_stepper *stepper, double *m);
/* Computes the covariance spread [n][n] that a step adds for Wiener increments of variance 1, in
 * natural sizes. */
void noise_step_spread(struct noise_stepper *stepper, double *spread);

/* Returns the logarithm of the factor by which a step h [s] of the method makes a linear scene grow
 * more than it does itself: at most 0 if the step is stable; NAN for scenes that are not linear or
 * have more than GROWTH_VARIABLES. */
double noise_stepper_excess_growth(const struct noise_forcing *forcing,
                                   const struct noise_method *method, double h);
/* Returns the largest step [s] up to h with which this excess growth is at most rate_max [1/s], or
 * 0 if there is none. */
double noise_stepper_stable_limit(const struct noise_forcing *forcing,
                                  const struct noise_method *method, double h, double rate_max);
