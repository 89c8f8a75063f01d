/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The journal of a run: the list of requests that were made of it, by which undo, saved sessions
 * and `record` recreate its state bit for bit. */
#include <hooke/run.h>
#include <hooke/session/events.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>
#include <hooke/scene/formula.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the list ---- */

/* Returns true for changes of parameters, with or without those by commands of events. */
static bool is_parameter_change(const struct request *request, bool by_events)
{
    return request->kind == REQUEST_SET && (by_events || !request->by_event);
}

/* Fills t with the times [s] of the latest changes of parameters, at most `max`, in order; changes
 * by commands of events are left out. Returns their number. The list is linked from its last
 * request backwards, so the times are collected from the end and reversed. */
int journal_changes(const struct request *last, double *t, int max)
{
    int count = 0;
    for (; last && count < max; last = last->previous)
        if (is_parameter_change(last, false))
            t[count++] = last->from_t;
    for (int i = 0; i < count / 2; i++) {
        const double later = t[i];
        t[i] = t[count - 1 - i];
        t[count - 1 - i] = later;
    }
    return count;
}

int journal_count(const struct request *last)
{
    return last ? last->count : 0;
}

struct request *journal_retain(struct request *last)
{
    if (last)
        last->references++;
    return last;
}

/* Releases the reference to the list that ends with request `last`; requests without another owner
 * are freed. */
void journal_release(struct request *last)
{
    for (struct request *previous; last && --last->references == 0; last = previous) {
        previous = last->previous;
        free(last->condition);
        free(last);
    }
}

/* Fills in the members of a request that depend on those before it. */
static void link_request(struct request *request, struct request *previous)
{
    request->references = 1;
    request->previous = previous;
    request->count = journal_count(previous) + 1;
    request->backs = request->kind == REQUEST_BACK || (previous && previous->backs);
    if (previous && previous->kind == REQUEST_GO)
        request->go = previous;
    else
        request->go = previous ? previous->go : NULL;
}

/* Appends a request with a copy of the condition. Returns false with the error set if there are too
 * many or out of memory. */
bool journal_add(struct run_slot *slot, struct request request, struct text condition,
                 struct error *error)
{
    if (journal_count(slot->last) >= LIMIT_REQUESTS) {
        error_set(error, ERROR_COMMAND, "run %d has already been continued and changed %d times",
                  slot->run->number, LIMIT_REQUESTS);
        return error_hint(error, "start a new one: run");
    }
    struct request *made = malloc(sizeof *made);
    if (!made)
        return error_memory(error);
    *made = request;
    made->condition = NULL;
    link_request(made, slot->last);
    slot->last = made;
    if (condition.len == 0 || (made->condition = strndup(condition.data, condition.len)))
        return true;
    journal_drop(slot);
    return error_memory(error);
}

/* Removes the last request from the run's list. */
void journal_drop(struct run_slot *slot)
{
    struct request *dropped = slot->last;
    slot->last = journal_retain(dropped->previous);
    journal_release(dropped);
}

/* Lists the requests from number `first` on, oldest first; the caller frees the list. */
bool journal_list(const struct request *last, int first, const struct request ***list, int *count)
{
    *count = journal_count(last) > first ? journal_count(last) - first : 0;
    *list = malloc(((size_t)*count + 1) * sizeof **list);
    *count = *list ? *count : 0;
    for (int i = *count; *list && last && i-- > 0; last = last->previous)
        (*list)[i] = last;
    return *list != NULL;
}

const struct request *journal_last_go(const struct request *last)
{
    return !last || last->kind == REQUEST_GO ? last : last->go;
}

const struct request *journal_pending(const struct run_slot *slot)
{
    return journal_last_go(slot->last);
}

/* Returns the last REQUEST_GO for changing, copied first if other lists share it; NULL with the
 * error set. */
struct request *journal_edit_pending(struct run_slot *slot, struct error *error)
{
    struct request *last = slot->last, *request = last;
    const struct request *pending = journal_last_go(last);
    bool alone = request->references == 1;
    for (; request != pending; alone &= request->references == 1)
        request = request->previous;
    if (alone)
        return request;
    /* it and the later requests are copied if other lists own them, too */
    const struct request **list;
    int count;
    if (!journal_list(last, request->count - 1, &list, &count)) {
        error_memory(error);
        return NULL;
    }
    struct request *edited = NULL;
    slot->last = journal_retain(request->previous);
    bool ok = true;
    for (int i = 0; i < count && ok; i++) {
        ok = journal_add(slot, *list[i], text_of(list[i]->condition), error);
        edited = i == 0 ? slot->last : edited;
    }
    free(list);
    journal_release(ok ? last : slot->last);
    if (!ok)
        slot->last = last;
    return ok ? edited : NULL;
}

/* Appends the rest of the last REQUEST_GO as a new request. */
bool journal_go_on(struct run_slot *slot, bool by_event, struct error *error)
{
    const struct request *request = journal_pending(slot);
    const struct request again = {.kind = REQUEST_GO,
                                  .start_step = slot->run->steps,
                                  .from_t = slot->run->t,
                                  .t = request->t,
                                  .end = request->end,
                                  .by_event = by_event};
    return journal_add(slot, again, text_of(request->condition), error);
}

/* Brings the journal up to date after the run was taken back: adds a request if going back has to
 * be repeated (adaptive runs, methods with memory, rows at even times), else removes the requests
 * made after the present step. */
bool journal_back(struct run_slot *slot, int64_t old_step, double before_t, int64_t rows,
                  struct error *error)
{
    const struct run *run = slot->run;
    if ((run->plan.adaptive || run_remembers(run) || run->settings.record.rule == RECORD_TIMES) &&
        run->steps > 0)
        return journal_add(slot,
                           (struct request){.kind = REQUEST_BACK,
                                            .start_step = old_step,
                                            .from_t = before_t,
                                            .rows = rows,
                                            .end = run->steps},
                           TEXT(""), error);
    while (slot->last && slot->last->start_step + (slot->last->kind == REQUEST_KICK) > run->steps)
        journal_drop(slot);
    const struct request *request = journal_pending(slot);
    if (request && request->met > run->steps) {
        struct request *edited = journal_edit_pending(slot, error);
        if (!edited)
            return false;
        edited->met = 0;
    }
    return true;
}

/* Fills in the scene with the parameters in force: reading from the end, the last change of each
 * one counts. */
void journal_scene(const struct run_slot *slot, bool by_events, struct scene *scene)
{
    bool is_known[PARAM_MAX] = {false};
    *scene = slot->run->scene;
    for (const struct request *request = slot->last; request; request = request->previous) {
        const int param = request->param;
        if (!is_parameter_change(request, by_events) || is_known[param])
            continue;
        is_known[param] = scene->chosen[param] = true;
        scene->value[param] = request->value.value;
        scene->uncertainty[param] =
            isnan(request->value.uncertainty) ? 0 : request->value.uncertainty;
    }
}

/* Returns true if a request from number `first` on was not made by an event. */
bool journal_changed(const struct run_slot *slot, int first)
{
    const struct request *request = slot->last;
    while (journal_count(request) > first && request->by_event)
        request = request->previous;
    return journal_count(request) > first;
}

/* ---- repeating requests ---- */

/* Advances the run towards the target of a request, with its condition and events, up to step
 * `end`. so_far is the run with the earlier requests as its journal. */
static void request_repeat(struct session *session, const struct run_slot *so_far,
                           const struct request *request, int64_t end)
{
    struct run *run = so_far->run;
    struct names names = {.session = session, .run = run};
    struct in_force force = {.slot = so_far};
    struct names watched = {.session = session, .run = run, .in_force = &force, .saved_only = true};
    const struct expr_scope watching = names_scope(&watched);
    const struct expr_scope scope = names_scope(&names);
    struct arena arena = {0};
    struct condition condition;
    struct error ignored;
    size_t used;
    struct run_target target = {.t = request->t, .steps = end - run->steps, .scope = &scope};
    if (target.steps < 0) /* if it is 0, the last bits of t may still have to change */
        return;
    if (request->condition &&
        condition_compile(text_of(request->condition), &scope, &arena, &condition, &used, &ignored))
        target.condition = &condition;
    events_compile(so_far->events, &watching, &arena, &target.event, &target.events, &ignored);
    run_advance(run, &target, 0, NULL);
    arena_reset(&arena);
}

/* Repeats the journal's requests (going on, stepping back, kicks, changed parameters) on the slot's
 * run until its step `steps`, along the list that ends at `last`, from the first request made at or
 * after the run's present step. Returns false if out of memory. */
static bool repeat_requests(struct session *session, struct run_slot *slot, struct request *last,
                            int64_t steps)
{
    struct run *run = slot->run;
    struct error ignored;
    struct request *done = last;
    const struct request **list;
    int count;
    while (done && done->start_step >= run->steps)
        done = done->previous;
    if (!journal_list(last, journal_count(done), &list, &count))
        return false;
    const struct request *going = journal_last_go(done);
    struct run_slot so_far = {.run = run, .events = slot->events, .last = done};
    for (int i = 0; i < count; i++) {
        if (going)
            request_repeat(session, &so_far, going, list[i]->start_step);
        so_far.last = i + 1 < count ? list[i + 1]->previous : last;
        if (list[i]->start_step < run->steps && list[i]->kind != REQUEST_GO)
            continue;
        if (list[i]->kind == REQUEST_GO) {
            going = list[i];
        } else if (list[i]->kind == REQUEST_BACK) {
            run_back(run, list[i]->rows);
        } else if (list[i]->kind == REQUEST_KICK) {
            run_kick(run, list[i]->param, list[i]->value.value, &ignored);
        } else {
            struct scene scene;
            journal_scene(&so_far, true, &scene);
            run_rebind(run, &scene, &ignored);
        }
    }
    if (going)
        request_repeat(session, &so_far, going, steps);
    free(list);
    return true;
}

/* Returns true if both requests ask for the same at the same step. */
static bool same_request(const struct request *a, const struct request *b)
{
    return a->kind == b->kind && a->start_step == b->start_step && a->t == b->t &&
           a->param == b->param && a->rows == b->rows &&
           memcmp(&a->value, &b->value, sizeof a->value) == 0 &&
           text_equal(text_of(a->condition), text_of(b->condition));
}

/* Returns the step up to which the requests of both lists lead to the same states: INT64_MAX if the
 * lists are equal, 0 if one contains a step back, which is hard to compare. */
static int64_t common_steps(const struct request *a, const struct request *b)
{
    /* steps at which the first differing requests were made */
    int64_t mine = INT64_MAX, other = INT64_MAX;
    if ((a && a->backs) || (b && b->backs))
        return 0;
    while (a != b) {
        const int more = journal_count(a) - journal_count(b);
        const bool differ = more != 0 || !a || !b || !same_request(a, b);
        if (a && more >= 0) {
            mine = differ ? a->start_step : mine;
            a = a->previous;
        }
        if (b && more <= 0) {
            other = differ ? b->start_step : other;
            b = b->previous;
        }
    }
    return mine < other ? mine : other;
}

/* Returns true if a parameter was changed at that step; such a change has effect but leaves no
 * row. */
static bool parameter_changes_at(const struct request *last, int64_t step)
{
    for (; last && last->start_step >= step; last = last->previous)
        if (last->kind == REQUEST_SET && last->start_step == step)
            return true;
    return false;
}

/* Takes the run to the state at the end of another list: goes back to the last row that both lists
 * share, and repeats the requests from there. Returns false if out of memory. */
bool journal_restore(struct session *session, struct run_slot *slot, struct request *last,
                     int64_t steps, double t)
{
    struct run *run = slot->run;
    int64_t way = common_steps(slot->last, last);
    bool ok = true;
    way = steps < way ? steps : way;
    const bool changed = slot->last != last && (parameter_changes_at(slot->last, steps) ||
                                                parameter_changes_at(last, steps));
    if (run->steps != steps || run->t != t || way < steps || changed) {
        /* A method's memory of earlier steps comes back only by doing them again; a row at an even
         * time is no step, and a step control starts anew from any but the first. */
        if (run_remembers(run) || run->settings.record.rule == RECORD_TIMES ||
            (run->settings.record.rule == RECORD_EVERY && run->plan.adaptive))
            way = 0;
        size_t rows = trace_count(run->trace), back = 0;
        while (back + 1 < rows && trace_step(run->trace, rows - 1 - back) > way)
            back++;
        if (back > 0)
            run_back(run, (int64_t)back);
        /* changes at this step that the other list has, too, are repeated below */
        if (parameter_changes_at(slot->last, run->steps))
            run_unbind(run);
        ok = repeat_requests(session, slot, last, steps);
    }
    if (ok) {
        journal_retain(last);
        journal_release(slot->last);
        slot->last = last;
    }
    return ok;
}
