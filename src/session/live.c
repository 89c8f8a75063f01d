/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Runs that a person watches: they advance in slices at the pace of a clock, can pause, and
 * parameters can change on the way. */
#include <hooke/run.h>
#include <hooke/result.h>
#include <hooke/base/cancel.h>
#include <hooke/session/log.h>
#include <hooke/session/subject.h>
#include <hooke/scene/typed.h>

#include <math.h>
#include <string.h>

#define SLICE_NS 5000000    /* [ns] computing between two looks at the terminal */
#define WAIT_NS 100000000   /* [ns] longest wait for the clock, about a frame */
#define WINDOW_NS 500000000 /* [ns] interval over which the achieved speed is measured */
/* Wall time [s] by which a run may trail the clock before it stops catching up. */
#define CLOCK_LAG_MAX 0.2

/* Relation of simulated time to the clock: at `clock` the run was at t, and it continues at
 * `speed`. */
struct clock_pace {
    int64_t clock;    /* [ns] */
    double t;         /* [s] */
    double speed;     /* simulated seconds per second; HUGE_VAL for as fast as possible */
    double direction; /* 1 forward, -1 backward in time */
};

/* Returns the simulated time [s] by which the clock is ahead of the run; HUGE_VAL for runs as fast
 * as possible. */
static double clock_lag(const struct clock_pace *pace, const struct run *run, int64_t now)
{
    return isinf(pace->speed) ? HUGE_VAL
                              : (double)(now - pace->clock) * 1e-9 * pace->speed -
                                    pace->direction * (run->t - pace->t);
}

/* Returns the length [s] of the next step, or 0 for an adaptive run, which knows it only
 * afterwards. */
static double next_step(const struct run *run, const struct run_target *target)
{
    return run->plan.adaptive ? 0 : fmin(run->settings.dt, fabs(target->t - run->t));
}

/* Returns the number of steps that the run has to make to catch up with the clock; INT64_MAX for
 * runs as fast as possible. */
static int64_t steps_due(const struct clock_pace *pace, const struct run *run,
                         const struct run_target *target, int64_t now)
{
    const double ahead = clock_lag(pace, run, now), h = next_step(run, target);
    if (isinf(ahead))
        return INT64_MAX;
    if (!(ahead >= h) || ahead <= 0)
        return 0;
    const double steps = h > 0 ? floor(ahead / run->settings.dt) : 1;
    if (steps < 1)
        return 1;
    return steps < 1e15 ? (int64_t)steps : INT64_MAX;
}

/* Makes the steps that are due, for at most SLICE_NS, but not beyond step `last`. Returns false if
 * the target is reached or the run has stopped. */
static bool advance_slice(const struct clock_pace *pace, struct run *run,
                          const struct run_target *target, int64_t last,
                          const struct cancel *cancel)
{
    const int64_t begin = clock_ns();
    for (int64_t now = begin; now - begin < SLICE_NS; now = clock_ns()) {
        const int64_t due = steps_due(pace, run, target, now), left = last - run->steps;
        if (due == 0)
            return true;
        struct run_target part = *target;
        if (due < left)
            part.steps = due;
        else
            part.steps = last == INT64_MAX && due == INT64_MAX ? -1 : left;
        if (run_advance(run, &part, begin + SLICE_NS - now, cancel))
            return true;
        if (run->stop != STOP_END || run->t == target->t || run->steps >= last)
            return false;
    }
    return true;
}

/* Returns the clock time [ns] at which the next step is due, at least a slice later, so that the
 * processor does more than look at the clock. */
static int64_t next_look(const struct clock_pace *pace, const struct run *run,
                         const struct run_target *target, int64_t now)
{
    const double ahead = clock_lag(pace, run, now), h = next_step(run, target);
    if (ahead > 0 && ahead >= h)
        return now;
    const double wait = (h - ahead) / pace->speed * 1e9;
    int64_t delay;
    if (wait < SLICE_NS)
        delay = SLICE_NS;
    else
        delay = wait > WAIT_NS ? WAIT_NS : (int64_t)wait;
    return now + delay;
}

/* Returns the part of the way to the target, or -1 if the target has neither a number of steps nor
 * a time. */
static double fraction_done(const struct run *run, const struct run_target *target, double t_begin,
                            int64_t first)
{
    if (target->steps > 0)
        return (double)(run->steps - first) / (double)target->steps;
    return fabs(target->t) < T_UNREACHABLE ? (run->t - t_begin) / (target->t - t_begin) : -1;
}

/* Advances the run towards the target while the screen is kept up to date: at the pace of the clock
 * times live->speed if `clocked`, else as fast as possible. The pace begins anew when the user
 * changes the speed, and when the run trails the clock by more than CLOCK_LAG_MAX. If the user
 * pauses or quits, run->stop becomes STOP_CANCELLED. */
void live_advance(struct session *session, struct run *run, const struct run_target *target,
                  bool clocked)
{
    const struct front *front = &session->front;
    struct live *live = &session->live;
    const int64_t first = run->steps,
                  last = target->steps < 0 ? INT64_MAX : run->steps + target->steps;
    const double t_begin = run->t;
    const double begin_speed = clocked ? live->speed : HUGE_VAL;
    struct clock_pace pace = {clock_ns(), run->t, begin_speed, target->t < run->t ? -1 : 1};
    struct clock_pace window = pace;
    live->state = LIVE_RUNNING;
    live->pausing = false;
    live->fraction = 0;
    live->achieved = live->speed;
    while (advance_slice(&pace, run, target, last, front->cancel)) {
        int64_t now = clock_ns();
        live->fraction = fraction_done(run, target, t_begin, first);
        if (now - window.clock >= WINDOW_NS) {
            live->achieved =
                window.direction * (run->t - window.t) / ((double)(now - window.clock) * 1e-9);
            window = (struct clock_pace){now, run->t, 0, window.direction};
        }
        if (!front->slice(front->context, session, next_look(&pace, run, target, now)) ||
            live->pausing || session->execution.quit) {
            run->stop = STOP_CANCELLED;
            break;
        }
        now = clock_ns();
        const double speed = clocked ? live->speed : HUGE_VAL;
        if (speed != pace.speed ||
            (isfinite(speed) &&
             clock_lag(&pace, run, now) > next_step(run, target) + CLOCK_LAG_MAX * speed))
            pace = (struct clock_pace){now, run->t, speed, pace.direction};
    }
    live->pausing = false;
    live_refresh(session);
}

/* Sets the state and the marks of changes by the current run. */
void live_refresh(struct session *session)
{
    struct live *live = &session->live;
    const struct run *run = session_run(session);
    const struct run_slot *slot = run ? session->runs.slot[session->runs.current] : NULL;
    if (!run)
        live->state = LIVE_IDLE;
    else if (stop_is_pause(run->stop))
        live->state = LIVE_PAUSED;
    else
        live->state =
            run->stop == STOP_DIVERGED || run->stop == STOP_SINGULAR ? LIVE_DIVERGED : LIVE_IDLE;
    live->mark_count =
        slot ? journal_changes(slot->last, live->marks, (int)COUNT_OF(live->marks)) : 0;
}

/* ---- changes during a run ---- */

/* Returns true if both models are the same scene, perhaps with other typed lines. */
static bool same_scene(const struct model *a, const struct model *b)
{
    const struct model *base = typed_base(a);
    return a == b ||
           (base ? base == typed_base(b) : !typed_base(b) && strcmp(a->row.name, b->row.name) == 0);
}

/* Takes the changed parameter over into the run, with a request in its journal. Returns false with
 * the error set. */
bool live_bind(struct session *session, int param, double *t_start, struct error *error)
{
    struct run *run = session_run(session);
    const struct live *live = &session->live;
    const struct scene *now = &session->setup.scene;
    const char *name = param_at(now, param)->row.name;
    const bool is_start = param_is_start(now, param),
               is_other = run && !same_scene(run->system.model, now->model);
    /* lines typed since may have moved it */
    const int index = run ? scene_param(&run->scene, name) : -1;
    *t_start = NAN;
    if (live->changing && !run)
        return error_set(error, ERROR_COMMAND, "there is no run to change");
    if (live->changing && is_other) {
        error_set(error, ERROR_COMMAND, "run %d belongs to %s, but the scene is now %s",
                  run->number, run->scene.preset->row.name, now->preset->row.name);
        return error_hint(error, "type: scene %s", run->scene.preset->row.name);
    }
    if (live->changing && is_start)
        return error_set(error, ERROR_COMMAND,
                         "%s is an initial value and cannot be changed during a run", name);
    if (live->changing && index < 0)
        return error_set(error, ERROR_COMMAND, "run %d has no %s, which was defined later",
                         run->number, name);
    /* the run takes the change over if it advances, is paused at a prompt, or is to be changed */
    const bool going = run && (live->state == LIVE_RUNNING ||
                               (session->execution.typed && stop_is_pause(run->stop)) ||
                               live->changing || session->execution.reacting);
    if (!going || is_start || is_other || index < 0)
        return true;
    struct run_slot *slot = session->runs.slot[session->runs.current];
    const struct measured value = {now->value[param], now->uncertainty[param]};
    struct scene scene;
    const struct request request = {.kind = REQUEST_SET,
                                    .start_step = run->steps,
                                    .from_t = run->t,
                                    .param = index,
                                    .value = value,
                                    .by_event = session->execution.reacting};
    journal_scene(slot, true, &scene);
    if (!scene_set(&scene, index, value, error) || !journal_add(slot, request, TEXT(""), error))
        return false;
    if (!run_rebind(run, &scene, error)) {
        journal_drop(slot);
        return false;
    }
    const enum live_state state = live->state;
    if (state != LIVE_RUNNING && !live->changing && !session->execution.reacting) {
        /* a file needs the change as commands, since `set` alone changes no paused run in it */
        journal_write(session, slot, journal_count(slot->last) - 1, run->steps, 0, false,
                      &session->history.happened);
        if (!now->chosen[param])
            buffer_format(&session->history.happened, "unset %s\n", name);
    }
    live_refresh(session);
    session->live.state = state;
    *t_start = run->t;
    return true;
}

/* Changes a variable of the run's state, with a request in its journal. Returns false with the
 * error set. */
bool live_kick(struct session *session, int variable, double value, struct error *error)
{
    struct run *run = session_run(session);
    struct run_slot *slot = session->runs.slot[session->runs.current];
    const struct request request = {.kind = REQUEST_KICK,
                                    .start_step = run->steps,
                                    .from_t = run->t,
                                    .param = variable,
                                    .value = {value, 0},
                                    .by_event = session->execution.reacting};
    if (!journal_add(slot, request, TEXT(""), error))
        return false;
    if (run_kick(run, variable, value, error))
        return true;
    journal_drop(slot);
    return false;
}

/* Appends " from t = 3.2 s on", or nothing if t_start is NAN. */
void buffer_since(struct buffer *text, double t_start)
{
    if (isnan(t_start))
        return;
    buffer_put(text, TEXT(" from t = "));
    buffer_measured(text, (struct measured){t_start, 0}, QUANTITY_TIME, 6);
    buffer_put(text, TEXT(" on"));
}
