/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Changes a scene so that it starts at a given state. */
#include "modules/solving/compute/start.h"

#include <hooke/base/catalog.h>
#include <hooke/scene/poles.h>
#include <hooke/scene/typed.h>

#include <math.h>

/* Sets parameter i to a value without uncertainty, unless it has that value already. */
void scene_take_value(struct scene *scene, int i, double value)
{
    scene->chosen[i] = scene->chosen[i] || scene->value[i] != value;
    if (scene->value[i] != value)
        scene->uncertainty[i] = 0;
    scene->value[i] = value;
}

/* Returns the derivative of the initial value of variable i by a parameter, as a difference, or 0
 * if the parameter changes anything else, too (terms, mass, t0 or other initial values). */
static double start_slope(const struct scene *scene, const struct system *system, int param, int i)
{
    struct scene other = *scene;
    struct system moved;
    struct error ignored;
    const double increment = 0.125 * fmax(fabs(scene->value[param]), 1e-3);
    other.value[param] += scene->value[param] > 0 ? -increment : increment;
    if (!scene_bind_motion(&other, &moved, &ignored) || moved.terms != system->terms ||
        moved.mass != system->mass || moved.t0 != system->t0)
        return 0;
    for (int k = 0; k < system->terms; k++)
        if (!bound_term_equal(&system->term[k], &moved.term[k]))
            return 0;
    for (int k = 0; k < system->n; k++)
        if (k != i && moved.start[k] != system->start[k])
            return 0;
    return (moved.start[i] - system->start[i]) / (other.value[param] - scene->value[param]);
}

/* Makes a scene start at `state` [n] when its own start cannot be bound: takes the parameter values
 * that scene_bind_inside() finds for a region of this one point. Returns false with an error. */
static bool start_inside(struct scene *scene, const double *state, struct error *error)
{
    struct scene moved = *scene;
    struct system system;
    double box[LIMIT_VARIABLES][2];
    for (int i = 0; i < scene->model->n; i++)
        box[i][0] = box[i][1] = state[i];
    if (!scene_bind_inside(&moved, box, &system, error))
        return false;
    for (int i = 0; i < (int)scene_params(scene)->count; i++)
        scene_take_value(scene, i, moved.value[i]);
    return true;
}

/* Sets the parameters that are initial values so that the scene starts at that state [n]. Returns
 * false with an error, with some parameters possibly set. */
bool scene_start_at(struct scene *scene, const double *state, struct error *error)
{
    const struct scene original = *scene;
    struct system system;
    if (!scene_bind_motion(scene, &system, error))
        return start_inside(scene, state, error);
    for (int i = 0; i < system.n; i++) {
        const char *name = system_variable(&system, i).name;
        int param = -1;
        double slope = 0;
        while (slope == 0 && ++param < (int)scene_params(scene)->count)
            slope = start_slope(&original, &system, param, i);
        if (slope == 0)
            return error_set(error, ERROR_COMMAND, "no parameter sets the initial value of %s",
                             name);
        const double difference = state[i] - system.start[i];
        const struct measured value = {
            fabs(slope - 1) < 1e-6 ? state[i] : scene->value[param] + difference / slope, 0};
        if (difference != 0 && !scene_set(scene, param, value, error))
            return false;
    }
    return true;
}
