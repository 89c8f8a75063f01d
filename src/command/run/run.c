/* SPDX-License-Identifier: GPL-3.0-or-later */
/* run, continue, step, back, reset */
#ifndef COMMAND_ROWS
#include "command/internal.h"
#include "command/run/event_pass.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define SECONDS_ASKED 60     /* predicted run times above it need --force or a yes */
#define UNTIL_DURATIONS 1000 /* `run until` gives up after so many durations */
#define STEPS_MOST 1000000000
#define STEPS_JUDGED 100000 /* of an adaptive run, before its speed says how long it will take */
#define SLICE_NS 10000000   /* 10 ms between looks at the front end */

/* ---- going ---- */

bool allow_long(struct session *session, double seconds, double steps, bool force,
                struct error *error)
{
    char question[200];
    if (!(seconds > SECONDS_ASKED) || force)
        return true;
    snprintf(question, sizeof question, "this takes about %.0f s (%.3g steps)", seconds, steps);
    if (session->typed && (session->front.watched || session->front.confirm)) {
        /* Who watches it can pause it. */
        session->confirmed =
            session->front.watched || session->front.confirm(session->front.context, question);
        return session->confirmed || error_set(error, ERROR_CANCELLED, "not run");
    }
    error_set(error, ERROR_COMMAND, "%s", question);
    return session->setup.settings.duration_given || session->setup.scene.preset->duration == 0
               ? error_hint(error, "--force runs it all the same")
               : error_hint(error,
                            "%.4g s is the scene's own duration: give a shorter one ('duration = "
                            "10 s'), or choose "
                            "a method that adapts; --force runs it all the same",
                            session->setup.settings.duration);
}

/* The current run goes on along what was asked for last, at most `steps` steps of it (< 0: no
 * limit). */
struct advance {
    struct run_slot *slot;
    struct request request; /* as it was: the list may grow on the way */
    struct run_target target;
    int requests; /* journal and run as they were before */
    int64_t steps;
    double t;
    bool force;
    double left; /* [s] that it would have taken when it was given up */
};

/* Where an adaptive run was last looked at, on its way. */
struct pace {
    int64_t steps;
    double t, seconds;
};

/* The run's own events, in the names of its own scene. */
static bool watch(struct session *session, const struct arguments *given, struct advance *advance,
                  struct error *error)
{
    struct in_force *force = arena_alloc(given->arena, sizeof *force);
    struct names *names = arena_alloc(given->arena, sizeof *names);
    struct expr_scope *scope = arena_alloc(given->arena, sizeof *scope);
    const struct run_slot *slot = advance->slot;
    if (!force || !names || !scope)
        return error_memory(error);
    *force = (struct in_force){.slot = slot};
    *names =
        (struct names){.session = session, .in_force = force, .saved_only = true, .run = slot->run};
    *scope = names_scope(names);
    return events_compile(slot->events, scope, given->arena, &advance->target.event,
                          &advance->target.events, error);
}

static bool set_out(struct session *session, const struct arguments *given, int64_t steps,
                    struct advance *advance, struct error *error)
{
    struct run_slot *slot = session->run[session->current_run];
    const struct request *request = journal_pending(slot);
    const struct run *run = slot->run;
    const int64_t left = request->end == INT64_MAX ? -1 : request->end - run->steps;
    *advance = (struct advance){.slot = slot,
                                .request = *request,
                                .requests = journal_count(slot->last),
                                .steps = run->steps,
                                .t = run->t};
    advance->target =
        (struct run_target){.t = request->t,
                            .steps = steps >= 0 && (left < 0 || steps < left) ? steps : left,
                            .scope = given->scope};
    if (request->condition) {
        struct condition *condition = arena_alloc(given->arena, sizeof *condition);
        size_t used;
        if (!condition)
            return error_memory(error);
        if (!condition_compile(text_of(request->condition), given->scope, given->arena, condition,
                               &used, error)) {
            error->where = (struct text){NULL, 0};
            return false;
        }
        advance->target.condition = condition;
    }
    return !slot->events || watch(session, given, advance, error);
}

/*
 * How many steps an adaptive run takes nobody knows before. Each time that their number has doubled
 * the last half says how long the rest takes [s]; 0: not yet known.
 */
static double time_left(const struct run *run, const struct run_target *target, int64_t first,
                        struct pace *pace)
{
    const double rest = target->t - run->t;
    if (!run->plan.adaptive || target->condition || target->steps >= 0 || !(fabs(rest) < FAR) ||
        run->steps - first < (pace->steps ? 2 * (pace->steps - first) : STEPS_JUDGED))
        return 0;
    const double way = run->t - pace->t,
                 left = pace->steps ? (run->seconds - pace->seconds) * (rest / way) : 0;
    *pace = (struct pace){run->steps, run->t, run->seconds};
    return left;
}

/* False: it would take too long, and nobody wants that. */
static bool goes_on(struct session *session, const struct run *run, struct advance *advance,
                    int64_t first, struct pace *pace)
{
    struct error ignored = {0};
    const double steps = (double)pace->steps, t = pace->t;
    advance->left = advance->force ? 0 : time_left(run, &advance->target, first, pace);
    if (!(advance->left > SECONDS_ASKED))
        return true;
    const double more =
        ((double)run->steps - steps) * ((advance->target.t - run->t) / (run->t - t));
    return advance->force = allow_long(session, advance->left, more, false, &ignored);
}

static void travel(struct session *session, struct run *run, struct advance *advance, bool clocked)
{
    const struct front *front = &session->front;
    const struct run_target *target = &advance->target;
    const double from = run->t;
    struct pace pace = {.steps = 0};
    if (front->watched && front->slice) {
        live_advance(session, run, target, clocked && session->typed);
        return;
    }
    struct run_target rest = *target; /* its steps are counted from each call */
    const int64_t first = run->steps;
    while (run_advance(run, &rest, SLICE_NS, front->cancel)) {
        rest.steps = target->steps < 0 ? -1 : target->steps - (run->steps - first);
        if (!goes_on(session, run, advance, first, &pace)) {
            run->stop = STOP_GIVEN_UP;
            break;
        }
        if (front->progress)
            front->progress(front->context, run,
                            fabs(target->t) < FAR ? (run->t - from) / (target->t - from) : -1);
    }
    if (front->progress)
        front->progress(front->context, run, 2);
}

/* What `record`, and the transcript of the session, have to say where the statement alone does not
 * tell what happened. What events did it does again. */
static void tell(struct session *session, const struct advance *advance)
{
    const bool paused = stop_is_pause(advance->slot->run->stop);
    const bool whole = advance->requests == 1 && advance->steps == 0;
    if (paused || journal_changed(advance->slot, advance->requests))
        journal_write(session, advance->slot, whole ? 0 : advance->requests,
                      whole ? -1 : advance->steps, 0, false, &session->live.record);
}

static void reply_event(const struct run_slot *slot, const struct event_line *stopped,
                        struct reply *reply)
{
    const size_t count = run_event_records(slot->run);
    if (stopped)
        reply_line(reply, "event %s: stopped at t = %.9g s; 'continue' goes on%s", stopped->name,
                   slot->run->t,
                   stopped->action == EVENT_COMMANDS
                       ? ", as the last word of its commands by itself"
                       : "");
    if (count > (stopped ? 1 : 0))
        reply_line(reply, "%zu event%s noticed so far: 'list events' shows them", count,
                   count == 1 ? "" : "s");
}

/* Says how it went; false if it did not get where it should. */
static bool arrive(struct session *session, const struct advance *advance,
                   const struct event_pass *pass, struct reply *reply, struct error *error)
{
    struct run *run = advance->slot->run;
    run_diagnose(run);
    session->data_is_latest = false;
    session_changed(session);
    if (run->stop == STOP_CONDITION && pass->count == 0) {
        struct request *request = journal_edit_pending(advance->slot, error);
        if (!request)
            return false;
        request->met = run->steps;
    }
    tell(session, advance);
    if (run->stop == STOP_CANCELLED)
        reply_line(reply, "%s at t = %.6g s; 'continue' goes on",
                   session->front.watched ? "paused" : "stopped", run->t);
    seek_opinion(session, run);
    reply_run(session, run, reply);
    reply_event(advance->slot, pass->count > 0 ? pass->stopped[0] : NULL, reply);
    reply_growth(run, reply);
    reply_unsound(run, reply);
    reply_vanished(run, reply);
    struct error lost = {0};
    const bool right = reply_opinion(session, run, reply, &lost);
    reply_below_tolerance(run, reply);
    reply_missed_burst(run, reply);
    reply_phase_unknown(run, reply);
    reply_sliding(run, reply);
    reply_event_doubts(advance->slot, reply);
    if (run->stop == STOP_CANCELLED) {
        session->halted = session->front.watched;
        return session->front.watched ||
               error_set(error, ERROR_CANCELLED,
                         "run %d was interrupted and is kept up to t = %.6g s", run->number,
                         run->t);
    }
    if (run->stop == STOP_GIVEN_UP) {
        error_set(error, ERROR_COMMAND,
                  "given up at t = %.6g s after %lld steps: at this pace the rest takes about "
                  "%.2g s; run %d is kept up to there",
                  run->t, (long long)run->steps, advance->left, run->number);
        return error_hint(error, "--force runs it all the same%s",
                          run->method->flags & METHOD_IMPLICIT
                              ? ""
                              : "; try an implicit method that adapts, as radau5");
    }
    if (run->stop == STOP_END && advance->target.condition)
        return error_set(error, ERROR_COMMAND, "the condition did not become true up to t = %.6g s",
                         run->t);
    if (stop_is_failure(run->stop) || run->stop == STOP_FULL) {
        struct buffer why = {0};
        run_explain(run, &why);
        error_set(error, run->stop == STOP_FULL ? ERROR_COMMAND : ERROR_NUMERICAL, "%s",
                  buffer_view(&why));
        error_hint(error, "run %d is kept up to there", run->number);
        buffer_free(&why);
        return false;
    }
    if (!right)
        *error = lost;
    return right;
}

static void reply_running(const struct session *session, struct reply *reply)
{
    reply_line(reply, "running... (pause: Ctrl-C or F5; you can keep typing commands)");
    if (isfinite(session->live.speed))
        reply_line(reply, "it follows the clock; 'speed max': as fast as possible");
}

/*
 * On along the last request. `steps` ends it early on purpose: the run is then as good as paused,
 * what is left of the request can be done by `continue`.
 */
static bool advance(struct session *session, const struct arguments *given, int64_t steps,
                    bool clocked, struct reply *reply, struct error *error)
{
    struct advance advance;
    struct event_pass pass = {.count = 0};
    struct error why = {0};
    bool ok = true;
    if (!set_out(session, given, steps, &advance, error))
        return false;
    advance.force = advance.target.steps >= 0 || is_given(given, "force");
    struct run *run = advance.slot->run;
    const int64_t last = advance.target.steps < 0 ? -1 : run->steps + advance.target.steps;
    if (clocked && session->typed && session->front.watched && session->front.slice)
        reply_running(session, reply);
    do {
        advance.target.steps = last < 0 ? -1 : last - run->steps;
        travel(session, run, &advance, clocked);
    } while (events_pass(session, &advance.target, &pass, given, reply, &ok, &why));
    const bool early = run->stop == STOP_END && run->t != advance.request.t && steps >= 0 &&
                       run->steps < advance.request.end;
    if (early)
        advance.target.condition = NULL; /* it was not waited for */
    const bool arrived = arrive(session, &advance, &pass, reply, error);
    if (early && !stop_is_failure(run->stop))
        run->stop = STOP_CANCELLED;
    for (int i = 0; i < pass.count && arrived && ok; i++)
        ok = event_react(session, pass.stopped[i], given, reply, &why);
    if (arrived && !ok)
        *error = why;
    return arrived && ok;
}

static struct run *new_run(struct session *session, double span, int64_t steps, bool force,
                           struct error *error)
{
    const struct run_settings settings = session_run_settings(session);
    if (steps >= 0 && fabs(span) > (double)steps * settings.dt && !(settings.tol > 0))
        span = copysign((double)steps * settings.dt, span); /* no more than that is planned */
    struct run *run =
        run_create(&session->setup.scene, session->setup.method, &settings, span, error);
    if (!run)
        return NULL;
    struct plan plan = run->plan;
    if (steps >= 0 && plan.steps > (double)steps)
        plan.seconds *= (double)steps / plan.steps;
    if (!allow_long(session, plan.seconds, plan.steps, force, error)) {
        run_destroy(run);
        return NULL;
    }
    if (!session_add_run(session, run, error))
        return NULL;
    session->run[session->current_run]->events = session->setup.events;
    return run;
}

/* A request from where the current run is. */
static bool new_request(struct session *session, double t, int64_t end,
                        const struct given_argument *until, struct error *error)
{
    struct run_slot *slot = session->run[session->current_run];
    const struct request request = {
        .kind = REQUEST_GO, .from = slot->run->steps, .from_t = slot->run->t, .t = t, .end = end};
    const struct request *last = slot->last;
    /* Step by step is one request, not many. */
    if (end != INT64_MAX && last && last->kind == REQUEST_GO && last->t == t &&
        last->end == request.from) {
        struct request *edited = journal_edit_pending(slot, error);
        if (edited)
            edited->end = end;
        return edited != NULL;
    }
    return journal_add(slot, request, until->count ? until->item->text : TEXT(""), error);
}

static int64_t steps_given(const struct arguments *given)
{
    const struct given_argument *steps = argument_given(given, "steps");
    return steps->count ? (int64_t)steps->item->value.value : -1;
}

HANDLER(run)
{
    const struct given_argument *duration = argument_given(given, "DURATION"),
                                *to = argument_given(given, "to"),
                                *until = argument_given(given, "until"),
                                *number = argument_given(given, "number");
    const double t0 = param_value(&session->setup.scene, "t0");
    double span = session->setup.settings.duration;
    if (duration->count)
        span = duration->item->value.value;
    else if (to->count)
        span = to->item->value.value - t0;
    double t = to->count ? to->item->value.value : t0 + span;
    if (until->count) {
        t = t0 + UNTIL_DURATIONS * span;
        span = HUGE_VAL;
    }
    if (span == 0 || t == t0)
        return error_at(error, duration->count ? duration->where : to->where,
                        "there is nothing to run: the time asked for is the start t0");
    if (number->count &&
        (number->item->value.value < session->next_run || number->item->value.value > 1e9))
        return error_at(error, number->item->text, "the next run has the number %d or a larger one",
                        session->next_run);
    struct run *run = new_run(session, span, steps_given(given), is_given(given, "force"), error);
    if (!run)
        return false;
    if (number->count) {
        run->number = (int)number->item->value.value;
        session->next_run = run->number + 1;
    }
    reply_unchosen(session, reply);
    reply_assumed(session, run->plan.adaptive, !duration->count && !to->count, reply);
    reply_coarse(session, run, reply);
    reply_tiny(run, reply);
    return new_request(session, t, INT64_MAX, until, error) &&
           advance(session, given, steps_given(given), true, reply, error);
}

/* ---- the current run ---- */

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
    if (run->stop == STOP_STALLED || !(stop_is_failure(run->stop) || run->stop == STOP_FULL))
        return true;
    error_set(error, ERROR_COMMAND,
              "run %d cannot go on: it stopped because of status '%s' at t = %.6g s", run->number,
              stop_name(run->stop), run->t);
    return error_hint(
        error,
        run->stop == STOP_SINGULAR
            ? "there is no solution beyond: 'back N' goes back, 'run' starts a new one"
            : "change dt or the method and start a new one with 'run', or go back with 'back N'");
}

static void warn_other_scene(const struct session *session, const struct run *run,
                             struct reply *reply)
{
    const struct scene *now = &session->setup.scene;
    struct scene in_force;
    journal_scene(session->run[session->current_run], false, &in_force);
    if (now->model != in_force.model ||
        session->setup.events != session->run[session->current_run]->events ||
        memcmp(now->value, in_force.value, sizeof now->value) != 0 ||
        run->method != session->setup.method)
        reply_warning(reply,
                      "run %d goes on with the parameters and the method it has; 'change' gives it "
                      "others, 'run' "
                      "starts one with the present ones",
                      run->number);
}

static double direction(const struct run *run)
{
    return run->t < run->system.t0 ? -1 : 1;
}

/* Whether something is left of what was asked for before a pause, or an event. */
static bool is_paused(const struct session *session, const struct run *run)
{
    const struct request *request = journal_pending(session->run[session->current_run]);
    const bool at_event = run->stop == STOP_CONDITION && request && request->met == 0;
    return request && (stop_is_pause(run->stop) ||
                       (at_event && request->end == INT64_MAX && run->t != request->t));
}

static bool resume(struct session *session, const struct run *run, struct error *error)
{
    return stop_is_pause(run->stop) ||
           journal_go_on(session->run[session->current_run], false, error);
}

HANDLER(continue)
{
    const struct given_argument *duration = argument_given(given, "DURATION"),
                                *to = argument_given(given, "to"),
                                *until = argument_given(given, "until");
    const bool told = duration->count || to->count || until->count;
    struct run *run = current(session, error);
    struct plan plan;
    if (!run || !can_go_on(run, error))
        return false;
    double span = direction(run) * (duration->count ? duration->item->value.value
                                                    : session->setup.settings.duration);
    if (to->count)
        span = to->item->value.value - run->t;
    else if (until->count)
        span *= UNTIL_DURATIONS;
    else if (!told && is_paused(session, run))
        span = journal_pending(session->run[session->current_run])->t - run->t;
    const bool open = until->count || fabs(span) >= FAR || (!told && is_paused(session, run));
    if (to->count && (span == 0 || (run->steps > 0 && span * direction(run) < 0)))
        return error_at(error, to->where, "run %d has been there: it is at t = %.6g s", run->number,
                        run->t);
    if (!plan_make(&run->system, run->method, &run->settings,
                   open ? copysign(HUGE_VAL, span) : span, &plan, error))
        return false;
    if (steps_given(given) >= 0 && plan.steps > (double)steps_given(given))
        plan.seconds *= (double)steps_given(given) / plan.steps;
    if (!allow_long(session, plan.seconds, plan.steps, is_given(given, "force"), error))
        return false;
    warn_other_scene(session, run, reply);
    const bool paused = !told && is_paused(session, run);
    if (!paused && !new_request(session, to->count ? to->item->value.value : run->t + span,
                                INT64_MAX, until, error))
        return false;
    if (paused && !resume(session, run, error))
        return false;
    return advance(session, given, steps_given(given), true, reply, error);
}

HANDLER(step)
{
    const struct given_argument *count = argument_given(given, "N"), none = {.count = 0};
    const int64_t steps = count->count ? (int64_t)count->item->value.value : 1;
    struct run *run = session_run(session);
    if (steps > STEPS_MOST)
        return error_at(error, count->where, "more than 1e9 steps: use continue DURATION");
    if (!run)
        reply_unchosen(session, reply);
    if (run ? !can_go_on(run, error)
            : !(run =
                    new_run(session, (double)steps * session->setup.settings.dt, -1, true, error)))
        return false;
    if (is_paused(session, run))
        return resume(session, run, error) && advance(session, given, steps, false, reply, error);
    return new_request(session, direction(run) * FAR, run->steps + steps, &none, error) &&
           advance(session, given, -1, false, reply, error);
}

/* Back by so many recorded states; what is left of a paused request is still to be done. */
static bool go_back(struct session *session, struct run *run, int64_t rows, struct reply *reply,
                    struct error *error)
{
    struct run_slot *slot = session->run[session->current_run];
    const bool paused = is_paused(session, run);
    const int64_t steps = run->steps;
    const double t = run->t;
    if (!run_back(run, rows) && rows < INT64_MAX)
        reply_warning(reply, "run %d has fewer recorded states than that: it is at its start now",
                      run->number);
    const bool ok = journal_back(slot, steps, t, rows, error);
    if (paused && rows < INT64_MAX)
        run->stop = STOP_CANCELLED;
    session_changed(session);
    reply_run(session, run, reply);
    return ok;
}

HANDLER(back)
{
    const struct given_argument *count = argument_given(given, "N");
    struct run *run = current(session, error);
    if (!run)
        return false;
    if (run->steps == 0)
        return error_set(error, ERROR_COMMAND, "run %d is at its start", run->number);
    return go_back(session, run, count->count ? (int64_t)count->item->value.value : 1, reply,
                   error);
}

HANDLER(reset)
{
    UNUSED(given);
    struct run *run = current(session, error);
    if (!run)
        return false;
    if (run->steps > 0)
        return go_back(session, run, INT64_MAX, reply, error);
    reply_run(session, run, reply);
    return true;
}
#endif

COMMAND(run, .row = {"run", "", "start a new run at t0", "", "r"}, .group = "RUN",
        .text = "Runs for DURATION (else the setting 'duration'), to the time T, or until a "
                "condition becomes true. T "
                "before t0 and a\n"
                "negative DURATION go backwards. A condition that stays false ends the run after "
                "1000 durations, with "
                "an error. Says the\n"
                "largest error of the energy balance and, with a recording, the rms distance from "
                "it. --steps N pauses "
                "after N steps. In the\n"
                "panes the run follows the clock (see speed) while commands can be typed; 'pause' "
                "or Ctrl-C pauses it. "
                "--number is for saved\n"
                "sessions: the number of the new run.",
        .examples = "run 10 s\nrun until y < 0", .see = "continue step back plan runs compare",
        .flags = COMMAND_STARTS | COMMAND_CHANGES,
        ARGUMENTS(PLACE("DURATION", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME,
                        .group = 1),
                  WORD("to", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME,
                       .group = 1),
                  WORD("until", TYPE_CONDITION, .group = 1), OPTION("steps", TYPE_INTEGER),
                  OPTION("number", TYPE_INTEGER), OPTION("force", TYPE_NONE)))

COMMAND(continue, .row = {"continue", "", "let the current run go on", "", NULL}, .group = "RUN",
        .text = "A run that was paused, or stopped by an event, goes on to where it was to end. "
                "Otherwise for DURATION "
                "(else the setting\n"
                "'duration'), to the time T, or until a condition becomes true, with the "
                "parameters and the method of "
                "the run. The result\n"
                "is the same, bit for bit, as if the run had been longer from the start. --steps N "
                "pauses after N "
                "steps.",
        .examples = "run; continue 5 s\nrun 3 s; continue to 10 s", .see = "run step back change",
        .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("DURATION", TYPE_VALUE, .quantity = QUANTITY_TIME, .group = 1),
                  WORD("to", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME,
                       .group = 1),
                  WORD("until", TYPE_CONDITION, .group = 1), OPTION("steps", TYPE_INTEGER),
                  OPTION("force", TYPE_NONE)))

COMMAND(step, .row = {"step", "", "N steps more of the current run", "", "s"}, .group = "RUN",
        .text = "Starts a run where there is none.", .examples = "step\nstep 100",
        .see = "back continue run", .flags = COMMAND_CHANGES, ARGUMENTS(PLACE("N", TYPE_INTEGER)))

COMMAND(back, .row = {"back", "", "take the current run back by N recorded states", "", NULL},
        .group = "RUN", .text = "Restores what was recorded; nothing is integrated backwards.",
        .examples = "step 10; back 3\nback", .see = "step reset undo", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("N", TYPE_INTEGER)))

COMMAND(reset, .row = {"reset", "", "take the current run back to its start", "", NULL},
        .group = "RUN", .text = "Its parameters stay those it was started with.",
        .examples = "reset\nreset; step 5", .see = "back run", .flags = COMMAND_CHANGES)
