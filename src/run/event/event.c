/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Events: sign changes of an expression, located on the dense output of the step in which they
 * happen. Bounds of the expression prove that none is missed, or a doubt is noted. events_begin()
 * for each call of run_advance(), events_find() after each step. */
#include <hooke/scene/formula.h>
#include "run/event/watch.h"

#include <float.h>
#include <stdlib.h>

/* Rounding error, in units of the last place, of a sum over steps, besides one for each step. */
#define TIME_ROUNDING_ULPS 16
/* Touches of 0 that are nearer to each other, as a part of a step, count as one. */
#define TOUCH_SEPARATION 1e-7
/* They count as one, too, if the value is 0 at the ends of this many even parts between them. */
#define TOUCH_LOOKS 4
/* Factor by which the error of a step may have grown in the run. */
#define ERROR_GROWTH_FACTOR 100
/* Part of the sizes of the state that stands for the unknown error of fixed steps. */
#define NEAR_FIXED 1e-4
/* Moments that are nearer to each other, in units of the last place of t, are one. */
#define TIME_EQUAL_ULPS 8

static int sign_of(double value)
{
    return (value > 0) - (value < 0);
}

/* Returns the fraction of each variable's size by which a state may be wrong. */
static double error_fraction(const struct run *run)
{
    const double rounding = (TIME_ROUNDING_ULPS + (double)run->steps) * DBL_EPSILON;
    return run->plan.adaptive ? fmax(rounding, run->settings.tol) : rounding;
}

/* Returns the same for errors that have grown since: nearer to 0, a touch is not certain. */
static double doubt_fraction(const struct run *run)
{
    return run->plan.adaptive ? ERROR_GROWTH_FACTOR * error_fraction(run) : NEAR_FIXED;
}

/* Raises the sizes of the variables to those of a state. */
static void note_sizes(struct event_watch *watch, const double *y)
{
    for (int i = 0; i < watch->run->system.n; i++)
        watch->size[i] = fmax(watch->size[i], fabs(y[i]));
}

/* Finds the sizes of the variables in all recorded rows. */
static void sizes_find(struct event_watch *watch)
{
    const struct trace *trace = watch->run->trace;
    memset(watch->size, 0, sizeof watch->size);
    for (size_t row = 0; row < trace_count(trace); row++)
        note_sizes(watch, trace_state(trace, row));
    watch->sized = true;
}

void events_forget_sizes(struct run *run)
{
    if (run->private_state->watch)
        run->private_state->watch->sized = false;
}

/* ---- at the beginning of a call of run_advance() ---- */

/* Begins at the end of a run that the condition has stopped: it must become false first. */
static void depart_from_condition(struct event_watch *watch, struct watched *watched)
{
    struct run *run = watch->run;
    watched->departs = events_watch_is_zero(watch, watched, run->t, run->y, error_fraction(run));
    watched->touched = watched->departs ? run->t : NAN;
}

bool events_begin(struct run *run, const struct segment *segment)
{
    struct run_private *p = run->private_state;
    if (segment->target->events == 0 && !segment->target->condition) {
        events_forget_sizes(run);
        return true;
    }
    if (!p->watch)
        p->watch = calloc(1, sizeof *p->watch);
    struct event_watch *watch = p->watch;
    if (!watch || !events_watch_begin(watch, run, segment->target))
        return false;
    if (!watch->sized)
        sizes_find(watch);
    note_sizes(watch, run->y);
    for (int i = 0; i < watch->events; i++) {
        struct watched *watched = &watch->event[i];
        watched->value = events_watch_value(watch, watched, run->t, run->y);
        watched->known = true;
        watched->departs =
            watched->value == 0 ||
            (run->steps == 0 && events_watch_is_zero(watch, watched, run->t, run->y, DBL_EPSILON));
        watched->sign = watched->departs ? 0 : sign_of(watched->value);
        watched->touched = run->steps == 0 && watched->departs ? run->t : watched->touched;
        if (watched->value == 0 && watch->left[i].event == watched->event &&
            watch->left_step == run->steps && watch->left_t == run->t) {
            watched->departs = false;
            watched->sign = watch->left[i].sign;
        }
        if (i == watch->stop_event && run->stop == STOP_CONDITION)
            depart_from_condition(watch, watched);
        else if (i == watch->stop_event && watched->value == 0) {
            watched->departs = false;
            watched->sign =
                watch->or_equal ? watched->event->direction : -watched->event->direction;
        }
    }
    for (size_t i = run_event_records(run); i > 0 && run_event_record(run, i - 1)->t == run->t; i--)
        if (run_event_record(run, i - 1)->event < watch->events)
            watch->event[run_event_record(run, i - 1)->event].departs = true;
    return true;
}

/* ---- inside of a step ---- */

/* State of a search for an event in one step. */
struct event_search {
    struct event_watch *watch;
    struct watched *watched;
    int event;
    double stop_theta; /* fraction of the step at which an event stops the run; 1 if none does */
    bool failed;       /* memory ran out */
    double largest;    /* larger one of the magnitudes at both ends of the interval searched */
    /* Fraction of the step at which it is so close to 0 that a touch can be neither proved nor
     * excluded; NAN if there is none. */
    double doubtful_theta;
    /* Fraction of the step at which an event that would have stopped the run nearly happened; NAN
     * if there is none. */
    double miss;
    const struct root_search *roots; /* the search in progress; NULL if there is none */
};

/* Returns true if the event is the condition. */
static bool is_condition(const struct event_search *look)
{
    return look->event == look->watch->stop_event;
}

/* Returns the event's function at the fraction theta of the step. */
static double search_value(void *context, double theta)
{
    const struct event_search *look = context;
    double y[LIMIT_VARIABLES];
    path_state(&look->watch->path, theta, y);
    return events_watch_value(look->watch, look->watched, path_time(&look->watch->path, theta), y);
}

static struct jet search_bounds(void *context, double a, double b)
{
    const struct event_search *look = context;
    return events_watch_bounds(look->watch, look->watched, a, b);
}

/* Returns true if the function may be 0 at theta, within this fraction of the variables' sizes. */
static bool is_zero(const struct event_search *look, double theta, double fraction)
{
    const struct step_path *path = &look->watch->path;
    double y[LIMIT_VARIABLES];
    path_state(path, theta, y);
    return events_watch_is_zero(look->watch, look->watched, path_time(path, theta), y, fraction);
}

/* Returns true if a touch at theta is the one before, because the value has not left 0 since. */
static bool is_same_touch(const struct event_search *look, double theta, double fraction)
{
    const struct step_path *path = &look->watch->path;
    const double touched = look->watched->touched;
    const double touch_theta = (touched - path->inside.t) / path->inside.h;
    if (fabs(path_time(path, theta) - touched) <= TOUCH_SEPARATION * fabs(path->inside.h))
        return true;
    bool same = touch_theta >= 0 && touch_theta < theta;
    for (int k = 1; same && k < TOUCH_LOOKS; k++)
        same = is_zero(look, touch_theta + (theta - touch_theta) * k / TOUCH_LOOKS, fraction);
    return same;
}

/* Returns true if the function touches 0 at theta; otherwise notes if it is doubtful. */
static bool search_touches(void *context, double theta)
{
    struct event_search *look = context;
    const struct run *run = look->watch->path.inside.run;
    if (is_zero(look, theta, error_fraction(run)))
        return true;
    if (!is_condition(look) && isnan(look->doubtful_theta) &&
        is_zero(look, theta, doubt_fraction(run)) &&
        !is_same_touch(look, theta, doubt_fraction(run)))
        look->doubtful_theta = theta;
    return false;
}

/* Notes that an event nearly happens at theta: another solution, a tolerance away, may meet it. */
static bool search_misses(void *context, double theta)
{
    struct event_search *look = context;
    if (is_zero(look, theta, doubt_fraction(look->watch->run)))
        look->miss = theta;
    return false;
}

/* Adds an event to those found in the step. Returns false if out of memory. */
static bool crossing_add(struct event_watch *watch, const struct event_crossing *crossing)
{
    const size_t n = (size_t)watch->run->system.n;
    size_t capacity = watch->found_capacity;
    if (!array_reserve(&watch->found, sizeof *watch->found, watch->count, &capacity) ||
        !array_reserve(&watch->state, n * sizeof *watch->state, watch->count,
                       &watch->found_capacity))
        return false;
    watch->found[watch->count++] = *crossing;
    return true;
}

/* Returns true if the sign changes because the value goes through infinity: towards theta it grows
 * from both sides. A comparison becomes true there, too, but the value does not pass through 0. */
static bool is_pole(struct event_search *look, double theta)
{
    /* fractions of the step, from far to near */
    static const double far = 1e-4, inner_distance = 1e-10, grows = 30;
    if (look->watched->right || !(fabs(search_value(look, theta)) > grows * look->largest))
        return false;
    bool pole = true;
    for (int side = -1; side <= 1; side += 2)
        if (theta + side * far >= 0 && theta + side * far <= 1)
            pole = pole && fabs(search_value(look, theta + side * inner_distance)) >
                               grows * fabs(search_value(look, theta + side * far));
    return pole;
}

/* Takes note of a sign change (sign 1 or -1) or a touch (0) at theta, if the event asks for it.
 * Returns false if the search ends: the run stops there, records are full, or out of memory. */
static bool search_found(void *context, double theta, int sign)
{
    struct event_search *look = context;
    const struct step_path *path = &look->watch->path;
    const struct event *event = look->watched->event;
    /* A condition becomes true on the way, an event rises with time. */
    const int direction = path->inside.h > 0 || is_condition(look) ? sign : -sign;
    const bool touches =
        sign == 0 && event->touching && look->roots && look->roots->sign == -event->direction;
    if (event->direction != 0 && event->direction != direction && !touches)
        return true;
    if (sign != 0 && is_pole(look, theta))
        return true;
    if (event->touching && is_same_touch(look, theta, error_fraction(path->inside.run)))
        return true;
    if (sign == 0 && fabs(path_time(path, theta) - look->watched->passed) <=
                         TOUCH_SEPARATION * fabs(path->inside.h))
        return true;
    if (sign == 0)
        look->watched->touched = path_time(path, theta);
    look->watched->passed = path_time(path, theta);
    const struct event_crossing crossing = {theta, path_time(path, theta), look->event, direction};
    look->failed = look->failed || !crossing_add(look->watch, &crossing);
    if (event->stop)
        look->stop_theta = fmin(look->stop_theta, theta);
    return !look->failed && !event->stop && look->watch->count <= LIMIT_EVENT_RECORDS;
}

/* Finds the sign of the event's function just after a segment has begun at an event, where the
 * value itself is rounding. Tries the whole step, then its half, and so on, until bounds of the
 * slope or of the second derivative exclude another event in that part: a ball that has just been
 * thrown up may be back long before the end of the step. Returns the end of that part as a fraction
 * of the step, and sets *value to the value there, and watched->sign. Returns 0 with *value 0 if
 * there is no such part, and 0 with the value at the beginning if that is not 0, since commands
 * executed at the event have changed the state. */
static double departure_find(struct event_search *look, double *value)
{
    struct watched *watched = look->watched;
    watched->departs = false;
    if (!is_zero(look, 0, NEAR_FIXED)) {
        *value = search_value(look, 0);
        watched->sign = sign_of(*value);
        return 0;
    }
    for (int halvings = 0; halvings < 44; halvings++) {
        const double b = ldexp(1, -halvings);
        const struct jet jet = events_watch_bounds(look->watch, watched, 0, b);
        int sign = (jet.slope.lo > 0) - (jet.slope.hi < 0);
        if (sign == 0 && jet.bend.lo * jet.bend.hi > 0) {
            const struct interval slope = events_watch_bounds(look->watch, watched, 0, 0).slope;
            const int bend = sign_of(jet.bend.lo);
            sign = slope.lo <= 0 && slope.hi >= 0 ? bend : 0;
        }
        *value = sign != 0 ? search_value(look, b) : 0;
        if (sign == 0 || sign_of(*value) != sign)
            continue;
        watched->sign = sign;
        return b;
    }
    watched->sign = 0;
    *value = 0;
    return 0;
}

/*
 * Returns the sign just beyond a step's end, where the value is 0: that of the slope, or of the
 * second derivative where it only touches, or of the value a little later on the same polynomials.
 */
static int sign_beyond(const struct event_search *look, int previous_sign)
{
    static const double probe = 0x1p-10; /* fraction of the step */
    const struct step_path *path = &look->watch->path;
    const struct jet jet = events_watch_bounds(look->watch, look->watched, 1, 1);
    double y[LIMIT_VARIABLES];
    if (jet.slope.lo > 0 || jet.slope.hi < 0)
        return jet.slope.lo > 0 ? 1 : -1;
    if (jet.bend.lo > 0 || jet.bend.hi < 0)
        return jet.bend.lo > 0 ? 1 : -1;
    path_estimate(path, 1 + probe, y);
    const int sign = sign_of(
        events_watch_value(look->watch, look->watched, path->end_t + probe * path->inside.h, y));
    return sign != 0 ? sign : previous_sign;
}

/* Returns true if an event is due within the rounding of the times up to the end of the run. */
static bool is_due(const struct event_search *look, const struct run_target *target)
{
    const struct run *run = look->watch->run;
    const struct watched *watched = look->watched;
    if (run->t != target->t || watched->sign == 0 || watched->value == 0)
        return false;
    const struct interval slope = events_watch_bounds(look->watch, watched, 1, 1).slope;
    const double mean = slope.lo + (slope.hi - slope.lo) / 2, time_ahead = -watched->value / mean;
    const double size = fmax(fabs(run->t), fabs(run->t - run->system.t0));
    return time_ahead > 0 && time_ahead * fabs(look->watch->path.inside.h) <=
                                 (TIME_ROUNDING_ULPS + (double)run->steps) * DBL_EPSILON * size;
}

/* Notes that an event may have been missed in this step; `is_close` means by a touch only. */
static void doubt_note(struct run *run, const struct event_search *look, double theta,
                       bool is_close)
{
    struct event_doubt *doubt =
        &run->private_state->doubt[is_condition(look) ? LIMIT_EVENTS : look->event];
    const struct step_path *path = &look->watch->path;
    doubt->t_first = doubt->steps == 0 ? path_time(path, theta) : doubt->t_first;
    doubt->t_last = path->end_t;
    doubt->steps++;
    doubt->is_close = is_close && (doubt->is_close || doubt->steps == 1);
}

/* Searches the step from the fraction theta_begin, where the function has this value, to theta_end,
 * and notes a doubt where bounds do not decide. */
static void interval_search(struct event_search *look, double theta_begin, double value,
                            double theta_end)
{
    struct watched *watched = look->watched;
    struct event_watch *watch = look->watch;
    const struct step_path *path = &watch->path;
    const double times = fmax(fabs(path->inside.t), fabs(path->end_t));
    struct root_search roots = {.context = look,
                                .value = search_value,
                                .bounds = search_bounds,
                                .found = search_found,
                                .touches = watched->event->touching ? search_touches : NULL,
                                .min =
                                    fmax(DBL_EPSILON * times / fabs(path->inside.h), DBL_EPSILON),
                                .budget = watched->budget,
                                .sign = watched->sign};
    roots.nonzero = value != 0 || watched->value != 0;
    const bool misses = watched->event->stop && !watched->event->touching && !is_condition(look) &&
                        watch->run->plan.adaptive;
    if (misses)
        roots.touches = search_misses;
    if (roots.touches && !is_condition(look))
        roots.touch_tolerance = events_watch_error(watch, watched, path->end_t, path->end,
                                                   doubt_fraction(path->inside.run));
    const double end = theta_end < 1 ? search_value(look, theta_end) : watched->value;
    look->doubtful_theta = look->miss = NAN;
    look->roots = &roots;
    look->largest = fmax(fabs(value), fabs(end));
    roots_find(&roots, theta_begin, value, theta_end, end);
    look->roots = NULL;
    watched->sign = roots.sign;
    if (!isnan(look->miss) && !(look->stop_theta < 1))
        look->failed |= !responses_add_miss(watch->run, look->event, look->miss);
    if ((roots.unsure || !path->resolved) && roots.nonzero)
        doubt_note(watch->run, look, roots.unsure ? roots.unsure_from : theta_begin, false);
    else if (!isnan(look->doubtful_theta))
        doubt_note(watch->run, look, look->doubtful_theta, true);
    if (roots.unsure)
        watched->budget = watched->budget / 2 + 8;
    else if (watched->budget < 1000)
        watched->budget *= 2;
}

/* Searches the step just taken for the event of `look`, up to look->stop_theta. */
static void step_search(struct event_search *look, const struct run_target *target)
{
    struct watched *watched = look->watched;
    const struct step_path *path = &look->watch->path;
    double theta_begin = 0, value = watched->value;
    const double theta_tolerance = TIME_EQUAL_ULPS * DBL_EPSILON *
                                   fmax(fabs(path->inside.t), fabs(path->end_t)) /
                                   fabs(path->inside.h);
    const double theta_end = fmin(look->stop_theta + theta_tolerance, 1);
    watched->value = events_watch_value(look->watch, watched, path->end_t, path->end);
    if (watched->departs)
        theta_begin = departure_find(look, &value);
    const size_t old_count = look->watch->count;
    if (theta_begin < theta_end)
        interval_search(look, theta_begin, value, theta_end);
    if (theta_end < 1 || look->stop_theta < 1)
        return;
    const int sign = watched->sign;
    if (is_condition(look) &&
        watched->value == 0) { /* a strict one that is true beyond is found there */
        watched->sign =
            look->watch->or_equal ? watched->event->direction : -watched->event->direction;
        if (look->watch->or_equal && sign == -watched->sign)
            search_found(look, 1, watched->sign);
        return;
    }
    if (watched->value == 0 && sign != 0) {
        watched->sign = sign_beyond(look, sign);
        if (watched->sign != sign)
            search_found(look, 1, watched->sign);
    } else if (is_due(look, target) &&
               (look->watch->count == old_count || look->watch->found[old_count].theta < 1)) {
        watched->sign = -sign;
        search_found(look, 1, -sign);
    }
}

/* Orders events by time, then by definition, for qsort(). */
static int crossing_compare(const void *a, const void *b)
{
    const struct event_crossing *p = a, *q = b;
    return p->theta != q->theta ? (p->theta > q->theta) - (p->theta < q->theta)
                                : p->event - q->event;
}

/* Sorts the events found by time and computes their states. Events whose times differ only by
 * rounding count as simultaneous and keep the order of definition. */
static void crossings_sort(struct event_watch *watch)
{
    const struct step_path *path = &watch->path;
    const size_t n = (size_t)watch->run->system.n;
    struct event_crossing *found = watch->found;
    qsort(found, watch->count, sizeof *found, crossing_compare);
    for (size_t i = 1, first = 0; i < watch->count; i++) {
        const double t_tolerance =
            TIME_EQUAL_ULPS * DBL_EPSILON * fmax(fabs(found[i].t), fabs(path->inside.t));
        if (fabs(found[i].t - found[first].t) > t_tolerance) {
            first = i;
            continue;
        }
        struct event_crossing moved = found[i];
        moved.theta = found[first].theta;
        moved.t = found[first].t;
        size_t slot = i;
        for (; slot > first && found[slot - 1].event > moved.event; slot--)
            found[slot] = found[slot - 1];
        found[slot] = moved;
    }
    for (size_t i = 0; i < watch->count; i++)
        if (i > 0 && found[i].theta == found[i - 1].theta)
            memcpy(watch->state + i * n, watch->state + (i - 1) * n, n * sizeof *watch->state);
        else
            path_state(path, found[i].theta, watch->state + i * n);
}

/* Keeps the signs for the next call of run_advance(): a value may be 0 for longer than a step. */
static void signs_save(struct event_watch *watch)
{
    for (int i = 0; i < watch->events; i++) {
        watch->left[i].event = watch->event[i].event;
        watch->left[i].sign = watch->event[i].sign;
    }
    watch->left_step = watch->run->steps;
    watch->left_t = watch->run->t;
}

/* Events that stop the run are found first: the others are searched for up to there. */
bool events_find(struct run *run, const struct segment *segment, double t, double h)
{
    struct event_watch *watch = run->private_state->watch;
    const struct inside inside = inside_of(run, !run->plan.adaptive, t, h);
    struct event_search look = {.watch = watch, .stop_theta = 1, .largest = HUGE_VAL};
    path_begin(&watch->path, &inside);
    watch->count = 0;
    note_sizes(watch, run->y);
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < watch->events; i++) {
            if (watch->event[i].event->stop != (pass == 0))
                continue;
            look.watched = &watch->event[i];
            look.event = i;
            step_search(&look, segment->target);
        }
    if (watch->count > 0 && !look.failed)
        crossings_sort(watch);
    signs_save(watch);
    return !look.failed;
}
