/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the list ---- */

#define SCENE_EVERY 16 /* so many changed parameters are gone through where the scene in force is asked for */

static bool is_set(const struct leg *leg, bool by_events)
{
    return leg->kind == LEG_SET && (by_events || !leg->by_event);
}

static const struct leg *last_set(const struct leg *last, bool by_events)
{
    return !last || is_set(last, by_events) ? last : last->set[by_events].before;
}

int journal_changes(const struct leg *last, double *t, int most)
{
    const struct leg *leg = last_set(last, false);
    const int all = leg ? leg->set[false].count : 0, count = all < most ? all : most;
    for (int i = count; i-- > 0; leg = leg->set[false].before)
        t[i] = leg->from_t;
    return count;
}

int journal_count(const struct leg *last)
{
    return last ? last->count : 0;
}

struct leg *journal_share(struct leg *last)
{
    if (last)
        last->references++;
    return last;
}

void journal_release(struct leg *last)
{
    for (struct leg *before; last && --last->references == 0; last = before) {
        before = last->before;
        free(last->condition);
        free(last->set[0].scene);
        free(last->set[1].scene);
        free(last);
    }
}

/* What a leg knows of those before it. */
static void link_leg(struct leg *leg, struct leg *before)
{
    leg->references = 1;
    leg->before = before;
    leg->count = journal_count(before) + 1;
    leg->backs = leg->kind == LEG_BACK || (before && before->backs);
    leg->go = before && before->kind == LEG_GO ? before : before ? before->go : NULL;
    for (int i = 0; i < 2; i++) {
        leg->set[i].before = last_set(before, i);
        leg->set[i].count = (before ? before->set[i].count : 0) + is_set(leg, i);
        leg->set[i].scene = NULL;
    }
}

/* From time to time a leg keeps the whole scene. False: no memory. */
static bool keep_scene(struct held_run *held, bool by_events)
{
    struct leg *leg = held->last;
    struct scene scene, *copy;
    if (!is_set(leg, by_events) || leg->set[by_events].count % SCENE_EVERY != 0)
        return true;
    journal_scene(held, by_events, &scene);
    if ((copy = malloc(sizeof *copy)))
        *copy = scene;
    leg->set[by_events].scene = copy;
    return copy != NULL;
}

bool journal_add(struct held_run *held, struct leg leg, struct text condition, struct error *error)
{
    struct leg *made = malloc(sizeof *made);
    if (!made)
        return error_memory(error);
    *made = leg;
    made->condition = NULL;
    link_leg(made, held->last);
    held->last = made;
    const bool ok = (condition.len == 0 || (made->condition = strndup(condition.at, condition.len))) &&
                    keep_scene(held, false) && keep_scene(held, true);
    if (!ok)
        journal_drop(held);
    return ok || error_memory(error);
}

void journal_drop(struct held_run *held)
{
    struct leg *dropped = held->last;
    held->last = journal_share(dropped->before);
    journal_release(dropped);
}

bool journal_list(const struct leg *last, int first, const struct leg ***list, int *count)
{
    *count = journal_count(last) > first ? journal_count(last) - first : 0;
    *list = malloc(((size_t)*count + 1) * sizeof **list);
    *count = *list ? *count : 0;
    for (int i = *count; *list && i-- > 0; last = last->before)
        (*list)[i] = last;
    return *list != NULL;
}

static const struct leg *last_go(const struct leg *last)
{
    return !last || last->kind == LEG_GO ? last : last->go;
}

const struct leg *journal_pending(const struct held_run *held)
{
    return last_go(held->last);
}

struct leg *journal_edit_pending(struct held_run *held, struct error *error)
{
    struct leg *last = held->last, *leg = last;
    const struct leg *pending = last_go(last);
    bool alone = leg->references == 1;
    for (; leg != pending; alone &= leg->references == 1)
        leg = leg->before;
    if (alone)
        return leg;
    /* Copies of it and those after it, on what was before. */
    const struct leg **list;
    int count;
    if (!journal_list(last, leg->count - 1, &list, &count)) {
        error_memory(error);
        return NULL;
    }
    struct leg *edited = NULL;
    held->last = journal_share(leg->before);
    bool ok = true;
    for (int i = 0; i < count && ok; i++) {
        ok = journal_add(held, *list[i], text_of(list[i]->condition), error);
        edited = i == 0 ? held->last : edited;
    }
    free(list);
    journal_release(ok ? last : held->last);
    if (!ok)
        held->last = last;
    return ok ? edited : NULL;
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
    while (held->last && held->last->from + (held->last->kind == LEG_KICK) > run->steps)
        journal_drop(held);
    const struct leg *leg = journal_pending(held);
    if (leg && leg->met > run->steps) {
        struct leg *edited = journal_edit_pending(held, error);
        if (!edited)
            return false;
        edited->met = 0;
    }
    return true;
}

void journal_scene(const struct held_run *held, bool by_events, struct scene *scene)
{
    struct error ignored;
    const struct leg *set[SCENE_EVERY], *leg = last_set(held->last, by_events);
    int count = 0;
    for (; leg && !leg->set[by_events].scene; leg = leg->set[by_events].before)
        set[count++] = leg;
    *scene = leg ? *leg->set[by_events].scene : held->run->scene;
    while (count-- > 0)
        scene_set(scene, set[count]->param, set[count]->value, &ignored); /* was accepted then */
}

bool journal_changed(const struct held_run *held, int first)
{
    const struct leg *leg = held->last;
    while (journal_count(leg) > first && leg->by_event)
        leg = leg->before;
    return journal_count(leg) > first;
}

/* ---- doing it again ---- */

/* On along a leg until step `end`; so_far: the run with the legs done before. */
static void go(struct session *session, const struct held_run *so_far, const struct leg *leg, int64_t end)
{
    struct run *run = so_far->run;
    struct names names = {.session = session, .run = run};
    struct in_force force = {.held = so_far};
    struct names watched = {.session = session, .run = run, .in_force = &force, .saved_only = true};
    const struct expr_scope watching = names_scope(&watched);
    const struct expr_scope scope = names_scope(&names);
    struct arena arena = {0};
    struct condition condition;
    struct error ignored;
    size_t used;
    struct run_target target = {.t = leg->t, .steps = end - run->steps, .scope = &scope};
    if (target.steps < 0) /* 0: may be where a time is reached to the last bit */
        return;
    if (leg->condition && condition_compile(text_of(leg->condition), &scope, &arena, &condition, &used, &ignored))
        target.condition = &condition;
    events_compile(so_far->events, &watching, &arena, &target.event, &target.events, &ignored);
    run_advance(run, &target, 0, NULL);
    arena_reset(&arena);
}

/* The list that ends there, of which what led to the run's present step was done before. */
static bool replay(struct session *session, struct held_run *held, struct leg *last, int64_t steps)
{
    struct run *run = held->run;
    struct error ignored;
    struct leg *done = last;
    const struct leg **list;
    int count;
    while (done && done->from >= run->steps)
        done = done->before;
    if (!journal_list(last, journal_count(done), &list, &count))
        return false;
    const struct leg *going = last_go(done);
    struct held_run so_far = {.run = run, .events = held->events, .last = done};
    for (int i = 0; i < count; i++) {
        if (going)
            go(session, &so_far, going, list[i]->from);
        so_far.last = i + 1 < count ? list[i + 1]->before : last;
        if (list[i]->from < run->steps && list[i]->kind != LEG_GO)
            continue;
        if (list[i]->kind == LEG_GO) {
            going = list[i];
        } else if (list[i]->kind == LEG_BACK) {
            run_back(run, list[i]->rows);
        } else if (list[i]->kind == LEG_KICK) {
            run_kick(run, list[i]->param, list[i]->value.value, &ignored);
        } else {
            struct scene scene;
            journal_scene(&so_far, true, &scene);
            run_rebind(run, &scene, &ignored);
        }
    }
    if (going)
        go(session, &so_far, going, steps);
    free(list);
    return true;
}

static bool same_leg(const struct leg *a, const struct leg *b)
{
    return a->kind == b->kind && a->from == b->from && a->t == b->t && a->param == b->param && a->rows == b->rows &&
           memcmp(&a->value, &b->value, sizeof a->value) == 0 &&
           text_equal(text_of(a->condition), text_of(b->condition));
}

/* The step up to which both lists led along the same way; 0 where going back makes that hard to say. */
static int64_t common_way(const struct leg *a, const struct leg *b)
{
    int64_t mine = INT64_MAX, other = INT64_MAX; /* where the first that differ were asked for */
    if ((a && a->backs) || (b && b->backs))
        return 0;
    while (a != b) {
        const int more = journal_count(a) - journal_count(b);
        const bool differ = more != 0 || !same_leg(a, b);
        mine = differ && more >= 0 ? a->from : mine;
        other = differ && more <= 0 ? b->from : other;
        a = more >= 0 ? a->before : a;
        b = more <= 0 ? b->before : b;
    }
    return mine < other ? mine : other;
}

/* A parameter changed at that step is in force, and leaves no row. */
static bool sets_at(const struct leg *last, int64_t step)
{
    for (; last && last->from >= step; last = last->before)
        if (last->kind == LEG_SET && last->from == step)
            return true;
    return false;
}

bool journal_restore(struct session *session, struct held_run *held, struct leg *last, int64_t steps, double t)
{
    struct run *run = held->run;
    int64_t way = common_way(held->last, last);
    bool ok = true;
    way = steps < way ? steps : way;
    const bool changed = held->last != last && (sets_at(held->last, steps) || sets_at(last, steps));
    if (run->steps != steps || run->t != t || way < steps || changed) {
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
        if (sets_at(held->last, run->steps)) /* those that the other list has, too, are done again */
            run_unbind(run);
        ok = replay(session, held, last, steps);
    }
    if (ok) {
        journal_share(last);
        journal_release(held->last);
        held->last = last;
    }
    return ok;
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
    const struct leg **list, *going = held->last;
    int64_t at = since < 0 ? 0 : since;
    int count;
    if (!journal_list(held->last, first, &list, &count)) {
        text->failed = true;
        return false;
    }
    going = last_go(count > 0 ? list[0]->before : held->last);
    while (going && going->by_event && !by_events)
        going = going->go;
    for (int i = 0; i <= count; i++) {
        const struct leg *next = i < count ? list[i] : NULL;
        if (next && next->by_event && !by_events)
            continue;
        const int64_t to = next ? next->from : run->steps;
        /* No step, but the time: it was the one asked for but for rounding. */
        const bool ends = !next && going && going->from == at && going->from_t != run->t;
        if (going && (to > at || ends)) {
            if (!put_go(&c, going, at, to, next ? next->from_t : run->t)) {
                text->len = before;
                free(list);
                return false;
            }
            at = to;
        }
        if (next && next->kind == LEG_GO)
            going = next;
        if (!next || next->kind == LEG_GO)
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
    free(list);
    put_start(&c);
    return true;
}
