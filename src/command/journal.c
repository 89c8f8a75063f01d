/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "events.h"
#include "journal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the list ---- */

bool journal_add(struct held_run *held, struct leg leg, struct text condition, struct error *error)
{
    leg.condition = NULL;
    if (condition.len > 0 && !(leg.condition = strndup(condition.at, condition.len)))
        return error_memory(error);
    if ((held->legs & (held->legs - 1)) == 0) { /* full at every power of two */
        struct leg *larger = realloc(held->leg, (held->legs ? 2 * (size_t)held->legs : 1) * sizeof *larger);
        if (!larger) {
            free(leg.condition);
            return error_memory(error);
        }
        held->leg = larger;
    }
    held->leg[held->legs++] = leg;
    return true;
}

void journal_free(struct leg *leg, int legs)
{
    for (int i = 0; i < legs; i++)
        free(leg[i].condition);
    free(leg);
}

bool journal_copy(const struct leg *leg, int legs, struct leg **copy)
{
    size_t room = 1; /* as journal_add() has it */
    while (room < (size_t)legs)
        room *= 2;
    *copy = legs > 0 ? malloc(room * sizeof **copy) : NULL;
    if (legs == 0 || !*copy)
        return legs == 0;
    memcpy(*copy, leg, (size_t)legs * sizeof *leg);
    for (int i = 0; i < legs; i++)
        if (leg[i].condition && !((*copy)[i].condition = strdup(leg[i].condition))) {
            journal_free(*copy, i);
            *copy = NULL;
            return false;
        }
    return true;
}

struct leg *journal_pending(const struct held_run *held)
{
    for (int i = held->legs - 1; i >= 0; i--)
        if (held->leg[i].kind == LEG_GO)
            return &held->leg[i];
    return NULL;
}

bool journal_go_on(struct held_run *held, bool by_event, struct error *error)
{
    const struct leg *leg = journal_pending(held);
    const struct leg again = {.kind = LEG_GO, .from = held->run->steps, .from_t = held->run->t,
                              .t = leg->t, .end = leg->end, .by_event = by_event};
    return journal_add(held, again, text_of(leg->condition), error);
}

bool journal_back(struct held_run *held, int64_t before, double before_t, int64_t rows, struct error *error)
{
    const struct run *run = held->run;
    if ((run->plan.adaptive || run->settings.record.rule == RECORD_TIMES) && run->steps > 0)
        return journal_add(
            held, (struct leg){.kind = LEG_BACK, .from = before, .from_t = before_t, .rows = rows, .end = run->steps},
            TEXT(""), error);
    for (const struct leg *last; held->legs > 0; free(held->leg[--held->legs].condition)) {
        last = &held->leg[held->legs - 1];
        if (last->from + (last->kind == LEG_KICK) <= run->steps)
            break;
    }
    struct leg *leg = journal_pending(held);
    if (leg && leg->met > run->steps)
        leg->met = 0;
    return true;
}

void journal_scene(const struct held_run *held, bool by_events, struct scene *scene)
{
    struct error ignored;
    *scene = held->run->scene;
    for (int i = 0; i < held->legs; i++)
        if (held->leg[i].kind == LEG_SET && (by_events || !held->leg[i].by_event))
            scene_set(scene, held->leg[i].param, held->leg[i].value, &ignored); /* was accepted then */
}

bool journal_changed(const struct held_run *held, int first)
{
    while (first < held->legs && held->leg[first].by_event)
        first++;
    return first < held->legs;
}

/* ---- doing it again ---- */

/* On along a leg until step `end`; so_far: the run with the legs done before. */
static void go(struct session *session, const struct held_run *so_far, const struct leg *leg, int64_t end)
{
    struct run *run = so_far->run;
    struct names names = {.session = session, .run = run};
    struct in_force force = {.held = so_far, .legs = -1};
    struct names watched = {.session = session, .run = run, .in_force = &force, .saved_only = true};
    const struct expr_scope watching = names_scope(&watched);
    const struct expr_scope scope = names_scope(&names);
    struct arena arena = {0};
    struct condition condition;
    struct error ignored;
    size_t used;
    struct run_target target = {.t = leg->t, .steps = end - run->steps, .scope = &scope};
    if (leg->condition && condition_compile(text_of(leg->condition), &scope, &arena, &condition, &used, &ignored))
        target.condition = &condition;
    events_compile(so_far->events, &watching, &arena, &target.event, &target.events, &ignored);
    if (target.steps >= 0) /* 0: may be where a time is reached to the last bit */
        run_advance(run, &target, 0, NULL);
    arena_reset(&arena);
}

static void replay(struct session *session, struct held_run *held, const struct leg *leg, int legs, int64_t steps)
{
    struct run *run = held->run;
    const struct leg *going = NULL;
    struct error ignored;
    struct held_run so_far = {.run = run, .events = held->events, .leg = (struct leg *)(uintptr_t)leg};
    for (int i = 0; i < legs; i++, so_far.legs = i) {
        if (going)
            go(session, &so_far, going, leg[i].from);
        if (leg[i].from < run->steps && leg[i].kind != LEG_GO)
            continue; /* done before */
        if (leg[i].kind == LEG_GO) {
            going = &leg[i];
        } else if (leg[i].kind == LEG_BACK) {
            run_back(run, leg[i].rows);
        } else if (leg[i].kind == LEG_KICK) {
            run_kick(run, leg[i].param, leg[i].value.value, &ignored);
        } else {
            struct scene scene;
            so_far.legs = i + 1;
            journal_scene(&so_far, true, &scene);
            run_rebind(run, &scene, &ignored);
        }
    }
    if (going)
        go(session, &so_far, going, steps);
}

static bool same_leg(const struct leg *a, const struct leg *b)
{
    return a->kind == b->kind && a->from == b->from && a->t == b->t && a->param == b->param && a->rows == b->rows &&
           memcmp(&a->value, &b->value, sizeof a->value) == 0 &&
           text_equal(text_of(a->condition), text_of(b->condition));
}

/* The step up to which both lists led along the same way; 0 where going back makes that hard to say. */
static int64_t common_way(const struct held_run *held, const struct leg *leg, int legs)
{
    int i = 0;
    for (int k = 0; k < held->legs || k < legs; k++)
        if ((k < held->legs && held->leg[k].kind == LEG_BACK) || (k < legs && leg[k].kind == LEG_BACK))
            return 0;
    while (i < held->legs && i < legs && same_leg(&held->leg[i], &leg[i]))
        i++;
    const int64_t mine = i < held->legs ? held->leg[i].from : INT64_MAX, other = i < legs ? leg[i].from : INT64_MAX;
    return mine < other ? mine : other;
}

bool journal_restore(struct session *session, struct held_run *held, const struct leg *leg, int legs, int64_t steps,
                     double t)
{
    struct run *run = held->run;
    struct leg *copy;
    if (!journal_copy(leg, legs, &copy))
        return false;
    int64_t way = common_way(held, leg, legs);
    way = steps < way ? steps : way;
    if (run->steps != steps || run->t != t || way < steps) {
        /* What these remember of earlier steps comes back only by doing them again; a row at an even time is no step,
         * and a step control starts anew from any but the first. */
        if (run->method->flags & (METHOD_MULTISTEP | METHOD_YARDSTICK) || run->settings.record.rule == RECORD_TIMES ||
            (run->settings.record.rule == RECORD_EVERY && run->plan.adaptive))
            way = 0;
        size_t rows = trace_count(run->trace), back = 0;
        while (back + 1 < rows && trace_step(run->trace, rows - 1 - back) > way)
            back++;
        if (back > 0)
            run_back(run, (int64_t)back);
        replay(session, held, leg, legs, steps);
    }
    journal_free(held->leg, held->legs);
    held->leg = copy;
    held->legs = legs;
    return true;
}

/* ---- as commands ---- */

/* Whether a condition reads the same in a session that has no variables and results. */
static bool portable(const struct session *session, const struct run *run, const char *condition)
{
    struct names names = {.session = session, .run = run, .saved_only = true};
    const struct expr_scope scope = names_scope(&names);
    struct arena arena = {0};
    struct condition compiled;
    struct error ignored;
    size_t used;
    const bool ok = condition_compile(text_of(condition), &scope, &arena, &compiled, &used, &ignored);
    arena_reset(&arena);
    return ok;
}

struct composer {
    const struct session *session;
    const struct run *run;
    int number;   /* of the run, 0: the next */
    bool started; /* it exists already */
    struct buffer *text;
};

static void put_number(const struct composer *c)
{
    if (!c->started && c->number > 0)
        buffer_format(c->text, " --number %d", c->number);
}

/* The run at its start, for what happened before its first step. */
static void put_start(struct composer *c)
{
    if (c->started)
        return;
    buffer_put(c->text, TEXT("run --steps 1"));
    put_number(c);
    buffer_put(c->text, TEXT("\nreset\n"));
    c->started = true;
}

/* Along a leg from step `from` to step `to`, which was reached at time t. */
static bool put_go(struct composer *c, const struct leg *leg, int64_t from, int64_t to, double t)
{
    const struct run *run = c->run;
    const bool met = leg->condition && leg->met == to;
    if (met && !portable(c->session, run, leg->condition))
        return false;
    /* Options first: after a condition they would be read as minus signs. */
    buffer_put(c->text, c->started ? TEXT("continue") : TEXT("run"));
    put_number(c);
    if (met) {
        buffer_format(c->text, " until %s", leg->condition);
    } else {
        /* Without a target any time that is far enough does. */
        const double far = copysign(2 * (double)(to + 1) * run->settings.dt, leg->t);
        if (t != leg->t)
            buffer_format(c->text, " --steps %lld", (long long)(to - from));
        buffer_put(c->text, TEXT(" to "));
        buffer_real(c->text, run->plan.adaptive || fabs(leg->t) < FAR ? leg->t : run->t + far);
        buffer_put(c->text, TEXT(" s"));
    }
    buffer_char(c->text, '\n');
    c->started = true;
    return true;
}

void journal_put_change(const struct run *run, const struct leg *leg, struct buffer *text)
{
    const struct param_row *param = leg->kind == LEG_SET ? param_at(&run->scene, leg->param) : NULL;
    const struct variable *variable = &run->system.model->variable[param ? 0 : leg->param];
    buffer_format(text, "%s ", param ? param->row.name : variable->name);
    buffer_exact(text, leg->value, param ? param->quantity : variable->quantity);
}

bool journal_write(const struct session *session, const struct held_run *held, int first, int64_t since, int number,
                   bool by_events, struct buffer *text)
{
    const struct run *run = held->run;
    const size_t before = text->len;
    struct composer c = {session, run, number, since >= 0, text};
    const struct leg *going = NULL;
    int64_t at = since < 0 ? 0 : since;
    for (int i = 0; i <= held->legs; i++) {
        const struct leg *next = i < held->legs ? &held->leg[i] : NULL;
        if (next && next->by_event && !by_events)
            continue;
        const int64_t to = next ? next->from : run->steps;
        /* No step, but the time: it was the one asked for but for rounding. */
        const bool ends = !next && going && going->from == at && going->from_t != run->t;
        if (i >= first && going && (to > at || ends)) {
            if (!put_go(&c, going, at, to, next ? next->from_t : run->t)) {
                text->len = before;
                return false;
            }
            at = to;
        }
        if (next && next->kind == LEG_GO)
            going = next;
        if (!next || next->kind == LEG_GO || i < first)
            continue;
        put_start(&c);
        if (next->kind == LEG_BACK) {
            buffer_format(text, "back %lld", (long long)next->rows);
        } else {
            buffer_put(text, TEXT("change "));
            journal_put_change(run, next, text);
        }
        buffer_char(text, '\n');
        at = next->kind == LEG_BACK ? next->end : next->kind == LEG_KICK ? next->from + 1 : at;
    }
    put_start(&c);
    return true;
}
