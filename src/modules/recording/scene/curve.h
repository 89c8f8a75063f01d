/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The motion of a scene as a curve with parameters, for curve_fit(). scene_curve_mesh() chooses the
 * steps, scene_curve_evaluate() then computes values and derivatives, scene_curve_free() frees the
 * memory. The other functions are shared by curve.c and dry.c. */
#pragma once

#include "modules/recording/scene/linear.h"

struct cancel;

/* A scene, the parameters of the curve, and the steps that were chosen. */
struct scene_curve {
    struct scene scene; /* values of the parameters that are not free */
    /* Indices in the scene of the curve's parameters; an offset comes after them. */
    int index[CURVE_PARAMETERS], frees;
    bool offset;
    /* The series shows this state variable or, if `rate`, its derivative by time. */
    int variable;
    bool rate;
    double tol;                  /* tolerance with which steps are chosen */
    const struct method *method; /* method of the steps */
    /* Used instead of steps for linear scenes, else NULL; owned. */
    struct linear_motion *linear;
    double *mesh; /* [points] ascending times of the steps' ends; owned */
    size_t points;
    double *work;                /* work memory of the method, for the variation; owned */
    struct variation *variation; /* motion and derivatives, bound by each evaluation; not owned */
    const struct cancel *cancel;
};

/* Times of the samples, and the arrays that receive the curve there. */
struct sampling {
    const double *t; /* [n] */
    size_t n;
    /* Added to all values; values [n]; derivatives [n][columns], or NULL. */
    double offset, *value, *derivative;
    size_t columns;
};

/* Stores the samples from *i on that are at the start. Returns false if a sample lies before it. */
bool scene_curve_first(const struct scene_curve *curve, const struct system *system,
                       const struct sampling *sampling, size_t *i);
/* Stores the samples, from *i on, within the step that began at `t_begin`, by its polynomials, and
 * those at its end. The system of the step has the curve's variables first. */
void scene_curve_inside(const struct scene_curve *curve, const struct step *step,
                        const struct sampling *sampling, double t_begin, size_t *i);

/* Integrates along the mesh through turning points and rests of dry friction (dry.c). `system` is
 * the curve's variation or its base; the base is left frozen on one side of the friction. Returns
 * false if a step failed or if cancelled. */
bool scene_dry_march(const struct scene_curve *curve, const struct system *system,
                     const struct sampling *sampling);

/* Frees what the curve owns. */
void scene_curve_free(struct scene_curve *curve);
/* Computes the curve, which is the context, in the form that struct fit_curve expects. */
bool scene_curve_evaluate(void *context, const double *parameter, const double *t, size_t n,
                          double *value, double *derivative);
/* Chooses the steps for these parameters, up to the last sample: of an explicit method, unless
 * these would be very many. A linear scene whose samples have few different intervals needs none.
 * Returns false with the error. */
bool scene_curve_mesh(struct scene_curve *curve, const double *parameter,
                      const struct series *series, struct error *error);
