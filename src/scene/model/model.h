/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Declarations for the files of models. A new model needs a file NAME.c, and its name below and in
 * models.c. Its parameters are a macro PARAMS(P) with a line P(name, unit, quantity, default [SI],
 * range, brief) each; PARAM_PLACES derives the indices P_name from it, and PARAM_ROWS the table. */
#pragma once

#include <hooke/base/elementary.h>

#include <float.h>
#include <math.h>

#include <hooke/base/numeric.h>
#include <hooke/scene.h>

struct catalog;

extern const struct model pendulum_model, elastic_pendulum_model, kepler_model, henon_heiles_model,
    prothero_robinson_model, robertson_model, orego_model;

/* An empty catalog, for models without derived quantities. */
extern const struct catalog no_derived;

/* ---- parameters ---- */

/* ranges of a parameter */
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

/* ---- derived quantities: rows as in derived.c, the function name(scene) gives the value ---- */

/* Returns a value that follows from the parameters, with the uncertainty that theirs give it. */
struct measured scene_propagate(const struct scene *scene, double (*value)(const struct scene *));
/* Returns the energy [J] at the start; NAN if the scene cannot be bound. */
double scene_start_energy(const struct scene *scene);

#define MEASURED(name, ...)                                                                        \
    static struct measured name##_measured(const struct scene *scene)                              \
    {                                                                                              \
        return scene_propagate(scene, name);                                                       \
    }
#define DERIVED_ROW(name, unit, kind, brief, citation, back, param)                                \
    {{#name, unit, brief, citation, NULL}, QUANTITY_##kind, name##_measured, back, param},

/* Sets *derived to the derived quantities of the oscillator, for a model of typed equations of one
 * coordinate, except those whose names the model uses. Returns false if out of memory. */
bool derived_for_typed(const struct model *model, struct arena *arena, struct catalog *derived);

/* ---- terms: heads of a row's functions, whose bodies need not use all arguments ---- */

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

/* Sets the natural sizes of an oscillator, with the force cubic y^3 [1/(m^2 s^2)] and van der Pol's
 * force, of coefficient mu [1/s] and width [m], beside those of system->oscillator. */
void oscillator_scale(struct system *system, double cubic, double mu, double width);

/* Smallest natural size: its reciprocal is finite, as are those of sums of tolerances of it. */
#define SCALE_MIN 1e-290

/* Returns a size near `scale` that error norms can divide by. */
static inline double scale_clamp(double scale)
{
    if (!(scale > 0))
        return 1; /* nothing moves, so that any size will do */
    return fmin(fmax(scale, SCALE_MIN), DBL_MAX);
}
