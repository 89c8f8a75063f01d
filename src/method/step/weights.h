/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Weights of explicit Runge-Kutta methods that the compiler does not know: those that are not 0 are
 * picked once for all steps of one size. Sums have the order of rk_body.h, so that they give the
 * same bits.
 */
#pragma once

#include "method/step/step.h"

/* Most stages of an explicit Runge-Kutta method. */
enum { WEIGHT_STAGES = 16 };

/* The weights of a stage that are not 0, times h, and the stages that they multiply. */
struct weights {
    int count, stage[WEIGHT_STAGES];
    double weight[WEIGHT_STAGES];
};

/* Picks the weights w [count] that are not 0. */
static inline void weights_take(struct weights *weights, const double *w, int count, double h)
{
    weights->count = 0;
    for (int j = 0; j < count; j++)
        if (w[j] != 0) {
            weights->stage[weights->count] = j;
            weights->weight[weights->count++] = h * w[j];
        }
}

/* Fills weights [stages]: number 0 for the new state, the others for the stages from the second
 * on. */
static inline void stages_take(struct weights *weights, const struct tableau *tableau, double h)
{
    weights_take(&weights[0], tableau->b, tableau->stages, h);
    for (int s = 1; s < tableau->stages; s++)
        weights_take(&weights[s], tableau_row(tableau, s), s, h);
}
