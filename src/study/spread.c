/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The uncertainty of a motion from that of its parameters. */
#include "scene_curve.h"

#include <math.h>
#include <string.h>

#define TOLERANCE 1e-10

static double quadratic(const double *slope, const double *covariance, int count)
{
    double sum = 0;
    for (int i = 0; i < count; i++)
        for (int j = 0; j < count; j++)
            sum += slope[i] * covariance[i * count + j] * slope[j];
    return sum;
}

/* Derivatives [n][count] along one motion. */
static bool slopes(struct scene_curve *c, const struct spread_request *request, double *value,
                   double *slope, struct error *error)
{
    const struct series series = {.t = request->t, .y = request->t, .n = request->n};
    double at[CURVE_PARAMETERS];
    for (int j = 0; j < c->frees; j++)
        at[j] = c->scene.value[c->place[j]];
    return scene_curve_mesh(c, at, &series, error) &&
           (scene_curve_evaluate(c, at, request->t, request->n, value, slope) ||
            (cancelled(request->cancel)
                 ? error_set(error, ERROR_CANCELLED, "it was stopped")
                 : error_set(error, ERROR_NUMERICAL,
                             "the motion has no derivatives by its parameters up to %g s",
                             request->t[request->n - 1])));
}

bool study_spread(const struct spread_request *request, struct arena *arena, double *deviation,
                  struct error *error)
{
    const size_t n = request->n, count = (size_t)request->count;
    struct scene_curve c = {.scene = *request->scene,
                            .frees = request->count,
                            .variable = request->variable,
                            .tol = TOLERANCE,
                            .cancel = request->cancel};
    struct system system;
    if (!scene_bind(&c.scene, &system, error))
        return false;
    if (request->count > CURVE_PARAMETERS || system.n * (request->count + 1) > LIMIT_VARIABLES)
        return error_set(error, ERROR_COMMAND,
                         "%d uncertain parameters are too many for this scene", request->count);
    double *value = arena_array(arena, n, sizeof *value),
           *slope = arena_array(arena, n * count, sizeof *slope);
    c.variation = arena_alloc(arena, sizeof *c.variation);
    if (!value || !slope || !c.variation)
        return error_memory(error);
    memcpy(c.place, request->place, count * sizeof *c.place);
    const bool ok = slopes(&c, request, value, slope, error);
    scene_curve_free(&c);
    for (size_t i = 0; i < n && ok; i++)
        deviation[i] =
            sqrt(fmax(quadratic(slope + i * count, request->covariance, request->count), 0));
    return ok;
}
