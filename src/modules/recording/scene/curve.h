/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The motion of a scene as a curve with parameters. */
#pragma once

#include "modules/recording/scene/linear.h"

struct cancel;

struct scene_curve {
    struct scene scene;
    int index[CURVE_PARAMETERS], frees; /* the curve's parameters; the offset comes after them */
    bool offset;
    int variable; /* content of the series: this state variable, */
    bool rate;    /* or its derivative */
    double tol;
    const struct method *method;
    struct linear_motion *linear; /* used in place of steps, or NULL; owned */
    double *mesh;                 /* [points] times of the steps' ends, ascending; owned */
    size_t points;
    double *work;                /* work memory of the method, for the variation; owned */
    struct variation *variation; /* motion and derivatives, bound by each evaluation; not owned */
    const struct cancel *cancel;
};

/* Destination of a curve. */
struct sampling {
    const double *t;
    size_t n;
    double offset, *value, *derivative; /* [n], [n][columns] or NULL */
    size_t columns;
};

/* Evaluates the samples from *i on that are at the start. Returns false if the start lies behind
 * one of them. */
bool scene_curve_first(const struct scene_curve *curve, const struct system *system,
                       const struct sampling *sampling, size_t *i);
/* Those within the step that began at `t_begin`, by its polynomials, and those at its end. `system`
 * of the step has the curve's variables first. */
void scene_curve_inside(const struct scene_curve *curve, const struct step *step,
                        const struct sampling *sampling, double t_begin, size_t *i);

/* Integrates along the mesh through the turning points and rests of dry friction (dry.c). `system`
 * is the curve's variation or its base; the base is left frozen. Returns false if a step failed or
 * if cancelled. */
bool scene_dry_march(const struct scene_curve *curve, const struct system *system,
                     const struct sampling *sampling);

void scene_curve_free(struct scene_curve *curve);
/* As struct fit_curve wants it, the curve being the context. */
bool scene_curve_evaluate(void *context, const double *parameter, const double *t, size_t n,
                          double *value, double *derivative);
/* Chooses the steps for these parameters, as far as the last sample: explicit unless these would be
 * very many; none where the scene is linear and the samples come at few different intervals. */
bool scene_curve_mesh(struct scene_curve *curve, const double *parameter,
                      const struct series *series, struct error *error);
