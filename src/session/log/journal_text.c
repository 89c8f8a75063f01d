/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes the journal of a run as commands (run, continue, change, back) that recreate the run in a
 * new session. */
#include <hooke/run.h>
#include <hooke/result.h>
#include <hooke/base/number.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>
#include <hooke/scene/formula.h>

#include <math.h>
#include <stdlib.h>

/* Returns true if a condition has the same meaning in a session without the user's variables and
 * results. */
static bool condition_is_portable(const struct session *session, const struct run *run,
                                  const char *condition)
{
    struct names names = {.session = session, .run = run, .saved_only = true};
    const struct expr_scope scope = names_scope(&names);
    struct arena arena = {0};
    struct condition compiled;
    struct error ignored;
    size_t used;
    const bool ok =
        condition_compile(text_of(condition), &scope, &arena, &compiled, &used, &ignored);
    arena_reset(&arena);
    return ok;
}

/* State of the writing of one journal. */
struct composer {
    const struct session *session;
    const struct run *run;
    int number;   /* number of the run; 0 for the next one */
    bool started; /* the run exists when the next command is executed */
    bool waits;   /* the last command written has a target that the run has not reached */
    struct buffer *text;
};

/* Appends the option that numbers the run, to its first command. */
static void put_number_option(const struct composer *c)
{
    if (!c->started && c->number > 0)
        buffer_format(c->text, " --number %d", c->number);
}

/* Appends commands that create the run and leave it at its start, for requests that were made
 * before its first step. Does nothing if the run exists already (c->started). */
static void put_run_start(struct composer *c)
{
    if (c->started)
        return;
    buffer_put(c->text, TEXT("run --steps 1"));
    put_number_option(c);
    buffer_put(c->text, TEXT("\nreset\n"));
    c->started = true;
}

/* Writes the command that advances the run from step step_begin to step step_end, which was reached
 * at time t. last means that the request is the last of the run. Returns false if its condition is
 * not portable. */
static bool put_advance(struct composer *c, const struct request *request, int64_t step_begin,
                        int64_t step_end, double t, bool last)
{
    const struct run *run = c->run;
    const bool met = request->condition && request->met == step_end;
    if (met && !condition_is_portable(c->session, run, request->condition))
        return false;
    /* `step N` leaves no target to continue to, so that it fits only if there is none to keep */
    const bool ends = request->end < INT64_MAX || (last && !run->plan.adaptive),
               waits = last && stop_is_pause(run->stop);
    if (ends && !waits && !met && !c->waits && t != request->t &&
        (c->started || request->t > request->from_t)) {
        put_run_start(c);
        buffer_format(c->text, "step %lld\n", (long long)(step_end - step_begin));
        return true;
    }
    c->waits = !met && t != request->t;
    /* Options first: after a condition they would be read as minus signs. */
    buffer_put(c->text, c->started ? TEXT("continue") : TEXT("run"));
    put_number_option(c);
    if (met) {
        buffer_format(c->text, " until %s", request->condition);
    } else {
        /* If there is no target, any time that is far enough will do. */
        const double far = copysign(2 * (double)(step_end + 1) * run->settings.dt, request->t);
        if (t != request->t)
            buffer_format(c->text, " --steps %lld", (long long)(step_end - step_begin));
        buffer_put(c->text, TEXT(" to "));
        buffer_real(c->text, run->plan.adaptive || fabs(request->t) < T_UNREACHABLE ? request->t
                                                                                    : run->t + far);
        buffer_put(c->text, TEXT(" s"));
    }
    buffer_char(c->text, '\n');
    c->started = true;
    return true;
}

/* Appends name and value of a change, such as "gamma 0.1 1/s". */
void journal_put_change(const struct run *run, const struct request *request, struct buffer *text)
{
    const struct param_row *param =
        request->kind == REQUEST_SET ? param_at(&run->scene, request->param) : NULL;
    const struct variable *variable = &run->system.model->variable[param ? 0 : request->param];
    buffer_format(text, "%s ", param ? param->row.name : variable->name);
    buffer_exact(text, request->value, param ? param->quantity : variable->quantity);
}

/* Appends the commands that repeat the requests; each interval between two of them belongs to the
 * latest REQUEST_GO. Returns false, with nothing appended, if a condition is not portable or memory
 * runs out. */
bool journal_write(const struct session *session, const struct run_slot *slot, int first,
                   int64_t first_step, int number, bool by_events, struct buffer *text)
{
    const struct run *run = slot->run;
    const size_t saved_len = text->len;
    struct composer c = {session, run, number, first_step >= 0, false, text};
    const struct request **list, *going;
    int64_t step_begin = first_step < 0 ? 0 : first_step;
    int count;
    if (!journal_list(slot->last, first, &list, &count)) {
        text->failed = true;
        return false;
    }
    going = journal_last_go(count > 0 ? list[0]->previous : slot->last);
    while (going && going->by_event && !by_events)
        going = going->go;
    for (int i = 0; i <= count; i++) {
        const struct request *next = i < count ? list[i] : NULL;
        if (next && next->by_event && !by_events)
            continue;
        const int64_t step_end = next ? next->start_step : run->steps;
        /* the last request changed only the last bits of the time, in no step */
        const bool ends =
            !next && going && going->start_step == step_begin && going->from_t != run->t;
        if (going && (step_end > step_begin || ends)) {
            if (!put_advance(&c, going, step_begin, step_end, next ? next->from_t : run->t,
                             !next)) {
                text->len = saved_len;
                free(list);
                return false;
            }
            step_begin = step_end;
        }
        if (next && next->kind == REQUEST_GO)
            going = next;
        if (!next || next->kind == REQUEST_GO)
            continue;
        put_run_start(&c);
        if (next->kind == REQUEST_BACK) {
            buffer_format(text, "back %lld", (long long)next->rows);
        } else {
            buffer_put(text, TEXT("change "));
            journal_put_change(run, next, text);
        }
        buffer_char(text, '\n');
        if (next->kind == REQUEST_BACK)
            step_begin = next->end;
        else
            step_begin = next->kind == REQUEST_KICK ? next->start_step + 1 : step_begin;
    }
    free(list);
    /* a run that was taken back to its start but still has a target */
    if (!c.started && going && stop_is_pause(run->stop) && put_advance(&c, going, 0, 1, NAN, true))
        buffer_put(text, TEXT("back 1\n"));
    put_run_start(&c);
    return true;
}
