/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Least squares of the equation of motion in one pass over the samples, with a baseline that is
 * projected out block by block: nothing of the length of the recording is stored.
 */
#pragma once

#include "modules/recording/series/internal.h"

struct cancel;

enum { BASELINE_TERMS = 3, BASELINE_MIN = 24 }; /* samples in a block */

/* Model of the offset: a polynomial in each block of samples. */
struct baseline {
    size_t blocks;
    size_t *edge; /* [blocks + 1] samples */
    int terms;    /* 1 is a constant, 2 a line, 3 a parabola */
};

struct law_samples {
    const struct samples *samples;
    const unsigned char *use; /* [n] */
    struct baseline baseline;
    double middle; /* value near the offset, subtracted first to reduce rounding */
    const struct cancel *cancel;
};

enum { LAW_PARAMETERS = EQUATION_PARAMETERS - 1 }; /* all but the offset */

/* Parameters that are fitted: places among the equation's values. */
struct law_fit {
    int parameters;
    int index[LAW_PARAMETERS];
    struct equation motion; /* the start, then the answer; without the offset */
    double omega;           /* omega of the start: a result far from it is rejected */
    bool converged;
    double rss;
    size_t used;
    double inverse[LAW_PARAMETERS][LAW_PARAMETERS]; /* (J^T J)^-1 */
};

/*
 * Descends from the motion to the minimum (Marquardt 1963). A full step that promises less than
 * `trust` variances is taken without another look at the samples, and is the last. `rounding` [y^2]
 * is that of a sum of squares. Returns false if it has not converged.
 */
bool law_descend(const struct law_samples *x, double trust, double rounding, struct law_fit *fit);
/* Returns the sum of squares at the present motion, or NAN if it has no value. */
double law_squares(const struct law_samples *x, struct law_fit *fit);
/*
 * y less motion and baseline for all samples [n], whether they take part or not; level [blocks] of
 * the baseline in the middle of each block, and slope [y/s] there, or NULL.
 */
bool law_residuals(const struct law_samples *x, const struct law_fit *fit, double *residual,
                   double *level, double *slope);
/* Returns the standard deviation for residuals of variance 1; `parameter` is the index among the
 * fit's parameters. */
double law_formal(const struct law_fit *fit, int parameter);
