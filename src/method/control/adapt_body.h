/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Parts of an accepted adaptive step: sizes of variables, the filter that plans the next step, the
 * clock. adapt.c compiles them for any method, kernel/controlled.c for explicit Runge-Kutta methods
 * where the compiler knows method and scene. Both compile this code, so both give the same bits.
 *
 * The next step is rho h, from the errors e of the last two accepted steps, in units of the aim:
 * rho = e_n^(-b1/k) e_n-1^(-b2/k) (h_n/h_n-1)^-a, where the estimate goes like h^k (digital
 * filters: Soderlind 2003, ACM Trans. Math. Softw. 29:1), through the limiter 1 + atan(rho
 * - 1) (Soderlind, Wang 2006, J. Comput. Appl. Math. 185:225). An error close to the aim leaves h
 * unchanged, so that an implicit method keeps its factors and no power is computed.
 */
#pragma once

#include "method/control/factor.h"
#include "method/step/step.h"

#include <float.h>

/* A probability at which compilers keep a branch, for which nothing waits, instead of a selection.
 */
#if defined(__GNUC__)
#define unlikely(condition) __builtin_expect_with_probability(condition, false, 0.999)
#else
#define unlikely(condition) (condition)
#endif

#ifndef INLINE
#define INLINE static inline __attribute__((always_inline))
#endif

/*
 * The filter of explicit methods must not swing at the edge of stability, where H211b rejects every
 * sixth step of tsit5 and PC47 every twelfth, and it must follow a trend, as on the way to a
 * pericentre, where PI42 has a quarter of the steps rejected. This one, halfway between PI42 and
 * PC47, does both (found by trying). Implicit methods use PC47.
 */
static const struct filter {
    double b1, b2, a;
} explicit = {8. / 10, -4. / 10, -5. / 10}, implicit = {11. / 10, -7. / 10, -10. / 10};

/* Part of the tolerance to aim at where the method's row gives none. */
#define TOLERANCE_FRACTION (1. / 3)
#define AIM_EXPLICIT 0.35 /* part of the largest accepted error */
#define AIM_IMPLICIT 0.5
#define KEEP_MIN 0.7 /* errors from here to KEEP_MAX, in units of the aim, leave h as it is */
#define KEEP_MAX 1.3
/* A step that is shorter than this part of the previous one follows a trend. */
#define STEADY_RATIO_MIN 0.9
#define STEP_SHRINK_MIN 0.2  /* Smallest factor of the step size after a rejection. */
#define STEP_GROWTH_MAX 10.0 /* Largest factor of the step size while there is no history. */
#define MIN_ERROR 1e-8       /* Errors (in units of the aim) below this count as this. */
/* Factor by which the last step may be longer, so that no sliver remains. */
#define LAST_STEP_STRETCH 1.01
/* Successive steps that may give no number; each makes the next a quarter as long. */
#define FAILED_STEPS_MAX 20
/* Shortest step in units of the last place of t; a shorter one would be rounding. */
#define MIN_ULPS 4

/* Returns the relative tolerance, which is at least 10 eps. */
INLINE double controller_tolerance(const struct controller *controller)
{
    const double min = 10 * DBL_EPSILON;
    return controller->tol > min ? controller->tol : min;
}

/* Updates the sizes of variables along the run (struct controller) by the state y at the start of a
 * step. */
INLINE void update_sizes(int n, const struct system *system, double t, const double *y,
                         struct controller *controller)
{
    const double elapsed = controller->sampling ? fabs(t - controller->sampled) : 0;
    controller->sampling = true;
    controller->sampled = t;
    controller->elapsed += elapsed;
    const double rate = 1 / controller->elapsed;
    for (int i = 0; i < n; i++) {
        const double min = system->scale[i], size = fabs(y[i]);
        double mean = 1;
        if (system->atol[i] > 0) {
            controller->scale[i] =
                fmin(system->atol[i] / controller_tolerance(controller), DBL_MAX);
            continue;
        }
        if (size > min)
            controller->excess[i] += elapsed * (sqrt(sqrt(size / min)) - 1);
        if (controller->excess[i] > 0)
            mean += controller->excess[i] * rate;
        mean *= mean;
        mean *= mean;
        controller->scale[i] =
            min * mean < DBL_MAX ? min * mean : min; /* keeps the system's size if it is NaN */
    }
}

/* Returns the largest error estimate that is accepted. The estimate goes with h^k and the
 * accumulated error with h^order, so that tol^(k/order) makes the latter proportional to tol. */
INLINE double largest_estimate(const struct method *method, double tol)
{
    const int k = method->embedded + 1;
    double proportional =
        k == method->order ? tol : factor_exp2(factor_log2(tol) * k / method->order);
    return (method->fraction > 0 ? method->fraction : TOLERANCE_FRACTION) * proportional;
}

/* Returns the shortest step [s] at time t. */
static inline double min_step(double t)
{
    return MIN_ULPS * (nextafter(fabs(t), HUGE_VAL) - fabs(t));
}

/* Gives the planned step the direction of span. A branch, so that the step does not wait for the
 * clock. */
INLINE void controller_orient(struct controller *controller, double span)
{
    if (unlikely((controller->h < 0) != (span < 0)))
        controller->h = -controller->h;
}

/* Returns the factor from squared errors in units of the accepted error to those in units of the
 * aim. */
INLINE double aim_factor(const struct method *method)
{
    return method->flags & METHOD_IMPLICIT ? 1 / (AIM_IMPLICIT * AIM_IMPLICIT)
                                           : 1 / (AIM_EXPLICIT * AIM_EXPLICIT);
}

/* Returns log2 of rho (see the top of this file), from squares of the last two errors in units of
 * the aim; ratio is h_n/h_n-1. */
INLINE double step_change_log2(const struct filter *filter, int k, double square, double previous,
                               double ratio)
{
    const double half = -0.5 / k;
    const double history =
        factor_log2(previous) * (half * filter->b2) - factor_log2(ratio) * filter->a;
    /* only the first operand has to be waited for */
    return factor_log2(square) * (half * filter->b1) + history;
}

/* Returns rho of a first step and after a rejection, by the last error alone. */
__attribute__((noinline, unused)) static double elementary_step_change(int k, double square)
{
    return factor_exp2(factor_log2(square) * (-0.5 / k));
}

/* Plans the next step after an accepted one of h; square is that of its error in units of the aim.
 * After a step that was cut short, only a longer plan replaces the old one. */
INLINE void plan_next(const struct method *method, struct controller *controller, double h,
                      double square, bool cut)
{
    const int k = method->embedded + 1;
    const struct filter *filter = method->flags & METHOD_IMPLICIT ? &implicit : &explicit;
    const double ratio = fabs(h / controller->last); /* a turn changes the sign of h */
    double rho = 1;
    square = square > MIN_ERROR * MIN_ERROR ? square : MIN_ERROR * MIN_ERROR;
    if (controller->previous == 0) {
        rho = elementary_step_change(k, square);
        rho = rho < STEP_GROWTH_MAX ? rho : STEP_GROWTH_MAX;
    } else if (square < KEEP_MIN * KEEP_MIN || square > KEEP_MAX * KEEP_MAX ||
               ratio < STEADY_RATIO_MIN) {
        rho = factor_limited(step_change_log2(filter, k, square, controller->previous, ratio));
    }
    if (controller->rejected)
        rho = rho < 1 ? rho : 1;
    if (cut && !(fabs(h * rho) > fabs(controller->h)))
        return;
    controller->previous = square;
    controller->last = h;
    controller->h = h * rho;
}

/* Returns t after the step, as a compensated sum of all steps (Neumaier 1974). */
INLINE double advance_clock(struct controller *controller, double t, double h)
{
    const double increment = h + controller->t_low, sum = t + increment, part = sum - t;
    controller->t_low = (t - (sum - part)) + (increment - part);
    return sum;
}

/* Returns t, or t_end if t is beyond it. A switch at the very end may be located beyond the end by
 * rounding, and the next step would go back across it. */
INLINE double limit_to_end(double t, double h, double t_end)
{
    return (h > 0 ? t > t_end : t < t_end) ? t_end : t;
}

INLINE void doubles_copy(int count, const double *source, double *target)
{
    for (int i = 0; i < count; i++)
        target[i] = source[i];
}

/*
 * Returns the step of the next attempt after one of h at t that was rejected, or 0 if it would be
 * too short. square is that of the error in units of the aim; it is not finite if there is none,
 * which happened `failures` times in a row.
 */
__attribute__((noinline, unused)) static double next_attempt(const struct method *method, double t,
                                                             double h, double square, int failures)
{
    double next = h / 4;
    if (isfinite(square)) {
        const double factor = elementary_step_change(method->embedded + 1, square);
        next = h * (factor > STEP_SHRINK_MIN ? factor : STEP_SHRINK_MIN);
    }
    return failures <= FAILED_STEPS_MAX && fabs(next) >= min_step(t) ? next : 0;
}
