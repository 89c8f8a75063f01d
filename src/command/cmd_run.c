/* SPDX-License-Identifier: GPL-3.0-or-later */
/* run, continue, step, back, reset */
#ifndef COMMAND_ROWS
#include "internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define SECONDS_ASKED 60    /* predicted run times above it need --force or a yes */
#define UNTIL_DURATIONS 1000 /* `run until` gives up after so many durations */
#define FAR 1e300            /* [s] no run gets there; finite, so that what is left of the way is a number */
#define SLICE_NS 10000000   /* 10 ms between looks at the front end */

/* ---- what is said about a run ------------------------------------------------------------------------------------------ */

void reply_run(const struct session *session, const struct run *run, struct reply *reply)
{
    struct ledger ledger;
    run_ledger(run, &ledger);
    const int digits = session->setup.settings.digits;
    struct buffer text = {0};
    buffer_put(&text, TEXT("t = "));
    buffer_measured(&text, (struct measured){run->t, 0}, QUANTITY_TIME, digits > 6 ? digits : 6);
    buffer_format(&text, ", %lld step%s, %s", (long long)run->steps, run->steps == 1 ? "" : "s", run->method->row.name);
    if (isfinite(ledger.error_max)) {
        buffer_put(&text, TEXT(", dE/E0 max "));
        buffer_short(&text, ledger.error_max, 2);
    }
    const double rms = run_data_rms(run, session_recording(session));
    if (isfinite(rms)) {
        buffer_put(&text, TEXT(", rms(y-data) = "));
        buffer_quantity(&text, rms, QUANTITY_LENGTH, 2);
    }
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    if (reply->format == FORMAT_TEXT)
        return;
    struct run_errors errors;
    run_errors(run, &errors);
    reply_begin(reply, "run");
    reply_int(reply, "run", run->number);
    reply_string(reply, "method", run->method->row.name);
    reply_real(reply, "dt", run->plan.adaptive ? (double)NAN : run->settings.dt);
    reply_real(reply, "tol", run->plan.adaptive ? run->settings.tol : (double)NAN);
    reply_int(reply, "steps", run->steps);
    reply_int(reply, "evals", run->cost.evals);
    reply_real(reply, "t", run->t);
    reply_real(reply, "y", run->y[0]);
    reply_real(reply, "v", run->system.order == 2 ? run->y[run->system.n / 2] : (double)NAN);
    reply_object(reply, "state");
    for (int i = 0; i < run->system.n; i++)
        reply_real(reply, system_variable(&run->system, i).name, run->y[i]);
    reply_close(reply);
    reply_real(reply, "energy", ledger.final);
    reply_real(reply, "energy_error", ledger.error_max);
    reply_real(reply, "error", errors.max);
    reply_string(reply, "status", stop_name(run->stop));
    reply_real(reply, "time", run->seconds);
    reply_end(reply);
}

/* Growth that the method made, not the scene: said once a run, before it reaches the bounds of a double. */
static void warn_growth(struct run *run, struct reply *reply)
{
    struct ledger ledger;
    const struct oscillator *o = &run->system.oscillator;
    if (run->warned_growth || !(run->plan.growth > 1) || o->damping < 0 || o->stiffness < 0 || run->stop == STOP_DIVERGED)
        return;
    run_ledger(run, &ledger);
    if (!(ledger.final > 100 * ledger.initial))
        return;
    struct buffer text = {0};
    buffer_format(&text, "the energy has grown by a factor of ");
    buffer_short(&text, ledger.final / ledger.initial, 2);
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

static void warn_coarse(const struct session *session, const struct run *run, struct reply *reply)
{
    const struct row *row = catalog_find(&derived_catalog, TEXT("T0"));
    const double period = ((const struct derived_row *)(const void *)row)->value(&session->setup.scene).value;
    const double dt = run->settings.dt;
    if (run->plan.adaptive || run->method->order == 0 || !(dt > 0.125 * period))
        return;
    struct buffer text = {0};
    buffer_put(&text, TEXT("dt = "));
    buffer_measured(&text, (struct measured){dt, 0}, QUANTITY_TIME, 4);
    buffer_format(&text, " is %.0f %% of the period T0 = ", 100 * dt / period);
    buffer_measured(&text, (struct measured){period, 0}, QUANTITY_TIME, 4);
    if (isfinite(run->plan.limit) && run->plan.limit > 0) {
        buffer_format(&text, "; %s needs dt < ", run->method->row.name);
        buffer_measured(&text, (struct measured){run->plan.limit, 0}, QUANTITY_TIME, 3);
        buffer_put(&text, TEXT(" to stay stable"));
    }
    reply_warning(reply, "%s", buffer_view(&text));
    buffer_free(&text);
}

/* ---- going --------------------------------------------------------------------------------------------------------------- */

static bool allow_long(struct session *session, const struct plan *plan, bool force, struct error *error)
{
    char question[200];
    if (!(plan->seconds > SECONDS_ASKED) || force)
        return true;
    snprintf(question, sizeof question, "this run takes about %.0f s (%.3g steps)", plan->seconds, plan->steps);
    if (session->typed && session->front.confirm)
        return session->front.confirm(session->front.context, question) || error_set(error, ERROR_CANCELLED, "not run");
    error_set(error, ERROR_COMMAND, "%s", question);
    return error_hint(error, "--force runs it all the same");
}

/* Advances in slices, says how it went; false if it did not get where it should. */
static bool advance(struct session *session, struct run *run, const struct run_target *target, struct reply *reply,
                    struct error *error)
{
    const struct front *front = &session->front;
    const double from = run->t;
    while (run_advance(run, target, SLICE_NS, front->cancel))
        if (front->progress)
            front->progress(front->context, run, isfinite(target->t) ? (run->t - from) / (target->t - from) : -1);
    if (front->progress)
        front->progress(front->context, run, 2);
    session->data_is_latest = false;
    session_changed(session);
    if (run->stop == STOP_CANCELLED)
        reply_line(reply, "stopped at t = %.6g s; 'continue' goes on", run->t);
    reply_run(session, run, reply);
    warn_growth(run, reply);
    if (run->stop == STOP_CANCELLED)
        return error_set(error, ERROR_CANCELLED, "run %d was interrupted and is kept up to t = %.6g s", run->number, run->t);
    if (run->stop == STOP_END && target->condition)
        return error_set(error, ERROR_COMMAND, "the condition did not become true up to t = %.6g s", run->t);
    if (run->stop == STOP_DIVERGED || run->stop == STOP_NO_SOLUTION || run->stop == STOP_STALLED || run->stop == STOP_FULL) {
        struct buffer why = {0};
        run_explain(run, &why);
        error_set(error, run->stop == STOP_FULL ? ERROR_COMMAND : ERROR_NUMERICAL, "%s", buffer_view(&why));
        error_hint(error, "run %d is kept up to there", run->number);
        buffer_free(&why);
        return false;
    }
    return true;
}

static struct run *new_run(struct session *session, double span, bool force, struct error *error)
{
    const struct run_settings settings = session_run_settings(session);
    struct run *run = run_create(&session->setup.scene, session->setup.method, &settings, span, error);
    if (!run)
        return NULL;
    if (!allow_long(session, &run->plan, force, error)) {
        run_destroy(run);
        return NULL;
    }
    return session_add_run(session, run, error) ? run : NULL;
}

HANDLER(run)
{
    const struct given *duration = given_for(given, "DURATION"), *to = given_for(given, "to"), *until = given_for(given, "until");
    const double t0 = session->setup.scene.value[param_index("t0")];
    double span = session->setup.settings.duration;
    struct run_target target = {.steps = -1, .scope = given->scope};
    if (duration->count)
        span = duration->item->value.value;
    else if (to->count)
        span = to->item->value.value - t0;
    target.t = to->count ? to->item->value.value : t0 + span;
    if (until->count) {
        target.condition = until->item->condition;
        target.t = t0 + UNTIL_DURATIONS * span;
        span = HUGE_VAL;
    }
    if (span == 0 || target.t == t0) {
        error_at(error, duration->count ? duration->where : to->where, "there is nothing to run: the time asked for is the start t0");
        return false;
    }
    struct run *run = new_run(session, span, is_given(given, "force"), error);
    if (!run)
        return false;
    warn_coarse(session, run, reply);
    return advance(session, run, &target, reply, error);
}

/* ---- the current run -------------------------------------------------------------------------------------------------------- */

static struct run *current(const struct session *session, struct error *error)
{
    struct run *run = session_run(session);
    if (!run) {
        error_set(error, ERROR_COMMAND, "there is no run yet");
        error_hint(error, "type: run");
    }
    return run;
}

static bool can_go_on(const struct run *run, struct error *error)
{
    if (run->stop != STOP_DIVERGED && run->stop != STOP_NO_SOLUTION && run->stop != STOP_FULL)
        return true;
    error_set(error, ERROR_COMMAND, "run %d cannot go on: it stopped because of status '%s' at t = %.6g s", run->number,
              stop_name(run->stop), run->t);
    return error_hint(error, "change dt or the method and start a new one with 'run', or go back with 'back N'");
}

static void warn_other_scene(const struct session *session, const struct run *run, struct reply *reply)
{
    const struct scene *now = &session->setup.scene;
    if (memcmp(now->value, run->scene.value, sizeof now->value) != 0 || run->method != session->setup.method)
        reply_warning(reply, "run %d goes on with the parameters and the method it was started with; 'run' starts one with the present ones",
                      run->number);
}

static double direction(const struct run *run)
{
    return run->t < run->system.t0 ? -1 : 1;
}

HANDLER(continue)
{
    const struct given *duration = given_for(given, "DURATION");
    const double span = duration->count ? duration->item->value.value : session->setup.settings.duration;
    struct run *run = current(session, error);
    struct plan plan;
    if (!run || !can_go_on(run, error) ||
        !plan_make(&run->system, run->method, &run->settings, direction(run) * span, &plan, error) ||
        !allow_long(session, &plan, is_given(given, "force"), error))
        return false;
    warn_other_scene(session, run, reply);
    return advance(session, run, &(struct run_target){.t = run->t + direction(run) * span, .steps = -1}, reply, error);
}

HANDLER(step)
{
    const struct given *count = given_for(given, "N");
    const int64_t steps = count->count ? (int64_t)count->item->value.value : 1;
    struct run *run = session_run(session);
    if (run ? !can_go_on(run, error) : !(run = new_run(session, (double)steps * session->setup.settings.dt, true, error)))
        return false;
    if (count->count == 0 || steps <= 1000000000)
        return advance(session, run, &(struct run_target){.t = direction(run) * FAR, .steps = steps}, reply, error);
    return error_at(error, count->where, "more than 1e9 steps: use continue DURATION");
}

HANDLER(back)
{
    const struct given *count = given_for(given, "N");
    const int64_t rows = count->count ? (int64_t)count->item->value.value : 1;
    struct run *run = current(session, error);
    if (!run)
        return false;
    if (run->steps == 0)
        return error_set(error, ERROR_COMMAND, "run %d is at its start", run->number);
    if (!run_back(run, rows))
        reply_warning(reply, "run %d has fewer recorded states than that: it is at its start now", run->number);
    session_changed(session);
    reply_run(session, run, reply);
    return true;
}

HANDLER(reset)
{
    UNUSED(given);
    struct run *run = current(session, error);
    if (!run)
        return false;
    if (run->steps > 0) {
        run_back(run, INT64_MAX);
        session_changed(session);
    }
    reply_run(session, run, reply);
    return true;
}
#endif

COMMAND(run, .row = {"run", "", "start a new run at t0", "", "r"}, .group = "RUN",
        .text = "Runs for DURATION (else the setting 'duration'), to the time T, or until a condition becomes true. T before t0 and a\n"
                "negative DURATION go backwards. A condition that stays false ends the run after 1000 durations, with an error. Says the\n"
                "largest error of the energy balance and, with a recording, the rms distance from it.",
        .examples = "run 10 s\nrun until y < 0", .see = "continue step back plan runs compare", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("DURATION", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME, .group = 1),
                  WORD("to", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME, .group = 1),
                  WORD("until", TYPE_CONDITION, .group = 1), OPTION("force", TYPE_NONE)))

COMMAND(continue, .row = {"continue", "", "let the current run go on", "", NULL}, .group = "RUN",
        .text = "For DURATION (else the setting 'duration'), with the parameters and the method that the run was started with. The result\n"
                "is the same, bit for bit, as if the run had been longer from the start.",
        .examples = "continue 5 s\nrun; continue", .see = "run step back", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("DURATION", TYPE_VALUE, .quantity = QUANTITY_TIME), OPTION("force", TYPE_NONE)))

COMMAND(step, .row = {"step", "", "N steps more of the current run", "", "s"}, .group = "RUN",
        .text = "Starts a run where there is none.", .examples = "step\nstep 100", .see = "back continue run", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("N", TYPE_INTEGER)))

COMMAND(back, .row = {"back", "", "take the current run back by N recorded states", "", NULL}, .group = "RUN",
        .text = "Restores what was recorded; nothing is integrated backwards.", .examples = "step 10; back 3\nback",
        .see = "step reset undo", .flags = COMMAND_CHANGES, ARGUMENTS(PLACE("N", TYPE_INTEGER)))

COMMAND(reset, .row = {"reset", "", "take the current run back to its start", "", NULL}, .group = "RUN",
        .text = "Its parameters stay those it was started with.", .examples = "reset\nreset; step 5", .see = "back run",
        .flags = COMMAND_CHANGES)
