/* SPDX-License-Identifier: GPL-3.0-or-later */
/* run_diagnose(): finds out whether a run failed because its solution ends. If a run failed, an
 * accurate solution is followed from run_own_start(): an unstable method, or a loose tolerance,
 * fails where the solution itself continues. A run that reached its target is examined only if one
 * of its fixed steps looks strange (strange.c), or if the solution does not get across the shortest
 * of its adaptive steps. */
#include <hooke/base/cancel.h>

#include "run/private.h"

#include <math.h>

/* The solution is followed beyond the end of the run by this part of the time since the start,
 * because a method may fail before the solution ends. */
static const double ahead_share = 0.1;

/* Finds the row of the last change of the scene or of the state; the first row if there is none. */
size_t run_own_start(const struct run *run)
{
    const struct run_private *p = run->private_state;
    int64_t step = p->epoch[p->epochs - 1].first;
    size_t row = 0;
    if (p->kicks > 0 && p->kick[p->kicks - 1].step > step)
        step = p->kick[p->kicks - 1].step;
    if (step > 0)
        row = trace_row_from(run->trace, step);
    while (row + 1 < trace_count(run->trace) && p->kicks > 0 &&
           trace_step(run->trace, row + 1) == step)
        row++;
    return row < trace_count(run->trace) ? row : trace_count(run->trace) - 1;
}

int64_t run_follow_steps(double evals)
{
    static const double steps_min = 2000, evals_a_step = 120; /* a tenth of the run's */
    return (int64_t)fmin(FOLLOW_STEPS_MAX, steps_min + evals / evals_a_step);
}

/* Follows the exact solution from the state in `row`, to which the method may have led the run, up
 * to time `end` in at most steps_max steps, and sets *followed. An end of the solution counts only
 * if another method, from the run's start, does not get past that time either; what cannot be
 * concluded is SOLUTION_UNKNOWN. */
static void follow_row(const struct run *run, size_t row, double end, int64_t steps_max,
                       struct followed *followed)
{
    static const double tol = 1e-7, overshoot = 1.01;
    const struct trace *trace = run->trace;
    const size_t start = run_own_start(run);
    const double t_start = trace_time(trace, start);
    double ignored[LIMIT_VARIABLES];
    run_follow(&run->system, trace_time(trace, row), trace_state(trace, row), end, steps_max,
               run->cancel, followed);
    if (followed->fate == SOLUTION_GROWS ||
        (followed->fate == SOLUTION_GOES_ON && !run->plan.adaptive))
        followed->fate = SOLUTION_UNKNOWN;
    if (followed->fate == SOLUTION_ENDS &&
        run_solve_cheaply(&run->system, t_start, trace_state(trace, start),
                          t_start + overshoot * (followed->t - t_start), tol, ignored, run->cancel))
        followed->fate = SOLUTION_GOES_ON;
}

/* Follows the solution from its own start, and from the row if that is not enough. */
void run_follow_from(const struct run *run, size_t row, double end, int64_t steps_max,
                     struct followed *followed)
{
    const struct trace *trace = run->trace;
    const size_t start = run_own_start(run);
    run_follow(&run->system, trace_time(trace, start), trace_state(trace, start), end, steps_max,
               run->cancel, followed);
    if (followed->fate == SOLUTION_UNKNOWN && row > start)
        follow_row(run, row, end, steps_max, followed);
}

/* Returns the first row that is no more than a thousandth of `way`, the run's time since its start,
 * before the present time. */
static size_t row_shortly_before(const struct run *run, double way)
{
    return trace_row_at(run->trace, run->t - 1e-3 * way);
}

/* Sets run->stop and run->singular if the followed solution ends. Returns false if it does not. */
bool run_end_singular(struct run *run, const struct followed *followed)
{
    if (followed->fate != SOLUTION_ENDS)
        return false;
    run->stop = STOP_SINGULAR;
    run->singular = (struct singularity){.t = followed->t, .finite = followed->finite};
    return true;
}

/* Returns true if the steps have become short beside `way`, the time since the start, and the
 * second half of them covered next to nothing of it, or little in steps that became ever
 * shorter. */
static bool steps_shrink(const struct run *run, double way)
{
    static const double nowhere = 1e-3, little = 0.3, shorter = 4;
    const struct trace *trace = run->trace;
    const size_t half = trace_row_from(trace, run->steps / 2 + 1) - 1;
    const double h = fabs(run->controller.h), t = trace_time(trace, half),
                 covered = fabs(run->t - t);
    return h < RUN_CREEP * fabs(way) &&
           (covered < nowhere * fabs(way) || (covered < little * fabs(way) && half > 0 &&
                                              shorter * h < fabs(t - trace_time(trace, half - 1))));
}

/* Follows the solution ahead of a run whose steps shrink; stops the run if the solution ends
 * there. */
bool run_creeps(struct run *run)
{
    static const int64_t share = 8; /* a look may take one step for this many of the run */
    struct run_private *p = run->private_state;
    if (run->steps < p->look)
        return false;
    p->look = 2 * run->steps;
    if (p->original) /* a repeated run: the original has looked already */
        return false;
    trace_present(run->trace, run->steps, run->t, run->y);
    const double way = run->t - trace_time(run->trace, run_own_start(run));
    if (!steps_shrink(run, way))
        return false;
    struct followed followed;
    run_follow_from(run, row_shortly_before(run, way), run->t + ahead_share * way,
                    run->steps / share, &followed);
    if (cancelled(run->cancel)) /* no result: the look is repeated when the run continues */
        p->look = run->steps;
    return run_end_singular(run, &followed);
}

/* Follows the solution of a run that failed beyond its end: sets the fate, and run->stop if the
 * solution ends. */
static void diagnose_failure(struct run *run)
{
    const double way = run->t - trace_time(run->trace, run_own_start(run)),
                 ahead = ahead_share * fabs(way) + (run->plan.adaptive ? 0 : 16 * run->settings.dt);
    const bool back = run->plan.adaptive ? run->controller.h < 0 : trace_grid(run->trace)->h < 0;
    struct followed followed;
    run_follow_from(run, row_shortly_before(run, way), run->t + (back ? -ahead : ahead),
                    run_follow_steps((double)run->cost.evals), &followed);
    run->private_state->fate = followed.fate;
    run_end_singular(run, &followed);
}

/* Returns true if the equations end where the solution got to, at `point`: a time `ahead` of it the
 * derivative is undefined, or that of the steepest variable leads back. y' = -1/y ends at 0,
 * whereas y' = -1/sqrt(|y|) goes on. */
static bool turns_back(const struct system *system, const struct followed *point, double ahead)
{
    double y[LIMIT_VARIABLES], slope[LIMIT_VARIABLES], slope_ahead[LIMIT_VARIABLES];
    bool defined = true;
    int steepest = 0;
    system_derivative(system, point->t, point->y, slope);
    for (int i = 0; i < system->n; i++) {
        y[i] = point->y[i] + ahead * slope[i];
        if (fabs(slope[i]) > fabs(slope[steepest]))
            steepest = i;
    }
    system_derivative(system, point->t + ahead, y, slope_ahead);
    for (int i = 0; i < system->n; i++)
        defined = defined && isfinite(slope_ahead[i]);
    for (int i = 0; i < system->n; i++)
        y[i] = i == steepest ? y[i] : point->y[i];
    system_derivative(system, point->t, y, slope_ahead);
    return !defined || slope[steepest] * slope_ahead[steepest] < 0;
}

/* Returns true if the solution that ends at `point` really ends there: followed again from there,
 * with the finest possible time steps, it still ends. `way` is the time for which it was followed
 * before. A solution that is only steep, as that of y' = 1/(y^2 + 1e-8), does not end. */
static bool ends_for_sure(const struct run *run, const struct followed *point, double way)
{
    static const double span = 1e-6,
                        span_factor = 100; /* parts of the way; of the time to the end */
    const double t = run->system.autonomous ? 0 : point->t;
    struct followed again;
    run_follow(&run->system, t, point->y, t + span * way, run_follow_steps(0), run->cancel, &again);
    return again.fate == SOLUTION_ENDS &&
           (!point->finite || (run->system.autonomous &&
                               turns_back(&run->system, point, span_factor * (again.t - t))));
}

/* Returns the length of the adaptive step to a recorded row. */
static double step_before(const struct trace *trace, size_t row)
{
    const size_t time = trace->width - 1;
    return fabs(trace_row(trace, row)[time] - trace_row(trace, row - 1)[time]);
}

/* Finds adaptive steps across the end of a solution. Steps shrink on the way there, so the solution
 * is followed from where they begin to shrink before the shortest one; in short runs with a loose
 * tolerance, whose steps may not shrink, from the start. Sets run->stop if it ends. */
static void find_end_passed(struct run *run)
{
    enum { FEW = 32, SHARE = 8 }; /* rows; of all rows, new ones for a look */
    static const double shrunk = 0.01, loose = 0.01,
                        span_factor = 1.5; /* a run may end too early */
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    const size_t last = trace->count - 1, start = run_own_start(run);
    p->looked = p->looked > last ? 0 : p->looked;
    const size_t first = p->looked > start ? p->looked : start;
    if (last - first <= p->looked / SHARE)
        return;
    p->looked = last;
    double least = INFINITY, longest = 0, t_before = trace_row(trace, first)[trace->width - 1];
    size_t row_begin = last, row_end = last;
    for (size_t row = first + 1; row < last; row++) {
        const double t = trace_row(trace, row)[trace->width - 1], h = fabs(t - t_before);
        t_before = t;
        longest = h > longest ? h : longest;
        if (h < least && h < shrunk * longest) {
            least = h;
            row_begin = row;
        }
    }
    if (row_begin < last) {
        row_end = row_begin + 1;
        while (row_begin > first + 1 &&
               step_before(trace, row_begin - 1) >= step_before(trace, row_begin))
            row_begin--;
        row_begin--;
    } else if (last - first <= FEW && run->settings.tol >= loose) {
        row_begin = first;
    } else {
        return;
    }
    const double t = trace_time(trace, row_begin),
                 way = span_factor * (trace_time(trace, row_end) - t),
                 t_end = fabs(way) < fabs(run->t - t) ? t + way : run->t;
    struct followed followed;
    if (!run_seems_to_end(&run->system, t, trace_state(trace, row_begin), t_end, run->cancel))
        return;
    run_follow_from(run, row_begin, run->t, run_follow_steps((double)run->cost.evals), &followed);
    if (followed.fate == SOLUTION_ENDS &&
        ends_for_sure(run, &followed, followed.t - trace_time(trace, start)))
        run_end_singular(run, &followed);
}

/* Chooses the checks that suit the run: failure, fixed steps, or adaptive steps. */
void run_diagnose(struct run *run)
{
    const bool failed =
        run->stop == STOP_DIVERGED || run->stop == STOP_STALLED || run->stop == STOP_NO_SOLUTION;
    run->private_state->fate = SOLUTION_UNKNOWN;
    if (!failed)
        run_check_first_steps(run);
    if (run->stop == STOP_SINGULAR || run_is_never_singular(&run->system))
        return;
    if (failed)
        diagnose_failure(run);
    if (!run->plan.adaptive && run->steps > 0 && run->private_state->fate == SOLUTION_UNKNOWN)
        run_find_strange_steps(run);
    if (run->plan.adaptive && !failed && run->trace && run->trace->timed)
        find_end_passed(run);
}
