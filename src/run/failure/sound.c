/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Steps that are far too long. A method with fixed steps goes on even where a step is nonsense: one
 * of a Rosenbrock method next to a stiff transient, one that rings between both sides of 0. So a
 * step that looks strange is compared with the solution from where it began.
 */
#include "run/private.h"

#include <math.h>
#include <stdlib.h>

#define STEPS_MOST 2000
#define STEPS_SMOOTH 32 /* by a method that is not for stiff equations */
/* times the values before and after it: such an error leaves nothing of them */
#define UNSOUND 1.2
#define STEPS_AHEAD 32 /* what is still small grows within so many */
#define CHECKS 64      /* of steps one by one */

bool run_solve(const struct system *system, double t, const double *y, double end, const char *by,
               double tol, double *to, const struct cancel *cancel)
{
    const struct method *method = method_find(by);
    double state[LIMIT_VARIABLES],
        *work = method ? malloc((method_work_size(method, system->n) + 1) * sizeof *work) : NULL;
    struct step step = {.system = system, .y = state, .work = work, .t = t};
    struct controller controller = {.tol = tol};
    if (!work)
        return false;
    copy_state(state, y, system->n);
    int64_t steps = 0;
    const int64_t max = method->flags & METHOD_IMPLICIT ? STEPS_MOST : STEPS_SMOOTH;
    while (step.t != end && steps++ < max && !cancelled(cancel) &&
           method_adapt(method, &step, &controller, end) == STEP_OK) {
    }
    free(work);
    if (to && step.t == end)
        copy_state(to, state, system->n);
    return step.t == end;
}

bool run_solve_cheaply(const struct system *system, double t, const double *y, double end,
                       double tol, double *to, const struct cancel *cancel)
{
    return run_solve(system, t, y, end, RUN_SOLVE_SMOOTH, tol, to, cancel) ||
           run_solve(system, t, y, end, RUN_SOLVE_STIFF, tol, to, cancel);
}

/* What the values are like before and after a step of h, by the solution: the largest, so that what
 * has just begun at 0 is not taken for 0. False: that is not known. */
static bool sizes(const struct run *run, double t, double h, const double *y, double *solution,
                  double *size)
{
    const struct system *system = &run->system;
    double next[LIMIT_VARIABLES] = {0};
    if (!run_solve_cheaply(system, t, y, t + h, RUN_SOLVE_TOL, solution, run->cancel))
        return false;
    for (int k = 0; k < system->n; k++)
        size[k] = fmax(fabs(y[k]), fabs(solution[k]));
    double ahead = 2;
    while (ahead <= STEPS_AHEAD &&
           run_solve_cheaply(system, t, y, t + ahead * h, RUN_SOLVE_TOL, next, run->cancel)) {
        for (int k = 0; k < system->n; k++)
            size[k] = fmax(size[k], fabs(next[k]));
        ahead *= 4;
    }
    return true;
}

/* Returns the largest value of a state in natural sizes; *variable is its index. */
static double scaled_size(const struct system *system, const double *y, int *variable)
{
    double max = 0;
    *variable = 0;
    for (int k = 0; k < system->n; k++)
        if (fabs(y[k]) / system->scale[k] > max) {
            max = fabs(y[k]) / system->scale[k];
            *variable = k;
        }
    return max;
}

/*
 * Compares a step of h that does not grow with a solution that does: what is stable at any step
 * damps that, too. Where the solution leaves the range of numbers in the step, a part of the step
 * shows it. Returns false if the step follows the solution, or if that is not known.
 */
static bool skips_growth(const struct run *run, double t, double h, const double *y,
                         const double *end, struct unsound_step *unsound)
{
    /* in natural sizes: what begins at 0 grows by any factor */
    static const double grown = 8, missed = 0.25, start_min = 1e-3;
    enum { SHORTER_MAX = 96 };
    const struct system *system = &run->system;
    const bool is_first = t == system->t0;
    double solution[LIMIT_VARIABLES] = {0}, part = 1;
    int variable, ignored;
    if (!system->autonomous || !(scaled_size(system, y, &ignored) > start_min))
        return false; /* a drive, which makes anything out of nothing */
    for (int i = 0; i < (is_first ? SHORTER_MAX : 1) && !cancelled(run->cancel); i++, part /= 16) {
        if (!run_solve_cheaply(system, t, y, t + part * h, RUN_SOLVE_TOL, solution, run->cancel))
            continue;
        const double size = scaled_size(system, solution, &variable);
        if (!(size > grown * scaled_size(system, y, &ignored)) ||
            !(scaled_size(system, end, &ignored) < missed * size))
            return false;
        *unsound =
            (struct unsound_step){.times = size / scaled_size(system, y, &ignored),
                                  .t = t + part * h,
                                  .value = y[variable] + part * (end[variable] - y[variable]),
                                  .solution = solution[variable],
                                  .variable = variable};
        return true;
    }
    return false;
}

void run_check_step(struct run *run, size_t i)
{
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    const double *y = trace_state(trace, i), *end = trace_state(trace, i + 1);
    const double t = trace_time(trace, i), t_end = trace_time(trace, i + 1);
    double solution[LIMIT_VARIABLES] = {0}, size[LIMIT_VARIABLES] = {0};
    p->unchecked = i + 1; /* and after many, fewer and fewer: a share of the run */
    if (++p->checks > CHECKS)
        p->unchecked += (size_t)ldexp(1, (int)fmin(40, (double)(p->checks - CHECKS) / 8));
    struct unsound_step missed;
    if (run->unsound.times == 0 && skips_growth(run, t, t_end - t, y, end, &missed)) {
        run->unsound = missed;
        return;
    }
    if (run->plan.adaptive || !sizes(run, t, t_end - t, y, solution, size))
        return;
    for (int k = 0; k < run->system.n; k++) {
        const double times = fabs(end[k] - solution[k]) / size[k];
        if (times > UNSOUND && times > run->unsound.times)
            run->unsound = (struct unsound_step){.times = times,
                                                 .t = t_end,
                                                 .value = end[k],
                                                 .solution = solution[k],
                                                 .variable = k};
    }
}

void run_check_first_steps(struct run *run)
{
    enum { FIRST_STEPS = 2 }; /* the first one of a multistep method is another method's */
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    const struct system *system = &run->system;
    double slope[LIMIT_VARIABLES];
    int ignored;
    if (!trace || p->checks > 0 ||
        !(run->method->flags & METHOD_IMPLICIT || run->method->rosenbrock))
        return;
    const size_t first = run_own_start(run);
    for (size_t i = first; i < first + FIRST_STEPS && i + 1 < trace_count(trace); i++) {
        const double *y = trace_state(trace, i), t = trace_time(trace, i),
                     h = trace_time(trace, i + 1) - t;
        if (trace_step(trace, i + 1) != trace_step(trace, i) + 1 || run->unsound.times > 0)
            return;
        p->checks++;
        system_derivative(system, t, y, slope);
        for (int k = 0; k < system->n; k++)
            slope[k] *= h;
        struct unsound_step missed;
        if (!(scaled_size(system, slope, &ignored) < scaled_size(system, y, &ignored)) &&
            skips_growth(run, t, h, y, trace_state(trace, i + 1), &missed))
            run->unsound = missed;
    }
}
