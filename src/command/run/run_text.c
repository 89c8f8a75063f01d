/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is said about a run: how it went, and what is wrong with its step. */
#include <hooke/report.h>
#include <hooke/run/unresolved.h>
#include <hooke/scene/typed.h>
#include <hooke/command/handler.h>

#include <float.h>
#include <math.h>

#define TINY 1.5e-154 /* its square is the least normal number */

#define STANDARD_GRAVITY 9.80665 /* [m/s^2] */
#define NEAR_GRAVITY 0.05        /* share of it by which a sensor may be off */

/* An acceleration whose mean is that of gravity, to either side, was measured with it: NAN, or the
 * mean [m/s^2]. */
static double gravity_in(const struct recording *recording)
{
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < recording->rows; i++)
        if (isfinite(recording->y[i])) {
            sum += recording->y[i] - recording->zero;
            count++;
        }
    const double mean = sum / (double)count;
    const bool near = fabs(fabs(mean) - STANDARD_GRAVITY) < NEAR_GRAVITY * STANDARD_GRAVITY;
    return near && recording->column[recording->value].quantity == QUANTITY_ACCELERATION ? mean
                                                                                         : NAN;
}

/* Why a recording of the same time is neither drawn over the run nor compared with it; or how,
 * where it has no unit. */
static void say_apart(const struct session *session, const struct run *run, struct reply *reply)
{
    const struct recording *recording = session_recording(session);
    const struct variable first = system_variable(&run->system, 0);
    const bool bare = recording && recorded_bare(recording);
    const double gravity =
        recording && recorded_derivative(recording, run) == 2 ? gravity_in(recording) : NAN;
    if (recording && isfinite(gravity))
        reply_line(reply,
                   "%s holds gravity: its mean is %.4g m/s^2, and the rms counts it ('data zero "
                   "%.6g m/s^2')",
                   recording->name, gravity, recording->zero + gravity);
    if (!recording || run->system.order != 2 || run->system.n != 2 ||
        (recorded_derivative(recording, run) >= 0 && !bare) ||
        !(fmin(run->system.t0, run->t) < recording->window[1] &&
          fmax(run->system.t0, run->t) > recording->window[0]))
        return;
    const struct column *value = &recording->column[recording->value];
    const char *needs = first.quantity == QUANTITY_ANGLE ? "deg" : "cm";
    if (bare) {
        struct buffer lacks = {0};
        put_bare(recording, &lacks);
        reply_line(reply,
                   "%s: %s %s: its numbers are laid over the run as %s ('load FILE "
                   "unit=%s' says otherwise)",
                   recording->name, value->name, buffer_view(&lacks), quantity_unit(first.quantity),
                   needs);
        buffer_free(&lacks);
    } else {
        reply_line(
            reply, "%s is not laid over the run, nor compared with it: it holds %s %s, %s is %s %s",
            recording->name, quantity_article(value->quantity), quantity_name(value->quantity),
            first.name, quantity_article(first.quantity), quantity_name(first.quantity));
    }
}

/* How a recording of a quantity that is no motion is laid over the run. */
static void say_scale(const struct session *session, const struct run *run,
                      const struct data_distance *data, struct reply *reply)
{
    if (!data->scaled || !isfinite(data->rms))
        return;
    const char *name = session_recording(session)->name,
               *first = system_variable(&run->system, 0).name;
    struct buffer text = {0};
    buffer_put(&text, isfinite(data->gain) ? TEXT("scaled: ") : TEXT(""));
    if (isfinite(data->gain))
        put_scale(data, run, &text);
    else
        buffer_format(&text, "not laid over the run: %s and %s do not move together",
                      quantity_name(data->quantity), first);
    reply_line(reply, "%s: %s", name, buffer_view(&text));
    buffer_free(&text);
}

/* Says that a recording lies beside the run as a whole, and what takes that out. */
static void say_offset(const struct session *session, const struct data_distance *data,
                       struct reply *reply)
{
    if (!isfinite(data->rms) || !isfinite(data->offset))
        return;
    const struct recording *recording = session_recording(session);
    const enum quantity own = recording->column[recording->value].quantity;
    struct buffer text = {0};
    buffer_format(&text, "%s is on average ", recording->name);
    buffer_quantity(&text, fabs(data->offset), data->quantity, 3);
    buffer_format(&text,
                  " %s the run, which is most of the rms: 'fit' and 'adopt' find its zero, or "
                  "'data zero ",
                  data->offset > 0 ? "above" : "below");
    buffer_quantity(&text, recording->zero + data->offset, own, 4);
    buffer_put(&text, TEXT("' sets it"));
    reply_line(reply, "%s", buffer_view(&text));
    buffer_free(&text);
}

#define NOTABLE 1e-3 /* of E0: a smaller error asks for no reason */

/* Next to an error that is large only because the energy was far larger on the way: by how much. */
static void put_peak(const struct run *run, const struct ledger *ledger, struct buffer *text)
{
    const double peak = ledger->error_max > NOTABLE ? run_energy_peak(run, ledger) : NAN;
    if (isnan(peak))
        return;
    buffer_put(text, TEXT(" (E up to "));
    buffer_short(text, peak, 2);
    buffer_put(text, TEXT(" E0)"));
}

/* Says how far the energy, or its balance where drag or a drive changes it, has been off; of a long
 * run how far in some of its rows, or, where that would take long, what the energy is now. */
static void put_energy(const struct run *run, struct buffer *text)
{
    const bool balanced = run->plan.ledger;
    struct ledger found, *ledger = &found;
    run_ledger_brief(run, ledger);
    if (run->stop == STOP_SINGULAR)
        return;
    if (!isfinite(ledger->error_max)) {
        if (run->steps == 0 || !isfinite(ledger->factor))
            return;
        buffer_put(text, balanced ? TEXT(", E = ") : TEXT(", dE/E0 "));
        buffer_short(text, balanced ? ledger->factor : ledger->factor - 1, balanced ? 3 : 2);
        buffer_put(text, balanced ? TEXT(" E0") : TEXT(" at the end"));
        return;
    }
    const bool large = ledger->error_max >= 1;
    if (balanced)
        buffer_format(text, ", energy balance %s ", large ? "off by" : "within");
    else
        buffer_put(text, TEXT(", dE/E0 max "));
    buffer_short(text, ledger->error_max, 2);
    if (balanced)
        buffer_put(text, large ? TEXT(" times E0") : TEXT(" of E0"));
    else if (isnan(ledger->work))
        buffer_put(text, TEXT(" in a sample of rows"));
    put_peak(run, ledger, text);
}

void reply_run(const struct session *session, const struct run *run, struct reply *reply)
{
    struct run_record record;
    if (reply->quiet && !reply_wants_records(reply))
        return;
    run_record_init(&record, session, run);
    const struct data_distance *data = &record.data;
    const int digits = session->setup.settings.digits;
    struct buffer text = {0};
    buffer_put(&text, TEXT("t = "));
    buffer_measured(&text, (struct measured){run->t, 0}, QUANTITY_TIME, digits > 6 ? digits : 6);
    buffer_format(&text, ", %lld step%s, %s", (long long)run->steps, run->steps == 1 ? "" : "s",
                  run->method->row.name);
    put_energy(run, &text);
    if (run->cost.turns > 0)
        buffer_format(&text, ", %lld extra step%s to end at %s", (long long)run->cost.turns,
                      run->cost.turns == 1 ? "" : "s",
                      run->system.switches > run->system.dry ? "switches" : "turning points");
    if (isfinite(record.rest)) {
        buffer_put(&text, TEXT(", held by dry friction from "));
        buffer_quantity(&text, record.rest, QUANTITY_TIME, 4);
    }
    if (isfinite(data->rms)) {
        const struct variable compared = run_derivative(run, data->derivative);
        buffer_format(&text, ", rms(%s-data) = ", compared.name);
        buffer_quantity(&text, data->rms, data->quantity, 2);
        if (data->bad > 0)
            buffer_format(&text, " (%zu bad sample%s left out)", data->bad,
                          data->bad == 1 ? "" : "s");
    }
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    say_scale(session, run, data, reply);
    say_offset(session, data, reply);
    say_apart(session, run, reply);
    if (reply_wants_records(reply))
        reply_run_record(&record, reply);
}

void reply_unresolved(const struct run *run, struct reply *reply)
{
    double dt;
    if (stop_is_failure(run->stop) || !run_force_unresolved(run, &dt))
        return;
    struct buffer text = {0};
    buffer_put(&text, TEXT("the force changes in time faster than steps of dt = "));
    buffer_quantity(&text, run->settings.dt, QUANTITY_TIME, 3);
    buffer_put(&text, TEXT(" can show: this run is not one of that force; try "));
    if (isfinite(dt)) {
        buffer_put(&text, TEXT("dt <= "));
        buffer_quantity(&text, dt, QUANTITY_TIME, 2);
        buffer_put(&text, TEXT(", or "));
    }
    buffer_put(&text, TEXT("an adaptive method"));
    reply_warning(reply, "%s", text.data ? text.data : "");
    buffer_free(&text);
}

void reply_growth(struct run *run, struct reply *reply)
{
    struct ledger ledger;
    const struct oscillator *o = &run->system.oscillator;
    if (run->warned_growth || !(run->plan.growth > 1) || o->damping < 0 || o->stiffness < 0 ||
        stop_is_failure(run->stop))
        return;
    run_ledger_brief(run, &ledger);
    if (!(ledger.final > 100 * ledger.initial))
        return;
    struct buffer text = {0};
    if (ledger.initial > 0) {
        buffer_put(&text, TEXT("the energy has grown by a factor of "));
        buffer_short(&text, ledger.final / ledger.initial, 2);
    } else {
        buffer_put(&text, TEXT("the energy has grown from 0 to "));
        buffer_quantity(&text, ledger.final, QUANTITY_ENERGY, 3);
    }
    buffer_format(&text, ": %s lets the amplitude grow by ", run->method->row.name);
    buffer_short(&text, run->plan.growth, 6);
    buffer_put(&text, TEXT(" a step"));
    if (isfinite(run->plan.limit) && run->plan.limit > 0) {
        buffer_put(&text, TEXT("; it is stable below dt = "));
        buffer_measured(&text, (struct measured){run->plan.limit, 0}, QUANTITY_TIME, 3);
    }
    reply_warning(reply, "%s", buffer_view(&text));
    buffer_free(&text);
    run->warned_growth = true;
}

/* Warns of fixed steps across an integrable pole: the stages beside it make the step. */
static void reply_poles(struct run *run, struct reply *reply)
{
    if (run->warned_unsound || run->cost.poles == 0 || stop_is_failure(run->stop))
        return;
    reply_warning(reply,
                  "%lld step%s across a time at which a slope is infinite: what fixed steps give "
                  "from there on may be far off; use an adaptive method (radau5, tol = 1e-6)",
                  (long long)run->cost.poles, run->cost.poles == 1 ? " goes" : "s go");
    run->warned_unsound = true;
}

void reply_unsound(struct run *run, struct reply *reply)
{
    reply_poles(run, reply);
    const struct unsound_step *unsound = &run->unsound;
    if (run->warned_unsound || !(unsound->times > 0) || stop_is_failure(run->stop))
        return;
    const char *remedy = "";
    if (run->plan.adaptive)
        remedy = "; dt sets it: try a shorter one";
    else if (run->method->flags & METHOD_ADAPTIVE)
        remedy = "; with tol = 1e-6 it chooses its own steps";
    reply_warning(reply,
                  "%s too long for %s: at t = %.4g s a step gives %s = %.3g, the solution is "
                  "%.3g%s",
                  run->plan.adaptive ? "the first step is" : "dt is", run->method->row.name,
                  unsound->t, system_variable(&run->system, unsound->variable).name, unsound->value,
                  unsound->solution, remedy);
    run->warned_unsound = true;
}

void reply_missed_burst(struct run *run, struct reply *reply)
{
    const struct burst *burst = &run->missed;
    const double length = fabs(burst->to - burst->from);
    if (run->warned_burst || length == 0)
        return;
    reply_warning(reply,
                  "no step has seen what happens near t = %.4g s in less than %.1g s: this run is "
                  "one without it; fixed "
                  "steps ('tol = off') of dt = %.1g s see it",
                  burst->from + (burst->to - burst->from) / 2, length, length / 100);
    run->warned_burst = true;
}

void reply_tiny(const struct run *run, struct reply *reply)
{
    double size = 0;
    for (int i = 0; i < run->system.n; i++)
        size = fmax(size, fabs(run->y[i]));
    if (size > 0 && size < TINY)
        reply_warning(
            reply,
            "the squares of numbers below %g are 0: energies read 0 and nothing can be measured",
            TINY);
}

#define PHASE_UNKNOWN 1e-3 /* [rad] */

void reply_phase_unknown(const struct run *run, struct reply *reply)
{
    const struct oscillator *o = &run->system.oscillator;
    const double phase = sqrt(fmax(o->stiffness, 0)) * fabs(run->t - run->system.t0),
                 unknown = phase * DBL_EPSILON;
    if (!(run->method->flags & METHOD_EXACT) || !o->whole || !(unknown > PHASE_UNKNOWN))
        return;
    if (unknown >= 2 * M_PI)
        reply_warning(
            reply,
            "after %.3g rad the phase has no right digit: one rounding of k or m moves it by more "
            "than a turn; only the amplitude means something",
            phase);
    else
        reply_warning(reply,
                      "after %.3g rad the phase is uncertain by %.2g rad: that is what one "
                      "rounding of k or m "
                      "does",
                      phase, unknown);
}

void reply_vanished(const struct run *run, struct reply *reply)
{
    double size = 0, start = 0;
    for (int i = 0; i < run->system.n; i++) {
        size = fmax(size, fabs(run->y[i]));
        start = fmax(start, fabs(run->system.start[i]));
    }
    const bool rests = run->controller.switches.slides > 0; /* where forces hold it: it is at 0 */
    if (start >= DBL_MIN && size < DBL_MIN && run->steps > 0 && !rests)
        reply_warning(reply,
                      "the motion has vanished: every value is below the smallest number, %.3g",
                      DBL_MIN);
}

void reply_sliding(struct run *run, struct reply *reply)
{
    const struct switches_state *state = &run->controller.switches;
    const struct system *system = &run->system;
    const bool slides = state->slides + state->across > 0, piles = state->piles > 0;
    const bool slot = system->dry && state->slides > 0 && state->first == system->switches - 1 &&
                      state->across == 0;
    if (slot && !piles) /* as dry friction should: the run says so */
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
                      "switches (if, abs, sign, ...) pile up at t = %.6g s, the first in %s: from "
                      "there on the "
                      "motion is held where they meet",
                      state->slid, names);
    else if (state->slides == 0)
        reply_warning(reply,
                      "from t = %.6g s on no side of a switch (if, abs, sign, ...) leads on: steps "
                      "go across, "
                      "and their errors are not known",
                      state->slid);
    else
        reply_warning(reply,
                      "at a switch (if, abs, sign, ...) in %s both sides lead back to it, first at "
                      "t = %.6g s: "
                      "the motion sticks to it or slides along, until one side turns away",
                      names, state->slid);
    run->warned_sliding = true;
    run->warned_piling = piles;
    buffer_free(&text);
}

void reply_unchosen(struct session *session, struct reply *reply)
{
    const struct setup *setup = &session->setup;
    if (session->said_method || setup->method_chosen || !typed_preset(setup->scene.model))
        return;
    session->said_method = true;
    struct buffer text = {0};
    buffer_format(&text, "no method was chosen: %s, dt = ", setup->method->row.name);
    buffer_measured(&text, (struct measured){setup->settings.dt, 0}, QUANTITY_TIME, 4);
    reply_warning(reply,
                  "%s; 'method dop853' is accurate, 'method radau5' where the equations are stiff",
                  buffer_view(&text));
    buffer_free(&text);
}

void reply_assumed(struct session *session, bool adapts, bool by_setting, struct reply *reply)
{
    const struct settings *settings = &session->setup.settings;
    const bool duration = by_setting && !settings->duration_chosen,
               tol = adapts && !settings->tol_chosen, first = adapts && !settings->dt_chosen;
    if (session->said_assumed || !typed_preset(session->setup.scene.model) ||
        !(duration || tol || first))
        return;
    session->said_assumed = true;
    struct buffer text = {0};
    const char *and = "";
    if (duration) {
        buffer_put(&text, TEXT("duration = "));
        buffer_measured(&text, (struct measured){settings->duration, 0}, QUANTITY_TIME, 4);
        and = ", ";
    }
    if (tol) {
        buffer_format(&text, "%stol = ", and);
        buffer_short(&text, settings->tol, 3);
        and = ", ";
    }
    if (first) {
        buffer_format(&text, "%sfirst step dt = ", and);
        buffer_measured(&text, (struct measured){session_first_step(session), 0}, QUANTITY_TIME, 4);
    }
    reply_line(reply, "assumed: %s ('%s = ...' sets it)", buffer_view(&text),
               duration ? "duration"
               : tol    ? "tol"
                        : "dt");
    buffer_free(&text);
}

void reply_shorter(const struct session *session, struct reply *reply)
{
    const struct run *run = session_run(session);
    const double span = run ? fabs(run->t - run->system.t0) : 0,
                 duration = session->setup.settings.duration;
    if (!run || run->system.model != session->setup.scene.model || !(span > (1 + 1e-9) * duration))
        return;
    reply_line(reply,
               "over %.6g s, the setting 'duration'; run %d took %.6g s ('duration = %.6g s' "
               "studies that)",
               duration, run->number, span, span);
}

void reply_inapplicable(const struct session *session, struct reply *reply)
{
    struct scene scene = session->setup.scene;
    struct system system;
    struct error why;
    enum drag drag = session->setup.drag;
    scene.across = session->setup.settings.turning == TURNING_OFF;
    if (scene_bind(&scene, &system, &why) &&
        !method_applies(session->setup.method, &system, &drag, &why))
        reply_warning(reply, "%s%s%s", why.text, why.hint[0] ? ": " : "", why.hint);
}

/* Returns the period [s] in which a scene of two variables turns about its starting point, NAN for
 * other scenes and where it does not turn there. */
static double turning_period(const struct system *system)
{
    double j[4];
    if (system->n != 2)
        return NAN;
    system_jacobian(system, system->t0, system->start, j);
    const double half_trace = (j[0] + j[3]) / 2, determinant = j[0] * j[3] - j[1] * j[2];
    return 2 * M_PI / sqrt(determinant - half_trace * half_trace);
}

void reply_coarse(const struct session *session, const struct run *run, struct reply *reply)
{
    const double own = derived_value(&session->setup.scene, "T0"), dt = run->settings.dt,
                 period = isnan(own) ? turning_period(&run->system) : own;
    /* A motion that is no oscillation by itself may leave its start at another pace. */
    if (run->plan.adaptive || run->method->order == 0 || !(dt > (isnan(own) ? 1 : 0.125) * period))
        return;
    struct buffer text = {0};
    buffer_put(&text, TEXT("dt = "));
    buffer_measured(&text, (struct measured){dt, 0}, QUANTITY_TIME, 4);
    if (dt < period) {
        buffer_format(&text, " is %.0f %% of", 100 * dt / period);
    } else {
        buffer_put(&text, TEXT(" is "));
        buffer_short(&text, dt / period, 3);
        buffer_put(&text, TEXT(" times"));
    }
    buffer_put(&text, isnan(own) ? TEXT(" the period at the start, ") : TEXT(" the period T0 = "));
    buffer_measured(&text, (struct measured){period, 0}, QUANTITY_TIME, 4);
    if (isfinite(run->plan.limit) && run->plan.limit > 0) {
        buffer_format(&text, "; %s needs dt < ", run->method->row.name);
        buffer_measured(&text, (struct measured){run->plan.limit, 0}, QUANTITY_TIME, 3);
        buffer_put(&text, TEXT(" to stay stable"));
    }
    reply_warning(reply, "%s", buffer_view(&text));
    buffer_free(&text);
}
