/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Curves with their linear parameters projected out. */
#ifndef HOOKE_ANALYSIS_FIT_PROJECTION_H
#define HOOKE_ANALYSIS_FIT_PROJECTION_H

#include "analysis/internal.h"

struct projection {
    const struct fit_curve *curve; /* of all parameters */
    const struct series *series;
    int linear[CURVE_PARAMETERS], linears, other[CURVE_PARAMETERS], others;
    const char *name[CURVE_PARAMETERS]; /* of the others */
    double *value, *column;             /* [n] */
    double *derivative, *basis;         /* [n][parameters], [n][linears] */
};

/* linear [parameters]: in which of them the curve is linear, all together. False: no memory. */
bool projection_init(struct projection *v, const struct fit_curve *curve, const bool *linear,
                     const struct series *series, struct arena *arena);
/*
 * Sets the linear parameters in x [parameters] to the best for the others there. value [n] and
 * derivative [n][others] of the curve with them, or NULL. False: no finite values there, or linear
 * parameters that are not determined.
 */
bool project(struct projection *v, double *x, double *value, double *derivative, double *rss);
/* The same (the context) as struct fit_curve wants it: a curve of the other parameters alone. */
bool projection_evaluate(void *context, const double *parameter, const double *t, size_t n,
                         double *value, double *derivative);

#define CURVE_MANY 20000 /* samples from which on a start comes from a part of them */

/* Every so manieth of more than CURVE_MANY, else all of them. False: no memory. */
bool curve_part(const struct series *series, struct arena *arena, struct series *part);

#endif
