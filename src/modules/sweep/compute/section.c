/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points of a sweep at a section, each as a run of its own: its events are those that `event NAME
 * when` records, its strobe the rows that are recorded after each period. */
#include <hooke/base/numeric.h>
#include "modules/sweep/compute/section.h"

#include <float.h>
#include <stdlib.h>

#define LOOK_STEPS 1024 /* number of steps between two checks of the events */
/* Two times are equal if their distance is at most this many rounding units. */
#define SECTION_TIME_ULPS 16
#define STATE_DISTANCE_MAX 1e-6 /* relative distance below which a state has come again */
/* A motion still settles if a distance of states changes by more than this fraction of it. */
#define DISTANCE_CHANGE_MAX 1e-2
#define REPEATS_MAX 1000 /* largest number of events after which states are compared */

/* Allocates the section of a worker. Returns false if out of memory. */
bool section_create(struct sweep_worker *worker)
{
    struct section *section = calloc(1, sizeof *section);
    const size_t n = (size_t)worker->job->request->scene->model->n;
    worker->section = section;
    if (!section || !worker->job->in_lanes)
        return section;
    section->state = malloc((SWEEP_ROWS + 1) * n * LANE_COUNT * sizeof *section->state);
    section->slope = malloc(n * sizeof *section->slope);
    return section->state && section->slope;
}

/* Frees the memory; NULL is allowed. */
void section_free(struct section *section)
{
    if (!section)
        return;
    arena_reset(&section->arena);
    free(section->state);
    free(section->slope);
    free(section);
}

double section_steps(const struct sweep_request *request, const struct system *system)
{
    const struct sweep_section *section = &request->section;
    const double period = section->strobe ? system_drive(system) : NAN;
    return (double)(section->skip + section->keep) * period / request->settings.dt;
}

/* ---- names ---- */

/* Values of the names of an event: of the run, and of the scene. */
struct point_names {
    struct expr_scope own; /* scope of the run */
    const struct scene *scene;
};

/* Returns the value of a slot. */
static double name_load(const void *context, int slot)
{
    const struct point_names *names = context;
    if (slot < SWEEP_SLOT_PARAM)
        return names->own.load(names->own.context, slot);
    return sweep_scene_value(names->scene, slot);
}

/* Returns the slot of a name of the run, or -1 for a name of the scene, which becomes a number. */
static int own_slot(void *context, int slot)
{
    (void)context;
    return slot < SWEEP_SLOT_PARAM ? slot : -1;
}

/* Compiles the section's event for one point, with the point's parameters as numbers. Returns false
 * if out of memory. */
static bool crossings_settle(struct sweep_worker *worker, struct crossings *crossings)
{
    struct point_names names = {.scene = &worker->scene};
    const struct expr_scope scope = {.context = &names, .load = name_load};
    struct arena *arena = &worker->section->arena;
    struct event *event = &crossings->event;
    *event = worker->job->request->section.event;
    run_scope(crossings->run, &names.own);
    crossings->scope = names.own;
    event->left = expr_settle(event->left, &scope, own_slot, NULL, arena);
    event->right = event->right ? expr_settle(event->right, &scope, own_slot, NULL, arena) : NULL;
    event->scope = &crossings->scope;
    event->stop = false;
    return event->left && (event->right || !worker->job->request->section.event.right);
}

/* ---- one point ---- */

/* Creates the run of sweep point i, which records the section's points: strobed once per drive
 * period, or by the section's event. Returns false, and notes the error for that point, if the
 * scene has no drive, the run cannot be created or if out of memory. On success the caller frees
 * crossings->run. */
bool crossings_begin(struct sweep_worker *worker, int64_t i, struct crossings *crossings)
{
    const struct sweep_request *request = worker->job->request;
    const struct sweep_section *section = &request->section;
    struct system *bound = &worker->section->bound;
    struct error error = {0};
    double span = request->duration;
    *crossings = (struct crossings){.run = NULL};
    bool ok =
        sweep_point(request, worker->job->sweep, i, &worker->scene, &worker->settings, &error);
    struct run_settings settings = worker->settings;
    settings.record = (struct recording_rule){.rule = RECORD_EVERY, .every = INT64_MAX};
    settings.unbalanced = true;
    if (ok && section->strobe && (ok = scene_bind_motion(&worker->scene, bound, &error))) {
        crossings->period = system_drive(bound);
        span = crossings->period * ((double)(section->skip + section->keep) + 0.5);
        settings.record =
            (struct recording_rule){.rule = RECORD_TIMES, .interval = crossings->period};
        if (!(crossings->period > 0))
            ok = error_set(&error, ERROR_COMMAND, "this scene has no drive with a period");
    }
    if (ok)
        crossings->run = run_create(&worker->scene, request->method, &settings, span, &error);
    if (crossings->run && !section->strobe && !crossings_settle(worker, crossings)) {
        error_memory(&error);
        run_destroy(crossings->run);
        crossings->run = NULL;
    }
    if (!crossings->run)
        sweep_refuse(worker, i, &error);
    for (int k = 0; crossings->run && k < crossings->run->system.n; k++)
        crossings->angle[k] = variable_is_angle(&crossings->run->system, k);
    return crossings->run;
}

bool crossings_end(const struct sweep_request *request, const struct run *run, int64_t steps,
                   double time)
{
    return run->plan.adaptive ? fabs(time) > request->duration
                              : (double)steps > ceil(request->duration / run->settings.dt);
}

/* Returns the number of events before the first interval without one that is as long as the run's
 * duration, after which the search ended. */
static int64_t events_of(const struct sweep_request *request, const struct run *run)
{
    const int64_t count = (int64_t)run_event_records(run);
    int64_t steps = 0;
    double t = run->system.t0;
    for (int64_t k = 0; k < count; k++) {
        const struct event_record *record = run_event_record(run, (size_t)k);
        if (crossings_end(request, run, record->step - steps, record->t - t))
            return k;
        steps = record->step;
        t = record->t;
    }
    return count;
}

/* Returns the value of a measure at a state. */
static double measure_value(const struct sweep_measure *measure, const struct system *system,
                            double t, const double *y)
{
    if (measure->kind != SWEEP_OBSERVABLE)
        return sweep_measured(measure, system, t, y);
    return observable_defined(measure->observable, system, false)
               ? measure->observable->value(&(struct sample){.t = t, .y = y, .system = system})
               : NAN;
}

/* Returns true if that row of the trace is the state after `period` periods of the drive. */
bool crossings_strobed(const struct crossings *crossings, size_t row, int64_t period)
{
    const struct run *run = crossings->run;
    const double t0 = run->system.t0, due = t0 + (double)period * crossings->period;
    return row < trace_count(run->trace) &&
           fabs(trace_time(run->trace, row) - due) <=
               SECTION_TIME_ULPS * DBL_EPSILON * fmax(fabs(due), fabs(t0));
}

/* Returns an angle reduced to (-pi, pi], and other values unchanged. */
static double reduce_angle(const struct crossings *crossings, int variable, double value)
{
    return crossings->angle[variable] ? remainder(value, TWO_PI) : value;
}

/* Sets *t and y [n] to time and state of section point `index`: the event record with that index
 * or, for a strobe, row index + 1 of the trace, which must be the state after `period` periods of
 * the drive. Angles are reduced to one turn. Returns false if the strobe's row does not exist. */
static bool state_at(const struct crossings *crossings, int64_t index, int64_t period, double *t,
                     double *y)
{
    const struct run *run = crossings->run;
    if (crossings->period > 0) { /* the first row is the start */
        if (!crossings_strobed(crossings, (size_t)index + 1, period))
            return false;
        *t = trace_time(run->trace, (size_t)index + 1);
    } else {
        *t = run_event_record(run, (size_t)index)->t;
    }
    const double *state = crossings->period > 0 ? trace_state(run->trace, (size_t)index + 1)
                                                : run_event_record_state(run, (size_t)index);
    for (int k = 0; k < run->system.n; k++)
        y[k] = reduce_angle(crossings, k, state[k]);
    return true;
}

/* Returns true if each of the `count` states equals the one `apart` events later, within
 * STATE_DISTANCE_MAX of the variables' sizes; that is, if the orbit is periodic. */
static bool states_repeat(const struct crossings *crossings, const double *state, int64_t count,
                          int64_t apart)
{
    const struct system *system = &crossings->run->system;
    const int n = system->n;
    for (int64_t k = 0; k + apart < count; k++)
        for (int i = 0; i < n; i++) {
            const double a = state[k * n + i], b = state[(k + apart) * n + i];
            const double size = fmax(fmax(fabs(a), fabs(b)), system->scale[i]);
            if (!(fabs(reduce_angle(crossings, i, a - b)) <= STATE_DISTANCE_MAX * size))
                return false;
        }
    return true;
}

/* Returns the distance, in natural sizes, between state k and the state `lag` events later. */
static double distance_of_states(const struct crossings *crossings, const double *state, int64_t k,
                                 int64_t lag)
{
    const struct system *system = &crossings->run->system;
    double apart = 0;
    for (int i = 0; i < system->n; i++) {
        const double a = state[k * system->n + i], b = state[(k + lag) * system->n + i];
        apart = fmax(apart, fabs(reduce_angle(crossings, i, a - b)) / system->scale[i]);
    }
    return apart;
}

/* Returns true if the states still approach an orbit of half as many points, which near a period
 * doubling happens slowly and from both sides. */
static bool states_still_settle(const struct crossings *crossings, const double *state,
                                int64_t count, int64_t apart)
{
    const int64_t half = apart / 2, last = half > 0 ? (count - 1 - half) / half * half : 0;
    if (apart % 2 != 0)
        return false;
    const double first = distance_of_states(crossings, state, 0, half);
    return !(fabs(distance_of_states(crossings, state, last, half) - first) <=
             DISTANCE_CHANGE_MAX * first);
}

/* Returns the number of events after which the states [count][n] repeat, or NAN if they do not or
 * still settle. */
static double count_repeats(const struct crossings *crossings, const double *state, int64_t count)
{
    for (int64_t apart = 1; 2 * apart <= count && apart <= REPEATS_MAX; apart++)
        if (states_repeat(crossings, state, count, apart))
            return states_still_settle(crossings, state, count, apart) ? NAN : (double)apart;
    return NAN;
}

/* Stores the events of the run from number `first` up to `count`, at most section->keep, as results
 * of point i: the number of events after which the states repeat (NAN if they do not), then for
 * each event its time and measures. */
void crossings_take(struct sweep_worker *worker, int64_t i, const struct crossings *crossings,
                    int64_t first, int64_t count)
{
    const struct sweep_request *request = worker->job->request;
    const struct sweep_section *section = &request->section;
    const struct system *system = &crossings->run->system;
    const int64_t keep = count - first < section->keep ? count - first : section->keep;
    double *values = sweep_values(worker, i), *value = values + 1,
           *state = arena_array(&worker->section->arena, (size_t)(keep > 0 ? keep : 0) + 1,
                                (size_t)system->n * sizeof *state);
    int64_t k = 0;
    for (double t; state && k < keep; k++) {
        double *y = state + k * system->n;
        if (!state_at(crossings, first + k, section->skip + k + 1, &t, y))
            break;
        *value++ = t;
        for (int m = 0; m < request->measures; m++)
            *value++ = measure_value(&request->measure[m], system, t, y);
    }
    values[0] = state ? count_repeats(crossings, state, k) : NAN;
    worker->failed |= !state;
}

/* Advances the run to the last wanted event (skip + keep), or until no event has come for as long
 * as the duration. Returns early if the run fails or is cancelled. */
static void advance_events(const struct sweep_request *request, struct crossings *crossings)
{
    const size_t wanted = (size_t)(request->section.skip + request->section.keep);
    struct run *run = crossings->run;
    for (;;) {
        const struct run_target target = {
            .t = HUGE_VAL, .steps = LOOK_STEPS, .event = &crossings->event, .events = 1};
        while (run_advance(run, &target, 0, request->cancel)) {
        }
        const size_t count = run_event_records(run);
        int64_t last_step = 0;
        double last_t = run->system.t0;
        if (count > 0) {
            last_step = run_event_record(run, count - 1)->step;
            last_t = run_event_record(run, count - 1)->t;
        }
        if (run->stop != STOP_END || count >= wanted ||
            crossings_end(request, run, run->steps - last_step, run->t - last_t))
            return;
    }
}

/* Computes point i at the section by a run of its own, without lanes. The strobe's run lasts half a
 * period longer than needed, so that rounding does not omit its last row. */
void section_alone(struct sweep_worker *worker, int64_t i)
{
    const struct sweep_request *request = worker->job->request;
    const struct sweep_section *section = &request->section;
    struct crossings crossings;
    arena_reset(&worker->section->arena);
    if (!crossings_begin(worker, i, &crossings))
        return;
    struct run *run = crossings.run;
    const struct run_target target = {
        .t = run->system.t0 + crossings.period * ((double)(section->skip + section->keep) + 0.5),
        .steps = -1};
    if (!section->strobe)
        advance_events(request, &crossings);
    else
        while (run_advance(run, &target, 0, request->cancel)) {
        }
    if (run->stop != STOP_CANCELLED) {
        crossings_take(worker, i, &crossings, section->skip,
                       section->strobe ? (int64_t)trace_count(run->trace) - 1
                                       : events_of(request, run));
        worker->job->sweep->status[i] = (signed char)run->stop;
    }
    worker->steps += (double)run->steps;
    run_destroy(run);
}
