/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Natural sizes of what a typed scene moves: the largest |value| at the start and on a short trial
 * run, by Heun's method with the step that Euler's allows. It goes over about a period or time
 * constant, as far as the Jacobian at the start knows it, and ends early where it meets something
 * faster. Where that is a pole, sizes are those of the first half of the way to it: near the pole
 * they have no limit. What grows away is of the size it has after one time constant: a run may be
 * short, and then nothing in it is of any later size. What a linear system with constant
 * coefficients reaches is known without a trial.
 */
#include <hooke/base/elementary.h>

#include <string.h>

#include "scene/model/exact.h"
#include "scene/model/model.h"
#include "scene/typed/typed.h"

#define TRIAL_STEPS_MAX 200
#define TRIAL_TIME_CONSTANTS 8.0 /* Length of the trial run in time constants. */
#define TRIAL_FIRST_STEP 1e-6    /* First step of the trial run as a part of its span. */
/* Error allowed in a step, relative to the largest values so far. */
#define TRIAL_TOLERANCE 0.02
#define POWER_ITERATIONS 16 /* Number of applications of the Jacobian. */
/* Steps that have become as short as this part of the elapsed time lead to a pole. */
#define POLE_STEP_RELATIVE 1e-6
/* A variable that stays below this part of the largest size in the trial has not been reached. */
#define UNREACHED_SIZE_MAX 1e-20
/* Size that an unreached variable gets, because a size of 0 makes every error infinite. */
#define UNREACHED_SIZE 1e-12

/* Returns |J^16 v|^(1/16), which is about the largest |eigenvalue| of the Jacobian at the start
 * [1/s]; 0 if nothing moves. */
static double fastest_rate(const struct system *system)
{
    const int n = system->n;
    double v[LIMIT_VARIABLES], w[LIMIT_VARIABLES], sum = 0, size = 1;
    double *jac = system_new_jacobian(system, system->t0, system->start);
    for (int i = 0; i < n; i++)
        v[i] = 1;
    for (int k = 0; jac && k < POWER_ITERATIONS && size > 0; k++) {
        size = 0;
        for (int i = 0; i < n; i++) {
            w[i] = 0;
            for (int j = 0; j < n; j++)
                w[i] += jac[i * n + j] * v[j];
            size = fmax(size, fabs(w[i]));
        }
        if (!isfinite(size))
            size = 0;
        for (int i = 0; i < n; i++)
            v[i] = w[i] / size;
        sum += fixed_log(size);
    }
    const double rate = jac && size > 0 ? fixed_exp(sum / POWER_ITERATIONS) : 0;
    free(jac);
    return rate;
}

static bool all_finite(const double *y, int n)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(y[i]))
            return false;
    return true;
}

/* Returns true if the sizes have outgrown those after one time constant, `early`. */
static bool grown(int n, const double *early, const double *max)
{
    double then = 0, now = 0;
    for (int i = 0; i < n; i++) {
        then = fmax(then, early[i]);
        now = fmax(now, max[i]);
    }
    return then > 0 && now > TRANSIENT_GROWTH_MAX * then;
}

/*
 * Runs a trial from the start over `span`, and raises max [n] to the largest values on the way. If
 * the motion grows far beyond its early values, max has only these. Returns the time [s] after the
 * start at which steps became shorter and shorter, or 0 if there is no such pole. Sets *there to
 * true if the trial reached the end or grew so, else to false.
 */
static double try_out(const struct system *system, double span, double *max, bool *there)
{
    const int n = system->n;
    double y[LIMIT_VARIABLES], f[LIMIT_VARIABLES], g[LIMIT_VARIABLES], next[LIMIT_VARIABLES],
        early[LIMIT_VARIABLES];
    double t = system->t0, h = TRIAL_FIRST_STEP * span, end = t + span;
    memcpy(y, system->start, (size_t)n * sizeof *y);
    memcpy(early, max, (size_t)n * sizeof *early);
    system_derivative(system, t, y, f);
    for (int step = 0; step < TRIAL_STEPS_MAX && t < end && t + h > t; step++) {
        double error = 0;
        for (int i = 0; i < n; i++)
            next[i] = y[i] + h * f[i];
        system_derivative(system, t + h, next, g);
        for (int i = 0; i < n; i++) {
            if (max[i] > 0) /* else it has just left 0 */
                error = fmax(error, fabs(h * (g[i] - f[i]) / 2) / fmax(max[i], fabs(next[i])));
            next[i] = y[i] + h * (f[i] + g[i]) / 2;
        }
        if (!all_finite(next, n) || !(error <= 4 * TRIAL_TOLERANCE)) {
            h /= 4;
            continue;
        }
        t += h;
        memcpy(y, next, (size_t)n * sizeof *y);
        for (int i = 0; i < n; i++)
            max[i] = fmax(max[i], fabs(y[i]));
        if (t - system->t0 <= span / TRIAL_TIME_CONSTANTS) {
            memcpy(early, max, (size_t)n * sizeof *early);
        } else if (grown(n, early, max)) {
            memcpy(max, early, (size_t)n * sizeof *early);
            *there = true;
            return 0;
        }
        system_derivative(system, t, y, f);
        h *= fmin(2, 0.9 * sqrt(TRIAL_TOLERANCE / fmax(error, 1e-6)));
        h = fmin(h, span / 16);
    }
    *there = t >= end;
    return t < end && h < POLE_STEP_RELATIVE * (t - system->t0) ? t - system->t0 : 0;
}

/* Tries the scene with its switches frozen. A motion that sticks to a switch shakes about it in
 * ever shorter steps; sizes are then those on the branches of the start. */
static bool try_frozen(const struct system *system, double span, const double *start, double *max)
{
    struct system frozen;
    double branch[LIMIT_SWITCHES], size[LIMIT_VARIABLES];
    bool there = false;
    if (system->switches == 0)
        return false;
    system_branches(system, system->t0, system->start, branch);
    system_freeze(system, branch, &frozen);
    memcpy(size, start, (size_t)system->n * sizeof *size);
    if (try_out(&frozen, span, size, &there) > 0 || !there)
        return false;
    memcpy(max, size, (size_t)system->n * sizeof *size);
    return true;
}

/* Raises max [n] to the sizes of a trial run: up to its end, or with frozen switches if it does not
 * get there, or over half the way to a pole. */
static void try_sizes(const struct system *system, double span, double *max)
{
    double start[LIMIT_VARIABLES];
    bool there;
    memcpy(start, max, sizeof start);
    const double pole = try_out(system, span, max, &there);
    if (!there && try_frozen(system, span, start, max))
        return;
    if (pole > 0) {
        memcpy(max, start, sizeof start);
        try_out(system, pole / 2, max, &there);
    }
}

/* Gives variables that the trial did not reach, such as the far end of a chain, a small size. */
static void size_unseen(int n, double *max)
{
    double largest = 0;
    for (int i = 0; i < n; i++)
        largest = isfinite(max[i]) ? fmax(largest, max[i]) : largest;
    for (int i = 0; i < n; i++)
        if (!(max[i] >= UNREACHED_SIZE_MAX * largest))
            max[i] = UNREACHED_SIZE * largest;
}

/* Sets the start; all natural sizes are 1. */
void typed_start(const double *param, struct system *system)
{
    const struct typed *typed = system->model->typed;
    system->t0 = param[typed->t0];
    for (int i = 0; i < system->n; i++) {
        system->start[i] = param[typed->initial[i]];
        system->scale[i] = 1;
    }
}

/* Sets the start and the natural sizes: of an oscillator, by the exact solution, or by a trial
 * run. */
void typed_begin(const double *param, struct system *system)
{
    double max[LIMIT_VARIABLES];
    typed_start(param, system);
    for (int i = 0; i < system->n; i++)
        max[i] = fabs(system->start[i]);
    if (system->oscillator.whole) {
        oscillator_scale(system, 0, 0, 0);
        return;
    }
    const double rate = fastest_rate(system);
    if (linear_has_exact(system))
        linear_sizes(system, rate, max);
    else
        try_sizes(system, rate > 0 ? TRIAL_TIME_CONSTANTS / rate : 1, max);
    size_unseen(system->n, max);
    for (int i = 0; i < system->n; i++)
        system->scale[i] = scale_clamp(max[i]);
}
