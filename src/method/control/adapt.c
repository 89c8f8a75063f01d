/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Step-size control: one accepted step of a method with an error estimate (adapt_body.h), also of
 * systems with switches. First step: Hairer, Norsett, Wanner 1993, Solving ODEs I, II.4. */
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize(                                                                              \
    "no-tree-vectorize") /* a pair that was stored one by one cannot be loaded at once */
#endif
#include <hooke/base/elementary.h>
#include <hooke/scene/typed.h>
#include "method/control/adapt_body.h"
#include "method/control/switch.h"

#include <assert.h>

/* Part of a step ahead at which the direction of a switch is evaluated. */
#define PROBE_STEP_FRACTION 1e-4

/* Returns the RMS of x_i / (tol max(scale_i, |y_i|, |z_i|)). */
static double scaled_norm(const struct step *step, double tol, const double *x, const double *y,
                          const double *z)
{
    const int n = step->system->n;
    return sqrt(scaled_square(n, step_scale(step), x, y, z) / (n * tol * tol));
}

/* Chooses a first step [s], with the sign of span, by the size of the first and second derivative
 * (II.4, algorithm of Gladwell, Shampine, Brankin 1987). order is that of the method. */
static double first_step(struct step *step, double tol, int order, double span)
{
    const struct system *system = step->system;
    int n = system->n;
    const double *y = step->y;
    double f0[LIMIT_VARIABLES], f1[LIMIT_VARIABLES], z[LIMIT_VARIABLES];
    double natural = system->order == 2 ? system->scale[0] / system->scale[n / 2] : 1; /* [s] */
    /* used if the derivatives say nothing */
    double cautious = 1e-3 * fmin(natural, fabs(span));
    system_derivative(system, step->t, y, f0);
    step->cost.evals++;
    double size = scaled_norm(step, tol, y, y, y), slope = scaled_norm(step, tol, f0, y, y);
    double h = size < 1e-5 || slope < 1e-5 ? cautious : 0.01 * (size / slope);
    h = copysign(fmin(h, fabs(span)), span);

    for (int i = 0; i < n; i++)
        z[i] = y[i] + h * f0[i];
    system_derivative(system, step->t + h, z, f1);
    step->cost.evals++;
    for (int i = 0; i < n; i++)
        f1[i] -= f0[i];
    double fastest = fmax(slope, scaled_norm(step, tol, f1, y, y) / fabs(h));
    double best = fastest > 1e-15 ? fixed_pow(0.01 / fastest, 1.0 / (order + 1)) : cautious;
    best = fmin(100 * fabs(h), fmin(best, fabs(span)));
    return copysign(isfinite(best) && best > 0 ? best : cautious, span);
}

/* Restores state, low parts and time after a rejected attempt, and counts it. */
INLINE void restore_attempt(int n, struct step *step, struct controller *controller, double t,
                            const double *y, const double *low)
{
    doubles_copy(n, y, step->y);
    if (step->low)
        doubles_copy(n, low, step->low);
    step->t = t;
    step->warm = false;
    step->cost.rejected++;
    controller->rejected = true;
}

/* Returns the squared error of a step from `previous`, in units of the tolerance and summed over
 * variables. The square is used because nothing has to wait for a root. */
INLINE double error_square(int n, const struct step *step, const double *previous)
{
    return step->square >= 0 ? step->square
                             : scaled_square(n, step_scale(step), step->error, previous, step->y);
}

/* Takes one accepted step towards t_end. If the system is frozen on branches, switches holds their
 * state, else it is NULL. Returns a failure, with state, time and controller as before, if no step
 * is short enough. Inlined for each small n. */
INLINE enum step_status adapt_size(int n, const struct method *method, struct step *step,
                                   struct controller *controller, double t_end,
                                   struct switches_state *switches)
{
    const double tol = controller_tolerance(controller), t = step->t, span = t_end - t;
    const double max = largest_estimate(method, tol);
    const bool turns = !switches && step->system->kinks && method_turns(method, step->system);
    const double accepted = 1 / (n * max * max), aims = aim_factor(method);
    /* restored on failure, so that another call begins where this one did */
    const double planned = controller->h;
    const bool rejected = controller->rejected;
    struct switches_state state;
    if (switches)
        state = *switches;
    double previous[LIMIT_VARIABLES], low[LIMIT_VARIABLES] = {0}, own_error[LIMIT_VARIABLES],
                                      *wanted_error = step->error;
    doubles_copy(n, step->y, previous);
    if (step->low)
        doubles_copy(n, step->low, low);

    for (int attempt = 0, failures = 0;; attempt++) {
        bool last = fabs(controller->h) * LAST_STEP_STRETCH >= fabs(span);
        step->h = controller->h;
        if (unlikely(last)) /* as a branch, since the first stage does not wait for branches */
            step->h = span;
        step->error = wanted_error ? wanted_error : own_error;
        step->again = attempt > 0;
        step->tol = max;
        step->square = -1;
        enum step_status status = step_take(method, step);
        bool turned = false;
        int ended = -1;
        double square = status == STEP_OK ? error_square(n, step, previous) * accepted : NAN;
        step->square = -1;
        if (turns && status == STEP_OK)
            status = turn_step(method, step, t, previous, low, &turned);
        /* Switches inside a step on frozen branches mean something only if the whole step is
         * accurate. */
        if (switches && square <= 1)
            status = switch_step(method, step, t, previous, low, &ended);
        turned = turned || ended >= 0;
        last = last && !turned;
        if (turned)
            square = status == STEP_OK ? error_square(n, step, previous) * accepted : NAN;
        const double aimed = square * aims;
        step->error = wanted_error;
        step->tol = 0;

        if (square <= 1) {
            /* a step that was cut short does not shorten the step that was planned */
            plan_next(method, controller, step->h, aimed, last || turned);
            step->t = last ? t_end : advance_clock(controller, t, step->h);
            step->t = limit_to_end(step->t, span, t_end);
            if (step->t == t_end)
                controller->t_low = 0;
            controller->rejected = false;
            step->cost.turns += turned;
            if (switches)
                switch_next(step, switches, ended);
            return STEP_OK;
        }

        restore_attempt(n, step, controller, t, previous, low);
        if (!isfinite(square) && status == STEP_OK)
            status = STEP_NONFINITE;
        failures += !isfinite(aimed);
        controller->h = next_attempt(method, t, step->h, aimed, failures);
        if (controller->h == 0) {
            controller->h = planned;
            controller->rejected = rejected;
            if (switches)
                *switches = state;
            return status == STEP_OK ? STEP_STALLED : status;
        }
    }
}

/* Calls adapt_size() for any number of variables. */
static enum step_status adapt(const struct method *method, struct step *step,
                              struct controller *controller, double t_end,
                              struct switches_state *switches)
{
    return adapt_size(step->system->n, method, step, controller, t_end, switches);
}

/* Takes one step of an external library's own step control, no farther than t_end, on frozen
 * branches. A step across the end of a branch is shortened to that end. Returns the status; on
 * failure state and time are unchanged. */
static enum step_status adapt_library(const struct method *method, struct step *step,
                                      struct controller *controller, double t_end)
{
    const double t = step->t;
    double previous[LIMIT_VARIABLES];
    int ended = -1;
    memcpy(previous, step->y, (size_t)step->system->n * sizeof *previous);
    enum step_status status = method->adapt(method, step, controller, t_end);
    if (status == STEP_OK)
        status = switch_step(method, step, t, previous, NULL, &ended);
    if (status != STEP_OK) {
        memcpy(step->y, previous, (size_t)step->system->n * sizeof *previous);
        step->t = t;
        step->warm = false;
        return status;
    }
    if (ended >= 0)
        step->t = limit_to_end(t + step->h, t_end - t, t_end);
    step->cost.turns += ended >= 0;
    switch_next(step, &controller->switches, ended);
    return STEP_OK;
}

/* Takes one accepted step towards t_end of a system with switches, on a copy that is frozen on the
 * branches at the start of the step, or of the system itself if no combination of branches holds
 * there. Returns the status of the step, STEP_NONFINITE if the equations are not defined where it
 * ended. */
static enum step_status adapt_between_switches(const struct method *method, struct step *step,
                                               struct controller *controller, double t_end)
{
    const struct system *whole = step->system;
    step_function *kernel = step->kernel;
    struct system frozen;
    struct sliding sliding = {0};
    const double probe_step =
        PROBE_STEP_FRACTION * fmin(fabs(controller->h), fabs(t_end - step->t));
    if (!switch_begin(step, &controller->switches, copysign(probe_step, t_end - step->t), &sliding,
                      &frozen)) {
        sliding_free(&sliding);
        return method->adapt ? method->adapt(method, step, controller, t_end)
                             : adapt(method, step, controller, t_end, NULL);
    }
    step->system = &frozen;
    step->kernel = NULL;
    const enum step_status status =
        method->adapt ? adapt_library(method, step, controller, t_end)
                      : adapt(method, step, controller, t_end, &controller->switches);
    step->system = whole;
    step->kernel = kernel;
    sliding_free(&sliding);
    if (status == STEP_OK && !switch_is_there(step))
        return STEP_NONFINITE;
    if (controller->switches.begins)
        step->warm = false;
    return status;
}

/* Takes a step of a system without switches whose first step has a size. */
INLINE enum step_status adapt_plain(int n, const struct method *method, struct step *step,
                                    struct controller *controller, double t_end)
{
    update_sizes(n, step->system, step->t, step->y, controller);
    step->scale = controller->scale;
    controller_orient(controller, t_end - step->t);
    const enum step_status status = adapt_size(n, method, step, controller, t_end, NULL);
    step->scale = NULL;
    return status;
}

/* Makes an instance of adapt_plain() for n variables. */
#define ADAPT_PLAIN(name, n)                                                                       \
    static enum step_status name(const struct method *method, struct step *step,                   \
                                 struct controller *controller, double t_end)                      \
    {                                                                                              \
        return adapt_plain(n, method, step, controller, t_end);                                    \
    }
ADAPT_PLAIN(adapt_two, 2)
ADAPT_PLAIN(adapt_three, 3)
ADAPT_PLAIN(adapt_four, 4)

/* Takes one accepted step of any system towards t_end, by one of three controls: a library's own
 * (method->adapt) if the system has no switches, that on frozen branches if it has, or else
 * adapt(). controller->h = 0 asks for a choice of the first step, which a library makes itself.
 * Returns the status of the step. */
static enum step_status adapt_any(const struct method *method, struct step *step,
                                  struct controller *controller, double t_end)
{
    const double span = t_end - step->t;
    update_sizes(step->system->n, step->system, step->t, step->y, controller);
    step->scale = controller->scale;
    enum step_status status;
    if (method->adapt && step->system->switches == 0) {
        status = method->adapt(method, step, controller, t_end);
    } else {
        if (controller->h == 0)
            controller->h = first_step(step, controller_tolerance(controller), method->order, span);
        controller_orient(controller, span);
        status = step->system->switches > 0
                     ? adapt_between_switches(method, step, controller, t_end)
                     : adapt(method, step, controller, t_end, NULL);
    }
    step->scale = NULL;
    return status;
}

/* Takes one accepted step towards t_end, by the fastest code for the system: a kernel, an instance
 * for its number of variables, or adapt_any(). */
enum step_status method_adapt(const struct method *method, struct step *step,
                              struct controller *controller, double t_end)
{
    const int n = step->system->n;
    assert(method->flags & METHOD_ADAPTIVE);
    if (t_end - step->t == 0)
        return STEP_OK;
    /* h = 0 means that the first step has to be chosen */
    if (method->adapt || step->system->switches > 0 || controller->h == 0)
        return adapt_any(method, step, controller, t_end);
    if (step->controlled && !step->low && !step->system->kinks) {
        enum step_status status;
        step->controlled(step, controller, t_end, 1, NULL, &status);
        return status;
    }
    switch (n) {
    case 2:
        return adapt_two(method, step, controller, t_end);
    case 3:
        return adapt_three(method, step, controller, t_end);
    case 4:
        return adapt_four(method, step, controller, t_end);
    default:
        return adapt_any(method, step, controller, t_end);
    }
}

bool method_adapts_many(const struct step *step, const struct controller *controller)
{
    return step->controlled && !step->low && !step->system->kinks && step->system->switches == 0 &&
           controller->h != 0;
}

int64_t method_adapt_many(struct step *step, struct controller *controller, double t_end,
                          int64_t count, double *row, enum step_status *status)
{
    assert(method_adapts_many(step, controller) && step->t != t_end);
    return step->controlled(step, controller, t_end, count, row, status);
}
