/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sums of damped sines: y = c + d s + sum of exp(-gamma s/2) (a cos(omega s) + b sin(omega s)), s =
 * t - origin. */
#pragma once

#include "modules/recording/series/internal.h"

struct cancel;

enum {
    /* places of c, d, and of the first mode's parameters */
    MODES_OFFSET,
    MODES_SLOPE,
    MODES_FIRST
};
enum { MODE_OMEGA, MODE_GAMMA, MODE_A, MODE_B, MODE_PARAMETERS };

struct mode_curve {
    int modes;
    double origin; /* [s] */
    const struct cancel *cancel;
    struct fit_curve curve;
    bool linear[CURVE_PARAMETERS];
};

/* The curve's context is the structure, which has to stay where it is. */
void mode_curve_init(struct mode_curve *curve, int modes, const struct series *series);

/* Result of a search for a number of modes. */
struct mode_start {
    double value[CURVE_PARAMETERS];
    double rss;
    double autocorrelation; /* lag 1 of the residuals */
};

/*
 * Searches for as many modes as `modes`, one after the other, in `x` or, if there are many samples,
 * in averages of neighbours. start[k] [modes + 1] becomes the best fit found with k of them,
 * start[0] the straight line; *samples becomes the number of samples used. A quick search finds
 * only whether several modes contribute most of the motion. Returns the number of modes found, or
 * -1 if out of memory or cancelled.
 */
int modes_search(const struct samples *x, int modes, bool quick, const struct cancel *cancel,
                 struct mode_start *start, double *samples);
/*
 * Returns by how much BIC prefers k modes to k - 1, the frequency being the best of n/2
 * (Bonferroni). Correlated residuals count as fewer: those with all `found` modes, since a mode
 * that is still missing correlates them, too.
 */
double modes_evidence(const struct mode_start *start, int k, int found, double samples);
