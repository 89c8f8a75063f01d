/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Least squares of the equation of motion in one pass over the samples, with a baseline that is
 * projected out block by block; nothing as long as the recording is stored. */
#pragma once

#include "modules/recording/series/internal.h"

struct cancel;

/* Largest number of terms of a baseline; smallest number of samples in a block. */
enum { BASELINE_TERMS = 3, BASELINE_MIN = 24 };

/* Model of the offset: a polynomial in each block of samples. */
struct baseline {
    size_t blocks;
    size_t *edge; /* [blocks + 1] first sample of each block, then n */
    int terms;    /* 1 for a constant, 2 for a line, 3 for a parabola */
};

/* The samples of a fit and the model of their offset. */
struct law_samples {
    const struct samples *samples;
    const unsigned char *use; /* [n] 1 for samples that take part */
    struct baseline baseline;
    double middle; /* value near the offset, subtracted to reduce rounding */
    const struct cancel *cancel;
};

/* Largest number of fitted parameters: all of the equation but the offset. */
enum { LAW_PARAMETERS = EQUATION_PARAMETERS - 1 };

/* A fit of one law: its free parameters, the motion, and the result. */
struct law_fit {
    int parameters;
    int index[LAW_PARAMETERS]; /* index in the equation of each free parameter */
    struct equation motion;    /* the start, then the answer; without the offset */
    double omega;              /* omega of the start; a motion far from it is rejected */
    bool converged;
    double rss;                                     /* sum of squares */
    size_t used;                                    /* number of samples that took part */
    double inverse[LAW_PARAMETERS][LAW_PARAMETERS]; /* (J^T J)^-1 */
};

/* Descends from the motion to the minimum (Marquardt 1963). A full step that promises to gain less
 * than `trust` variances is taken without evaluation, and is the last. `rounding` [y^2] is the
 * rounding of a sum of squares. Returns false if it has not converged. */
bool law_descend(const struct law_samples *x, double trust, double rounding, struct law_fit *fit);
/* Returns the sum of squares at the present motion, or NAN if it has no value. */
double law_squares(const struct law_samples *x, struct law_fit *fit);
/* Sets residual [n] to y minus motion and baseline for all samples, whether they take part or not.
 * level and slope [blocks], each may be NULL, receive the baseline in the middle of each block and
 * its slope [y/s]. Returns false if the motion cannot be integrated or if cancelled. */
bool law_residuals(const struct law_samples *x, const struct law_fit *fit, double *residual,
                   double *level, double *slope);
/* Returns the standard deviation of a parameter, by its index in the fit, for residuals of variance
 * 1. */
double law_formal(const struct law_fit *fit, int parameter);
