/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Declarations for the files of models. A new model needs a file model_NAME.c, and its name below
 * and in models.c.
 *
 * Its parameters are a macro PARAMS(P) with a line P(name, unit, quantity, default [SI], range,
 * brief) each. PARAM_PLACES derives the indices P_name from it, and PARAM_ROWS the table.
 */
#pragma once

#include <hooke/base/elementary.h>

#include <float.h>
#include <math.h>

#include <hooke/base/numeric.h>
#include <hooke/scene.h>

struct catalog;

extern const struct model pendulum_model, elastic_pendulum_model, kepler_model, henon_heiles_model,
    prothero_robinson_model, robertson_model, orego_model;

/* empty catalog, for models without derived quantities */
extern const struct catalog no_derived;

/* ---- parameters ---- */

#define UNBOUNDED_BELOW .min = -HUGE_VAL
#define AT_LEAST(limit) .min = (limit)
#define ABOVE(limit) .min = (limit), .min_excluded = true

#define PARAM_PLACE(name, ...) P_##name,
#define PARAM_PLACES(PARAMS) enum { PARAMS(PARAM_PLACE) P_COUNT }
#define PARAM_ROW(name, unit, kind, value, range, brief)                                           \
    {.row = {#name, (unit), (brief), "", NULL},                                                    \
     .quantity = QUANTITY_##kind,                                                                  \
     .initial = (value),                                                                           \
     range},

/* ---- derived quantities: rows as in derived.c, name(scene) gives the value ---- */

struct measured scene_propagate(const struct scene *scene, double (*value)(const struct scene *));
double scene_start_energy(const struct scene *scene); /* [J] */

#define MEASURED(name, ...)                                                                        \
    static struct measured name##_measured(const struct scene *scene)                              \
    {                                                                                              \
        return scene_propagate(scene, name);                                                       \
    }
#define DERIVED_ROW(name, unit, kind, brief, citation, back, param)                                \
    {{#name, unit, brief, citation, NULL}, QUANTITY_##kind, name##_measured, back, param},

/* Those of the oscillator for one whose equation was typed, but where the name is taken. Returns
 * false if out of memory. */
bool derived_for_typed(const struct model *model, struct arena *arena, struct catalog *derived);

/* ---- terms: not each needs all that a row's function is given ---- */

#define UNUSED __attribute__((__unused__))
#define TERM_BIND(name)                                                                            \
    static bool name##_bind(UNUSED const double *param, UNUSED double *c,                          \
                            UNUSED struct oscillator *oscillator)
#define TERM_ADD(name)                                                                             \
    static void name##_add(UNUSED const double *c, UNUSED double t, UNUSED const double *y,        \
                           double *a)
#define TERM_JACOBIAN(name)                                                                        \
    static void name##_jacobian(UNUSED const double *c, UNUSED double t, UNUSED const double *y,   \
                                double *jac)
#define TERM_POTENTIAL(name) static double name##_potential(const double *c, const double *y)

/* Natural sizes of one oscillator, with cubic y^3 [1/(m^2 s^2)] and van der Pol's force beside it.
 */
void oscillator_scale(struct system *system, double cubic, double mu, double width);

/* Its reciprocal is a finite number, as are those of sums of tolerances of it. */
#define SCALE_MIN 1e-290

/* A natural size that error norms can divide by. */
static inline double scale_clamp(double scale)
{
    if (!(scale > 0))
        return 1; /* nothing moves: any scale will do */
    return fmin(fmax(scale, SCALE_MIN), DBL_MAX);
}
