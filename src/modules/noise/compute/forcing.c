/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Binds a scene with its noise (noise_forcing_bind): damping, and strength of the noise from a
 * temperature or as stated. */
#include "modules/noise/compute/forcing.h"

#include <stdlib.h>
#include <string.h>

/* Relative difference of two dampings that are the same but for rounding. */
static const double damping_tolerance = 1e-9;
/* Number of states at which the damping is examined. */
enum { DAMPING_PROBES = 4 };

/* Fills y [n] with the start, its position moved by `shift` natural sizes and its velocity set to
 * `speed` natural sizes. */
static void probe_state(const struct system *system, double shift, double speed, double *y)
{
    const int half = system->n / 2;
    for (int i = 0; i < half; i++) {
        y[i] = system->start[i] + shift * (1 + 0.37 * i) * system->scale[i];
        y[half + i] = speed * (1 - 0.29 * i / half) * system->scale[half + i];
    }
}

/* Finds the damping rate of each coordinate, gamma [n/2], from the Jacobian at a few probe states.
 * Returns false if the damping depends on position or time, or couples coordinates, so that it is
 * not one rate per coordinate, or if out of memory. */
static bool linear_damping(const struct system *system, double *gamma)
{
    static const double shift[DAMPING_PROBES] = {0, 0.31, -0.47, 0.83};
    const int n = system->n, half = n / 2;
    bool linear = true;
    for (int probe = 0; probe < DAMPING_PROBES && linear; probe++) {
        double y[LIMIT_VARIABLES];
        probe_state(system, shift[probe], 0, y);
        const double t = system->t0 + 0.7 * probe;
        double *jacobian = system_new_jacobian(system, t, y);
        if (!jacobian)
            return false;
        for (int i = 0; i < half && linear; i++) {
            const double *row = jacobian + (half + i) * n + half;
            if (probe == 0)
                gamma[i] = -row[i] + 0.0;
            for (int j = 0; j < half; j++)
                linear = linear && fabs(-row[j] - (i == j ? gamma[i] : 0)) <=
                                       damping_tolerance * fabs(gamma[i]);
        }
        free(jacobian);
    }
    return linear;
}

/* Returns true if the drag of the scene differs from -gamma v at one of a few velocities, as
 * quadratic drag does. */
static bool has_other_drag(const struct system *system, const double *gamma)
{
    static const double speed[DAMPING_PROBES] = {0.4, -0.9, 1.7, -0.2};
    const int half = system->n / 2;
    for (int probe = 0; probe < DAMPING_PROBES && system->velocity; probe++) {
        double y[LIMIT_VARIABLES], drag[LIMIT_VARIABLES];
        probe_state(system, 0.3 * probe, speed[probe], y);
        system_drag(system, system->t0, y, drag);
        for (int i = 0; i < half; i++) {
            const double linear = gamma[i] * y[half + i];
            if (!(fabs(drag[i] + linear) <= damping_tolerance * fabs(linear)))
                return true;
        }
    }
    return false;
}

/* Sets the damping of each velocity: the scene's own or the stated one. Returns false with *error
 * if a temperature needs a damping that does not exist. */
static bool bind_damping(const struct noise_request *request, struct noise_forcing *forcing,
                         struct error *error)
{
    const struct system *system = &forcing->system;
    double scene_gamma[LIMIT_VARIABLES] = {0};
    const bool known = linear_damping(system, scene_gamma);
    const bool stated = !isnan(request->gamma);
    if (!known)
        memset(scene_gamma, 0, sizeof scene_gamma);
    if (!known && !stated && request->strengths == 0) {
        error_set(error, ERROR_COMMAND,
                  "the damping does not depend on the velocity alone, so no temperature can be "
                  "assigned to it");
        return error_hint(error, "gamma=V adds a damping with its own noise");
    }
    for (int i = 0; i < forcing->count; i++) {
        forcing->gamma[i] = stated ? request->gamma : scene_gamma[i];
        forcing->extra[i] = stated ? request->gamma - scene_gamma[i] : 0;
        if (request->strengths == 0 && !(forcing->gamma[i] > 0)) {
            error_set(error, ERROR_COMMAND, "a temperature needs damping, but that of %s is %g 1/s",
                      system_variable(system, i).name, forcing->gamma[i]);
            return error_hint(error, "gamma=V sets a damping, noise=V sets the noise directly");
        }
    }
    forcing->other_drag = has_other_drag(system, scene_gamma);
    return true;
}

/* Sets the strength of the noise on each variable, by the fluctuation-dissipation theorem if a
 * temperature is given. Returns false with *error if the number of stated strengths is wrong. */
static bool bind_strength(const struct noise_request *request, struct noise_forcing *forcing,
                          struct error *error)
{
    const struct system *system = &forcing->system;
    if (request->strengths > 1 && request->strengths != forcing->count)
        return error_set(
            error, ERROR_COMMAND, "noise= has %d values; give one, or %d (one for each %s)",
            request->strengths, forcing->count, system->order == 2 ? "velocity" : "variable");
    for (int i = 0; i < forcing->count; i++) {
        if (request->strengths > 0) {
            forcing->strength[i] = request->strength[request->strengths > 1 ? i : 0];
            continue;
        }
        const double mass = system->mass * (system->ratio[i] > 0 ? system->ratio[i] : 1);
        forcing->strength[i] = sqrt(2 * forcing->gamma[i] * request->energy / mass);
    }
    return true;
}

/* Binds the scene with the requested noise into *forcing. Noise acts on velocities in scenes of
 * second order, on all variables in others. Returns false with an error if the scene and the
 * request do not fit. */
bool noise_forcing_bind(const struct scene *scene, const struct noise_request *request,
                        struct noise_forcing *forcing, struct error *error)
{
    *forcing = (struct noise_forcing){.energy = request->energy};
    if (!scene_bind(scene, &forcing->system, error))
        return false;
    const struct system *system = &forcing->system;
    const bool second = system->order == 2;
    forcing->first = second ? system->n / 2 : 0;
    forcing->count = system->n - forcing->first;
    if (system->dry) {
        error_set(error, ERROR_COMMAND, "dry friction cannot be combined with noise");
        return error_hint(error, "friction = 0");
    }
    if (!second && request->strengths == 0) {
        error_set(error, ERROR_COMMAND,
                  "a temperature needs velocities, but the scene is of first order and has none");
        return error_hint(error, "noise=V sets the strength of the noise");
    }
    if (!second && !isnan(request->gamma))
        return error_set(error, ERROR_COMMAND,
                         "gamma= needs velocities, but the scene is of first order and has none");
    return (!second || bind_damping(request, forcing, error)) &&
           bind_strength(request, forcing, error);
}
