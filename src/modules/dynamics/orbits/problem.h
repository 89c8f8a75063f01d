/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Equilibria and periodic orbits as curve problems (continuation.h): their unknowns, residuals and
 * tests. */
#pragma once

#include "modules/dynamics/orbits/multipliers.h"

/* Indices of the tests of the two kinds of curves, named after the special points at their
 * zeros. */
enum equilibrium_test { EQUILIBRIUM_FOLD, EQUILIBRIUM_CROSSING, EQUILIBRIUM_HOPF };
enum orbit_test { ORBIT_FOLD, ORBIT_CROSSING, ORBIT_DOUBLING, ORBIT_TORUS };

/* The problem f(y, p) = 0 with unknowns y and p. */
struct equilibrium_curve {
    struct vector_field *field;
    double psize; /* unit of the parameter */
    struct curve_problem problem;
};

/* Sets up the problem in which the field's first free parameter varies, in units of `psize`. */
void equilibrium_curve_init(struct equilibrium_curve *curve, struct vector_field *field,
                            double psize);

/* The problem of a periodic orbit by multiple shooting: unknowns are the states at the beginning of
 * each segment, the period unless it is the drive's, and the parameter. */
struct orbit_curve {
    struct vector_field *field;
    int segments; /* number of segments */
    /* Segment i begins at fixed[i] [s] plus share[i] of the period; the last one ends at 0 and
     * 1. */
    double fixed[CURVE_MAX], share[CURVE_MAX];
    bool forced;                  /* the scene has a drive, which gives the period */
    int multiple;                 /* number of drive periods in the period */
    double drive;                 /* [s] period of the drive, or 0 if the parameter changes it */
    double psize, tsize;          /* units of the parameter and of the period */
    int winding[FIELD_VARIABLES]; /* turns of angles in a period */
    double reference[FIELD_VARIABLES]; /* a state on the orbit, in units of size */
    /* Direction of motion there; the orbit's start lies in the plane across it. */
    double normal[FIELD_VARIABLES];
    /* Map of each segment and rate at its start, in units of size, from the last residual. */
    double map[CURVE_MAX * FIELD_VARIABLES], rate[CURVE_MAX];
    double log_determinant;   /* logarithm of the determinant of the whole map */
    double growth[CURVE_MAX]; /* largest entry of the map of each segment */
    struct curve_problem problem;
};

/* Sets up the problem for an orbit near a state [SI] with a period [s], or with `multiple` periods
 * of the drive if there is one. psize is the unit of the parameter. Returns false if the motion
 * cannot be followed for that time. */
bool orbit_curve_init(struct orbit_curve *curve, struct vector_field *field, double psize,
                      const double *state, double period, int multiple);
/* Computes the states of a segment, grid [FIELD_TIMES][n], which begins at time *t and lasts *span
 * [s]. Returns false if the motion cannot be followed. */
bool orbit_curve_follow(const struct orbit_curve *curve, const double *u, int segment, double *t,
                        double *span, double *grid);
/* Computes the unknowns u of the orbit from a state [SI] at the field's present parameter. Returns
 * false if the motion cannot be followed. */
bool orbit_curve_unknowns(struct orbit_curve *curve, const double *state, double period, double *u);
/* Makes this orbit the reference that fixes the phase of those to come. `tangent`, unless NULL, is
 * converted to orbits of that phase. */
void orbit_curve_refer(struct orbit_curve *curve, const double *u, double *tangent);
/* Returns the cosine between the motion of the orbit examined last and the reference: 1 at first,
 * and negative where the orbit has shrunk to an equilibrium and grows again on the other side, half
 * a period later. Returns 1 if driven. */
double orbit_curve_upright(const struct orbit_curve *curve);
/* Lets a change of the period lengthen those segments in which the motion is slow, so that states
 * move along the orbit as little as possible, and converts `direction` at u to the new unknowns.
 * Only for autonomous orbits. Returns false if nothing has changed. */
bool orbit_curve_stretch(struct orbit_curve *curve, const double *u, double *direction);
/* Returns true if differences grow so much in some segment that shorter ones are needed and there
 * is room for them. */
bool orbit_curve_is_long(const struct orbit_curve *curve);
/* Halves those segments, and converts u and a direction there to the new unknowns. Returns false if
 * a flow cannot be followed. */
bool orbit_curve_cut(struct orbit_curve *curve, double *u, double *direction);
/* Returns the period [s]. */
double orbit_curve_period(const struct orbit_curve *curve, const double *u);
/* Computes the multipliers from the maps of the last residual. Returns false if no eigenvalues are
 * found. */
bool orbit_curve_multipliers(const struct orbit_curve *curve, struct multipliers *multipliers);
/* Computes the derivative of the flow over the whole orbit [n][n], in units of sizes, as the
 * product of the maps of the segments. Accurate only if differences do not grow too much. */
void orbit_curve_map(const struct orbit_curve *curve, double *map);

/* Computes the bialternate product 2 J x 1, a matrix of n (n - 1)/2 rows whose eigenvalues are the
 * sums of two eigenvalues of J (Govaerts 2000, 4.4); it is singular at a Hopf point. */
void matrix_pair_sums(int n, const double *jacobian, double *pairs);
