/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The equation z = y + h f(t, z) of implicit methods: closed form for the oscillator, else damped Newton iteration. */
#include "step.h"

#include <float.h>

/* Halvings of an increment that does not bring the equation nearer to 0, and iterations before giving up. */
enum { HALVINGS = 8, ITERATIONS = 10 };

/* An increment this small (relative) that does not shrink any more is rounding, not failure. */
static const double STANDSTILL = 1e-10;

size_t newton_work(const struct method *method, int n)
{
    (void)method;
    return (size_t)n * (size_t)(n + 6);
}

/*
 * q' = q + h v', v' = v + h (F(q) - stiffness h v' - damping v' - quadratic |v'| v'): a scalar equation in v', because
 * the force that does not depend on velocity is linear in q.
 */
static enum step_status solve_oscillator(struct step *step, double t, double h, const double *y, double *z)
{
    const struct oscillator *o = &step->system->oscillator;
    double force;
    system_force(step->system, t, y, &force);
    step->cost.evals++;
    step->cost.solves++;
    double a = 1 + o->damping * h + o->stiffness * h * h, r = y[1] + h * force;
    if (!isfinite(a) || !isfinite(r))
        return STEP_NONFINITE;
    z[1] = drag_root(a, o->quadratic * h, r);
    z[0] = y[0] + h * z[1];
    return isfinite(z[1]) ? STEP_OK : STEP_NO_SOLUTION;
}

/* Solves a x = b in place (x replaces b): Gaussian elimination with partial pivoting. False: a is singular. */
static bool solve_linear(int n, double *a, double *b)
{
    for (int p = 0; p < n; p++) {
        int best = p;
        for (int i = p + 1; i < n; i++)
            if (fabs(a[i * n + p]) > fabs(a[best * n + p]))
                best = i;
        double pivot = a[best * n + p];
        if (pivot == 0 || !isfinite(pivot))
            return false;
        if (best != p) {
            for (int j = p; j < n; j++) {
                double swap = a[p * n + j];
                a[p * n + j] = a[best * n + j];
                a[best * n + j] = swap;
            }
            double swap = b[p];
            b[p] = b[best];
            b[best] = swap;
        }
        for (int i = p + 1; i < n; i++) {
            double factor = a[i * n + p] / pivot;
            for (int j = p + 1; j < n; j++)
                a[i * n + j] -= factor * a[p * n + j];
            b[i] -= factor * b[p];
        }
    }
    for (int i = n; i-- > 0;) {
        for (int j = i + 1; j < n; j++)
            b[i] -= a[i * n + j] * b[j];
        b[i] /= a[i * n + i];
    }
    return true;
}

/* Largest component, each measured by its natural size or its value. */
static double size_of(const struct system *system, const double *x, const double *z)
{
    double largest = 0;
    for (int i = 0; i < system->n; i++) {
        double size = fabs(x[i]) / fmax(system->scale[i], fabs(z[i]));
        if (!(size <= largest)) /* also NaN */
            largest = size;
    }
    return largest;
}

/* rest = y + h f(t, z) - z; returns its size */
static double residual(struct step *step, double t, double h, const double *y, const double *z, double *rest)
{
    system_derivative(step->system, t, z, rest);
    step->cost.evals++;
    for (int i = 0; i < step->system->n; i++)
        rest[i] = y[i] - z[i] + h * rest[i];
    return size_of(step->system, rest, z);
}

enum step_status implicit_euler_solve(struct step *step, double t, double h, const double *y, double *z, double *work)
{
    const struct system *system = step->system;
    int n = system->n;
    if (system->order == 2 && n == 2 && system->oscillator.whole)
        return solve_oscillator(step, t, h, y, z);

    double *jacobian = work, *increment = work + n * n, *trial = increment + n, *rest = trial + n, *next = rest + n;
    double last = HUGE_VAL;
    memcpy(z, y, (size_t)n * sizeof *z);
    double off = residual(step, t, h, y, z, rest);
    if (!isfinite(off))
        return STEP_NONFINITE;
    for (int iteration = 0; iteration < ITERATIONS; iteration++) {
        /* (1 - h J) increment = rest */
        system_jacobian(system, t, z, jacobian);
        step->cost.jacobians++;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                jacobian[i * n + j] = (i == j) - h * jacobian[i * n + j];
        memcpy(increment, rest, (size_t)n * sizeof *rest);
        step->cost.solves++;
        if (!solve_linear(n, jacobian, increment))
            return STEP_NO_SOLUTION;

        /* Until increments stop decreasing; a tolerance biases the rounding (Hairer, McLachlan, Razakarivony 2008). */
        double move = size_of(system, increment, z);
        if (move <= DBL_EPSILON / 2 || (move >= last && move <= STANDSTILL))
            return STEP_OK;
        last = move;

        double part = 1, off_next = HUGE_VAL;
        for (int halving = 0; halving <= HALVINGS; halving++, part /= 2) {
            for (int i = 0; i < n; i++)
                trial[i] = z[i] + part * increment[i];
            off_next = residual(step, t, h, y, trial, next);
            if (off_next < off || move <= STANDSTILL)
                break;
        }
        if (!(off_next < off || move <= STANDSTILL))
            return STEP_NO_SOLUTION;
        off = off_next;
        memcpy(z, trial, (size_t)n * sizeof *z);
        memcpy(rest, next, (size_t)n * sizeof *rest);
    }
    return last <= STANDSTILL ? STEP_OK : STEP_NO_SOLUTION;
}
