/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Equilibria and periodic orbits as curve problems. */
#pragma once

#include "modules/dynamics/orbits/multipliers.h"

/* Tests of the two kinds of curves, and what their zeros are. */
enum equilibrium_test { EQUILIBRIUM_FOLD, EQUILIBRIUM_CROSSING, EQUILIBRIUM_HOPF };
enum orbit_test { ORBIT_FOLD, ORBIT_CROSSING, ORBIT_DOUBLING, ORBIT_TORUS };

struct equilibrium_curve {
    struct vector_field *field;
    double psize; /* unit of the parameter */
    struct curve_problem problem;
};

/* Sets up the problem in which the field's first free parameter varies. `psize` is its range. */
void equilibrium_curve_init(struct equilibrium_curve *curve, struct vector_field *field,
                            double psize);

struct orbit_curve {
    struct vector_field *field;
    int segments;
    /* Segment i begins at fixed[i] [s] plus share[i] of the period; the last one ends at 0 and
     * 1. */
    double fixed[CURVE_MAX], share[CURVE_MAX];
    bool forced;
    int multiple; /* number of drive periods in the period */
    double drive; /* [s] period of the drive, or 0 if the parameter changes it */
    double psize, tsize;
    int winding[FIELD_VARIABLES];      /* turns of angles in a period */
    double reference[FIELD_VARIABLES]; /* a state on the orbit, in units of size */
    /* Direction of motion there; the orbit's start lies in the plane across it. */
    double normal[FIELD_VARIABLES];
    /* Map of each segment and rate at its start, in units of size, from the last residual. */
    double map[CURVE_MAX * FIELD_VARIABLES], rate[CURVE_MAX];
    double log_determinant;   /* logarithm of the determinant of the whole map */
    double growth[CURVE_MAX]; /* largest entry of the map of each segment */
    struct curve_problem problem;
};

/* Starts at this state [SI], with the period [s] where it is not the drive's. `multiple` periods of
 * the drive. Returns false if the motion does not come that far. */
bool orbit_curve_init(struct orbit_curve *curve, struct vector_field *field, double psize,
                      const double *state, double period, int multiple);
/* The states of a segment, grid [FIELD_TIMES][n], from time *t on over *span [s]; false if the
 * motion does not get there. */
bool orbit_curve_follow(const struct orbit_curve *curve, const double *u, int segment, double *t,
                        double *span, double *grid);
/* Unknowns of the orbit that starts there, at the field's present parameter. */
bool orbit_curve_unknowns(struct orbit_curve *curve, const double *state, double period, double *u);
/* Fixes the phase by this orbit from here on. `tangent` there is converted to orbits of this phase;
 * NULL if there is none. */
void orbit_curve_refer(struct orbit_curve *curve, const double *u, double *tangent);
/* Returns the cosine between the motion of the orbit examined last and the reference: 1 at first,
 * and negative where the orbit has shrunk to an equilibrium and grows again on the other side, half
 * a period later. Returns 1 if driven. */
double orbit_curve_upright(const struct orbit_curve *curve);
/* Redistributes the change of the period to the segments in which the motion is slow, so that
 * nothing else moves along the orbit, and converts `direction` at u to the new unknowns. Only for
 * autonomous orbits. Returns false if they are unchanged. */
bool orbit_curve_stretch(struct orbit_curve *curve, const double *u, double *direction);
/* orbit_curve_is_long() returns true if shorter segments are needed. orbit_curve_cut() halves those
 * in which differences grow too much, converts u and a direction there to the new unknowns, and
 * returns false if it cannot. */
bool orbit_curve_is_long(const struct orbit_curve *curve);
bool orbit_curve_cut(struct orbit_curve *curve, double *u, double *direction);
/* Returns the period [s]. */
double orbit_curve_period(const struct orbit_curve *curve, const double *u);
/* Computes the multipliers from the maps of the last residual. Returns false if no eigenvalues are
 * found. */
bool orbit_curve_multipliers(const struct orbit_curve *curve, struct multipliers *multipliers);
/* The map over the whole orbit [n][n], where it is not too far from 1. */
void orbit_curve_map(const struct orbit_curve *curve, double *map);

/* 2 J x 1 in the space of pairs i < j [n (n - 1)/2]^2: its eigenvalues are sums of two of J's
 * (Govaerts 2000, 4.4). */
void matrix_pair_sums(int n, const double *jacobian, double *pairs);
