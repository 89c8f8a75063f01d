/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The events found in a step: which of them stops the run, and the records that are kept of
 * them. */
#include "run/event/watch.h"

/* Appends the record of an event with its state [n]. Returns false if out of memory, or if
 * LIMIT_EVENT_RECORDS are kept already. */
static bool event_record_add(struct run *run, const struct event_crossing *crossing,
                             const double *state)
{
    struct event_records *all = &run->private_state->event_records;
    const size_t n = (size_t)run->system.n;
    if (all->count == LIMIT_EVENT_RECORDS)
        return false;
    size_t capacity = all->capacity;
    if (!array_reserve(&all->record, sizeof *all->record, all->count, &capacity) ||
        !array_reserve(&all->state, n * sizeof *all->state, all->count, &all->capacity))
        return false;
    all->record[all->count] =
        (struct event_record){crossing->event, crossing->direction, run->steps, crossing->t};
    memcpy(all->state + all->count++ * n, state, n * sizeof *all->state);
    return true;
}

/* Returns true, with its fraction, if the condition is the first of the events that stop the
 * run. */
bool events_until(const struct run *run, double *theta)
{
    const struct event_watch *watch = run->private_state->watch;
    bool stopped = false; /* another event came earlier */
    for (size_t i = 0; i < watch->count; i++) {
        const struct event_crossing *crossing = &watch->found[i];
        if (crossing->event == watch->stop_event && (!stopped || crossing->theta == *theta)) {
            *theta = crossing->theta;
            return true;
        }
        if (watch->event[crossing->event].event->stop && !stopped) {
            stopped = true;
            *theta = crossing->theta;
        }
    }
    return false;
}

bool events_stop(const struct run *run)
{
    const struct event_watch *watch = run->private_state->watch;
    for (size_t i = 0; i < watch->count; i++)
        if (watch->event[watch->found[i].event].event->stop)
            return true;
    return false;
}

/* Moves the events at that moment to the run's time and state. */
void events_until_at(struct run *run, double theta)
{
    const struct event_watch *watch = run->private_state->watch;
    for (size_t i = 0; i < watch->count; i++) {
        struct event_crossing *crossing = &watch->found[i];
        const bool is_earlier = (run->t - crossing->t) * watch->path.inside.h > 0;
        if (crossing->theta > theta || (crossing->theta < theta && is_earlier))
            continue;
        crossing->t = run->t;
        copy_state(watch->state + i * (size_t)run->system.n, run->y, run->system.n);
    }
}

/* Records the events up to the run's time, and stops the run at the first one that stops it. */
bool events_keep(struct run *run, const struct segment *segment, double h, bool *stops)
{
    const struct event_watch *watch = run->private_state->watch;
    const int n = run->system.n;
    for (size_t i = 0; i < watch->count; i++) {
        const struct event_crossing *crossing = &watch->found[i];
        const double *state = watch->state + i * (size_t)n;
        if ((crossing->t - run->t) * h > 0)
            break;
        if (crossing->event == watch->stop_event)
            continue;
        if (!event_record_add(run, crossing, state))
            return false;
        if (!segment->target->event[crossing->event].stop || *stops)
            continue;
        copy_state(run->y, state, n);
        run->t = crossing->t;
        forget_rounding(run->private_state, n);
        run->private_state->step.warm = false;
        *stops = true;
        if (!responses_add_moment(run, crossing->event))
            return false;
    }
    return true;
}

struct event_doubt run_event_doubt(const struct run *run, int event)
{
    return run->private_state->doubt[event];
}

/* Drops records beyond the present step and time. */
void event_records_truncate(struct run *run, double ahead)
{
    struct event_records *all = &run->private_state->event_records;
    for (; all->count > 0; all->count--) {
        const struct event_record *last = &all->record[all->count - 1];
        if (last->step < run->steps ||
            (last->step == run->steps && (last->t - run->t) * ahead <= 0))
            break;
    }
}

size_t run_event_records(const struct run *run)
{
    return run->private_state->event_records.count;
}

const struct event_record *run_event_record(const struct run *run, size_t i)
{
    return &run->private_state->event_records.record[i];
}

const double *run_event_record_state(const struct run *run, size_t i)
{
    return run->private_state->event_records.state + i * (size_t)run->system.n;
}
