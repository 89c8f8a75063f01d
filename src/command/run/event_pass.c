/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Executes the commands of events that have stopped a run, and decides if the run continues after
 * them. */
#include <hooke/scene/formula.h>
#include "command/run/event_pass.h"

#include <math.h>

#define PASSES_MAX 10000 /* most events after which a run continues in one command */
/* Events pile up if they are closer than this part of the longest time between two. */
#define PILE_TIME_RELATIVE 1e-6

/*
 * The commands see and change the parameters of the run, not those of the set-up. They are not
 * recorded, since the run's statement executes them again.
 */
bool event_react(struct session *session, const struct event_line *event,
                 const struct arguments *args, struct reply *reply, struct error *error)
{
    const struct source where = {.name = event->name, .line = 1, .parent = args->where};
    const struct scene scene = session->setup.scene;
    if (event->action != EVENT_COMMANDS)
        return true;
    journal_scene(session->runs.slot[session->runs.current], true, &session->setup.scene);
    session->execution.reacting = true;
    const struct text commands =
        event_commands(text_of(event->commands), &session->execution.passing);
    const bool ok = command_exec(session, commands, &where, reply);
    session->execution.reacting = session->execution.passing = false;
    session->setup.scene = scene;
    if (!ok)
        *error = (struct error){.code = ERROR_NONE}; /* it was reported there */
    return ok;
}

/* Checks whether events stop the run too often: more than PASSES_MAX times in one command, or the
 * same event in ever shorter intervals, like the bounces of a ball (Zeno). Updates the statistics
 * of pass->event[] with the event records since the last call. Returns true with the error set if
 * so, else false. */
static bool piles_up(const struct run_slot *slot, struct event_pass *pass, struct error *error)
{
    const struct run *run = slot->run;
    if (++pass->passed > PASSES_MAX) {
        error_set(error, ERROR_NUMERICAL,
                  "events have stopped run %d %d times, most recently at t = %.9g s, the limit for "
                  "one command",
                  run->number, PASSES_MAX, run->t);
        return !error_hint(error, "'continue' continues the run");
    }
    for (; pass->seen < run_event_records(run); pass->seen++) {
        const struct event_record *record = run_event_record(run, pass->seen);
        const int i = record->event;
        const double interval = fabs(record->t - pass->event[i].last);
        if (pass->event[i].known) {
            pass->event[i].close = interval <= PILE_TIME_RELATIVE * pass->event[i].longest
                                       ? pass->event[i].close + 1
                                       : 0;
            pass->event[i].longest = fmax(pass->event[i].longest, interval);
        }
        pass->event[i].known = true;
        pass->event[i].last = record->t;
        if (pass->event[i].close < 3 || slot->events->line[i].action != EVENT_COMMANDS)
            continue;
        error_set(error, ERROR_NUMERICAL,
                  "the event %s repeats faster and faster (last after %.2g s) and accumulates at t "
                  "= %.9g s",
                  slot->events->line[i].name, interval, run->t);
        return !error_hint(error,
                           "run %d is kept up to there; an event with 'do stop' can end it earlier",
                           run->number);
    }
    return false;
}

/* Returns true if the condition of `run until` holds now. */
static bool is_met(const struct run_target *target)
{
    return target->condition &&
           condition_holds(target->condition, condition_value(target->condition, target->scope));
}

/* Executes the commands of the events that have stopped the run. Returns true if the run continues:
 * all of them end in `continue`, and they have not met the condition of `run until`. */
bool events_pass(struct session *session, const struct run_target *target, struct event_pass *pass,
                 const struct arguments *args, struct reply *reply, bool *ok, struct error *error)
{
    struct run_slot *slot = session->runs.slot[session->runs.current];
    bool passes = true;
    pass->count = events_stopped_at(slot, pass->stopped);
    for (int i = 0; i < pass->count && passes; i++)
        event_commands(text_of(pass->stopped[i]->commands),
                       &passes); /* none of others than EVENT_COMMANDS */
    if (pass->count == 0 || !passes)
        return false;
    *ok = !piles_up(slot, pass, error);
    const bool met = is_met(target);
    for (int i = 0; i < pass->count && *ok; i++)
        *ok = event_react(session, pass->stopped[i], args, reply, error);
    if (*ok && !met && is_met(target)) { /* met because of their changes */
        pass->count = 0;
        return false;
    }
    *ok = *ok && journal_go_on(slot, true, error);
    return *ok;
}

/* Includes equations (COMMAND_IN_EVENTS), which in an event set a velocity. */
bool event_executes(const struct command *command)
{
    return (command->flags & (COMMAND_ANYTIME | COMMAND_IN_EVENTS)) != 0;
}

bool refuse_in_event(const struct command *command, struct text where, struct error *error)
{
    error_at(error, where, "an event cannot execute %s", command->row.name);
    return error_hint(
        error, "events can set, print and note; 'continue' as the last word continues the run");
}
