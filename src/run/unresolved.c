/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Forces that change in time faster than fixed steps look. Where a force repeats between the points
 * of a step, every stage sees the same value, and the run is one of another force (Shannon 1949,
 * Proc. IRE 37:10).
 */
#include <hooke/run/unresolved.h>
#include "run/private.h"

#include <math.h>

enum { LOOKS = 64, SHORTER = 40 };
/* Steps that are tried instead; no simple fraction, so that they are no multiple of a period. */
static const double SHORTER_BY = 0.37;

/* Sum over all rates of the squared difference of two derivatives, in units of their sizes. */
static double difference_squared(const struct system *system, const double *size, const double *a,
                                 const double *b)
{
    double sum = 0;
    for (int i = 0; i < system->n; i++)
        if (size[i] > 0)
            sum += (a[i] - b[i]) / size[i] * ((a[i] - b[i]) / size[i]);
    return sum;
}

/* Evaluates the derivatives of one state y at the beginning, middle and end of the step from t.
 * Fills parabola [n] with the value at theta of the parabola through them, and inside [n] with the
 * derivatives at theta. */
static void look_at_step(const struct system *system, const double *y, double t, double h,
                         double theta, double *parabola, double *inside)
{
    double f[3][LIMIT_VARIABLES];
    for (int k = 0; k < 3; k++)
        system_derivative(system, t + k * h / 2, y, f[k]);
    system_derivative(system, t + theta * h, y, inside);
    for (int i = 0; i < system->n; i++)
        parabola[i] = f[0][i] * (1 - theta) * (1 - 2 * theta) + f[1][i] * 4 * theta * (1 - theta) +
                      f[2][i] * theta * (2 * theta - 1);
}

/* Returns true if steps of h, looked at in LOOKS of them between t0 and the run's end, miss more
 * than this share of how the force changes in time. */
static bool misses_changes(const struct run *run, double h, double share)
{
    const struct system *system = &run->system;
    const double steps = floor((run->t - system->t0) / h);
    double parabola[LIMIT_VARIABLES], inside[2][LIMIT_VARIABLES], size[LIMIT_VARIABLES] = {0};
    double missed = 0, varies = 0;
    /* The first pass finds the sizes. */
    for (int k = 0; k < 2 * LOOKS; k++) {
        /* Irrational multiples spread over the run and over the step. */
        const int look = k % LOOKS, now = k & 1;
        const double t = system->t0 + floor(fmod((look + 0.5) * 0.618033988749895, 1) * steps) * h,
                     theta = fmod((look + 0.5) * 0.754877666246693, 1);
        look_at_step(system, system->start, t, h, theta, parabola, inside[now]);
        for (int i = 0; i < system->n; i++) {
            if (!isfinite(inside[now][i]) || !isfinite(parabola[i]))
                return false;
            size[i] = fmax(size[i], fmax(fabs(inside[now][i]), fabs(parabola[i])));
        }
        if (k < LOOKS)
            continue;
        missed += difference_squared(system, size, inside[now], parabola);
        varies += difference_squared(system, size, inside[now], inside[!now]);
    }
    /* Two independent values differ by sqrt 2 times what each varies by. */
    return varies > LOOKS * FORCE_VARIES_MIN * FORCE_VARIES_MIN &&
           missed > share * share * varies / 2;
}

bool run_force_unresolved(const struct run *run, double *dt)
{
    const struct system *system = &run->system;
    const double h = copysign(run->settings.dt, run->t - system->t0);
    *dt = NAN;
    if (run->plan.adaptive || run->steps < 1 || system->autonomous ||
        run->method->flags & METHOD_EXACT || method_meets_switches(run->method, system) ||
        !misses_changes(run, h, FORCE_MISSED_SHARE))
        return false;
    for (int k = 1; k <= SHORTER && isnan(*dt); k++)
        if (!misses_changes(run, h * pow(SHORTER_BY, k), FORCE_MISSED_SHARE / 10))
            *dt = fabs(h) * pow(SHORTER_BY, k);
    return true;
}
