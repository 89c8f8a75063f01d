/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A scene as a vector field with free parameters: rates, Jacobian, derivatives by parameters, and
 * the flow with its derivatives. Equilibria, orbits, branches and exponents are computed from
 * it. */
#pragma once

#include "modules/solving/compute/algebra.h"
#include "modules/solving/compute/solve.h"

#include "modules/dynamics/dynamics.h"

#include "modules/solving/compute/variation.h"

struct cancel;

/* Largest number of variables n: with n^2 derivatives by the start and n by each parameter they are
 * one system. */
#define FIELD_VARIABLES 7

#define MOST_FREE 2 /* largest number of free parameters */

/* The field, freed by field_free(). */
struct vector_field {
    struct scene scene;
    struct system system;         /* scene with its present parameters */
    int n;                        /* number of variables, at most FIELD_VARIABLES */
    int params, param[2];         /* free parameters, as indices of the scene's */
    double unit[2];               /* units of the free parameters: about their ranges */
    double size[FIELD_VARIABLES]; /* natural sizes of the variables, > 0 */
    double tol;                   /* relative tolerance of the integration, in natural sizes */
    double turn[FIELD_VARIABLES]; /* full turn of an angle, or 0 if it is no angle */
    struct variation *variation;  /* variational equations, or NULL until they are needed */
    bool varied;                  /* true if `variation` is that of the present parameters */
    /* Derivatives of the drive by the free parameters, or NAN if unknown. */
    double drive_by[2];
    bool stiff;    /* an explicit method needed too many steps, so that radau5 is used */
    int64_t evals; /* evaluations of right-hand sides and Jacobians so far */
    const struct cancel *cancel;
};

/* Prepares the field, of which up to two parameters may be free. Returns false with `error` filled
 * if there are too many variables or kinks. */
bool field_init(struct vector_field *field, const struct scene *scene, const int *param, int params,
                struct error *error);
void field_free(struct vector_field *field);
/* Sets the free parameters to value [params], SI. Returns false if the scene cannot have them. */
bool field_set(struct vector_field *field, const double *value);
/* Sets the scene's parameter with index `place` to a value, SI. Returns false if the scene cannot
 * have it. */
bool field_hold(struct vector_field *field, int place, double value);

/* Computes y' [n] at the field's t0. */
void field_rate(struct vector_field *field, const double *y, double *rate);
/* Computes the Jacobian [n][n] of y' by y at t0. */
void field_jacobian(struct vector_field *field, const double *y, double *jacobian);
/* Computes the derivative [n] of y' by free parameter j at t0, as a central difference. Returns
 * false if the scene cannot have the values on both sides. */
bool field_by_parameter(struct vector_field *field, int j, const double *y, double *slope);

/* Returns the period of the drive [s], 0 if nothing depends on time, or NAN if something does, but
 * not with one period. */
double field_drive(const struct vector_field *field);
/* Returns the derivative of that period by free parameter j [s per SI unit], or NAN if unknown. */
double field_drive_by(struct vector_field *field, int j);

/* Derivatives of the end of a flow by its start, in units of the variables' sizes. */
struct flow_slopes {
    double by_start[FIELD_VARIABLES * FIELD_VARIABLES];
    double log_determinant; /* logarithm of the determinant of by_start */
    /* Derivatives by each free parameter, at a fixed time. */
    double by_parameter[MOST_FREE][FIELD_VARIABLES];
};

/*
 * Computes the state `span` [s] after t in `end` [n], and its derivatives unless NULL. Returns
 * false if the solution does not get there or if cancelled.
 */
bool field_flow(struct vector_field *field, double t, const double *start, double span, double *end,
                struct flow_slopes *slopes);

/* Computes states at t + k span/256, k = 0 ... 256, to plotting accuracy (1e-10 of sizes). Fails as
 * the function above. */
#define FIELD_TIMES STUDY_TIMES
bool field_follow(struct vector_field *field, double t, const double *start, double span,
                  double *grid);

/* Returns y - x along variable i in units of its size; for angles the shorter way around. */
double field_apart(const struct vector_field *field, int i, const double *x, const double *y);
/* Returns the largest of these distances over all variables. */
double field_distance(const struct vector_field *field, const double *x, const double *y);

/* Finds the state [n] on the straight line from a to b that is nearest to y. */
void field_nearest_on_line(const struct vector_field *field, const double *y, const double *a,
                           const double *b, double *nearest);

/* A plane in state space; the normal is in units of the variables' sizes. */
struct field_plane {
    double origin[FIELD_VARIABLES], normal[FIELD_VARIABLES];
};

/* Makes the plane through a state across the motion there. */
void field_plane_across(struct vector_field *field, const double *state, struct field_plane *plane);
/* Returns the signed distance of y from the plane, times the length of the normal. */
double field_side(const struct vector_field *field, const struct field_plane *plane,
                  const double *y);
/* Returns the time [s] after t at which the motion from `start` crosses the plane; `start`, and
 * `end` after `span`, must be on different sides. Sets point [n] to the state there. Returns NAN if
 * the motion cannot be followed or if cancelled. */
double field_crossing(struct vector_field *field, double t, const double *start, double span,
                      const double *end, const struct field_plane *plane, double *point);

/* Returns true if the right-hand sides jump anywhere on the way from `start` over `span` [s], so
 * that derivatives of the flow do not predict differences. A kink, a jump of their slopes alone,
 * does not count. */
bool field_jumps(struct vector_field *field, double t, const double *start, double span);
