/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Step-size control: one accepted step of a method with an error estimate.
 *
 * The next step is rho h, from the errors e of the last two accepted steps, in units of what is aimed at:
 * rho = e_n^(-b1/k) e_n-1^(-b2/k) (h_n/h_n-1)^-a, where the estimate goes like h^k (digital filters: Soderlind 2003,
 * ACM Trans. Math. Softw. 29:1), through the limiter 1 + atan(rho - 1) (Soderlind, Wang 2006, J. Comput. Appl. Math.
 * 185:225). An error that is just right leaves h as it is: an implicit method keeps its factors, and no power is
 * computed. First step: Hairer, Norsett, Wanner 1993, Solving ODEs I, II.4.
 */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize("no-tree-vectorize") /* a pair that was stored one by one cannot be loaded at once */
#endif
#include "method/control/factor.h"
#include "method/step/step.h"
#include "method/control/switch.h"

#include <assert.h>
#include <float.h>

/*
 * Explicit methods want two things. At the edge of stability a filter must not swing: H211b rejects every sixth step
 * there, PC47 of tsit5 every twelfth. On the way to a pericentre it must follow the trend: PI42 has a quarter of the
 * steps rejected. What is here, halfway between PI42 and PC47, does both (found by trying).
 */
static const struct filter {
    double b1, b2, a;
} explicit = {8. / 10, -4. / 10, -5. / 10}, implicit = {11. / 10, -7. / 10, -10. / 10}; /* the latter: PC47 */

#define SHARE (1. / 3)    /* of the tolerance, where the row says nothing */
#define AIM_EXPLICIT 0.35 /* of the largest error that is accepted */
#define AIM_IMPLICIT 0.5
#define KEEP_LEAST 0.7 /* errors from here to KEEP_MOST, in units of the aim, leave h as it is */
#define KEEP_MOST 1.3
#define FALLS 0.9        /* but a step so much shorter than the one before stands in a trend */
#define SHRINK 0.2       /* limit of the change after a rejection, */
#define GROW 10.0        /* and while there is no history */
#define LEAST_ERROR 1e-8 /* smaller ones say nothing about the next */
#define STRETCH 1.01     /* a last step may be this much longer, so that no sliver remains */
#define FAILURES 20      /* steps in a row that give no number: each makes the next a quarter */
#define LEAST_ULPS 4     /* of t: a smaller step is only rounding, though the clock counts it */
#define PROBE 1e-4       /* of a step: how far ahead the direction of a switch is looked for */

#define INLINE static inline __attribute__((always_inline))

/* RMS of x_i / (tol max(scale_i, |y_i|, |z_i|)) */
static double norm(const struct step *step, double tol, const double *x, const double *y, const double *z)
{
    const int n = step->system->n;
    return sqrt(scaled_square(n, step_scale(step), x, y, z) / (n * tol * tol));
}

INLINE double tolerance(const struct controller *controller)
{
    const double least = 10 * DBL_EPSILON;
    return controller->tol > least ? controller->tol : least;
}

/* One more sample of the sizes, at the start of a step. */
INLINE void follow(int n, const struct step *step, struct controller *controller)
{
    const struct system *system = step->system;
    const double by = controller->sampling ? fabs(step->t - controller->sampled) : 0;
    controller->sampling = true;
    controller->sampled = step->t;
    controller->elapsed += by;
    const double rate = 1 / controller->elapsed;
    for (int i = 0; i < n; i++) {
        const double least = system->scale[i], size = fabs(step->y[i]);
        double mean = 1;
        if (system->atol[i] > 0) {
            controller->scale[i] = fmin(system->atol[i] / tolerance(controller), DBL_MAX);
            continue;
        }
        if (size > least)
            controller->excess[i] += by * (sqrt(sqrt(size / least)) - 1);
        if (controller->excess[i] > 0)
            mean += controller->excess[i] * rate;
        mean *= mean;
        mean *= mean;
        controller->scale[i] = least * mean < DBL_MAX ? least * mean : least; /* not where it is NaN */
    }
}

/* The estimate goes with h^k, what adds up with h^order: this makes the latter go with tol. */
INLINE double largest_estimate(const struct method *method, double tol)
{
    const int k = method->embedded + 1;
    double proportional = k == method->order ? tol : factor_exp2(factor_log2(tol) * k / method->order);
    return (method->share > 0 ? method->share : SHARE) * proportional;
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
    double size = norm(step, tol, y, y, y), slope = norm(step, tol, f0, y, y);
    double h = size < 1e-5 || slope < 1e-5 ? cautious : 0.01 * (size / slope);
    h = copysign(fmin(h, fabs(span)), span);

    for (int i = 0; i < n; i++)
        z[i] = y[i] + h * f0[i];
    system_derivative(system, step->t + h, z, f1);
    step->cost.evals++;
    for (int i = 0; i < n; i++)
        f1[i] -= f0[i];
    double fastest = fmax(slope, norm(step, tol, f1, y, y) / fabs(h));
    double best = fastest > 1e-15 ? pow(0.01 / fastest, 1.0 / (order + 1)) : cautious;
    best = fmin(100 * fabs(h), fmin(best, fabs(span)));
    return copysign(isfinite(best) && best > 0 ? best : cautious, span);
}

static double least_step(double t)
{
    return LEAST_ULPS * (nextafter(fabs(t), HUGE_VAL) - fabs(t));
}

/* Errors in units of what is aimed at, by those in units of what is accepted; both squared */
INLINE double by_aim(const struct method *method)
{
    return method->flags & METHOD_IMPLICIT ? 1 / (AIM_IMPLICIT * AIM_IMPLICIT) : 1 / (AIM_EXPLICIT * AIM_EXPLICIT);
}

/* log2 of rho as above, from squares of errors in units of the aim; ratio: h_n/h_n-1 */
INLINE double change(const struct filter *filter, int k, double square, double previous, double ratio)
{
    const double half = -0.5 / k;
    const double history = factor_log2(previous) * (half * filter->b2) - factor_log2(ratio) * filter->a;
    return factor_log2(square) * (half * filter->b1) + history; /* which alone is waited for */
}

/* rho of a first step and after a rejection. */
static double change_elementary(int k, double square)
{
    return factor_exp2(factor_log2(square) * (-0.5 / k));
}

/*
 * Plans the next step after an accepted one of step->h; square: of its error in units of the aim.
 * cut: only a longer one counts.
 */
INLINE void plan_next(const struct method *method, const struct step *step, struct controller *controller,
                      double square, bool cut)
{
    const int k = method->embedded + 1;
    const struct filter *filter = method->flags & METHOD_IMPLICIT ? &implicit : &explicit;
    const double ratio = fabs(step->h / controller->last); /* a turn changes the sign of h */
    double rho = 1;
    square = square > LEAST_ERROR * LEAST_ERROR ? square : LEAST_ERROR * LEAST_ERROR;
    if (controller->previous == 0) {
        rho = change_elementary(k, square);
        rho = rho < GROW ? rho : GROW;
    } else if (square < KEEP_LEAST * KEEP_LEAST || square > KEEP_MOST * KEEP_MOST || ratio < FALLS) {
        rho = factor_limited(change(filter, k, square, controller->previous, ratio));
    }
    if (controller->rejected)
        rho = rho < 1 ? rho : 1;
    if (cut && !(fabs(step->h * rho) > fabs(controller->h)))
        return;
    controller->previous = square;
    controller->last = step->h;
    controller->h = step->h * rho;
}

/* t after the step, as the sum of all steps. */
INLINE double advance_clock(struct controller *controller, double t, double h)
{
    const double by = h + controller->t_low, sum = t + by, part = sum - t;
    controller->t_low = (t - (sum - part)) + (by - part);
    return sum;
}

/* A switch at the very end is located beyond it by rounding: the next step would go back across. */
INLINE double not_beyond(double t, double h, double t_end)
{
    return (t - t_end) * copysign(1, h) > 0 ? t_end : t;
}

INLINE void copy(int count, const double *from, double *to)
{
    for (int i = 0; i < count; i++)
        to[i] = from[i];
}

/* A step that was not good: puts everything back as it was and makes the next attempt smaller. */
INLINE void take_back(int n, struct step *step, struct controller *controller, double t, const double *y,
                      const double *low)
{
    copy(n, y, step->y);
    if (step->low)
        copy(n, low, step->low);
    step->t = t;
    step->warm = false;
    step->cost.rejected++;
    controller->rejected = true;
}

/* Of the error of a step from `before`, in units of the tolerance: nothing waits for its root. */
INLINE double error_square(int n, const struct step *step, const double *before)
{
    return step->square >= 0 ? step->square : scaled_square(n, step_scale(step), step->error, before, step->y);
}

/* One accepted step; where the system is on frozen branches, `switches` say which. Inlined for each small n. */
INLINE enum step_status adapt_size(int n, const struct method *method, struct step *step,
                                   struct controller *controller, double t_end, struct switches_state *switches)
{
    const double tol = tolerance(controller), t = step->t, span = t_end - t;
    const double most = largest_estimate(method, tol);
    const bool turns = !switches && step->system->kinks && method_turns(method, step->system);
    const double accepted = 1 / (n * most * most), aims = by_aim(method);
    const double planned = controller->h; /* after a failure another try begins where this one did */
    const bool rejected = controller->rejected;
    struct switches_state state;
    if (switches)
        state = *switches;
    double before[LIMIT_VARIABLES], low[LIMIT_VARIABLES], own_error[LIMIT_VARIABLES], *asked = step->error;
    copy(n, step->y, before);
    if (step->low)
        copy(n, step->low, low);

    for (int attempt = 0, failures = 0;; attempt++) {
        bool last = fabs(controller->h) * STRETCH >= fabs(span);
        step->h = controller->h;
        if (__builtin_expect(last, false)) /* a branch: the first stage does not wait for it */
            step->h = span;
        step->error = asked ? asked : own_error;
        step->again = attempt > 0;
        step->tol = most;
        step->square = -1;
        enum step_status status = step_take(method, step);
        bool turned = false;
        int ended = -1;
        double square = status == STEP_OK ? error_square(n, step, before) * accepted : NAN;
        step->square = -1;
        if (turns && status == STEP_OK)
            status = turn_step(method, step, t, before, low, &turned);
        /* What lies inside a step on frozen branches says something only where it is good as a whole. */
        if (switches && square <= 1)
            status = switch_step(method, step, t, before, low, &ended);
        turned = turned || ended >= 0;
        last = last && !turned;
        if (turned)
            square = status == STEP_OK ? error_square(n, step, before) * accepted : NAN;
        const double aimed = square * aims;
        step->error = asked;
        step->tol = 0;

        if (square <= 1) {
            /* A step that was cut short says nothing against the longer one that was planned. */
            plan_next(method, step, controller, aimed, last || turned);
            step->t = last ? t_end : advance_clock(controller, t, step->h);
            step->t = not_beyond(step->t, span, t_end);
            if (step->t == t_end)
                controller->t_low = 0;
            controller->rejected = false;
            step->cost.turns += turned;
            if (switches)
                switch_next(step, switches, ended);
            return STEP_OK;
        }

        take_back(n, step, controller, t, before, low);
        if (isfinite(square)) {
            const double factor = change_elementary(method->embedded + 1, aimed);
            controller->h = step->h * (factor > SHRINK ? factor : SHRINK);
        } else {
            if (status == STEP_OK)
                status = STEP_NONFINITE;
            failures++;
            controller->h = step->h / 4;
        }
        if (failures > FAILURES || fabs(controller->h) < least_step(t)) {
            controller->h = planned;
            controller->rejected = rejected;
            if (switches)
                *switches = state;
            return status == STEP_OK ? STEP_STALLED : status;
        }
    }
}

static enum step_status adapt(const struct method *method, struct step *step, struct controller *controller,
                              double t_end, struct switches_state *switches)
{
    return adapt_size(step->system->n, method, step, controller, t_end, switches);
}

/* One step of a library's own control on frozen branches: one across the end of a branch is taken again, up to there. */
static enum step_status adapt_library(const struct method *method, struct step *step, struct controller *controller,
                                      double t_end)
{
    const double t = step->t;
    double before[LIMIT_VARIABLES];
    int ended = -1;
    memcpy(before, step->y, (size_t)step->system->n * sizeof *before);
    enum step_status status = method->adapt(method, step, controller, t_end);
    if (status == STEP_OK)
        status = switch_step(method, step, t, before, NULL, &ended);
    if (status != STEP_OK) {
        memcpy(step->y, before, (size_t)step->system->n * sizeof *before);
        step->t = t;
        step->warm = false;
        return status;
    }
    if (ended >= 0)
        step->t = not_beyond(t + step->h, t_end - t, t_end);
    step->cost.turns += ended >= 0;
    switch_next(step, &controller->switches, ended);
    return STEP_OK;
}

/* On frozen branches. */
static enum step_status adapt_between_switches(const struct method *method, struct step *step,
                                               struct controller *controller, double t_end)
{
    const struct system *whole = step->system;
    step_function *kernel = step->kernel;
    struct system frozen;
    struct sliding sliding;
    const double by = PROBE * fmin(fabs(controller->h), fabs(t_end - step->t));
    if (!switch_begin(step, &controller->switches, copysign(by, t_end - step->t), &sliding, &frozen))
        return method->adapt ? method->adapt(method, step, controller, t_end)
                             : adapt(method, step, controller, t_end, NULL);
    step->system = &frozen;
    step->kernel = NULL;
    const enum step_status status = method->adapt ? adapt_library(method, step, controller, t_end)
                                                  : adapt(method, step, controller, t_end, &controller->switches);
    step->system = whole;
    step->kernel = kernel;
    if (controller->switches.begins)
        step->warm = false;
    return status;
}

/* Where there is neither a switch nor a first step to choose. */
INLINE enum step_status adapt_plain(int n, const struct method *method, struct step *step,
                                    struct controller *controller, double t_end)
{
    follow(n, step, controller);
    step->scale = controller->scale;
    controller->h = copysign(controller->h, t_end - step->t);
    const enum step_status status = adapt_size(n, method, step, controller, t_end, NULL);
    step->scale = NULL;
    return status;
}

#define ADAPT_PLAIN(name, n)                                                                                           \
    static enum step_status name(const struct method *method, struct step *step, struct controller *controller,        \
                                 double t_end)                                                                         \
    {                                                                                                                  \
        return adapt_plain(n, method, step, controller, t_end);                                                        \
    }
ADAPT_PLAIN(adapt_two, 2)
ADAPT_PLAIN(adapt_three, 3)
ADAPT_PLAIN(adapt_four, 4)

static enum step_status adapt_any(const struct method *method, struct step *step, struct controller *controller,
                                  double t_end)
{
    const double span = t_end - step->t;
    follow(step->system->n, step, controller);
    step->scale = controller->scale;
    enum step_status status;
    if (method->adapt && step->system->switches == 0) {
        status = method->adapt(method, step, controller, t_end);
    } else {
        if (controller->h == 0)
            controller->h = first_step(step, tolerance(controller), method->order, span);
        controller->h = copysign(controller->h, span);
        status = step->system->switches > 0 ? adapt_between_switches(method, step, controller, t_end)
                                            : adapt(method, step, controller, t_end, NULL);
    }
    step->scale = NULL;
    return status;
}

enum step_status method_adapt(const struct method *method, struct step *step, struct controller *controller,
                              double t_end)
{
    const int n = step->system->n;
    assert(method->flags & METHOD_ADAPTIVE);
    if (t_end - step->t == 0)
        return STEP_OK;
    if (method->adapt || step->system->switches > 0 || controller->h == 0) /* 0: choose one */
        return adapt_any(method, step, controller, t_end);
    return n == 2   ? adapt_two(method, step, controller, t_end)
           : n == 3 ? adapt_three(method, step, controller, t_end)
           : n == 4 ? adapt_four(method, step, controller, t_end)
                    : adapt_any(method, step, controller, t_end);
}
