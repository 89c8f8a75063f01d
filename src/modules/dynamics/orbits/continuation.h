/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Continuation of curves of solutions by pseudo-arclength (Keller 1977): n equations in n + 1
 * unknowns, the last of which is the parameter, all in units of their natural sizes. Fill in a
 * struct curve_problem, correct a guess with curve_correct(), then call curve_step() in turn, and
 * curve_locate() where a test changes its sign. */
#pragma once

#include "modules/dynamics/orbits/field.h"

#define CURVE_MAX 64      /* largest number of unknowns, including the parameter */
#define CURVE_TESTS 4     /* largest number of tests */
#define CURVE_STEEP 1e-8  /* parameter's part of a tangent that a normal step does not resolve */
#define CURVE_LEVEL 1e-12 /* parameter's part of a tangent that is rounding */

/* The equations of a curve and the tests for its special points. */
struct curve_problem {
    void *context;
    int n; /* number of equations */
    /* computes f [n] and its derivatives [n][n + 1]; returns false if there is no such point or if
     * cancelled */
    bool (*residual)(void *context, const double *u, double *f, double *jacobian);
    /* Computes value [tests]: functions of a place that pass through 0 at special points, from the
     * unknowns u, the derivatives there and the tangent. Only their signs and zeros matter. */
    void (*test)(void *context, const double *u, const double *jacobian, const double *tangent,
                 double *value);
    int tests;
    /* Chooses whether residuals are computed to rounding or as accurately as a step needs; NULL if
     * there is no choice. */
    void (*aim)(void *context, bool fine);
    unsigned singular; /* bits of tests whose zeros are places where two curves cross */
    struct curve_work *work;
};

/* Work memory: two matrices, which are too large for a stack. */
struct curve_work {
    double jacobian[CURVE_MAX * CURVE_MAX]; /* derivatives at the place examined last */
    double matrix[CURVE_MAX * CURVE_MAX];   /* overwritten by the solver */
};

/* A point of the curve. */
struct curve_place {
    double u[CURVE_MAX], tangent[CURVE_MAX]; /* [n + 1]; the tangent has length 1 */
    double test[CURVE_TESTS];
    double residual; /* largest residual before the last correction */
    int corrections;
    bool careful; /* corrected to rounding, since the parameter hardly changes there */
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
/* Finds the zero of a test between two points of the curve where its signs differ. Sets
 * *uncertainty to half of the width, as arclength, of the interval that holds it. Returns false if
 * it is not found. */
bool curve_locate(const struct curve_problem *problem, const struct curve_place *a,
                  const struct curve_place *b, int test, struct curve_place *point,
                  double *uncertainty);
/* Finds the point in the plane across the chord from a to b, at that share of it. Returns false if
 * none was found. */
bool curve_between(const struct curve_problem *problem, const struct curve_place *a,
                   const struct curve_place *b, double share, struct curve_place *point);
/* A smooth function of the points of a curve; NAN where it is unknown. */
typedef double curve_value(void *context, const struct curve_place *point);
/* Finds the zero of such a function between two points of the curve where its signs differ, even if
 * the curve is singular there. Sets *uncertainty, and returns, as curve_locate(). */
bool curve_find_zero(const struct curve_problem *problem, const struct curve_place *a,
                     const struct curve_place *b, curve_value *value, void *context,
                     struct curve_place *point, double *uncertainty);
/* Returns the largest magnitude in u [n], at least 1: steps are longer where the solution has grown
 * beyond its natural size. */
double curve_unit(int n, const double *u);
/* Returns the Euclidean distance of two points [n]. */
double curve_distance(int n, const double *a, const double *b);
