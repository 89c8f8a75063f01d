/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sums of damped sines: y = c + d s + sum of exp(-gamma s/2) (a cos(omega s) + b sin(omega s)), s =
 * t - origin. modes_search() finds starts with an increasing number of modes, modes_evidence()
 * tells how many are real, and series_modes() (fit.h) fits them. */
#pragma once

#include "modules/recording/series/internal.h"

struct cancel;

enum {
    /* Indices of c, d, and of the first mode's parameters. */
    MODES_OFFSET,
    MODES_SLOPE,
    MODES_FIRST
};
/* Order of a mode's parameters. */
enum { MODE_OMEGA, MODE_GAMMA, MODE_A, MODE_B, MODE_PARAMETERS };

/* A sum of modes as a curve that curve_fit() can fit. */
struct mode_curve {
    int modes;
    double origin; /* [s] time from which s counts */
    const struct cancel *cancel;
    struct fit_curve curve;
    bool linear[CURVE_PARAMETERS]; /* parameters in which the sum is linear */
};

/* Initialises the curve. The structure is the context of its fit_curve and must not be moved. */
void mode_curve_init(struct mode_curve *curve, int modes, const struct series *series);

/* Best fit found with a certain number of modes. */
struct mode_start {
    double value[CURVE_PARAMETERS]; /* parameters of the sum */
    double rss;                     /* sum of squares of the residuals */
    double autocorrelation;         /* lag 1 of the residuals */
};

/* Searches up to `modes` modes, one after the other, in `x` or, if there are many samples, in
 * averages of neighbours. start [modes + 1]: start[k] becomes the best fit found with k modes,
 * start[0] the straight line. Sets *samples to the number of samples used. A quick search only
 * finds whether several modes contribute most of the motion. Returns the number of modes found, or
 * -1 if out of memory or cancelled. */
int modes_search(const struct samples *x, int modes, bool quick, const struct cancel *cancel,
                 struct mode_start *start, double *samples);
/* Returns by how much BIC prefers k modes to k - 1, with a penalty for choosing the frequency among
 * n/2 (Bonferroni). Correlated residuals count as fewer samples; the correlation is that with all
 * `found` modes, because a missing mode correlates residuals, too. */
double modes_evidence(const struct mode_start *start, int k, int found, double samples);
