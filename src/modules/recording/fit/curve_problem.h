/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A curve and a series as a least-squares problem: what the fit and its judgement share. */
#pragma once

#include "modules/recording/fit/least_squares.h"
#include "modules/recording/series/internal.h"

struct curve_problem {
    const struct fit_curve *curve;
    struct least_squares model;
    int order[CURVE_PARAMETERS]; /* places in the curve of the model's parameters */
    const double *t, *y;
    size_t n;
    double unit[CURVE_PARAMETERS];
    double *value, *scratch, *weight, *residual; /* [n] */
    double *derivative;                          /* [n][parameters] */
    double point[CURVE_PARAMETERS]; /* the point that residuals and derivatives are those of */
    bool known;                     /* there is one */
    double size;                    /* length of y: rounding */
    double scale;                   /* robust standard deviation the weights were set with */
    bool robust, rough, costly;
    size_t stretch; /* see struct curve_options */
    const struct cancel *cancel;
};

/* Every sample counts alike. linear [parameters], or NULL: in which the curve is linear, all
 * together; those come first in the model. Returns false if out of memory or cancelled. */
bool curve_problem_init(struct curve_problem *problem, const struct fit_curve *curve,
                        const bool *linear, const struct series *series, struct arena *arena);
/* Sets the linear parameters in x [parameters], in the curve's order, to the best for the others.
 * Returns the sum of squares, NAN where there is none. */
double curve_solve_linears(struct curve_problem *problem, double *x);

enum { CURVE_MANY = 20000 }; /* samples from which on a start comes from a part of them */

/* Takes every so manieth of more than CURVE_MANY, else all of them. Returns false if out of memory.
 */
bool curve_part(const struct series *series, struct arena *arena, struct series *part);

/* ---- quality of an answer (judgement.c) ---- */

/* Fills values, covariance (not widened), what is determined, the two criteria, residual and rss.
 * If `probe` is true, it also evaluates one standard deviation to either side, which takes two
 * evaluations a parameter. */
void fit_judge(struct curve_problem *problem, const double *x, bool probe, struct curve_fit *fit);
/* Diagnostics of the residuals, widening, intervals, words. */
void fit_conclude(const struct curve_problem *problem, struct curve_fit *fit);

/* Intervals from fits to the fitted curve with new noise of the same size and autocorrelation. */
bool fit_bootstrap(const struct curve_problem *problem, const struct series *series,
                   const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
                   struct error *error);
