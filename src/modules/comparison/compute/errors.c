/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Errors of the states of a solve on the common grid, against a reference. */
#include "modules/comparison/compute/errors.h"

#include <math.h>

/* Returns the largest |a - b| over the scored variables, in units of amplitudes, or NAN. */
double grid_distance(const struct reference *reference, const double *a, const double *b)
{
    double max = 0;
    for (int i = 0; i < reference->scored; i++) {
        const double distance = fabs(a[i] - b[i]) / reference->amplitude[i];
        if (!(distance <= max)) /* NAN too */
            max = distance;
    }
    return max;
}

/* Amplitude and phase, as a turn of the plane (q - centre, v/omega) that grows with time. */
struct phase_turn {
    double size, angle;
};

/* Returns amplitude and phase of a state of the linear oscillator, around its resting position. */
static struct phase_turn oscillator_turn(const struct oscillator *o, const double *y)
{
    const double q = y[0] + o->gravity / o->stiffness, p = y[1] / sqrt(o->stiffness);
    return (struct phase_turn){hypot(q, p), atan2(-p, q)};
}

/* Returns the mechanical energy of a state. */
static double mechanical_energy(const struct system *system, const double *y)
{
    return system_kinetic(system, y) + system_potential(system, y);
}

/* Computes all errors of a solve from its states on the grid. */
void grid_errors(const struct system *system, const struct reference *reference, const double *grid,
                 struct study_errors *errors)
{
    const int n = system->n, last = STUDY_TIMES - 1;
    const struct oscillator *o = &system->oscillator;
    const bool turns = system->order == 2 && n == 2 && o->whole && o->stiffness > 0,
               mechanics = system->order == 2;
    const double start = mechanics ? mechanical_energy(system, system->start) : NAN;
    double max = 0, missing = 0, scale = 0, phase = turns ? 0 : NAN, amplitude = NAN;
    for (int k = 0; k <= last; k++) {
        const double *y = grid + k * n, *exact = reference->y + k * n;
        if (isnan(y[0]))
            continue;
        max = fmax(max, grid_distance(reference, y, exact));
        if (mechanics) {
            const double wanted = system->conservative ? start : mechanical_energy(system, exact);
            missing = fmax(missing, fabs(mechanical_energy(system, y) - wanted));
            scale = fmax(scale, fabs(wanted));
        }
        if (turns) {
            const struct phase_turn a = oscillator_turn(o, y), b = oscillator_turn(o, exact);
            /* A motion that has vanished has no phase. Otherwise the difference is followed across
             * +-pi. */
            if (a.size == 0 && b.size > 0)
                phase = NAN;
            phase += remainder(a.angle - b.angle - phase, 2 * 3.14159265358979323846);
            amplitude = b.size > 0 ? a.size / b.size - 1 : NAN;
        }
    }
    *errors = (struct study_errors){
        .max = max,
        .end = grid_distance(reference, grid + last * n, reference->y + last * n),
        .energy = mechanics && scale > 0 ? missing / scale : NAN,
        .phase = phase,
        .amplitude = amplitude};
}
