/* SPDX-License-Identifier: GPL-3.0-or-later */
/* run_explain(): why a run stopped, in words for the user, with advice. Each explain_ function
 * appends one explanation; those that return a bool append nothing and return false if theirs does
 * not apply. */
#include <hooke/base/number.h>
#include <hooke/base/elementary.h>

#include "run/private.h"

#include <math.h>
#include <stdlib.h>

/* Returns x > 0 rounded down to one digit, for advice. */
static double round_down_to_digit(double x)
{
    double unit = fixed_pow(10, floor(fixed_log10(x)));
    return floor(x / unit) * unit;
}

/* Appends a time with its unit. */
static void put_time(struct buffer *text, double seconds, int digits)
{
    buffer_short(text, seconds, digits);
    buffer_format(text, " s");
}

#define STEP_HOPELESS 1e-6 /* Part of the step in use; a shorter one is no useful advice. */
/* Part of the largest state above which linear growth, not the method, explains it. */
#define LINEAR_GROWTH_MIN 1e-30
#define T0_LARGE 1e6    /* a t0 above this many times the run's length costs t its digits */
#define TOL_SMALL 1e-11 /* Step control may see only rounding below this tolerance. */

/* A state is trusted up to this many natural sizes, or sizes at the start; a larger one may be the
 * work of an unstable method. */
#define RELIABLE_SIZES 2

/* Returns the last recorded state before the run blew up, or the first one, and sets *t [s]. A
 * state that has blown up says nothing about the rates of the scene. */
static const double *trusted_state(const struct run *run, double *t)
{
    const struct system *system = &run->system;
    *t = run->t;
    if (!run->trace)
        return run->y;
    for (size_t row = trace_count(run->trace); row-- > 0;) {
        const double *y = trace_state(run->trace, row);
        bool sound = true;
        for (int i = 0; i < system->n && sound; i++)
            sound = fabs(y[i]) <= RELIABLE_SIZES * fmax(system->scale[i], fabs(system->start[i]));
        if (sound || row == 0) {
            *t = trace_time(run->trace, row);
            return y;
        }
    }
    return run->y;
}

/* Returns the rate [1/s] of the fastest motion near trusted_state(): the norm of the Jacobian in
 * scaled variables. */
static double fastest_rate(const struct run *run)
{
    double t;
    const double *y = trusted_state(run, &t);
    double max = 0;
    const struct system *system = &run->system;
    const int n = system->n;
    double *jac = system_new_jacobian(system, t, y);
    for (int i = 0; jac && i < n; i++) {
        double sum = 0;
        for (int j = 0; j < n; j++)
            sum += fabs(jac[i * n + j]) * system->scale[j] / system->scale[i];
        max = fmax(max, sum);
    }
    free(jac);
    return max;
}

/* Returns what run_diagnose() has found out about the solution. */
static enum solution_fate fate_of(const struct run *run)
{
    return run->private_state ? run->private_state->fate : SOLUTION_UNKNOWN;
}

/* Computes the derivatives slope [n]. Returns the variable whose derivative is not a finite number,
 * or -1 if all are finite. */
static int undefined_slope(const struct system *system, double t, const double *y, double *slope)
{
    system_derivative(system, t, y, slope);
    for (int i = 0; i < system->n; i++)
        if (!isfinite(slope[i]))
            return i;
    return -1;
}

/* Explains that a short way ahead, in the direction of motion, the equations have no value: beyond
 * the end of a square root or a logarithm. */
static bool explain_domain(const struct run *run, struct buffer *text)
{
    /* fractions of the step that was set */
    static const double ahead[] = {1e-6, 1e-4, 0.01, 0.1, 1};
    const struct system *system = &run->system;
    double slope[LIMIT_VARIABLES], y[LIMIT_VARIABLES], ignored[LIMIT_VARIABLES];
    const bool is_backward = !run->plan.adaptive && run->trace && trace_grid(run->trace)->h < 0;
    if (undefined_slope(system, run->t, run->y, slope) >= 0)
        return false;
    for (size_t k = 0; k < COUNT_OF(ahead); k++) {
        const double h = (is_backward ? -1 : 1) * ahead[k] * run->settings.dt;
        for (int i = 0; i < system->n; i++)
            y[i] = run->y[i] + h * slope[i];
        const int undefined = undefined_slope(system, run->t + h, y, ignored);
        if (undefined < 0 || !isnan(ignored[undefined]))
            continue;
        const double farther = 1.5 * h;
        for (int i = 0; i < system->n; i++)
            y[i] = run->y[i] + farther * slope[i];
        if (undefined_slope(system, run->t + farther, y, ignored) < 0)
            return false;
        buffer_format(text,
                      "%s' is not a number after t = ", system_variable(system, undefined).name);
        put_time(text, run->t, 6);
        buffer_put(text, TEXT(", where the equations are not defined"));
        return true;
    }
    return false;
}

/* Explains what is wrong with a state from which no step can be made: a variable that is too large,
 * or a derivative that is not finite. */
static bool explain_state(const struct run *run, struct buffer *text)
{
    /* fractions of a fixed step at which its stages are */
    static const double ahead[] = {0, 0.5, 1};
    const struct system *system = &run->system;
    for (int i = 0; i < system->n; i++) {
        if (fabs(run->y[i]) <= run_bound(system, i))
            continue;
        buffer_format(text, "%s = ", system_variable(system, i).name);
        buffer_short(text, run->y[i], 3);
        buffer_put(text, TEXT(" exceeds "));
        buffer_short(text, run_bound(system, i), 1);
        buffer_put(text, TEXT(", the limit of a run; use larger units"));
        return true;
    }
    for (size_t k = 0; k < (run->plan.adaptive ? 1 : COUNT_OF(ahead)); k++) {
        const double t = run->t + ahead[k] * (run->plan.adaptive ? 0 : run->settings.dt);
        double slope[LIMIT_VARIABLES];
        system_derivative(system, t, run->y, slope);
        for (int i = 0; i < system->n; i++) {
            if (isfinite(slope[i]))
                continue;
            buffer_format(text,
                          "%s' is not a finite number at t = ", system_variable(system, i).name);
            put_time(text, t, 6);
            struct text reason;
            if (system->autonomous)
                reason = TEXT(" for the state at that time");
            else
                reason =
                    run->plan.adaptive
                        ? TEXT("; no step can begin there, but a run can begin later")
                        : TEXT("; choose dt so that no step ends there, or an adaptive method");
            buffer_put(text, reason);
            return true;
        }
    }
    return false;
}

/* Returns which method to try if the scene's rates are too fast for the step: the exact one for an
 * oscillator that swings, since implicit methods would damp it, else an implicit one. */
static const char *remedy_for_rate(const struct run *run)
{
    const struct oscillator *o = &run->system.oscillator;
    return o->whole && 4 * o->stiffness > o->damping * o->damping ? "'method exact'"
                                                                  : "an implicit method";
}

/* Appends the advice to try steps of dt [s] or less, an implicit method if that helps, or one of
 * both. Steps shorter than STEP_HOPELESS times the present ones are advised only if an implicit
 * method does not help. */
static void put_shorter_step(const struct run *run, double dt, bool implicit_helps,
                             struct buffer *text)
{
    const bool hopeless = dt < STEP_HOPELESS * run->settings.dt;
    buffer_put(text, TEXT("; try "));
    if (!hopeless || !implicit_helps) {
        buffer_put(text, TEXT("dt <= "));
        put_time(text, round_down_to_digit(dt), 1);
    }
    if (implicit_helps)
        buffer_format(text, "%s%s", hopeless ? "" : " or ", remedy_for_rate(run));
}

/* Explains why an adaptive run diverged although its solution does not. */
static void explain_adaptive_divergence(const struct run *run, struct buffer *text)
{
    const double rate = fastest_rate(run);
    if (!(run->method->flags & METHOD_IMPLICIT) && !run->method->rosenbrock &&
        rate * run->settings.dt * STEP_HOPELESS > 1) {
        buffer_put(text, TEXT("the scene's fastest rate is about "));
        buffer_short(text, rate, 2);
        buffer_format(text, " 1/s, too fast for %s; try %s", run->method->row.name,
                      remedy_for_rate(run));
    } else if (fate_of(run) == SOLUTION_GOES_ON) {
        buffer_put(text, TEXT("the errors of the steps grew beyond the range of numbers, although "
                              "the solution continues; try a smaller tol"));
    } else {
        buffer_put(text, TEXT("no step, however short, gives a state within the range of numbers; "
                              "the cause is unknown"));
    }
}

/* Returns true if the solution itself leaves the range of numbers although it reaches infinity only
 * after infinite time. */
static bool solution_grows(const struct run *run)
{
    double largest = 0;
    for (int i = 0; i < run->system.n; i++)
        largest = fmax(largest, fabs(run->y[i]) / run_bound(&run->system, i));
    return fate_of(run) == SOLUTION_GROWS ||
           (run->plan.adaptive && run->system.linear && largest > LINEAR_GROWTH_MIN);
}

/* Explains why a run of fixed steps diverged: the scene grows, or the step is above the stability
 * limit of the method or too long for the scene's rates. */
static void explain_fixed_divergence(const struct run *run, struct buffer *text)
{
    const struct oscillator *o = &run->system.oscillator;
    const char *name = run->method->row.name;
    double dt = run->settings.dt, limit = run->plan.limit, growth = run->plan.growth;
    /* Computed only if it is needed, because it may pass over many rows. */
    const double rate = isnan(limit) ? fastest_rate(run) : NAN;
    bool implicit = run->method->flags & METHOD_IMPLICIT;
    if (o->whole && (o->stiffness < 0 || o->damping < 0)) {
        buffer_format(text, "the scene itself grows (%s < 0)", o->stiffness < 0 ? "k" : "gamma");
    } else if (limit == 0 && o->damping == 0) {
        buffer_format(text, "%s is unstable on an undamped oscillator for every dt (growth ", name);
        buffer_short(text, growth, 5);
        buffer_format(text, " per step); try symplectic-euler");
    } else if (limit > 0 && dt > limit) {
        buffer_format(text, "dt = ");
        put_time(text, dt, 6);
        buffer_format(text, " is above the stability limit ");
        put_time(text, limit, 3);
        buffer_format(text, " of %s", name);
        put_shorter_step(run, limit / 10, limit < STEP_HOPELESS * dt, text);
    } else if (growth > 1) {
        buffer_format(text, "%s grows by ", name);
        buffer_short(text, growth, 5);
        buffer_format(text, " per step at this dt; try a smaller dt or an implicit method");
    } else if (!implicit && isnan(limit) && isfinite(rate) && rate * dt > 1) {
        buffer_format(text, "the scene's fastest rate is about ");
        buffer_short(text, rate, 2);
        buffer_format(text, " 1/s, too fast for %s at dt = ", name);
        put_time(text, dt, 6);
        put_shorter_step(run, 1 / rate, true, text);
    } else {
        buffer_put(text, fate_of(run) == SOLUTION_GOES_ON
                             ? TEXT("with steps of this size the state exceeds the range of "
                                    "numbers, but the solution continues")
                             : TEXT("the state exceeds the range of numbers; it is unknown whether "
                                    "the solution does"));
        put_shorter_step(run, dt / 10, false, text);
    }
}

/* Explains why a run left the range of numbers. */
static void explain_divergence(const struct run *run, struct buffer *text)
{
    if (explain_domain(run, text) || explain_state(run, text))
        return;
    if (solution_grows(run))
        buffer_put(text, TEXT("the solution itself grows beyond the range of numbers"));
    else if (run->plan.adaptive)
        explain_adaptive_divergence(run, text);
    else
        explain_fixed_divergence(run, text);
}

/* Returns true if some derivative has an infinite slope in the state that was reached, as
 * sqrt(abs(v)) has at v = 0: then an implicit method has no Jacobian. */
static bool has_no_jacobian(const struct run *run)
{
    const struct system *system = &run->system;
    double *jac = system_new_jacobian(system, run->t, run->y);
    bool finite = true;
    for (int i = 0; jac && i < system->n * system->n; i++)
        finite = finite && isfinite(jac[i]);
    free(jac);
    return !finite;
}

/* Explains why the equations of an implicit step were not solved. */
static void explain_no_solution(const struct run *run, struct buffer *text)
{
    if (explain_domain(run, text) || explain_state(run, text))
        return;
    if (has_no_jacobian(run)) {
        buffer_format(text,
                      "the equations have an infinite slope there, and %s needs their Jacobian; "
                      "try a method that does not, such as dopri5",
                      run->method->row.name);
        return;
    }
    buffer_format(text, "the implicit equation of %s was not solved", run->method->row.name);
    if (run->plan.adaptive) {
        buffer_format(text, " by any step, however short%s",
                      fate_of(run) == SOLUTION_GOES_ON
                          ? ", although the solution continues; try a smaller tol"
                          : "");
    } else {
        put_shorter_step(run, run->settings.dt / 2, false, text);
    }
}

/* Explains why the step of an adaptive run went below the rounding of the time. */
static void explain_stall(const struct run *run, struct buffer *text)
{
    const double way = fabs(run->t - run->system.t0);
    if (explain_domain(run, text) || explain_state(run, text))
        return;
    buffer_put(text, TEXT("the step for tol = "));
    buffer_short(text, run->settings.tol, 3);
    buffer_put(text, TEXT(" is below the rounding of t"));
    if (fabs(run->system.t0) > T0_LARGE * way)
        buffer_put(text, TEXT(", which is large; choose t0 near 0"));
    else if (run->settings.tol < TOL_SMALL)
        buffer_put(text, TEXT("; try a larger tol"));
    else if (fate_of(run) == SOLUTION_GOES_ON)
        buffer_put(text, TEXT(", although the solution continues; try a smaller tol"));
    else
        buffer_put(text, TEXT("; the equations may jump there or have a singularity"));
}

/* Explains that the solution itself ends at a finite time. */
static void explain_singularity(const struct run *run, struct buffer *text)
{
    const bool is_past_singularity =
        fabs(run->t - run->system.t0) > 1.001 * fabs(run->singular.t - run->system.t0);
    buffer_format(text, "the solution itself %s at t = ", singularity_text(&run->singular));
    put_time(text, run->singular.t, 6);
    buffer_put(text, run->singular.finite ? TEXT(": ") : TEXT(" (a finite-time blow-up): "));
    if (is_past_singularity)
        buffer_put(text, TEXT("results of the method after that time are meaningless"));
    else if (run->singular.finite && !run->system.autonomous)
        buffer_put(text, TEXT("it may continue later, but no step gets past that time"));
    else
        buffer_put(text, TEXT("no method and no step gets past that time"));
}

/* Appends how, when and why the run stopped, as one sentence. */
void run_explain(const struct run *run, struct buffer *text)
{
    /* Words before the time at which the run stopped. */
    static const char *const what[] = {
        [STOP_NONE] = "at",
        [STOP_END] = "reached",
        [STOP_CONDITION] = "the condition became true at",
        [STOP_DIVERGED] = "diverged at",
        [STOP_CANCELLED] = "cancelled at",
        [STOP_NO_SOLUTION] = "no solution at",
        [STOP_STALLED] = "stalled at",
        [STOP_FULL] = "stopped at",
        [STOP_SINGULAR] = "stopped at",
        [STOP_GIVEN_UP] = "given up at",
    };
    buffer_format(text, "%s t = ", what[run->stop]);
    put_time(text, run->t, run->stop == STOP_CONDITION ? 10 : 6);
    buffer_format(text, " (step %lld)", (long long)run->steps);
    switch (run->stop) {
    case STOP_DIVERGED:
        buffer_put(text, TEXT(": "));
        explain_divergence(run, text);
        break;
    case STOP_NO_SOLUTION:
        buffer_put(text, TEXT(": "));
        explain_no_solution(run, text);
        break;
    case STOP_STALLED:
        buffer_put(text, TEXT(": "));
        explain_stall(run, text);
        break;
    case STOP_FULL:
        if (run_event_records(run) == LIMIT_EVENT_RECORDS) {
            buffer_format(text,
                          ": %d events were recorded, which is the limit; define a rarer event",
                          LIMIT_EVENT_RECORDS);
            break;
        }
        buffer_format(
            text,
            ": the trace holds %zu rows in %.4g MB and has no room for more; try 'set record auto'",
            trace_count(run->trace), (double)trace_bytes(run->trace) / 1e6);
        break;
    case STOP_SINGULAR:
        buffer_put(text, TEXT(": "));
        explain_singularity(run, text);
        break;
    case STOP_NONE:
    case STOP_END:
    case STOP_CONDITION:
    case STOP_CANCELLED:
    case STOP_GIVEN_UP:
        break;
    }
}
