/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Events: sign changes of an expression, located on the dense output of the step in which they happen. */
#include "private.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* ---- from text ---- */

static size_t blanks(struct text text, size_t at)
{
    while (at < text.len && (text.at[at] == ' ' || text.at[at] == '\t'))
        at++;
    return at;
}

static struct text from(struct text text, size_t at)
{
    return (struct text){text.at + at, text.len - at};
}

/* An expression and its unit at text[*at]. */
static const struct expr *side(struct text text, size_t *at, const struct expr_scope *scope, struct arena *arena,
                               const struct unit **unit, struct error *error)
{
    size_t used;
    const struct expr *expr = expr_compile(from(text, *at), scope, arena, &used, error);
    if (!expr)
        return NULL;
    *at = blanks(text, *at + used);
    *unit = unit_match(from(text, *at));
    if (*unit)
        *at = blanks(text, *at + text_of((*unit)->row.name).len);
    return expr;
}

/* The word at text[*at], if it is there. */
static bool take_word(struct text text, size_t *at, struct text word)
{
    const struct text rest = from(text, *at);
    if (!text_starts(rest, word) || (rest.len > word.len && rest.at[word.len] != ' ' && rest.at[word.len] != '\t'))
        return false;
    *at += word.len;
    return true;
}

bool event_compile(struct text text, const struct expr_scope *scope, struct arena *arena, struct event *event,
                   size_t *used, struct error *error)
{
    const struct unit *left = NULL, *right = NULL;
    size_t at = 0;
    struct event made = {.left = side(text, &at, scope, arena, &left, error), .scope = scope};
    if (!made.left)
        return false;
    if (at < text.len && (text.at[at] == '<' || text.at[at] == '>')) {
        made.direction = text.at[at] == '<' ? -1 : 1;
        at++;
        at += at < text.len && text.at[at] == '=';
        made.right = side(text, &at, scope, arena, &right, error);
        if (!made.right)
            return false;
        if (left && right && left->quantity != right->quantity)
            return error_at(error, text, "the two sides do not compare: %s is a unit of %s, %s of %s", left->row.name,
                            quantity_name(left->quantity), right->row.name, quantity_name(right->quantity));
    }
    const size_t word = at;
    const int direction = take_word(text, &at, TEXT("rising")) ? 1 : take_word(text, &at, TEXT("falling")) ? -1 : 0;
    if (direction != 0 && made.right)
        return error_at(error, (struct text){text.at + word, at - word},
                        "a comparison happens where it becomes true, rising or falling are for expressions");
    made.direction = direction != 0 ? direction : made.direction;
    made.left_factor = left ? left->factor : 1;
    made.right_factor = right ? right->factor : 1;
    memcpy(made.name, event->name, sizeof made.name);
    made.stop = event->stop;
    *event = made;
    *used = at;
    return true;
}

/* ---- values inside of a step ---- */

/* The step that was taken: the run's present state is its end. */
struct interval {
    struct run *run;
    const struct event *event;
    struct inside inside;
    double t, h, end_t;
    double end[LIMIT_VARIABLES];
};

struct inside inside_of(struct run *run, bool cold, double t, double h)
{
    struct inside inside = {run, *run->method, t, h};
    if (cold && method_turns(run->method, &run->system))
        inside.method.dense = NULL;
    return inside;
}

/* Steps of an adaptive method may be so long that a cubic through their ends says little: a shorter step does. */
void inside_state(const struct inside *inside, double theta, double *y)
{
    struct run *run = inside->run;
    struct run_private *p = run->private_state;
    struct sliding sliding;
    struct system frozen;
    struct step last = p->step;
    if (run->plan.adaptive)
        last.system = method_adapted(&run->system, &run->controller, &sliding, &frozen);
    if (p->side) {
        struct step step = last;
        step.kernel = last.system == &run->system ? last.kernel : NULL;
        step.t = inside->t;
        step.h = theta * inside->h;
        step.y = y;
        step.work = p->side;
        step.error = step.low = NULL;
        step.warm = step.again = false;
        copy_state(y, p->before, run->system.n);
        const enum step_status status = method_turning_step(run->method, &step);
        p->step.cost = step.cost;
        if (status == STEP_OK)
            return;
    }
    method_dense(&inside->method, &last, p->before, theta, y);
}

static void state_at(const struct interval *interval, double theta, double *y)
{
    const struct run *run = interval->run;
    struct run_private *p = run->private_state;
    if (theta <= 0 || theta >= 1) {
        copy_state(y, theta <= 0 ? p->before : interval->end, run->system.n);
        return;
    }
    inside_state(&interval->inside, theta, y);
}

static double time_at(const struct interval *interval, double theta)
{
    return theta >= 1 ? interval->end_t : interval->t + theta * interval->h;
}

static double event_value(const struct event *event)
{
    double value = expr_value(event->left, event->scope) * event->left_factor;
    return event->right ? value - expr_value(event->right, event->scope) * event->right_factor : value;
}

/* The scope knows the run's present state only: it is put there for a moment. */
static double value_at(const struct interval *interval, double theta)
{
    struct run *run = interval->run;
    double y[LIMIT_VARIABLES];
    state_at(interval, theta, y);
    copy_state(run->y, y, run->system.n);
    run->t = time_at(interval, theta);
    const double value = event_value(interval->event);
    copy_state(run->y, interval->end, run->system.n);
    run->t = interval->end_t;
    return value;
}

/*
 * Where the value passes through 0 between a and b, where it is fa and fb: the point beyond. Regula falsi with the
 * Illinois rule, every third time a bisection.
 */
static double locate(const struct interval *interval, double a, double fa, double b, double fb)
{
    const double least = DBL_EPSILON * fmax(fabs(interval->t), fabs(interval->end_t));
    double ga = fa, gb = fb;
    for (int i = 0; i < 200 && fb != 0 && fabs((b - a) * interval->h) > least; i++) {
        double x = i % 3 == 2 ? a + (b - a) / 2 : a + (b - a) * (ga / (ga - gb));
        if (!(x > a && x < b))
            x = a + (b - a) / 2;
        if (!(x > a && x < b))
            break;
        const double f = value_at(interval, x);
        if ((f < 0) == (fa < 0) && f != 0) {
            a = x;
            ga = f;
            gb /= 2;
        } else {
            b = x;
            fb = gb = f;
            ga /= 2;
        }
    }
    return b;
}

static signed char sign_of(double value)
{
    return (signed char)((value > 0) - (value < 0));
}

/* ---- in the course of a run ---- */

void events_begin(const struct run *run, struct leg *leg)
{
    for (int i = 0; i < leg->target->events; i++) {
        leg->sign[i] = sign_of(event_value(&leg->target->event[i]));
        leg->departs[i] = leg->sign[i] == 0;
    }
    for (size_t i = run_happenings(run); i > 0 && run_happening(run, i - 1)->t == run->t; i--)
        leg->departs[run_happening(run, i - 1)->event] = true;
}

/*
 * Where a leg begins at an event, the value there is rounding; its sign is the one a moment later, from where it grows
 * steadily. A ball that has just been thrown up may be back long before the end of the step. *theta, *value: that
 * moment; those of the beginning if the value does not grow.
 */
static void depart(const struct interval *interval, struct leg *leg, int event, double *theta, double *value)
{
    double last = *value, least = 4 * fabs(*value), a = 0;
    int grows = 0;
    leg->departs[event] = false;
    for (double b = 0x1p-40; b < 0.5; b *= 2) {
        const double f = value_at(interval, b);
        const bool steady = fabs(f) > least && sign_of(f) == sign_of(last) && fabs(f) > 1.5 * fabs(last);
        grows = steady ? grows + 1 : 0;
        if (grows == 1)
            a = b;
        if (grows == 3) {
            *theta = a;
            *value = value_at(interval, a);
            leg->sign[event] = sign_of(*value);
            return;
        }
        last = f;
    }
}

static void insert(struct crossings *crossings, const struct crossing *crossing, double h)
{
    int place = crossings->count++;
    for (; place > 0 && (crossings->found[place - 1].t - crossing->t) * h > 0; place--)
        crossings->found[place] = crossings->found[place - 1];
    crossings->found[place] = *crossing;
}

/* From one half of the step to its end: value `fa` at `a`, the sign before it is leg->sign. */
static double look_at(const struct interval *interval, struct leg *leg, int event, double a, double fa, double b,
                      struct crossings *crossings)
{
    const double fb = value_at(interval, b);
    const signed char before = leg->sign[event], after = fb == 0 ? (signed char)-before : sign_of(fb);
    if (after == 0 || fb != fb)
        return fb;
    leg->sign[event] = after;
    const int direction = interval->h > 0 ? after : -after;
    const int wanted = interval->event->direction;
    if (before == 0 || before == after || (wanted != 0 && wanted != direction))
        return fb;
    struct crossing crossing = {.event = event, .direction = direction};
    const double theta = sign_of(fa) == before ? locate(interval, a, fa, b, fb) : a;
    crossing.t = time_at(interval, theta);
    state_at(interval, theta, crossing.y);
    insert(crossings, &crossing, interval->h);
    return fb;
}

void events_find(struct run *run, struct leg *leg, double t, double h, struct crossings *crossings)
{
    struct interval interval = {
        .run = run, .inside = inside_of(run, !run->plan.adaptive, t, h), .t = t, .h = h, .end_t = run->t};
    copy_state(interval.end, run->y, run->system.n);
    crossings->count = 0;
    for (int i = 0; i < leg->target->events; i++) {
        interval.event = &leg->target->event[i];
        double begin = 0, value = value_at(&interval, 0);
        if (leg->departs[i])
            depart(&interval, leg, i, &begin, &value);
        value = look_at(&interval, leg, i, begin, value, 0.5, crossings);
        look_at(&interval, leg, i, 0.5, value, 1, crossings);
    }
}

static bool keep(struct run *run, const struct crossing *crossing)
{
    struct happenings *all = &run->private_state->happenings;
    const size_t n = (size_t)run->system.n;
    if (all->count == LIMIT_HAPPENINGS)
        return false;
    if (all->count == all->room) {
        const size_t room = all->room ? 2 * all->room : 16;
        struct happening *at = realloc(all->at, room * sizeof *at);
        all->at = at ? at : all->at;
        double *state = at ? realloc(all->state, room * n * sizeof *state) : NULL;
        all->state = state ? state : all->state;
        if (!state)
            return false;
        all->room = room;
    }
    all->at[all->count] = (struct happening){crossing->event, crossing->direction, run->steps, crossing->t};
    memcpy(all->state + all->count++ * n, crossing->y, n * sizeof *crossing->y);
    return true;
}

bool events_keep(struct run *run, const struct leg *leg, const struct crossings *crossings, double h, bool *stops)
{
    for (int i = 0; i < crossings->count; i++) {
        const struct crossing *crossing = &crossings->found[i];
        if ((crossing->t - run->t) * h > 0)
            break;
        if (!keep(run, crossing))
            return false;
        if (!leg->target->event[crossing->event].stop || *stops)
            continue;
        copy_state(run->y, crossing->y, run->system.n);
        run->t = crossing->t;
        forget_rounding(run->private_state, run->system.n);
        run->private_state->step.warm = false;
        *stops = true;
    }
    return true;
}

void happenings_truncate(struct run *run, double ahead)
{
    struct happenings *all = &run->private_state->happenings;
    for (; all->count > 0; all->count--) {
        const struct happening *last = &all->at[all->count - 1];
        if (last->step < run->steps || (last->step == run->steps && (last->t - run->t) * ahead <= 0))
            break;
    }
}

size_t run_happenings(const struct run *run)
{
    return run->private_state->happenings.count;
}

const struct happening *run_happening(const struct run *run, size_t i)
{
    return &run->private_state->happenings.at[i];
}

const double *run_happening_state(const struct run *run, size_t i)
{
    return run->private_state->happenings.state + i * (size_t)run->system.n;
}
