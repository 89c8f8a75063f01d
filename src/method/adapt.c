/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Step-size control: one accepted step of a method with an error estimate.
 * Source: Hairer, Norsett, Wanner 1993, Solving ODEs I, II.4 (first step, PI control with the constants of DOPRI5).
 */
#include "step.h"

#include <assert.h>
#include <float.h>

#define BETA 0.04  /* weight of the error before */
#define SAFETY 0.9 /* aim below the tolerance */
#define SHRINK 0.2 /* limits of the change from one step to the next */
#define GROW 10.0
#define STRETCH 1.01    /* a last step may be this much longer, so that no sliver remains */
#define FAILURES 20     /* steps in a row that give no number: each makes the next a quarter */
#define LEAST_ULPS 16   /* of t: a smaller step is only rounding */
#define MEMORY (1. / 8) /* share of the newest estimate in the smoothed stiffness */

/* RMS of x_i / (tol max(scale_i, |y_i|, |z_i|)) */
static double norm(const struct system *system, double tol, const double *x, const double *y, const double *z)
{
    double sum = 0;
    for (int i = 0; i < system->n; i++) {
        double ratio = x[i] / (tol * fmax(system->scale[i], fmax(fabs(y[i]), fabs(z[i]))));
        sum += ratio * ratio;
    }
    return sqrt(sum / system->n);
}

/* A first step by the size of the first and second derivative (II.4, algorithm of Gladwell, Shampine, Brankin 1987). */
static double first_step(struct step *step, double tol, int order, double span)
{
    const struct system *system = step->system;
    int n = system->n;
    const double *y = step->y;
    double f0[LIMIT_VARIABLES], f1[LIMIT_VARIABLES], z[LIMIT_VARIABLES];
    double natural = system->order == 2 ? system->scale[0] / system->scale[n / 2] : 1; /* [s] */
    double cautious = 1e-3 * fmin(natural, fabs(span)); /* where the derivatives say nothing */
    system_derivative(system, step->t, y, f0);
    step->cost.evals++;
    double size = norm(system, tol, y, y, y), slope = norm(system, tol, f0, y, y);
    double h = size < 1e-5 || slope < 1e-5 ? cautious : 0.01 * (size / slope);
    h = copysign(fmin(h, fabs(span)), span);

    for (int i = 0; i < n; i++)
        z[i] = y[i] + h * f0[i];
    system_derivative(system, step->t + h, z, f1);
    step->cost.evals++;
    for (int i = 0; i < n; i++)
        f1[i] -= f0[i];
    double fastest = fmax(slope, norm(system, tol, f1, y, y) / fabs(h));
    double best = fastest > 1e-15 ? pow(0.01 / fastest, 1.0 / (order + 1)) : cautious;
    best = fmin(100 * fabs(h), fmin(best, fabs(span)));
    return copysign(isfinite(best) && best > 0 ? best : cautious, span);
}

static double least_step(double t)
{
    return LEAST_ULPS * (nextafter(fabs(t), HUGE_VAL) - fabs(t));
}

/* Takes back a step whose error is too large. */
static void take_back(struct step *step, double t, const double *y)
{
    memcpy(step->y, y, (size_t)step->system->n * sizeof *y);
    step->t = t;
    step->warm = false;
}

static void note_stiffness(const struct method *method, const struct step *step, struct controller *controller)
{
    double estimate = rk_stiffness(method, step);
    if (isfinite(estimate))
        controller->stiffness += MEMORY * (estimate - controller->stiffness);
}

enum step_status method_adapt(const struct method *method, struct step *step, struct controller *controller,
                              double t_end)
{
    const double tol = fmax(controller->tol, 10 * DBL_EPSILON), t = step->t, span = t_end - t;
    const double exponent = 1.0 / (method->embedded + 1);
    double before[LIMIT_VARIABLES], own_error[LIMIT_VARIABLES], *asked = step->error;
    enum step_status status;
    assert(method->flags & METHOD_ADAPTIVE);
    if (span == 0)
        return STEP_OK;
    if (controller->h == 0)
        controller->h = first_step(step, tol, method->order, span);
    controller->h = copysign(controller->h, span);
    memcpy(before, step->y, (size_t)step->system->n * sizeof *before);

    for (int failures = 0;;) {
        bool last = fabs(controller->h) * STRETCH >= fabs(span);
        step->h = last ? span : controller->h;
        step->error = asked ? asked : own_error;
        status = method_step(method, step);
        double error = status == STEP_OK ? norm(step->system, tol, step->error, before, step->y) : NAN;
        step->error = asked;

        if (error <= 1) {
            double change = SAFETY * pow(controller->previous > 0 ? controller->previous : 1, BETA) /
                            pow(error, exponent - 0.75 * BETA);
            change = fmin(fmax(change, SHRINK), controller->rejected ? 1 : GROW); /* error 0: grow */
            /* A last step that was cut short says nothing against the longer one that was planned. */
            if (!last || fabs(step->h) * change > fabs(controller->h)) {
                controller->h = step->h * change;
                controller->previous = fmax(error, 1e-4);
            }
            if (last)
                step->t = t_end;
            controller->rejected = false;
            note_stiffness(method, step, controller);
            return STEP_OK;
        }

        if (status == STEP_OK)
            take_back(step, t, before);
        step->cost.rejected++;
        controller->rejected = true;
        if (isfinite(error)) {
            controller->h = step->h * fmax(SAFETY / pow(error, exponent - 0.75 * BETA), SHRINK);
        } else {
            if (status == STEP_OK)
                status = STEP_NONFINITE;
            if (++failures > FAILURES)
                return status;
            controller->h = step->h / 4;
        }
        if (fabs(controller->h) < least_step(t))
            return status == STEP_OK ? STEP_STALLED : status;
    }
}
