/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Explicit Runge-Kutta methods that the compiler does not know: the weights that are not 0, picked once for all steps
 * of one size. The sums are those of rk_body.h, in their order: the same bits.
 */
#ifndef HOOKE_METHOD_STEP_WEIGHTS_H
#define HOOKE_METHOD_STEP_WEIGHTS_H

#include "method/step/step.h"

enum { WEIGHT_STAGES = 16 };

/* The weights of a stage that are not 0, times h. */
struct shares {
    int count, stage[WEIGHT_STAGES];
    double share[WEIGHT_STAGES];
};

static inline void shares_take(struct shares *shares, const double *w, int count, double h)
{
    shares->count = 0;
    for (int j = 0; j < count; j++)
        if (w[j] != 0) {
            shares->stage[shares->count] = j;
            shares->share[shares->count++] = h * w[j];
        }
}

/* Of w - u; those that differ. */
static inline void shares_take_difference(struct shares *shares, const double *w, const double *u, int count)
{
    shares->count = 0;
    for (int j = 0; j < count; j++)
        if (w[j] != u[j]) {
            shares->stage[shares->count] = j;
            shares->share[shares->count++] = w[j] - u[j];
        }
}

/* shares [stages]: of the stages from the second on, [0]: of the step */
static inline void stages_take(struct shares *shares, const struct tableau *tableau, double h)
{
    shares_take(&shares[0], tableau->b, tableau->stages, h);
    for (int s = 1; s < tableau->stages; s++)
        shares_take(&shares[s], tableau_row(tableau, s), s, h);
}

#endif
