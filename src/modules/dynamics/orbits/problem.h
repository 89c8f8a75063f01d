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

/* The field's first free parameter varies; psize: its range. */
void equilibrium_curve_init(struct equilibrium_curve *curve, struct vector_field *field,
                            double psize);

struct orbit_curve {
    struct vector_field *field;
    int segments;
    /* each begins at fixed [s] and that share of the period; the last ends at 0 and 1 */
    double fixed[CURVE_MAX], share[CURVE_MAX];
    bool forced;
    int multiple; /* of the drive's period */
    double drive; /* [s] that period, where the parameter does not change it, or 0 if it does */
    double psize, tsize;
    int winding[FIELD_VARIABLES];      /* turns of angles in a period */
    double reference[FIELD_VARIABLES]; /* a state in units of size, and how it moves there: */
    double normal[FIELD_VARIABLES];    /* the orbit's start lies in the plane across */
    /* of the last residual: what each segment does, and how the orbit moves where it begins, in
     * units of size */
    double map[CURVE_MAX * FIELD_VARIABLES], rate[CURVE_MAX];
    double log_determinant;   /* of the map of the whole orbit */
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
/* From here on the phase is fixed by this orbit; the tangent there, NULL: there is none, goes on to
 * orbits of this phase. */
void orbit_curve_refer(struct orbit_curve *curve, const double *u, double *tangent);
/* How upright the orbit last looked at goes across that plane: 1, and below 0 where it has shrunk
 * to an equilibrium and grows again on the other side, half a period later. Forced: 1. */
double orbit_curve_upright(const struct orbit_curve *curve);
/* Where the motion slows down, that part of it takes what is added to the period, so that nothing
 * else moves along the orbit: `direction` at u becomes that of the new unknowns. False: they are as
 * they were. Autonomous. */
bool orbit_curve_stretch(struct orbit_curve *curve, const double *u, double *direction);
/* orbit_curve_is_long() returns true if shorter segments are needed. orbit_curve_cut() halves those
 * in which differences grow too much, converts u and a direction there to the new unknowns, and
 * returns false if it cannot. */
bool orbit_curve_is_long(const struct orbit_curve *curve);
bool orbit_curve_cut(struct orbit_curve *curve, double *u, double *direction);
double orbit_curve_period(const struct orbit_curve *curve, const double *u); /* [s] */
/* By the maps of the last residual. False: no eigenvalues are found. */
bool orbit_curve_multipliers(const struct orbit_curve *curve, struct multipliers *multipliers);
/* The map over the whole orbit [n][n], where it is not too far from 1. */
void orbit_curve_map(const struct orbit_curve *curve, double *map);

/* 2 J x 1 in the space of pairs i < j [n (n - 1)/2]^2: its eigenvalues are sums of two of J's
 * (Govaerts 2000, 4.4). */
void matrix_pair_sums(int n, const double *jacobian, double *pairs);
