/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Formulas of events, compiled for a run: their values at a state, and bounds of them inside of the
 * step just taken. */
#include <hooke/scene/formula.h>
#include "run/event/watch.h"

#include <float.h>
#include <stdlib.h>

/* Number of bounds of an event in a step before a warning that it may have been missed. */
#define EVENT_BOUNDS_MAX 4000
/* Number of parts of an interval at whose ends a column that is not a variable is evaluated. */
#define COLUMN_SAMPLES 12

/* ---- columns ---- */

/* Returns the column of the watch for a slot of the event's scope, which is added if it is new.
 * Returns -1 if the slot's value does not change in a run, or 0, and sets watch->failed, if out of
 * memory. A callback of expr_settle(). */
static int column_of(void *context, int slot)
{
    struct event_watch *watch = context;
    const struct expr_scope *scope = watch->scope;
    const int own = scope->moving ? scope->moving(scope->context, slot) : slot;
    if (own < 0)
        return -1;
    struct moving moving = run_scope_moving(watch->run, own);
    if (moving.kind == MOVING_OTHER)
        moving.index = slot;
    for (int i = 0; i < watch->columns; i++)
        if (watch->column[i].kind == moving.kind && watch->column[i].index == moving.index)
            return i;
    if (watch->columns == watch->capacity) {
        const int capacity = 2 * watch->capacity + 8;
        struct moving *column = arena_array(&watch->arena, (size_t)capacity, sizeof *column);
        watch->value = arena_array(&watch->arena, (size_t)capacity, sizeof *watch->value);
        watch->jet = arena_array(&watch->arena, (size_t)capacity, sizeof *watch->jet);
        watch->failed = watch->failed || !column || !watch->value || !watch->jet;
        if (watch->failed)
            return 0;
        if (watch->columns)
            memcpy(column, watch->column, (size_t)watch->columns * sizeof *column);
        watch->column = column;
        watch->capacity = capacity;
    }
    watch->column[watch->columns] = moving;
    return watch->columns++;
}

/* Makes watch->condition an event that stops the run when the target's condition becomes true. */
static void take_condition(struct event_watch *watch, const struct run_target *target)
{
    const struct condition *condition = target->condition;
    watch->or_equal = condition->or_equal;
    watch->condition = (struct event){.left = condition->left,
                                      .right = condition->right,
                                      .direction = condition->less ? -1 : 1,
                                      .touching = condition->or_equal,
                                      .stop = true,
                                      .scope = target->scope};
}

/* Compiles the formulas of all events in columns of what moves in a run; the rest are numbers. */
bool events_watch_begin(struct event_watch *watch, struct run *run, const struct run_target *target)
{
    arena_reset(&watch->arena);
    watch->columns = watch->capacity = 0;
    watch->failed = false;
    watch->run = run;
    watch->events = target->events + (target->condition != NULL);
    watch->stop_event = target->condition ? target->events : -1;
    if (target->condition)
        take_condition(watch, target);
    for (int i = 0; i < watch->events && !watch->failed; i++) {
        const struct event *event = i == watch->stop_event ? &watch->condition : &target->event[i];
        watch->scope = event->scope;
        struct watched made = {
            .event = event, .budget = EVENT_BOUNDS_MAX, .touched = NAN, .passed = NAN};
        made.left = expr_settle(event->left, event->scope, column_of, watch, &watch->arena);
        if (event->right)
            made.right = expr_settle(event->right, event->scope, column_of, watch, &watch->arena);
        watch->failed = watch->failed || !made.left || (event->right && !made.right);
        watch->event[i] = made;
    }
    return !watch->failed;
}

/* Frees the watch with everything that it owns. */
void events_watch_destroy(struct event_watch *watch)
{
    if (!watch)
        return;
    arena_reset(&watch->arena);
    free(watch->found);
    free(watch->state);
    free(watch);
}

/* ---- values ---- */

/* Returns the value of a column; `context` is the array of values. */
static double load_value(const void *context, int slot)
{
    return ((const double *)context)[slot];
}

/* Returns the value of a name in an event's expression that is not a variable (its slot in the
 * scope), at time t and state y. The scope reads the run's present state, so that the run is given
 * t and y for a moment. */
static double load_other(struct event_watch *watch, const struct watched *watched, int slot,
                         double t, const double *y)
{
    struct run *run = watch->run;
    const struct expr_scope *scope = watched->event->scope;
    const double end_t = run->t;
    double end[LIMIT_VARIABLES];
    if (y == run->y)
        return scope->load(scope->context, slot);
    copy_state(end, run->y, run->system.n);
    copy_state(run->y, y, run->system.n);
    run->t = t;
    const double value = scope->load(scope->context, slot);
    copy_state(run->y, end, run->system.n);
    run->t = end_t;
    return value;
}

/* Loads the columns at the state y and evaluates the formula. */
double events_watch_value(struct event_watch *watch, const struct watched *watched, double t,
                          const double *y)
{
    for (int i = 0; i < watch->columns; i++) {
        const struct moving *column = &watch->column[i];
        if (column->kind == MOVING_TIME)
            watch->value[i] = t;
        else
            watch->value[i] = column->kind == MOVING_STATE
                                  ? y[column->index]
                                  : load_other(watch, watched, column->index, t, y);
    }
    const struct expr_scope scope = {.context = watch->value, .load = load_value};
    const double value = expr_value(watched->left, &scope);
    return watched->right ? value - expr_value(watched->right, &scope) : value;
}

/* ---- bounds ---- */

/* Returns bounds of a - b, widened by rounding; everything if a difference of infinities is
 * undefined, and NAN if a or b is. */
static struct interval less_interval(struct interval a, struct interval b)
{
    const double lo = a.lo - b.hi, hi = a.hi - b.lo, slack = 4 * DBL_EPSILON;
    if (a.lo != a.lo || b.lo != b.lo)
        return (struct interval){NAN, NAN};
    if (lo != lo || hi != hi)
        return (struct interval){-HUGE_VAL, HUGE_VAL};
    return (struct interval){lo - slack * fabs(lo), hi + slack * fabs(hi)};
}

/* Returns the bounds of the event's function by those of its columns in watch->jet. */
static struct jet event_value_jet(const struct event_watch *watch, const struct watched *watched)
{
    const struct jet left = expr_jet(watched->left, watch->jet);
    if (!watched->right)
        return left;
    const struct jet right = expr_jet(watched->right, watch->jet);
    return (struct jet){less_interval(left.value, right.value),
                        less_interval(left.slope, right.slope),
                        less_interval(left.bend, right.bend)};
}

/* Returns the bounds of time for the fractions a to b of the step. */
static struct jet time_jet(const struct step_path *path, double a, double b)
{
    const double t_begin = path_time(path, a), t_end = path_time(path, b), h = path->inside.h;
    const double rounding = 2 * DBL_EPSILON * fmax(fabs(t_begin), fabs(t_end));
    return (struct jet){
        {fmin(t_begin, t_end) - rounding, fmax(t_begin, t_end) + rounding}, {h, h}, {0, 0}};
}

/* Returns bounds of a slot that is not a variable, by a polynomial through some of its values. They
 * are an estimate and prove nothing. */
static struct jet other_jet(struct event_watch *watch, const struct watched *watched, int slot,
                            double a, double b)
{
    double y[LIMIT_VARIABLES], value[COLUMN_SAMPLES + 1];
    const double apart = fmax(b - a, 1e-9), begin = fmin(a, 1 - apart);
    for (int k = 0; k <= COLUMN_SAMPLES; k++) {
        const double theta = begin + apart * k / COLUMN_SAMPLES;
        path_estimate(&watch->path, theta, y);
        value[k] = load_other(watch, watched, slot, path_time(&watch->path, theta), y);
    }
    return path_fit(value, COLUMN_SAMPLES, begin, begin + apart);
}

/* Bounds the columns for the fractions a to b of the step, and the formula by those. */
struct jet events_watch_bounds(struct event_watch *watch, const struct watched *watched, double a,
                               double b)
{
    const struct step_path *path = &watch->path;
    path_make(&watch->path);
    for (int i = 0; i < watch->columns; i++) {
        const struct moving *column = &watch->column[i];
        if (column->kind == MOVING_TIME)
            watch->jet[i] = time_jet(path, a, b);
        else
            watch->jet[i] = column->kind == MOVING_STATE
                                ? path_jet(path, column->index, a, b)
                                : other_jet(watch, watched, column->index, a, b);
    }
    return event_value_jet(watch, watched);
}

/* Returns bounds of the event's function at a state whose variables may be off by `error` of
 * their sizes, and whose time by twice TIME_EQUAL_ULPS of event.c, within which events are
 * simultaneous. */
static struct interval value_within(struct event_watch *watch, const struct watched *watched,
                                    double t, const double *y, double error)
{
    for (int i = 0; i < watch->columns; i++) {
        const struct moving *column = &watch->column[i];
        double value;
        if (column->kind == MOVING_TIME)
            value = t;
        else
            value = column->kind == MOVING_STATE ? y[column->index]
                                                 : load_other(watch, watched, column->index, t, y);
        const double size = column->kind == MOVING_STATE
                                ? fmax(fabs(value), watch->size[column->index])
                                : fabs(value);
        const double margin = size * (column->kind == MOVING_TIME ? 16 * DBL_EPSILON : error);
        watch->jet[i] = (struct jet){{value - margin, value + margin}, {0, 0}, {0, 0}};
    }
    return event_value_jet(watch, watched).value;
}

bool events_watch_is_zero(struct event_watch *watch, const struct watched *watched, double t,
                          const double *y, double error)
{
    const struct interval value = value_within(watch, watched, t, y, error);
    return value.lo <= 0 && value.hi >= 0;
}

double events_watch_error(struct event_watch *watch, const struct watched *watched, double t,
                          const double *y, double error)
{
    const struct interval value = value_within(watch, watched, t, y, error);
    return (value.hi - value.lo) / 2;
}
