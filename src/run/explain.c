/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Why a run stopped, and what to do about it. */
#include <hooke/base/elementary.h>

#include "run/private.h"

#include <math.h>
#include <stdlib.h>

/* Rounded down to one digit: advice, not a bound. */
static double one_digit(double x)
{
    double unit = fixed_pow(10, floor(fixed_log10(x)));
    return floor(x / unit) * unit;
}

static void put_time(struct buffer *text, double seconds, int digits)
{
    buffer_short(text, seconds, digits);
    buffer_format(text, " s");
}

#define SOUND 2 /* natural sizes: what is larger may be the method's doing */

/* The last recorded state before it blew up, or the start. What a blown-up state says of rates
 * means nothing. */
static const double *sound_state(const struct run *run, double *t)
{
    const struct system *system = &run->system;
    *t = run->t;
    if (!run->trace)
        return run->y;
    for (size_t row = trace_count(run->trace); row-- > 0;) {
        const double *y = trace_state(run->trace, row);
        bool sound = true;
        for (int i = 0; i < system->n && sound; i++)
            sound = fabs(y[i]) <= SOUND * fmax(system->scale[i], fabs(system->start[i]));
        *t = trace_time(run->trace, row);
        if (sound || row == 0)
            return y;
    }
    return run->y;
}

/* [1/s] of the fastest motion near the last sound state: the norm of the Jacobian in scaled
 * variables. */
static double fastest_rate(const struct run *run)
{
    double t;
    const double *y = sound_state(run, &t);
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

static void explain_divergence(const struct run *run, struct buffer *text)
{
    const struct oscillator *o = &run->system.oscillator;
    const char *name = run->method->row.name;
    double dt = run->settings.dt, limit = run->plan.limit, growth = run->plan.growth,
           rate = fastest_rate(run);
    bool implicit = run->method->flags & METHOD_IMPLICIT;
    if (run->plan.adaptive) {
        buffer_format(text, "no step, however short, gives a state within the range of numbers: "
                            "the solution itself "
                            "seems to leave it");
    } else if (o->whole && (o->stiffness < 0 || o->damping < 0)) {
        buffer_format(text, "the scene itself grows (%s < 0)", o->stiffness < 0 ? "k" : "gamma");
    } else if (limit == 0 && o->damping == 0) {
        buffer_format(text, "%s is unstable on an undamped oscillator for every dt (growth ", name);
        buffer_short(text, growth, 5);
        buffer_format(text, " a step); try symplectic-euler");
    } else if (limit > 0 && dt > limit) {
        buffer_format(text, "dt = ");
        put_time(text, dt, 6);
        buffer_format(text, " is above the stability limit ");
        put_time(text, limit, 3);
        buffer_format(text, " of %s; try dt <= ", name);
        put_time(text, one_digit(limit / 10), 1);
    } else if (growth > 1) {
        buffer_format(text, "%s grows by ", name);
        buffer_short(text, growth, 5);
        buffer_format(text, " a step at this dt; try a smaller dt or an implicit method");
    } else if (!implicit && isnan(limit) && isfinite(rate) && rate * dt > 1) {
        buffer_format(text, "the scene's fastest rate is about ");
        buffer_short(text, rate, 2);
        buffer_format(text, " 1/s, too fast for %s at dt = ", name);
        put_time(text, dt, 6);
        buffer_format(text, "; try dt <= ");
        put_time(text, one_digit(1 / rate), 1);
        buffer_format(text, " or an implicit method");
    } else {
        buffer_format(text, "the state left the range of numbers; try dt <= ");
        put_time(text, one_digit(dt / 10), 1);
    }
}

void run_explain(const struct run *run, struct buffer *text)
{
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
        buffer_format(text, ": ");
        explain_divergence(run, text);
        break;
    case STOP_NO_SOLUTION:
        buffer_format(text, ": the implicit equation of %s was not solved", run->method->row.name);
        if (run->plan.adaptive) {
            buffer_format(text, " by any step, however short");
        } else {
            buffer_format(text, "; try dt <= ");
            put_time(text, one_digit(run->settings.dt / 2), 1);
        }
        break;
    case STOP_STALLED:
        buffer_format(text, ": the step for tol = ");
        buffer_short(text, run->settings.tol, 3);
        buffer_format(text, " is below the rounding of t; try a larger tol");
        if (!(run->method->flags & METHOD_IMPLICIT))
            buffer_format(text, " or an implicit method");
        break;
    case STOP_FULL:
        if (run_event_records(run) == LIMIT_EVENT_RECORDS) {
            buffer_format(text,
                          ": %d events were noticed, more are not kept; watch for something rarer",
                          LIMIT_EVENT_RECORDS);
            break;
        }
        buffer_format(
            text,
            ": the trace holds %zu rows in %.4g MB and has no room for more; try 'set record auto'",
            trace_count(run->trace), (double)trace_bytes(run->trace) / 1e6);
        break;
    case STOP_SINGULAR:
        buffer_format(text, ": the solution itself %s at t = ", singularity_text(&run->singular));
        put_time(text, run->singular.t, 6);
        buffer_put(text, run->singular.finite ? TEXT(": ") : TEXT(" (a finite-time blow-up): "));
        buffer_put(text,
                   fabs(run->t - run->system.t0) > 1.001 * fabs(run->singular.t - run->system.t0)
                       ? TEXT("what the method gives beyond means nothing")
                       : TEXT("no method and no step gets past it"));
        break;
    case STOP_NONE:
    case STOP_END:
    case STOP_CONDITION:
    case STOP_CANCELLED:
    case STOP_GIVEN_UP:
        break;
    }
}
