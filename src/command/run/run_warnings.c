/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Warnings about a run, its step or its method, each given once, and notes about what was
 * assumed. */
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include <hooke/run/unresolved.h>
#include <hooke/scene/typed.h>
#include <hooke/command/handler.h>

#include <float.h>
#include <math.h>

/* ---- before the first step ---- */

/* Warns once per session if a typed scene is run with the default method. */
void reply_unchosen(struct session *session, struct reply *reply)
{
    const struct setup *setup = &session->setup;
    if (session->execution.said_method || setup->method_chosen || !typed_preset(setup->scene.model))
        return;
    session->execution.said_method = true;
    reply_warning(reply,
                  "no method was chosen, so %s with dt = %s is used; choose 'method dop853' for "
                  "accuracy or 'method radau5' for stiff equations",
                  setup->method->row.name, SHOWN_VALUE(setup->settings.dt, QUANTITY_TIME, 4));
}

/* Tells once per scene which duration, tolerance and first step are used because none was set. */
void reply_assumed(struct session *session, bool adapts, bool by_setting, struct reply *reply)
{
    const struct settings *settings = &session->setup.settings;
    const bool duration = by_setting && !settings->duration_chosen,
               tol = adapts && !settings->tol_chosen, first = adapts && !settings->dt_chosen;
    if (session->execution.said_assumed || !typed_preset(session->setup.scene.model) ||
        !(duration || tol || first))
        return;
    session->execution.said_assumed = true;
    struct buffer *text = reply_buffer(reply);
    buffer_put(text, TEXT("assumed: "));
    if (duration)
        buffer_format(text, "duration = %s%s", SHOWN_VALUE(settings->duration, QUANTITY_TIME, 4),
                      tol || first ? ", " : "");
    if (tol)
        buffer_format(text, "tol = %s%s", SHOWN_SHORT(settings->tol, 3), first ? ", " : "");
    if (first)
        buffer_format(text, "first step dt = %s",
                      SHOWN_VALUE(session_first_step(session), QUANTITY_TIME, 4));
    const char *setting;
    if (duration)
        setting = "duration";
    else
        setting = tol ? "tol" : "dt";
    buffer_format(text, " ('%s = ...' sets it)", setting);
}

/* Tells that a study covers less time than the current run. */
void reply_shorter(const struct session *session, struct reply *reply)
{
    const struct run *run = session_run(session);
    const double span = run ? fabs(run->t - run->system.t0) : 0,
                 duration = session->setup.settings.duration;
    if (!run || run->system.model != session->setup.scene.model || !(span > (1 + 1e-9) * duration))
        return;
    reply_line(reply,
               "this covers %.6g s, the setting 'duration', but run %d is %.6g s long ('duration = "
               "%.6g s' covers all of it)",
               duration, run->number, span, span);
}

/* Warns if the method cannot step the scene. */
void reply_inapplicable(const struct session *session, struct reply *reply)
{
    struct scene scene = session->setup.scene;
    struct system system;
    struct error why;
    enum drag drag = session->setup.drag;
    scene.steps_across_kinks = session->setup.settings.turning == TURNING_OFF;
    if (scene_bind(&scene, &system, &why) &&
        !method_applies(session->setup.method, &system, &drag, &why))
        reply_warning(reply, "%s%s%s", why.text, why.hint[0] ? ": " : "", why.hint);
}

/* Returns the period [s] of rotation about the starting point of a scene of two variables, by its
 * Jacobian; NAN for other scenes and if it does not rotate there. */
static double turning_period(const struct system *system)
{
    double j[4];
    if (system->n != 2)
        return NAN;
    system_jacobian(system, system->t0, system->start, j);
    const double half_trace = (j[0] + j[3]) / 2, determinant = j[0] * j[3] - j[1] * j[2];
    return 2 * M_PI / sqrt(determinant - half_trace * half_trace);
}

/* Warns of fixed steps that are long compared with the period, or with the limit of stability. */
void reply_coarse(const struct session *session, const struct run *run, struct reply *reply)
{
    const double own = derived_value(&session->setup.scene, "T0"), dt = run->settings.dt,
                 period = isnan(own) ? turning_period(&run->system) : own;
    /* the pace at the start is only a guess if the motion is no oscillation by itself */
    if (run->plan.adaptive || run->method->order == 0 || !(dt > (isnan(own) ? 1 : 0.125) * period))
        return;
    struct buffer text = {0};
    if (dt < period)
        buffer_format(&text, "%.0f %% of the period ", 100 * dt / period);
    else
        buffer_format(&text, "%s times the period ", SHOWN_SHORT(dt / period, 3));
    buffer_format(&text, "%s%s",
                  isnan(own) ? "at the start, " : "T0 = ", SHOWN_VALUE(period, QUANTITY_TIME, 4));
    if (isfinite(run->plan.limit) && run->plan.limit > 0)
        buffer_format(&text, "; %s needs dt < %s to stay stable", run->method->row.name,
                      SHOWN_VALUE(run->plan.limit, QUANTITY_TIME, 3));
    reply_warning(reply, "dt = %s is %s", SHOWN_VALUE(dt, QUANTITY_TIME, 4), buffer_view(&text));
    buffer_free(&text);
}

/* Returns the largest magnitude of n values. */
static double largest_of(const double *value, int n)
{
    double size = 0;
    for (int i = 0; i < n; i++)
        size = fmax(size, fabs(value[i]));
    return size;
}

/* Warns of a state so small that its squares underflow. */
void reply_tiny(const struct run *run, struct reply *reply)
{
    const double tiny = 1.5e-154; /* its square is the least normal number */
    const double size = largest_of(run->y, run->system.n);
    if (size > 0 && size < tiny)
        reply_warning(
            reply, "numbers below %g have squares of 0: energies are 0 and nothing can be measured",
            tiny);
}

/* ---- after an advance ---- */

/* Warns once if the method, not the scene, makes the energy grow, before it overflows. */
static void reply_growth(struct run *run, struct reply *reply)
{
    struct ledger ledger;
    if (run->warned_growth || !run_is_unstable(run))
        return;
    run_ledger_brief(run, &ledger);
    struct buffer text = {0};
    if (ledger.initial > 0)
        buffer_format(&text, "by a factor of %s", SHOWN_SHORT(ledger.final / ledger.initial, 2));
    else
        buffer_format(&text, "from 0 to %s", SHOWN_QUANTITY(ledger.final, QUANTITY_ENERGY, 3));
    buffer_format(&text, ": %s multiplies the amplitude by %s per step", run->method->row.name,
                  SHOWN_SHORT(run->plan.growth, 6));
    if (isfinite(run->plan.limit) && run->plan.limit > 0)
        buffer_format(&text, "; it is stable below dt = %s",
                      SHOWN_VALUE(run->plan.limit, QUANTITY_TIME, 3));
    reply_warning(reply, "the energy has grown %s", buffer_view(&text));
    buffer_free(&text);
    run->warned_growth = true;
}

/* Warns if fixed steps are too long for the changes of a force in time. */
static void reply_unresolved(const struct run *run, struct reply *reply)
{
    double dt;
    if (stop_is_failure(run->stop) || !run_force_unresolved(run, &dt))
        return;
    struct buffer advice = {0};
    if (isfinite(dt))
        buffer_format(&advice, "dt <= %s, or ", SHOWN_QUANTITY(dt, QUANTITY_TIME, 2));
    reply_warning(reply,
                  "the force changes faster in time than steps of dt = %s can follow, so this run "
                  "is not reliable; try %san adaptive method",
                  SHOWN_QUANTITY(run->settings.dt, QUANTITY_TIME, 3), buffer_view(&advice));
    buffer_free(&advice);
}

/* Warns of fixed steps across a time at which a slope is infinite but integrable: the result
 * depends on how near stages come to it. */
static void reply_poles(struct run *run, struct reply *reply)
{
    if (run->warned_unsound || run->cost.poles == 0 || stop_is_failure(run->stop))
        return;
    reply_warning(reply,
                  "%lld step%s across a time at which a slope is infinite; fixed steps may be far "
                  "off from there on; use an adaptive method (radau5, tol = 1e-6)",
                  (long long)run->cost.poles, run->cost.poles == 1 ? " goes" : "s go");
    run->warned_unsound = true;
}

/* Warns once of a step whose result is far from the solution. */
void reply_unsound(struct run *run, struct reply *reply)
{
    reply_poles(run, reply);
    const struct unsound_step *unsound = &run->unsound;
    if (run->warned_unsound || !(unsound->times > 0) || stop_is_failure(run->stop))
        return;
    const char *remedy = "";
    if (run->plan.adaptive)
        remedy = "; set a smaller dt";
    else if (run->method->flags & METHOD_ADAPTIVE)
        remedy = "; with tol = 1e-6 the method chooses its steps itself";
    reply_warning(
        reply,
        "%s too long for %s: at t = %.4g s a step gives %s = %.3g, but the solution is %.3g%s",
        run->plan.adaptive ? "the first step is" : "dt is", run->method->row.name, unsound->t,
        system_variable(&run->system, unsound->variable).name, unsound->value, unsound->solution,
        remedy);
    run->warned_unsound = true;
}

/* Names a burst of the forces that no step has seen, once. */
static void reply_missed_burst(struct run *run, struct reply *reply)
{
    const struct burst *burst = &run->missed;
    const double length = fabs(burst->t_end - burst->t_begin);
    if (run->warned_burst || length == 0)
        return;
    reply_warning(reply,
                  "the steps missed a short pulse near t = %.4g s that lasts less than %.1g s, so "
                  "this run is without it; fixed steps ('tol = off') of dt = %.1g s include it",
                  burst->t_begin + (burst->t_end - burst->t_begin) / 2, length, length / 100);
    run->warned_burst = true;
}

/* Warns of an exact solution over so many periods that rounding k or m to a double changes its
 * phase, phase * DBL_EPSILON, by more than unknown_max. */
static void reply_phase_unknown(const struct run *run, struct reply *reply)
{
    const double unknown_max = 1e-3; /* [rad] */
    const struct oscillator *o = &run->system.oscillator;
    const double phase = sqrt(fmax(o->stiffness, 0)) * fabs(run->t - run->system.t0),
                 unknown = phase * DBL_EPSILON;
    if (!(run->method->flags & METHOD_EXACT) || !o->whole || !(unknown > unknown_max))
        return;
    if (unknown >= 2 * M_PI)
        reply_warning(reply,
                      "after %.3g rad no digit of the phase is correct: rounding k or m changes it "
                      "by more than a turn; only the amplitude is meaningful",
                      phase);
    else
        reply_warning(
            reply, "after %.3g rad the phase is uncertain by %.2g rad, because k and m are rounded",
            phase, unknown);
}

/* Warns if all values have become too small for a double, unless forces hold them at 0. */
static void reply_vanished(const struct run *run, struct reply *reply)
{
    const int n = run->system.n;
    const bool rests = run->controller.switches.slides > 0; /* forces hold it at 0 */
    if (largest_of(run->system.start, n) >= DBL_MIN && largest_of(run->y, n) < DBL_MIN &&
        run->steps > 0 && !rests)
        reply_warning(
            reply,
            "the motion has vanished: every value is below the smallest positive number, %.3g",
            DBL_MIN);
}

/* Warns once if the motion is held by switches, or if these pile up. */
static void reply_sliding(struct run *run, struct reply *reply)
{
    const struct switches_state *state = &run->controller.switches;
    const struct system *system = &run->system;
    const bool slides = state->slides + state->crossings > 0, piles = state->piles > 0;
    const bool slot = system->dry && state->slides > 0 && state->first == system->switches - 1 &&
                      state->crossings == 0;
    if (slot && !piles) /* expected of dry friction, and part of the run's line */
        return;
    if ((run->warned_sliding || !slides) && (run->warned_piling || !piles))
        return;
    struct buffer text = {0};
    int count = 0;
    for (int i = 0; i < system->n; i++)
        if (system_switch_sees(system, state->first, run->t, run->y, i))
            buffer_format(&text, "%s%s", count++ > 0 ? ", " : "", system_variable(system, i).name);
    const char *names = count > 0 ? buffer_view(&text) : "t";
    if (piles && !run->warned_piling)
        reply_warning(reply,
                      "switches (if, abs, sign, ...) accumulate at t = %.6g s, first in %s; from "
                      "then on the motion is held where they meet",
                      state->slid, names);
    else if (state->slides == 0)
        reply_warning(reply,
                      "from t = %.6g s on neither side of a switch (if, abs, sign, ...) has a "
                      "solution: steps go across it and their errors are unknown",
                      state->slid);
    else
        reply_warning(reply,
                      "at a switch (if, abs, sign, ...) in %s both sides lead back to it, first at "
                      "t = %.6g s: the motion sticks or slides along it until one side leads away",
                      names, state->slid);
    run->warned_sliding = true;
    run->warned_piling = piles;
    buffer_free(&text);
}

/* Gives all warnings that concern the run up to now. */
void reply_run_warnings(struct run *run, struct reply *reply)
{
    reply_growth(run, reply);
    reply_unresolved(run, reply);
    reply_unsound(run, reply);
    reply_vanished(run, reply);
    reply_missed_burst(run, reply);
    reply_phase_unknown(run, reply);
    reply_sliding(run, reply);
}
