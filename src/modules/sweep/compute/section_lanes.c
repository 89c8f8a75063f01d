/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Points of a sweep at a section, in lanes. Lanes show in which step of which point an event
 * happens; the point's own run then repeats that step and finds the event, with the same bits as a
 * run alone. Where it is not certain that the run sees the same events (values near 0 at the ends
 * of a step, or that might be 0 inside it) the point runs alone. */
#include "modules/sweep/compute/section.h"
#include <hooke/base/cancel.h>

#include <stdlib.h>
#include <string.h>

/* A value that is nearer to 0, relative to its change in a step, has no reliable sign. */
#define SIGN_ROUNDING 1e-9
/* A value may graze 0 inside a step if less than this fraction of it may remain there. */
#define GRAZE_FRACTION 0.25
#define DIVERGENCE_MIN 1e100 /* Same limit as in lanes.c. */
/* The next strobe counts as inside a step if it is this fraction of it before its end. */
#define STROBE_MARGIN 1e-9

/* ---- the event as a function of the state ---- */

/* Context of state_slot(). */
struct lane_names {
    const struct run *run;
    bool other; /* the event depends on something else than the state */
};

/* Returns the index of the state variable that a slot of the run's scope denotes; other slots are
 * noted. */
static int state_slot(void *context, int slot)
{
    struct lane_names *names = context;
    const struct moving moving = run_scope_moving(names->run, slot);
    names->other |= moving.kind != MOVING_STATE;
    return moving.kind == MOVING_STATE ? moving.index : slot;
}

/* Compiles the event of a lane as a function of the state. Returns false if it is none, or if out
 * of memory. */
static bool settle_lane(struct arena *arena, struct crossings *p)
{
    const struct event *event = &p->event;
    struct lane_names names = {.run = p->run};
    p->left = expr_settle(event->left, &p->scope, state_slot, &names, arena);
    if (p->left && event->right)
        p->right = expr_settle(event->right, &p->scope, state_slot, &names, arena);
    return p->left && (p->right || !event->right) && !names.other && !event->touching;
}

/* The state of one lane, for load_state(). */
struct lane_state {
    const double *value; /* [n][LANE_COUNT] */
    int lane;
};

/* Returns a state variable. */
static double load_state(const void *context, int slot)
{
    const struct lane_state *state = context;
    return state->value[(size_t)slot * LANE_COUNT + (size_t)state->lane];
}

/* Returns the event's value, left minus right side, at the states of a row for one lane. */
static double lane_value(const struct crossings *p, const double *row, int lane)
{
    const struct lane_state state = {row, lane};
    const struct expr_scope scope = {.context = &state, .load = load_state};
    const double left = expr_value(p->left, &scope);
    return p->right ? left - expr_value(p->right, &scope) : left;
}

/* Returns true if the event's value is linear in the state for all `used` lanes of n variables, and
 * stores its offset and slopes, found at the origin and at unit states. */
static bool is_linear(struct section *s, int n, int used)
{
    double unit[LIMIT_VARIABLES * LANE_COUNT] = {0};
    int slot[LIMIT_VARIABLES];
    for (int k = 0; k < n; k++)
        slot[k] = k;
    for (int lane = 0; lane < used; lane++) {
        const struct crossings *p = &s->lane[lane];
        if (!expr_linear(p->left, slot, n) || (p->right && !expr_linear(p->right, slot, n)))
            return false;
        s->offset[lane] = lane_value(p, unit, lane);
        for (int k = 0; k < n; k++) {
            unit[k * LANE_COUNT + lane] = 1;
            s->slope[k][lane] = lane_value(p, unit, lane) - s->offset[lane];
            unit[k * LANE_COUNT + lane] = 0;
        }
    }
    return true;
}

/* Computes the event's value for each lane at the states of a row, row[variable][lane]. `linear`
 * uses the coefficients of is_linear(), which is faster. */
static void fill_values(const struct section *s, bool linear, int n, int used, const double *row,
                        double *value)
{
    if (!linear) {
        for (int lane = 0; lane < used; lane++)
            value[lane] = lane_value(&s->lane[lane], row, lane);
        return;
    }
    for (int lane = 0; lane < used; lane++)
        value[lane] = s->offset[lane];
    for (int k = 0; k < n; k++)
        for (int lane = 0; lane < used; lane++)
            value[lane] += s->slope[k][lane] * row[(size_t)k * LANE_COUNT + (size_t)lane];
}

/* ---- steps ---- */

/* Makes `count` steps and stores the states after them in rows 1 to count of section->state; row 0
 * holds the states before them. */
static void march_states(struct sweep_worker *worker, int64_t count)
{
    const int n = worker->system[0].n;
    double *row = worker->section->state, y[LIMIT_VARIABLES];
    const size_t size = (size_t)n * LANE_COUNT;
    /* lanes_march() gives position and velocity, which are the state */
    if (n == 2 && worker->system[0].order == 2) {
        lanes_march(worker->lanes, count, row + size);
        return;
    }
    for (int64_t i = 1; i <= count; i++) {
        lanes_march(worker->lanes, 1, NULL);
        for (int lane = 0; lane < worker->used; lane++) {
            lanes_state(worker->lanes, lane, y);
            for (int k = 0; k < n; k++)
                row[(size_t)i * size + (size_t)k * LANE_COUNT + (size_t)lane] = y[k];
        }
    }
}

/* Repeats step number step + 1, which begins in state y, by the point's run, which locates the
 * event within the step. Returns false if the run sees no event there. */
static bool repeat_step(const struct sweep_worker *worker, struct crossings *p, int64_t step,
                        const double *y)
{
    const struct sweep_section *section = &worker->job->request->section;
    struct run *run = p->run;
    const struct run_target target = {
        .t = section->strobe
                 ? run->system.t0 + p->period * ((double)(section->skip + section->keep) + 0.5)
                 : HUGE_VAL,
        .steps = 1,
        .event = &p->event,
        .events = !section->strobe};
    const size_t events = run_event_records(run);
    run_place(run, step, y);
    run_advance(run, &target, 0, NULL);
    return section->strobe || run_event_records(run) == events + 1;
}

/* ---- the strobe ---- */

/* Returns the number of the step in which the lane's next period ends. */
static int64_t strobe_step(const struct sweep_worker *worker, const struct crossings *p)
{
    const double due = p->period * (double)(worker->job->request->section.skip + p->seen + 1),
                 h = worker->job->request->settings.dt;
    return (int64_t)floor(due / h - STROBE_MARGIN);
}

/* Repeats the step in which the period ends by the run of the point. Returns false if the run has
 * not recorded the end. */
static bool strobe_lane(const struct sweep_worker *worker, struct crossings *p, const double *y)
{
    const int64_t period = worker->job->request->section.skip + p->seen + 1;
    const size_t row = (size_t)p->seen + 1;
    repeat_step(worker, p, p->step, y);
    if (!crossings_strobed(p, row, period)) /* it lies at the very begin of the next step */
        repeat_step(worker, p, p->step + 1, p->run->y);
    return crossings_strobed(p, row, period);
}

/* Handles the lanes whose drive period ends within the step after number `step`: stores the state
 * at the end of the period and finds the step of the next one. Marks lanes that are finished or
 * have to run alone. */
static void strobe_lanes(struct sweep_worker *worker, int64_t step)
{
    const struct sweep_section *section = &worker->job->request->section;
    double y[LIMIT_VARIABLES];
    for (int lane = 0; lane < worker->used; lane++) {
        struct crossings *p = &worker->section->lane[lane];
        if (p->done || p->step != step)
            continue;
        lanes_state(worker->lanes, lane, y);
        p->alone = lane_suspicious(y, worker->system[0].n) || !strobe_lane(worker, p, y);
        p->seen++;
        p->step = strobe_step(worker, p);
        p->done = p->alone || p->seen == section->keep;
    }
}

/* Steps all lanes to the next step in which a period of the drive ends in some lane (p->step), has
 * strobe_lanes() record the states there, and so on, until each lane is done: it has seen all its
 * events, or its point has to run alone. Returns earlier if cancelled, which is checked before each
 * 16 * SWEEP_ROWS steps, as these take far less than the 0.1 s within which Ctrl-C has to act. */
static void march_strobe(struct sweep_worker *worker)
{
    const struct sweep_job *job = worker->job;
    int64_t step = 0;
    while (!cancelled(job->request->cancel)) {
        int64_t next = INT64_MAX;
        for (int lane = 0; lane < worker->used; lane++) {
            const struct crossings *p = &worker->section->lane[lane];
            next = p->done || p->step > next ? next : p->step;
        }
        if (next == INT64_MAX)
            return;
        for (int64_t steps; (steps = next - step) > 0 && !cancelled(job->request->cancel);) {
            steps = steps < 16 * SWEEP_ROWS ? steps : 16 * SWEEP_ROWS;
            lanes_march(worker->lanes, steps, NULL);
            step += steps;
        }
        strobe_lanes(worker, next);
    }
}

/* ---- events ---- */

/* Returns true if the parabola through three successive values, whose middle one is nearest to 0,
 * may touch or cross 0 between them. */
static bool may_graze(double a, double b, double c)
{
    if (!(fabs(b) <= fabs(a) && fabs(b) <= fabs(c)) || signbit(a) != signbit(c))
        return false;
    const double slope = (c - a) / 2, bend = a - 2 * b + c;
    return !((b - slope * slope / (2 * bend)) / b > GRAZE_FRACTION);
}

/* Examines a step of a lane for an event. value[0..2] are the event's values before the previous
 * step, at the begin of this step and at its end; `row` has the states at its begin. A value that
 * is 0, not finite, too close to 0 or possibly touching 0 is uncertain, and the lane then runs
 * alone. */
static void examine_step(struct sweep_worker *worker, int lane, int64_t step, const double *row,
                         const double value[3])
{
    const struct sweep_section *section = &worker->job->request->section;
    struct crossings *p = &worker->section->lane[lane];
    const double a = value[1], b = value[2], change = fabs(b - a);
    const int direction = p->event.direction;
    double y[LIMIT_VARIABLES];
    p->done = crossings_end(worker->job->request, p->run, step + 1 - p->last, 0);
    if (p->done || (step == 0 && a == 0 && b != 0)) /* A crossing at the start does not count. */
        return;
    const bool crosses = signbit(a) != signbit(b);
    p->alone = !isfinite(b) || b == 0 || a == 0 ||
               ((crosses || step == 0) && !(fmin(fabs(a), fabs(b)) > SIGN_ROUNDING * change)) ||
               (!crosses && signbit(value[0]) == signbit(a) && may_graze(value[0], a, b));
    if (!p->alone && crosses && (direction == 0 || (b > a) == (direction > 0))) {
        for (int k = 0; k < worker->system[0].n; k++)
            y[k] = row[(size_t)k * LANE_COUNT + (size_t)lane];
        p->last = step + 1;
        p->alone = lane_suspicious(y, worker->system[0].n) ||
                   (++p->seen > section->skip && !repeat_step(worker, p, step, y));
    }
    p->done = p->alone || p->seen == section->skip + section->keep;
}

/* Examines `count` steps from number `first` on, between count + 1 rows of states; the last row
 * then becomes row 0. `linear` is the result of is_linear(). Returns true if a lane is not
 * finished. */
static bool examine_rows(struct sweep_worker *worker, bool linear, int64_t first, int64_t count)
{
    struct section *s = worker->section;
    const int n = worker->system[0].n, used = worker->used;
    const size_t size = (size_t)n * LANE_COUNT;
    bool more = false;
    for (int64_t i = 0; i < count; i++) {
        const double *row = s->state + (size_t)i * size;
        fill_values(s, linear, n, used, row + size, s->value[2]);
        for (int lane = 0; lane < used; lane++)
            if (!s->lane[lane].done)
                examine_step(worker, lane, first + i, row,
                             (double[]){s->value[0][lane], s->value[1][lane], s->value[2][lane]});
        memmove(s->value[0], s->value[1], 2 * sizeof s->value[0]);
    }
    for (int lane = 0; lane < used; lane++)
        more |= !s->lane[lane].done;
    memcpy(s->state, s->state + (size_t)count * size, size * sizeof *s->state);
    return more;
}

/* Steps all lanes and examines their states for events, until all are finished or have to run
 * alone, or until cancelled. */
static void march_events(struct sweep_worker *worker)
{
    struct section *s = worker->section;
    const int n = worker->system[0].n;
    const bool linear = is_linear(s, n, worker->used);
    for (int lane = 0; lane < LANE_COUNT; lane++)
        for (int k = 0; k < n; k++)
            s->state[(size_t)k * LANE_COUNT + (size_t)lane] =
                worker->system[lane < worker->used ? lane : 0].start[k];
    fill_values(s, linear, n, worker->used, s->state, s->value[1]);
    memcpy(s->value[0], s->value[1], sizeof s->value[0]);
    for (int64_t row = 0; !cancelled(worker->job->request->cancel); row += SWEEP_ROWS) {
        march_states(worker, SWEEP_ROWS);
        if (!examine_rows(worker, linear, row, SWEEP_ROWS))
            return;
    }
}

/* ---- all of it ---- */

/* Stores the events of a lane that has come to its end. */
static void finish_lane(struct sweep_worker *worker, int lane)
{
    struct crossings *p = &worker->section->lane[lane];
    const struct sweep_section *section = &worker->job->request->section;
    const int64_t i = worker->point[lane];
    crossings_take(worker, i, p, 0, section->strobe ? p->seen : (int64_t)run_event_records(p->run));
    worker->job->sweep->status[i] = STOP_END;
    worker->side_by_side++;
    worker->steps += (double)(section->strobe ? p->step : p->last);
}

/* Computes the points in the lanes at the section. Points with uncertain events, and all if the
 * method carries data from step to step, run alone. */
void section_march(struct sweep_worker *worker)
{
    struct section *s = worker->section;
    const struct sweep_section *section = &worker->job->request->section;
    bool lanes = !lanes_carry(worker->job->request->method, worker->drag);
    arena_reset(&s->arena);
    for (int lane = 0; lane < worker->used; lane++) {
        struct crossings *p = &s->lane[lane];
        p->done = p->alone = !lanes || !crossings_begin(worker, worker->point[lane], p);
        if (!p->alone && section->strobe)
            p->step = strobe_step(worker, p);
        else if (!p->alone)
            lanes = settle_lane(&s->arena, p);
    }
    if (lanes && section->strobe)
        march_strobe(worker);
    else if (lanes)
        march_events(worker);
    for (int lane = 0; lane < worker->used; lane++) {
        struct crossings *p = &s->lane[lane];
        if (lanes && p->done && !p->alone)
            finish_lane(worker, lane);
        if (p->run)
            run_destroy(p->run);
        p->run = NULL;
    }
    for (int lane = 0; lane < worker->used && !cancelled(worker->job->request->cancel); lane++)
        if (!lanes || s->lane[lane].alone)
            section_alone(worker, worker->point[lane]);
}
