/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Least squares for any curve: what iteration and judgement share. */
#ifndef HOOKE_ANALYSIS_FIT_LEAST_SQUARES_H
#define HOOKE_ANALYSIS_FIT_LEAST_SQUARES_H

#include "analysis/internal.h"

struct problem {
    const struct fit_curve *curve;
    const double *t, *y, *low, *high;
    size_t n;
    /* of the change of variables at a bound: the start's distance from it */
    double unit[CURVE_PARAMETERS];
    double *value, *scratch, *weight; /* [n] */
    double *derivative;               /* [n][parameters] */
    double size;                      /* length of y: rounding */
    double scale;                     /* robust standard deviation the weights were set with */
    bool robust, rough, costly;
    size_t stretch; /* see struct curve_options */
    /* what judge() leaves: the full Gauss-Newton step from there, and its length relative to value
     * or uncertainty */
    double step[CURVE_PARAMETERS], length;
    double largest[CURVE_PARAMETERS]; /* of each column of the derivatives, by size */
    const struct cancel *cancel;
};

/* ---- bound.c ---- */

/* The parameter for the unbounded variable u, and its slope. */
double inside(const struct problem *p, int j, double u, double *slope);
/* The other way; a start on or beyond a bound is moved a little inside, where there is a slope. */
double outside(const struct problem *p, int j, double x);
/* Does it lie on a bound? inward: which way leads from there, 1 or -1. */
bool on_bound(const struct problem *p, int j, double x, double *inward);

/* ---- judgement.c: what an answer is worth ---- */

/* Fills values, covariance (not widened), what is determined, the two criteria, residual and rss;
 * probe: also look a standard deviation to either side, which takes two evaluations a parameter.
 * False: no memory. */
bool judge(struct problem *p, const double *x, bool probe, struct curve_fit *fit);
/* The Gauss-Newton step [parameters] for these residuals [n], with the present weights and the
 * derivatives that judge() left; nothing for parameters on their bounds. False: no memory. */
bool tangent_step(const struct problem *p, const struct curve_fit *fit, const double *residual,
                  double *step);
/* Diagnostics of the residuals, widening, intervals, words. */
void conclude(const struct problem *p, struct curve_fit *fit);
/* Intervals from fits to the fitted curve with new noise of the same size and autocorrelation. */
bool bootstrap(const struct problem *p, const struct series *series,
               const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
               struct error *error);

#endif
