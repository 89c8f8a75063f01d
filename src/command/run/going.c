/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Advances the current run along its last request until the target is reached, the run is paused or
 * an event stops it; run, continue and step use it. Asks before computations that take long. */
#include <hooke/report.h>
#include <hooke/scene/formula.h>
#include "command/run/going.h"
#include "command/run/event_pass.h"

#include <math.h>
#include <stdio.h>

/* Predicted computing time above which --force or a yes is needed [s]. */
static const double seconds_asked = 60;
/* Steps of an adaptive run before its remaining time is estimated. */
#define STEPS_JUDGED 100000
#define SLICE_NS 10000000 /* [ns] computing between two looks at the front end */

bool takes_long(double seconds)
{
    return seconds > seconds_asked;
}

/* Returns true if the run may take `seconds` for about `steps` steps: it is short, forced
 * (`force`), or a person at the prompt agrees or watches it and can pause it. Otherwise returns
 * false with the error set. */
bool allow_long(struct session *session, double seconds, double steps, bool force,
                struct error *error)
{
    char question[200];
    if (!takes_long(seconds) || force)
        return true;
    snprintf(question, sizeof question, "this will take about %.0f s (%.3g steps)", seconds, steps);
    if (session->execution.typed && (session->front.watched || session->front.confirm)) {
        /* A person who watches the run can pause it. */
        session->execution.confirmed =
            session->front.watched || session->front.confirm(session->front.context, question);
        return session->execution.confirmed || error_set(error, ERROR_CANCELLED, "not run");
    }
    error_set(error, ERROR_COMMAND, "%s", question);
    return session->setup.settings.duration_chosen || session->setup.scene.preset->duration == 0
               ? error_hint(error, "--force runs it anyway")
               : error_hint(error,
                            "%.4g s is the scene's own duration: give a shorter one ('duration = "
                            "10 s'), or choose an adaptive method; --force runs it anyway",
                            session->setup.settings.duration);
}

/* The way of the current run in the present command. */
struct advance {
    struct run_slot *slot;
    struct request request; /* copy of the last request, since the journal may grow on the way */
    struct run_target target;
    int requests;  /* length of the journal before */
    int64_t steps; /* steps of the run before */
    double t;      /* [s] time of the run before */
    bool force;    /* long computations are allowed */
    double left;   /* [s] estimated remaining computing time when it was given up */
};

/* Steps, simulated time [s] and computing time [s] when the remaining time of an adaptive run was
 * last estimated. */
struct step_pace {
    int64_t steps;
    double t, seconds;
};

/* Compiles the events of the run, with names of the run's own scene, into the target. Returns false
 * with the error set. */
static bool advance_watch(struct session *session, const struct arguments *args,
                          struct advance *advance, struct error *error)
{
    struct in_force *force = arena_alloc(args->arena, sizeof *force);
    struct names *names = arena_alloc(args->arena, sizeof *names);
    struct expr_scope *scope = arena_alloc(args->arena, sizeof *scope);
    const struct run_slot *slot = advance->slot;
    if (!force || !names || !scope)
        return error_memory(error);
    *force = (struct in_force){.slot = slot};
    *names =
        (struct names){.session = session, .in_force = force, .saved_only = true, .run = slot->run};
    *scope = names_scope(names);
    return events_compile(slot->events, scope, args->arena, &advance->target.event,
                          &advance->target.events, error);
}

/* Fills in *advance: the target of the last request, at most `steps` steps of it (none if < 0), its
 * condition and its events. Returns false with the error set. */
static bool advance_begin(struct session *session, const struct arguments *args, int64_t steps,
                          struct advance *advance, struct error *error)
{
    struct run_slot *slot = session->runs.slot[session->runs.current];
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
                            .scope = args->scope};
    if (request->condition) {
        struct condition *condition = arena_alloc(args->arena, sizeof *condition);
        size_t used;
        if (!condition)
            return error_memory(error);
        if (!condition_compile(text_of(request->condition), args->scope, args->arena, condition,
                               &used, error)) {
            error->where = (struct text){NULL, 0};
            return false;
        }
        advance->target.condition = condition;
    }
    return !slot->events || advance_watch(session, args, advance, error);
}

/* Returns the estimated remaining time [s] of an adaptive run, or 0 if it is not yet known. The
 * number of steps is not known beforehand: each time that it has doubled since the step `first`,
 * its last half is the basis of the estimate; *pace stores where that half began. */
static double time_left(const struct run *run, const struct run_target *target, int64_t first,
                        struct step_pace *pace)
{
    const double rest = target->t - run->t;
    if (!run->plan.adaptive || target->condition || target->steps >= 0 ||
        !(fabs(rest) < T_UNREACHABLE) ||
        run->steps - first < (pace->steps ? 2 * (pace->steps - first) : STEPS_JUDGED))
        return 0;
    const double way = run->t - pace->t,
                 left = pace->steps ? (run->seconds - pace->seconds) * (rest / way) : 0;
    *pace = (struct step_pace){run->steps, run->t, run->seconds};
    return left;
}

/* Estimates from `pace` how long the remaining run would take, in advance->left [s]. Returns false
 * if that is too long and the user, who is asked where possible, does not allow it; otherwise true,
 * and once allowed it is not asked again. `first` is the step at which this advance began. */
static bool may_continue(struct session *session, const struct run *run, struct advance *advance,
                         int64_t first, struct step_pace *pace)
{
    struct error ignored = {0};
    const double steps = (double)pace->steps, t = pace->t;
    advance->left = advance->force ? 0 : time_left(run, &advance->target, first, pace);
    if (!takes_long(advance->left))
        return true;
    const double more =
        ((double)run->steps - steps) * ((advance->target.t - run->t) / (run->t - t));
    return advance->force = allow_long(session, advance->left, more, false, &ignored);
}

/* Advances the run until the target is reached or the run has stopped. While a person watches it is
 * shown live, by the clock if `clocked` and the command was typed. Otherwise it advances in slices
 * of SLICE_NS; after each, progress is shown (the fraction, or -1 without a target time; 2 at the
 * end erases it), and a run that takes too long is given up unless the user allows it. `pace` is
 * where the previous slice ended. */
static void run_to_target(struct session *session, struct run *run, struct advance *advance,
                          bool clocked)
{
    const struct front *front = &session->front;
    const struct run_target *target = &advance->target;
    const double t_begin = run->t;
    struct step_pace pace = {.steps = 0};
    if (front->watched && front->slice) {
        live_advance(session, run, target, clocked && session->execution.typed);
        return;
    }
    struct run_target rest = *target; /* its steps are counted from each call */
    const int64_t first = run->steps;
    while (run_advance(run, &rest, SLICE_NS, front->cancel)) {
        rest.steps = target->steps < 0 ? -1 : target->steps - (run->steps - first);
        if (!may_continue(session, run, advance, first, &pace)) {
            run->stop = STOP_GIVEN_UP;
            break;
        }
        if (front->progress)
            front->progress(
                front->context, run,
                fabs(target->t) < T_UNREACHABLE ? (run->t - t_begin) / (target->t - t_begin) : -1);
    }
    if (front->progress)
        front->progress(front->context, run, 2);
}

/* Does the same as run_to_target(), and marks the session as advancing meanwhile. */
static void advance_run(struct session *session, struct run *run, struct advance *advance,
                        bool clocked)
{
    session->live.advancing = true;
    run_to_target(session, run, advance, clocked);
    session->live.advancing = false;
}

/* Writes the journal's new requests to the history if the statement alone would not repeat them:
 * after a pause and after changes during the run. Effects of events are left out, since events
 * happen again. */
static void advance_report(struct session *session, const struct advance *advance)
{
    const bool paused = stop_is_pause(advance->slot->run->stop);
    const bool whole = advance->requests == 1 && advance->steps == 0;
    if (paused || journal_changed(advance->slot, advance->requests)) {
        const int64_t steps = whole ? -1 : advance->steps;
        journal_write(session, advance->slot, whole ? 0 : advance->requests, steps, 0, false,
                      &session->history.happened);
    }
}

/* Replies which event has stopped the run (NULL for none) and how many have been recorded. */
static void reply_event(const struct run_slot *slot, const struct event_line *stopped,
                        struct reply *reply)
{
    const size_t count = run_event_records(slot->run);
    if (stopped)
        reply_line(reply, "event %s: stopped at t = %.9g s; 'continue' continues%s", stopped->name,
                   slot->run->t,
                   stopped->action == EVENT_COMMANDS
                       ? "; it does so by itself if the event's commands end with 'continue'"
                       : "");
    if (count > (stopped ? 1 : 0))
        reply_line(reply, "%zu event%s so far: 'list events' shows them", count,
                   plural_s((int64_t)count));
}

/* Replies with the result of a run that has just been advanced: event, second opinion, warnings,
 * and why it stopped. `pass` holds the events that stopped it; pass->count is 0 if none did.
 * Returns false with the error set if the run was interrupted, given up or failed, if the condition
 * of `until` did not become true, or if the second opinion shows the result to be lost. */
static bool advance_finish(struct session *session, const struct advance *advance,
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
    advance_report(session, advance);
    if (run->stop == STOP_CANCELLED)
        reply_line(reply, "%s at t = %.6g s; 'continue' continues",
                   session->front.watched ? "paused" : "stopped", run->t);
    seek_opinion(session, run, reply);
    reply_run(session, run, reply);
    reply_event(advance->slot, pass->count > 0 ? pass->stopped[0] : NULL, reply);
    struct error lost = {0};
    const bool right = reply_opinion(session, run, reply, &lost);
    reply_below_tolerance(run, reply);
    reply_run_warnings(run, reply);
    reply_event_doubts(advance->slot, reply);
    if (run->stop == STOP_CANCELLED) {
        session->execution.halted = session->front.watched;
        return session->front.watched ||
               error_set(error, ERROR_CANCELLED,
                         "run %d was interrupted and is kept up to t = %.6g s", run->number,
                         run->t);
    }
    if (run->stop == STOP_GIVEN_UP) {
        error_set(error, ERROR_COMMAND,
                  "given up at t = %.6g s after %lld steps: the rest would take about %.2g s at "
                  "this pace; run %d is kept up to there",
                  run->t, (long long)run->steps, advance->left, run->number);
        return error_hint(error, "--force runs it anyway%s",
                          run->method->flags & METHOD_IMPLICIT
                              ? ""
                              : "; try an adaptive implicit method such as radau5");
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

/* Tells a person who watches how to pause the run. */
static void reply_running(const struct session *session, struct reply *reply)
{
    reply_line(reply, "running... (pause: Ctrl-C or F5; you can keep typing commands)");
    if (isfinite(session->live.speed))
        reply_line(reply, "it follows the clock; 'speed max' runs as fast as possible");
}

/* Advances the current run along its last request, by at most `steps` steps (no limit if < 0), from
 * event to event, until one of them stops the run or the target is reached, and replies with the
 * result. `clocked` lets a run on the screen keep the pace of the clock. Returns false with *error
 * if the run or a command of an event fails. */
bool run_go_on(struct session *session, const struct arguments *args, int64_t steps, bool clocked,
               struct reply *reply, struct error *error)
{
    struct advance advance;
    struct event_pass pass = {.count = 0};
    struct error why = {0};
    bool ok = true;
    if (!advance_begin(session, args, steps, &advance, error))
        return false;
    advance.force = advance.target.steps >= 0 || has_argument(args, "force");
    struct run *run = advance.slot->run;
    const int64_t last = advance.target.steps < 0 ? -1 : run->steps + advance.target.steps;
    if (clocked && session->execution.typed && session->front.watched && session->front.slice)
        reply_running(session, reply);
    do {
        advance.target.steps = last < 0 ? -1 : last - run->steps;
        advance_run(session, run, &advance, clocked);
    } while (events_pass(session, &advance.target, &pass, args, reply, &ok, &why));
    const bool early = run->stop == STOP_END && run->t != advance.request.t && steps >= 0 &&
                       run->steps < advance.request.end;
    /* the condition was not to be reached in these steps */
    if (early)
        advance.target.condition = NULL;
    const bool arrived = advance_finish(session, &advance, &pass, reply, error);
    if (early && !stop_is_failure(run->stop))
        run->stop = STOP_CANCELLED;
    for (int i = 0; i < pass.count && arrived && ok; i++)
        ok = event_react(session, pass.stopped[i], args, reply, &why);
    if (arrived && !ok)
        *error = why;
    return arrived && ok;
}

void report_fraction(void *context, double fraction)
{
    const struct front *front = context;
    if (front->progress)
        front->progress(front->context, NULL, fraction);
}
