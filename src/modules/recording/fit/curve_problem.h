/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A curve (struct fit_curve) and a series as a least-squares problem. curve_fit.c makes and
 * minimises it, judgement.c computes uncertainties and diagnostics of the answer, bootstrap.c
 * repeats it with new noise. Order of calls: curve_problem_init(), a descent, fit_judge(),
 * fit_conclude(), and fit_bootstrap() if it is asked for. */
#pragma once

#include "modules/recording/fit/least_squares.h"
#include "modules/recording/series/internal.h"

struct curve_problem {
    const struct fit_curve *curve;
    struct least_squares model;
    int order[CURVE_PARAMETERS]; /* order[i]: index in the curve of the model's parameter i */
    /* Samples of the series [n]. The problem points to them and does not own them. */
    const double *t, *y;
    size_t n;
    /* Typical size of each parameter; within 1e-7 of it a parameter counts as being on its
     * bound. */
    double unit[CURVE_PARAMETERS];
    /* Values of the curve, work space, weights of the samples, and data minus curve, each [n]. */
    double *value, *scratch, *weight, *residual;
    double *derivative;             /* [n][parameters], in the curve's order */
    double point[CURVE_PARAMETERS]; /* parameters at which residual and derivative were evaluated */
    bool known;                     /* true if point, residual and derivative are set */
    double size;  /* Euclidean norm of y, which sets the size of rounding errors */
    double scale; /* robust standard deviation of the residuals for which the weights were set */
    /* Copied from struct curve_options, which explains them. */
    bool robust, rough, costly;
    size_t stretch; /* samples per stretch; see struct curve_options */
    const struct cancel *cancel;
};

/* Initialises the problem with equal weights; its arrays come from the arena. linear [parameters]
 * marks the parameters in which the curve is linear, all together; these come first in the model's
 * order. NULL means that none is known to be linear. Returns false if out of memory or
 * cancelled. */
bool curve_problem_init(struct curve_problem *problem, const struct fit_curve *curve,
                        const bool *linear, const struct series *series, struct arena *arena);
/* Sets the linear parameters in x [parameters], in the curve's order, to the least-squares values
 * for the given others. Returns the sum of squares, or NAN if the curve has no value there. */
double curve_solve_linears(struct curve_problem *problem, double *x);

/* Number of samples above which a fit first looks for its start in a thinned series. */
enum { CURVE_MANY = 20000 };

/* Sets *part to every k-th sample of a series with more than CURVE_MANY samples, so that at most
 * CURVE_MANY remain, else to the series itself. Returns false if out of memory. */
bool curve_part(const struct series *series, struct arena *arena, struct series *part);

/* ---- quality of an answer (judgement.c) ---- */

/* Fills, at the parameters x, the values, the covariance (not widened for correlated residuals),
 * which parameters are determined, the two criteria of convergence, the residuals and the sum of
 * squares. If `probe` is true, it also evaluates the curve one standard deviation to either side of
 * each parameter, at two evaluations a parameter. */
void fit_judge(struct curve_problem *problem, const double *x, bool probe, struct curve_fit *fit);
/* Completes a judged fit: diagnostics of the residuals, widened uncertainties, 95 % intervals, and
 * the verdict in words. */
void fit_conclude(const struct curve_problem *problem, struct curve_fit *fit);

/* Replaces the intervals by those of a parametric bootstrap: fits to the fitted curve with new
 * noise of the same size and autocorrelation. Returns false with the error if cancelled or out of
 * memory. */
bool fit_bootstrap(const struct curve_problem *problem, const struct series *series,
                   const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
                   struct error *error);
