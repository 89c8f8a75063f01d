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
#include "step.h"
#include "switch.h"

#include <assert.h>
#include <float.h>

/*
 * Explicit methods want two things. At the edge of stability a filter must not swing: H211b rejects every sixth step
 * there, PC47 of tsit5 every twelfth. On the way to a pericentre it must follow the trend: PI42 has a quarter of the
 * steps rejected. What is here, halfway between PI42 and PC47, does both (found by trying).
 */
static const struct filter {
    double b1, b2, a;
} elementary = {1, 0, 0}, /* first steps, rejected steps */
    explicit = {8. / 10, -4. / 10, -5. / 10}, implicit = {11. / 10, -7. / 10, -10. / 10}; /* the latter: PC47 */

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
#define MEMORY 0.4       /* share of the newest estimate in the smoothed stiffness, */
#define PROBE 1e-4       /* of a step: how far ahead the direction of a switch is looked for */
#define ESTIMATE_EACH 4  /* steps, because the estimate costs as much as a fifth of a step */

/* RMS of x_i / (tol max(scale_i, |y_i|, |z_i|)) */
static double norm(const struct step *step, double tol, const double *x, const double *y, const double *z)
{
    const int n = step->system->n;
    return sqrt(scaled_square(n, step_scale(step), x, y, z) / (n * tol * tol));
}

static double tolerance(const struct controller *controller)
{
    return fmax(controller->tol, 10 * DBL_EPSILON);
}

/* One more sample of the sizes, at the start of a step. */
static void follow(const struct step *step, struct controller *controller)
{
    const struct system *system = step->system;
    const double by = controller->sampling ? fabs(step->t - controller->sampled) : 0;
    controller->sampling = true;
    controller->sampled = step->t;
    controller->elapsed += by;
    for (int i = 0; i < system->n; i++) {
        const double least = system->scale[i], size = fabs(step->y[i]);
        double mean = 1;
        if (system->atol[i] > 0) {
            controller->scale[i] = fmin(system->atol[i] / tolerance(controller), DBL_MAX);
            continue;
        }
        if (size > least)
            controller->excess[i] += by * (sqrt(sqrt(size / least)) - 1);
        if (controller->excess[i] > 0)
            mean += controller->excess[i] / controller->elapsed;
        mean *= mean;
        mean *= mean;
        controller->scale[i] = least * mean < DBL_MAX ? least * mean : least; /* not where it is NaN */
    }
}

/* The estimate goes with h^k, what adds up with h^order: this makes the latter go with tol. */
static double largest_estimate(const struct method *method, double tol)
{
    const int k = method->embedded + 1;
    double proportional = k == method->order ? tol : pow(tol, (double)k / method->order);
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

static double aim(const struct method *method)
{
    return method->flags & METHOD_IMPLICIT ? AIM_IMPLICIT : AIM_EXPLICIT;
}

/* rho as above; error and previous in units of the aim; ratio: h_n/h_n-1 */
static double change(const struct filter *filter, int k, double error, double previous, double ratio)
{
    double rho = pow(error, -filter->b1 / k);
    if (filter->b2 != 0)
        rho *= pow(previous, -filter->b2 / k);
    return filter->a != 0 ? rho * pow(ratio, -filter->a) : rho;
}

/* Plans the next step after an accepted one of step->h; error in units of the aim. cut: only a longer one counts. */
static void plan_next(const struct method *method, const struct step *step, struct controller *controller, double error,
                      bool cut)
{
    const int k = method->embedded + 1;
    const struct filter *filter = method->flags & METHOD_IMPLICIT ? &implicit : &explicit;
    const double ratio = fabs(step->h / controller->last); /* a turn changes the sign of h */
    double rho = 1;
    error = error > LEAST_ERROR ? error : LEAST_ERROR;
    if (controller->previous == 0)
        rho = fmin(change(&elementary, k, error, 0, 1), GROW);
    else if (error < KEEP_LEAST || error > KEEP_MOST || ratio < FALLS)
        rho = 1 + atan(change(filter, k, error, controller->previous, ratio) - 1);
    if (controller->rejected)
        rho = fmin(rho, 1);
    if (cut && !(fabs(step->h * rho) > fabs(controller->h)))
        return;
    controller->previous = error;
    controller->last = step->h;
    controller->h = step->h * rho;
}

static void note_stiffness(const struct method *method, const struct step *step, struct controller *controller)
{
    if (controller->since++ % ESTIMATE_EACH != 0)
        return;
    double estimate = rk_stiffness(method, step);
    if (isfinite(estimate))
        controller->stiffness += MEMORY * (estimate - controller->stiffness);
}

/* t after the step, as the sum of all steps. */
static double advance_clock(struct controller *controller, double t, double h)
{
    const double by = h + controller->t_low, sum = t + by, part = sum - t;
    controller->t_low = (t - (sum - part)) + (by - part);
    return sum;
}

/* A switch at the very end is located beyond it by rounding: the next step would go back across. */
static double not_beyond(double t, double h, double t_end)
{
    return (t - t_end) * copysign(1, h) > 0 ? t_end : t;
}

/* A step that was not good: puts everything back as it was and makes the next attempt smaller. */
static void take_back(struct step *step, struct controller *controller, double t, const double *y, const double *low)
{
    size_t size = (size_t)step->system->n * sizeof *y;
    memcpy(step->y, y, size);
    if (step->low)
        memcpy(step->low, low, size);
    step->t = t;
    step->warm = false;
    step->cost.rejected++;
    controller->rejected = true;
}

/* One accepted step; where the system is on frozen branches, `switches` say which. */
static enum step_status adapt(const struct method *method, struct step *step, struct controller *controller,
                              double t_end, struct switches_state *switches)
{
    const double tol = tolerance(controller), t = step->t, span = t_end - t;
    const double most = largest_estimate(method, tol);
    const bool turns = !switches && method_turns(method, step->system);
    const double planned = controller->h; /* after a failure another try begins where this one did */
    const bool rejected = controller->rejected;
    struct switches_state state;
    if (switches)
        state = *switches;
    const size_t size = (size_t)step->system->n * sizeof *step->y;
    double before[LIMIT_VARIABLES], low[LIMIT_VARIABLES], own_error[LIMIT_VARIABLES], *asked = step->error;
    memcpy(before, step->y, size);
    if (step->low)
        memcpy(low, step->low, size);

    for (int attempt = 0, failures = 0;; attempt++) {
        bool last = fabs(controller->h) * STRETCH >= fabs(span);
        step->h = last ? span : controller->h;
        step->error = asked ? asked : own_error;
        step->again = attempt > 0;
        step->tol = most;
        enum step_status status = method_step(method, step);
        bool turned = false;
        int ended = -1;
        if (turns && status == STEP_OK)
            status = turn_step(method, step, t, before, low, &turned);
        if (switches && status == STEP_OK)
            status = switch_step(method, step, t, before, low, &ended);
        turned = turned || ended >= 0;
        last = last && !turned;
        double error = status == STEP_OK ? norm(step, step->tol, step->error, before, step->y) : NAN;
        step->error = asked;
        step->tol = 0;

        if (error <= 1) {
            /* A step that was cut short says nothing against the longer one that was planned. */
            plan_next(method, step, controller, error / aim(method), last || turned);
            step->t = last ? t_end : advance_clock(controller, t, step->h);
            step->t = not_beyond(step->t, span, t_end);
            if (step->t == t_end)
                controller->t_low = 0;
            controller->rejected = false;
            step->cost.turns += turned;
            note_stiffness(method, step, controller);
            if (switches)
                switch_next(step, switches, ended);
            return STEP_OK;
        }

        take_back(step, controller, t, before, low);
        if (isfinite(error)) {
            controller->h =
                step->h * fmax(change(&elementary, method->embedded + 1, error / aim(method), 0, 1), SHRINK);
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

enum step_status method_adapt(const struct method *method, struct step *step, struct controller *controller,
                              double t_end)
{
    const double span = t_end - step->t;
    assert(method->flags & METHOD_ADAPTIVE);
    if (span == 0)
        return STEP_OK;
    follow(step, controller);
    step->scale = controller->scale;
    enum step_status status;
    if (method->adapt && !step->system->pieces) {
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
