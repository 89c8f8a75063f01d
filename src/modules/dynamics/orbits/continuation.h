/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Curves of solutions: n equations in n + 1 unknowns, the last of which is the parameter, all of
 * them in units of their natural sizes. Pseudo-arclength (Keller 1977).
 */
#pragma once

#include "modules/dynamics/orbits/field.h"

#define CURVE_MAX 64 /* unknowns with the parameter */
#define CURVE_TESTS 4
#define CURVE_STEEP 1e-8  /* part of the parameter in a tangent that a step does not know, */
#define CURVE_LEVEL 1e-12 /* and that is rounding */

struct curve_problem {
    void *context;
    int n; /* equations */
    /* computes f [n] and its derivatives [n][n + 1]; returns false if there is no such point or if
     * cancelled */
    bool (*residual)(void *context, const double *u, double *f, double *jacobian);
    /*
     * Functions of a place on the curve that pass through 0 at special points [tests]: u, the
     * derivatives there and the tangent. Only their signs and zeros count.
     */
    void (*test)(void *context, const double *u, const double *jacobian, const double *tangent,
                 double *value);
    int tests;
    /* chooses whether residuals are exact to rounding or as a step along the curve needs; NULL if
     * they are always the same */
    void (*aim)(void *context, bool fine);
    unsigned singular; /* bits of tests whose zeros are places where two curves cross */
    struct curve_work *work;
};

/* Room for two matrices: too much for a stack. */
struct curve_work {
    double jacobian[CURVE_MAX * CURVE_MAX]; /* derivatives at the place examined last */
    double matrix[CURVE_MAX * CURVE_MAX];   /* overwritten by the solver */
};

struct curve_place {
    double u[CURVE_MAX], tangent[CURVE_MAX]; /* [n + 1]; the tangent has length 1 */
    double test[CURVE_TESTS];
    double residual; /* largest residual before the last correction */
    int corrections;
    bool careful; /* corrected to rounding, as the parameter hardly changes */
};

/*
 * Corrects a guess to the point where the curve meets the plane through the guess that is normal to
 * `direction` [n + 1]. The new tangent points the same way. `fine` corrects until only rounding is
 * left. Returns false if it does not converge.
 */
bool curve_correct(const struct curve_problem *problem, const double *guess,
                   const double *direction, bool fine, struct curve_place *point);
/* Computes the tangent at the place examined last, towards `direction`. Returns false if the
 * direction is across the curve. */
bool curve_tangent(const struct curve_problem *problem, const double *direction, double *tangent);
/* Finds the next point, `step` along the tangent and along the curvature since `previous` (NULL if
 * unknown), with its tests. Returns false if none is found. */
bool curve_step(const struct curve_problem *problem, const struct curve_place *previous,
                const struct curve_place *current, double step, struct curve_place *next);
/* The zero of a test between two points of the curve, where its signs differ, or at which it is 0;
 * where `tests` cross there the curve is singular. *uncertainty: half the width of what is
 * uncertain. */
bool curve_locate(const struct curve_problem *problem, const struct curve_place *a,
                  const struct curve_place *b, int test, struct curve_place *point,
                  double *uncertainty);
/* Finds the point in the plane across the chord from a to b, at that share of it. Returns false if
 * none was found. */
bool curve_between(const struct curve_problem *problem, const struct curve_place *a,
                   const struct curve_place *b, double share, struct curve_place *point);
/* A smooth function of the places of a curve; NAN where it is not known. */
typedef double curve_value(void *context, const struct curve_place *point);
/* Finds the zero of such a function between two points of the curve, where its signs differ, also
 * where the curve is singular; *uncertainty as curve_locate(). */
bool curve_find_zero(const struct curve_problem *problem, const struct curve_place *a,
                     const struct curve_place *b, curve_value *value, void *context,
                     struct curve_place *point, double *uncertainty);
/* The largest of [n] and 1: what has grown beyond its natural size is followed in longer steps. */
double curve_unit(int n, const double *u);
double curve_distance(int n, const double *a, const double *b);
