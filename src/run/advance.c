/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The loop of run_advance(): it makes steps until the target, a condition or event, a failure,
 * cancellation or the end of a time slice. advance_step() makes one step with everything that
 * belongs to it; advance_many() in many.c makes batches where nothing has to be looked at in
 * between. */
#include <hooke/base/cancel.h>
#include <hooke/scene/formula.h>
#include "run/event/watch.h"

#include <float.h>
#include <math.h>

/* Number of steps, and time [ns], between two looks at the clock and at cancellation. */
#define BATCH_MAX 4096
#define BATCH_NS_MIN 200000
#define BATCH_NS_MAX 800000

/* Returns true if the condition of the target is true at the present state of the run. */
static bool is_condition_true(const struct segment *segment)
{
    const struct condition *condition = segment->target->condition;
    return condition_holds(condition, condition_value(condition, segment->target->scope));
}

/* Returns true if two times differ by rounding only. An infinite b, which stands for a run without
 * an end, equals no time. */
static bool same_time(double a, double b)
{
    /* HUGE_VAL is no time */
    return isfinite(b) && fabs(a - b) <= 4 * DBL_EPSILON * fmax(fabs(a), fabs(b));
}

double run_arrival(double t, double end)
{
    return same_time(t, end) ? end : t;
}

/* Sets up *segment for one call of run_advance(): the grid of fixed steps (a new one if the
 * direction or the step has changed), the last step, the time of the next row, and the events.
 * Returns STOP_NONE if there are steps to make, STOP_END if the run is at the target already, or
 * STOP_FULL if out of memory. */
static enum stop segment_begin(struct run *run, const struct run_target *target,
                               struct segment *segment)
{
    struct run_private *p = run->private_state;
    *segment = (struct segment){
        .target = target, .limit = target->steps < 0 ? INT64_MAX : run->steps + target->steps};
    if (target->t == run->t || same_time(run->t, target->t)) {
        run->t = target->t;
        return STOP_END;
    }
    if (!trace_reserve_grids(run->trace,
                             3)) /* a turn now, a partial step at the end, going back into a step */
        return STOP_FULL;
    method_choose_kernels(run->method, &p->step, run->settings.kernel != KERNEL_GENERAL);
    double h = copysign(run->settings.dt, target->t - run->t);
    if (run->plan.adaptive) {
        run->controller.h = copysign(run->controller.h, h);
        if (trace_grid(run->trace)->origin != target->t)
            trace_regrid(run->trace, (struct time_grid){run->steps, target->t, h});
    } else {
        if (trace_grid(run->trace)->h != h) {
            trace_regrid(run->trace,
                         (struct time_grid){.first = run->steps, .origin = run->t, .h = h});
            p->step.warm = false;
        }
        segment->grid = *trace_grid(run->trace);
        struct stretch stretch = stretch_measure(segment->grid.origin, target->t, run->settings.dt);
        segment->last = segment->grid.first + stretch.whole;
        segment->rest = stretch.partial;
        segment->exact = stretch.exact;
        int64_t end = segment->last + (stretch.partial != 0);
        segment->limit = end < segment->limit ? end : segment->limit;
    }
    if (run->trace->interval > 0) {
        trace_aim(run->trace, run->t, h);
        segment->rows_between_steps = run->plan.adaptive || !trace_in_step(run->trace);
    }
    if (target->condition || target->events > 0)
        ledger_will_not_repeat(run);
    segment->armed = target->condition && !is_condition_true(segment);
    return events_begin(run, segment) ? STOP_NONE : STOP_FULL;
}

/* A comparison with NaN is false, so that states which are not finite are out of bounds. */
bool run_in_bounds(const struct run *run, const double *y)
{
    const double *bound = run->private_state->bound;
    for (int i = 0; i < run->system.n; i++)
        if (!(fabs(y[i]) <= bound[i]))
            return false;
    return true;
}

/* Puts the state before the last step back, with its compensated rounding. The method's memory of
 * earlier steps is given up. */
static void step_take_back(struct run *run)
{
    struct run_private *p = run->private_state;
    copy_state(run->y, p->previous_state, run->system.n);
    if (p->step.low)
        copy_state(p->step.low, p->low_before, run->system.n);
    p->step.warm = false;
}

/* Makes a step of h [s] from t, for which the method uses nothing that it remembers of earlier
 * steps. The step ends at turning points and switches on the way if the method does that. */
static enum step_status step_cold(struct run *run, double t, double h)
{
    struct step *step = &run->private_state->step;
    step->t = t;
    step->h = h;
    step->warm = false;
    return method_turning_step(run->method, step);
}

/* Context of condition_after(): the step that is repeated over a shorter length. */
struct partial_step {
    struct run *run;
    const struct segment *segment;
    double t;    /* [s] at which the step begins */
    bool failed; /* one of the shorter steps failed */
};

/* Repeats the step from its beginning over h [s] only, leaves the run there, and returns the value
 * of the condition; its sign tells whether the condition is true. Sets `failed` if a step fails. */
static double condition_after(void *context, double h)
{
    struct partial_step *part = context;
    struct run *run = part->run;
    step_take_back(run);
    part->failed = part->failed || (h != 0 && step_cold(run, part->t, h) != STEP_OK);
    run->t = part->t + h;
    return condition_value(part->segment->target->condition, part->segment->target->scope);
}

/* First half width of the interval around the interpolated time of the condition, as a fraction of
 * the step: interpolants are nearly always better than that. */
#define CONDITION_DISTANCE 1e-9

/* Finds an interval [*low, *high] of the step of length h, as times [s] since its beginning, at
 * whose ends the condition is first false and then true, and sets *f_low and *f_high to its values
 * there. The interval is widened around crossing_time, a time since the beginning of the step,
 * until it is found. Sets *low = *high if there is none; part->failed tells that a partial step
 * failed. */
static void condition_bracket(struct partial_step *part, double crossing_time, double h,
                              double *low, double *f_low, double *high, double *f_high)
{
    const struct condition *condition = part->segment->target->condition;
    for (double apart = CONDITION_DISTANCE;; apart *= 32) {
        const double a = crossing_time / h - apart, b = crossing_time / h + apart;
        *low = a > 0 ? a * h : 0;
        *high = b < 1 ? b * h : h;
        *f_low = condition_after(part, *low);
        *f_high = condition_after(part, *high);
        if (part->failed ||
            (!condition_holds(condition, *f_low) && condition_holds(condition, *f_high)))
            return;
        if (apart > 1)
            break;
    }
    *low = *high = crossing_time;
}

/* Puts the run where the condition becomes true in the step from t over h. An interpolant gave the
 * fraction theta of the step; the time is found to rounding with steps of the method itself.
 * Returns true if that is inside the step, false if it is the end of the step, which then stays. */
static bool condition_locate(struct run *run, const struct segment *segment, double t, double h,
                             double theta)
{
    const size_t size = (size_t)run->system.n * sizeof *run->y;
    const double end = run->t, ulp = DBL_EPSILON * fmax(fabs(t), fabs(end));
    struct partial_step part = {run, segment, t, false};
    double found[LIMIT_VARIABLES], low, high, f_low, f_high, crossing_time = theta * h;
    memcpy(found, run->y, size);
    condition_bracket(&part, crossing_time, h, &low, &f_low, &high, &f_high);
    if (low != high && !part.failed) {
        if (f_low != 0)
            crossing_time = root_between(condition_after, &part, low, f_low, high, f_high, ulp);
        else
            crossing_time = low;
        for (double more = ulp;
             !condition_holds(segment->target->condition, condition_after(&part, crossing_time)) &&
             crossing_time != high;
             more *= 2)
            crossing_time = fabs(crossing_time + copysign(more, h)) < fabs(high)
                                ? crossing_time + copysign(more, h)
                                : high;
    }
    const bool whole = crossing_time == h || part.failed;
    /* rows inside are of this step */
    if (!whole)
        condition_after(&part, crossing_time);
    else
        memcpy(run->y, found, size);
    run->t = whole ? end : t + crossing_time;
    forget_rounding(run->private_state, run->system.n);
    run->private_state->step.warm = false;
    return !whole;
}

/* Returns true, and puts the run there, if the condition became true in the step from t over h, so
 * that the run stops. Sets *inside if that is before the end of the step. */
static bool condition_meet(struct run *run, struct segment *segment, double t, double h,
                           bool *inside)
{
    const bool now = is_condition_true(segment);
    double theta = 1;
    /* A condition that no bounds can follow may be true all the same. */
    const bool met = events_until(run, &theta) || (now && segment->armed && !events_stop(run));
    if (met) {
        *inside |= condition_locate(run, segment, t, h, theta);
        run->private_state->gap_known = false; /* it may end elsewhere */
        events_until_at(run, theta);
    }
    segment->armed |= !now;
    return met;
}

/* Makes one step of the method. Sets *t and *h to the beginning and length of the step, and *end to
 * the time that its end gets: exactly the target's time at the last step. */
static enum step_status step_once(struct run *run, const struct segment *segment, double *t,
                                  double *h, double *end)
{
    struct step *step = &run->private_state->step;
    enum step_status status;
    if (run->plan.adaptive) {
        *t = step->t = run->t;
        status = method_adapt(run->method, step, &run->controller, segment->target->t);
        *h = step->h;
        *end = run_arrival(step->t, segment->target->t);
        return status;
    }
    *t = grid_time(&segment->grid, run->steps);
    if (run->steps == segment->last) {
        *h = segment->rest;
        *end = segment->target->t;
        return step_cold(run, *t, *h);
    }
    *h = segment->grid.h;
    *end = segment->exact && run->steps + 1 == segment->last
               ? segment->target->t
               : grid_time(&segment->grid, run->steps + 1);
    step->t = *t;
    step->h = *h;
    return method_turning_step(run->method, step);
}

/* Returns the reason for which a run stops after a step of that status; STOP_NONE for STEP_OK. */
enum stop stop_of_step(enum step_status status)
{
    static const enum stop stop[] = {[STEP_OK] = STOP_NONE,
                                     [STEP_NONFINITE] = STOP_DIVERGED,
                                     [STEP_NO_SOLUTION] = STOP_NO_SOLUTION,
                                     [STEP_STALLED] = STOP_STALLED};
    return stop[status];
}

/* Copies only as many members as the number of variables needs, because each step does it. */
void controller_copy(struct controller *target, const struct controller *source,
                     const struct system *system)
{
    const size_t tail_offset = offsetof(struct controller, elapsed),
                 switches = offsetof(struct controller, switches);
    target->tol = source->tol;
    copy_state(target->scale, source->scale, system->n);
    copy_state(target->excess, source->excess, system->n);
    memcpy((char *)target + tail_offset, (const char *)source + tail_offset,
           switches - tail_offset);
    if (system->switches > 0)
        target->switches = source->switches;
}

/* Returns true if the trace is full and a part of the thinning of the energy balance has to be done
 * before it can record another step. */
static inline bool must_thin(const struct run *run)
{
    return run->trace->count >= run->trace->cap && ledger_is_due(run);
}

/* Makes one step, or a part of the thinning of the trace if that is due: steps by the method, finds
 * events and the condition in the step, records the state, and keeps the energy balance. Returns
 * STOP_NONE if the run can continue. A step that fails, diverges or cannot be recorded is taken
 * back completely. */
static enum stop advance_step(struct run *run, struct segment *segment)
{
    struct run_private *p = run->private_state;
    if (run->steps >= segment->limit || run->t == segment->target->t)
        return STOP_END;
    if (must_thin(run)) /* instead of a step */
        return ledger_thin(run) ? STOP_NONE : STOP_FULL;
    double t, h, end, previous_t = run->t;
    struct controller controller;
    controller_copy(&controller, &run->controller, &run->system);
    p->gap_known = false;
    copy_state(p->previous_state, run->y, run->system.n);
    if (p->step.low)
        copy_state(p->low_before, p->step.low, run->system.n);
    enum step_status status = step_once(run, segment, &t, &h, &end);
    if (status != STEP_OK) {
        p->step.warm = false;
        return stop_of_step(status);
    }
    if (!run_in_bounds(run, run->y)) {
        step_take_back(run);
        controller_copy(&run->controller, &controller, &run->system);
        return STOP_DIVERGED;
    }
    bool off_grid = run->steps == segment->last, cold = !run->plan.adaptive, events_recorded = true;
    enum stop row_stop = STOP_NONE;
    run->steps++;
    run->t = end;
    enum stop stop = STOP_NONE;
    if (segment->target->events > 0 || segment->target->condition)
        events_recorded = events_find(run, segment, t, h);
    if (segment->target->condition && events_recorded &&
        condition_meet(run, segment, t, h, &off_grid)) {
        cold = true;
        stop = STOP_CONDITION;
        events_recorded = responses_add_moment(run, p->watch->stop_event);
    }
    if (run->trace->interval > 0)
        row_stop = even_record(run, cold, t, stop == STOP_CONDITION ? run->t - t : h);
    if (segment->target->events > 0) {
        bool stops = false;
        events_recorded = events_recorded && events_keep(run, segment, h, &stops);
        off_grid |= stops;
        if (stops && run->trace->interval > 0)
            even_drop(run->trace, run->t);
        stop = stops ? STOP_CONDITION : stop;
    }
    if (row_stop || !events_recorded || !trace_record(run->trace, run->steps, run->t, run->y)) {
        step_take_back(run);
        controller_copy(&run->controller, &controller, &run->system);
        run->steps--;
        run->t = previous_t;
        event_records_truncate(run, 0);
        responses_truncate(run);
        if (run->trace->interval > 0)
            even_drop(run->trace, previous_t);
        return row_stop ? row_stop : STOP_FULL;
    }
    if (off_grid && !run->plan.adaptive) {
        trace_regrid(run->trace, (struct time_grid){
                                     .first = run->steps, .origin = run->t, .h = segment->grid.h});
        p->step.warm = false;
    }
    ledger_take(run, run->y, run->plan.adaptive ? &run->t : NULL, (size_t)run->system.n, 1);
    return stop == STOP_NONE && run->plan.adaptive && run_creeps(run) ? STOP_SINGULAR : stop;
}

/* Alternates batches of steps with looks at the clock and at Ctrl-C; the batch size adapts to the
 * time that steps take. */
bool run_advance(struct run *run, const struct run_target *target, int64_t budget_ns,
                 const struct cancel *cancel)
{
    struct run_private *p = run->private_state;
    struct segment segment;
    int64_t begin = clock_ns(), now = begin;
    /* A caller that draws the energy between slices asks again: its part of a slice may be the
     * larger one. */
    const bool follows = budget_ns > 0 && ledger_is_asked(run);
    run->cancel = cancel ? cancel : run->cancel;
    enum stop stop = segment_begin(run, target, &segment);
    bool more = false;
    while (stop == STOP_NONE && !more) {
        if (cancelled(cancel)) {
            stop = STOP_CANCELLED;
            break;
        }
        if (!advance_many(run, &segment, &stop))
            for (int64_t i = 0; i < p->batch && stop == STOP_NONE; i++) {
                stop = advance_step(run, &segment);
                if (must_thin(run))
                    break;
            }
        if (follows && run->trace->bucket == 1)
            ledger_follow(run);
        int64_t then = now;
        now = clock_ns();
        if (now - then < BATCH_NS_MIN && p->batch < BATCH_MAX)
            p->batch *= 2;
        else if (now - then > BATCH_NS_MAX && p->batch > 1)
            p->batch /= 2;
        more = stop == STOP_NONE && budget_ns > 0 && now - begin >= budget_ns;
    }
    run->cost = p->step.cost;
    run->seconds += clock_seconds(begin);
    run->stop = stop;
    trace_present(run->trace, run->steps, run->t, run->y);
    return more;
}

/* Puts the run at a state after `steps` fixed steps, as if it had made them. */
void run_place(struct run *run, int64_t steps, const double *y)
{
    if (y != run->y)
        copy_state(run->y, y, run->system.n);
    run->steps = steps;
    run->t = grid_time(trace_grid(run->trace), steps);
    run->private_state->step.warm = false;
    forget_rounding(run->private_state, run->system.n);
}
