/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The motion of a scene as a curve with parameters. */
#ifndef HOOKE_STUDY_SCENE_CURVE_H
#define HOOKE_STUDY_SCENE_CURVE_H

#include "scene_linear.h"

struct scene_curve {
    struct scene scene;
    int place[CURVE_PARAMETERS], frees; /* the curve's parameters; the offset comes after them */
    bool offset;
    int variable; /* what the series is: this state variable, */
    bool rate;    /* or its derivative */
    double tol;
    const struct method *method;
    struct linear_motion *linear; /* in place of steps; NULL: by steps; owned */
    double *mesh;                 /* [points] times of the steps' ends, ascending; owned */
    size_t points;
    double *work;                /* of the method, for the variation; owned */
    struct variation *variation; /* where it is bound */
    struct {
        double *value, *slope; /* [n] [n][parameters], owned */
        double at[CURVE_PARAMETERS];
        const double *t; /* [n] of which samples */
        size_t n;    /* 0: nothing is known */
        size_t room; /* samples */
    } last;          /* evaluation with derivatives */
    const struct cancel *cancel;
};

void scene_curve_free(struct scene_curve *curve);
/* As struct fit_curve wants it, the curve being the context. */
bool scene_curve_evaluate(void *context, const double *parameter, const double *t, size_t n, double *value,
                          double *derivative);
/* Chooses the steps for these parameters, as far as the last sample: explicit unless these would be very many; none
 * where the scene is linear and the samples come at few different intervals. */
bool scene_curve_mesh(struct scene_curve *curve, const double *parameter, const struct series *series,
                      struct error *error);

#endif
