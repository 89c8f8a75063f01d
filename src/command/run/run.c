/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The commands run, continue, step, back and reset. Each makes a request in the run's journal,
 * along which run_go_on() advances the run. */
#ifndef COMMAND_ROWS
#include <hooke/command/handler.h>
#include "command/run/going.h"

#include <math.h>
#include <string.h>

#define UNTIL_DURATIONS 1000  /* number of durations after which `run until` gives up */
#define STEPS_MOST 1000000000 /* most steps of `step N` */

/* Creates a run of the session's set-up and makes it the current one. The run is planned for a span
 * [s, negative for backwards] of at most `steps` steps; steps < 0 means no limit. `force` allows
 * runs that take long. Returns NULL with the error set if the run cannot be created or would take
 * too long. The session owns the run. */
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
    session->runs.slot[session->runs.current]->events = session->setup.events;
    modules_forget_stopped(session);
    return run;
}

/* Adds the request to advance the current run to time t or step `end`, whichever comes first.
 * Successive single steps become one request. Returns false with the error set. */
static bool new_request(struct session *session, double t, int64_t end,
                        const struct argument_value *condition, struct error *error)
{
    struct run_slot *slot = session->runs.slot[session->runs.current];
    const struct request request = {.kind = REQUEST_GO,
                                    .start_step = slot->run->steps,
                                    .from_t = slot->run->t,
                                    .t = t,
                                    .end = end};
    const struct request *last = slot->last;
    /* Step by step is one request, not many. */
    if (end != INT64_MAX && last && last->kind == REQUEST_GO && last->t == t &&
        last->end == request.start_step) {
        struct request *edited = journal_edit_pending(slot, error);
        if (edited)
            edited->end = end;
        return edited != NULL;
    }
    return journal_add(slot, request, condition->count ? condition->item->text : TEXT(""), error);
}

/* Returns the value of --steps, or -1. */
static int64_t steps_option(const struct arguments *args)
{
    const struct argument_value *steps = argument_value(args, "steps");
    return steps->count ? (int64_t)steps->item->value.value : -1;
}

/* Runs the scene over the duration, to a time, or until a condition holds. */
HANDLER(run)
{
    const struct argument_value *duration = argument_value(args, "DURATION"),
                                *end_argument = argument_value(args, "to"),
                                *condition = argument_value(args, "until"),
                                *number = argument_value(args, "number");
    const double t0 = param_value(&session->setup.scene, "t0");
    double span = session->setup.settings.duration;
    if (duration->count)
        span = duration->item->value.value;
    else if (end_argument->count)
        span = end_argument->item->value.value - t0;
    double t = end_argument->count ? end_argument->item->value.value : t0 + span;
    if (condition->count) {
        t = t0 + UNTIL_DURATIONS * span;
        span = HUGE_VAL;
    }
    if (span == 0 || t == t0)
        return error_at(error, duration->count ? duration->where : end_argument->where,
                        "nothing to run: the end time equals the start time t0");
    if (number->count &&
        (number->item->value.value < session->runs.next_number || number->item->value.value > 1e9))
        return error_at(error, number->item->text,
                        "the number of the next run must be %d or larger",
                        session->runs.next_number);
    struct run *run =
        new_run(session, span, steps_option(args), has_argument(args, "force"), error);
    if (!run)
        return false;
    if (number->count) {
        run->number = (int)number->item->value.value;
        session->runs.next_number = run->number + 1;
    }
    reply_unchosen(session, reply);
    reply_assumed(session, run->plan.adaptive, !duration->count && !end_argument->count, reply);
    reply_coarse(session, run, reply);
    reply_tiny(run, reply);
    return new_request(session, t, INT64_MAX, condition, error) &&
           run_go_on(session, args, steps_option(args), true, reply, error);
}

/* ---- the current run ---- */

/* Returns the current run, or NULL with the error set. */
static struct run *current_run(const struct session *session, struct error *error)
{
    struct run *run = session_run(session);
    if (!run) {
        error_set(error, ERROR_COMMAND, "there is no run yet");
        error_hint(error, "type: run");
    }
    return run;
}

/* Returns true unless the run has failed or is full; then sets an error. */
static bool can_continue(const struct run *run, struct error *error)
{
    if (run->stop == STOP_STALLED || !(stop_is_failure(run->stop) || run->stop == STOP_FULL))
        return true;
    error_set(error, ERROR_COMMAND,
              "run %d cannot be continued: it stopped at t = %.6g s with status '%s'", run->number,
              run->t, stop_name(run->stop));
    return error_hint(
        error,
        run->stop == STOP_SINGULAR
            ? "no solution exists beyond that time; 'back N' goes back, 'run' starts a new run"
            : "change dt or the method and start a new run, or go back with 'back N'");
}

/* Warns if the set-up differs from the run, since the run continues with its own. */
static void warn_other_scene(const struct session *session, const struct run *run,
                             struct reply *reply)
{
    const struct scene *now = &session->setup.scene;
    struct scene in_force;
    journal_scene(session->runs.slot[session->runs.current], false, &in_force);
    if (now->model != in_force.model ||
        session->setup.events != session->runs.slot[session->runs.current]->events ||
        memcmp(now->value, in_force.value, sizeof now->value) != 0 ||
        run->method != session->setup.method)
        reply_warning(reply,
                      "run %d continues with its own parameters and method; 'change' changes them, "
                      "'run' starts a run with the present ones",
                      run->number);
}

/* Returns 1 for a run forward in time, -1 for one backward. */
static double direction(const struct run *run)
{
    return run->t < run->system.t0 ? -1 : 1;
}

/* Returns true if part of the last request is left after a pause or an event. */
static bool is_paused(const struct session *session, const struct run *run)
{
    const struct request *request = journal_pending(session->runs.slot[session->runs.current]);
    const bool at_event = run->stop == STOP_CONDITION && request && request->met == 0;
    return request && (stop_is_pause(run->stop) ||
                       (at_event && request->end == INT64_MAX && run->t != request->t));
}

/* Makes the rest of the last request the present one. Returns false with the error set. */
static bool resume_request(struct session *session, const struct run *run, struct error *error)
{
    return stop_is_pause(run->stop) ||
           journal_go_on(session->runs.slot[session->runs.current], false, error);
}

/* Completes a stopped study of a module or a paused run; otherwise advances the current run
 * further. */
HANDLER(continue)
{
    const struct argument_value *duration = argument_value(args, "DURATION"),
                                *end_argument = argument_value(args, "to"),
                                *condition = argument_value(args, "until");
    const bool limited = duration->count || end_argument->count || condition->count;
    const struct module *waiting = module_waiting(session);
    if (waiting && !limited && steps_option(args) < 0)
        return waiting->stopped.go_on(session, args, reply, error);
    struct run *run = current_run(session, error);
    struct plan plan;
    if (!run || !can_continue(run, error))
        return false;
    double span = direction(run) * (duration->count ? duration->item->value.value
                                                    : session->setup.settings.duration);
    if (end_argument->count)
        span = end_argument->item->value.value - run->t;
    else if (condition->count)
        span *= UNTIL_DURATIONS;
    else if (!limited && is_paused(session, run))
        span = journal_pending(session->runs.slot[session->runs.current])->t - run->t;
    const bool open =
        condition->count || fabs(span) >= T_UNREACHABLE || (!limited && is_paused(session, run));
    if (end_argument->count && (span == 0 || (run->steps > 0 && span * direction(run) < 0)))
        return error_at(error, end_argument->where,
                        "run %d is already past that time, at t = %.6g s", run->number, run->t);
    if (!plan_make(&run->system, run->method, &run->settings,
                   open ? copysign(HUGE_VAL, span) : span, &plan, error))
        return false;
    if (steps_option(args) >= 0 && plan.steps > (double)steps_option(args))
        plan.seconds *= (double)steps_option(args) / plan.steps;
    if (!allow_long(session, plan.seconds, plan.steps, has_argument(args, "force"), error))
        return false;
    warn_other_scene(session, run, reply);
    const bool paused = !limited && is_paused(session, run);
    if (!paused &&
        !new_request(session, end_argument->count ? end_argument->item->value.value : run->t + span,
                     INT64_MAX, condition, error))
        return false;
    if (paused && !resume_request(session, run, error))
        return false;
    return run_go_on(session, args, steps_option(args), true, reply, error);
}

/* Advances the current run, or a new one, by N steps. */
HANDLER(step)
{
    const struct argument_value *count = argument_value(args, "N"), none = {.count = 0};
    const int64_t steps = count->count ? (int64_t)count->item->value.value : 1;
    struct run *run = session_run(session);
    if (steps > STEPS_MOST)
        return error_at(error, count->where,
                        "'step' makes at most 1e9 steps; for more type: continue DURATION");
    if (!run)
        reply_unchosen(session, reply);
    if (run ? !can_continue(run, error)
            : !(run =
                    new_run(session, (double)steps * session->setup.settings.dt, -1, true, error)))
        return false;
    if (is_paused(session, run))
        return resume_request(session, run, error) &&
               run_go_on(session, args, steps, false, reply, error);
    return new_request(session, direction(run) * T_UNREACHABLE, run->steps + steps, &none, error) &&
           run_go_on(session, args, -1, false, reply, error);
}

/* Drops the last `rows` recorded states. What is left of a paused request can still be continued.
 * Returns false with the error set. */
static bool go_back(struct session *session, struct run *run, int64_t rows, struct reply *reply,
                    struct error *error)
{
    struct run_slot *slot = session->runs.slot[session->runs.current];
    const bool paused = is_paused(session, run);
    const int64_t steps = run->steps;
    const double t = run->t;
    if (!run_back(run, rows) && rows < INT64_MAX)
        reply_warning(reply, "run %d has fewer recorded states; it is now at its start",
                      run->number);
    const bool ok = journal_back(slot, steps, t, rows, error);
    if (paused && rows < INT64_MAX)
        run->stop = STOP_CANCELLED;
    session_changed(session);
    reply_run(session, run, reply);
    return ok;
}

/* Takes the current run back by N recorded states. */
HANDLER(back)
{
    const struct argument_value *count = argument_value(args, "N");
    struct run *run = current_run(session, error);
    if (!run)
        return false;
    if (run->steps == 0)
        return error_set(error, ERROR_COMMAND, "run %d is at its start", run->number);
    return go_back(session, run, count->count ? (int64_t)count->item->value.value : 1, reply,
                   error);
}

/* Takes the current run back to its start. */
HANDLER(reset)
{
    UNUSED(args);
    struct run *run = current_run(session, error);
    if (!run)
        return false;
    if (run->steps > 0)
        return go_back(session, run, INT64_MAX, reply, error);
    reply_run(session, run, reply);
    return true;
}
#endif

COMMAND(run, .row.alias = "r", .group = "RUN",
        .flags = COMMAND_STARTS | COMMAND_CHANGES | COMMAND_TABLES,
        ARGUMENTS(PLACE("DURATION", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME,
                        .group = 1),
                  WORD("to", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME,
                       .group = 1),
                  WORD("until", TYPE_CONDITION, .group = 1), OPTION("steps", TYPE_INTEGER),
                  OPTION("number", TYPE_INTEGER), OPTION("force", TYPE_NONE)))

COMMAND(continue, .group = "RUN", .flags = COMMAND_CHANGES | COMMAND_TABLES,
        ARGUMENTS(PLACE("DURATION", TYPE_VALUE, .quantity = QUANTITY_TIME, .group = 1),
                  WORD("to", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME,
                       .group = 1),
                  WORD("until", TYPE_CONDITION, .group = 1), OPTION("steps", TYPE_INTEGER),
                  OPTION("force", TYPE_NONE)))

COMMAND(step, .row.alias = "s", .group = "RUN", .flags = COMMAND_CHANGES | COMMAND_TABLES,
        ARGUMENTS(PLACE("N", TYPE_INTEGER)))

COMMAND(back, .group = "RUN", .flags = COMMAND_CHANGES, ARGUMENTS(PLACE("N", TYPE_INTEGER)))

COMMAND(reset, .group = "RUN", .flags = COMMAND_CHANGES)
