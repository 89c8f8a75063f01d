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

/* What the values are like before and after a step of h, by the solution: the largest, so that what
 * has just begun at 0 is not taken for 0. False: that is not known. */
static bool sizes(const struct run *run, double t, double h, const double *y, double *solution,
                  double *size)
{
    const struct system *system = &run->system;
    double next[LIMIT_VARIABLES];
    if (!run_solve(system, t, y, t + h, RUN_SOLVE_STIFF, RUN_SOLVE_TOL, solution, run->cancel))
        return false;
    for (int k = 0; k < system->n; k++)
        size[k] = fmax(fabs(y[k]), fabs(solution[k]));
    for (double ahead = 2;
         ahead <= STEPS_AHEAD &&
         run_solve(system, t, y, t + ahead * h, RUN_SOLVE_STIFF, RUN_SOLVE_TOL, next, run->cancel);
         ahead *= 4)
        for (int k = 0; k < system->n; k++)
            size[k] = fmax(size[k], fabs(next[k]));
    return true;
}

void run_check_step(struct run *run, size_t i)
{
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    const double *y = trace_state(trace, i), *end = trace_state(trace, i + 1);
    const double t = trace_time(trace, i), t_end = trace_time(trace, i + 1);
    double solution[LIMIT_VARIABLES], size[LIMIT_VARIABLES];
    p->unchecked = i + 1; /* and after many, fewer and fewer: a share of the run */
    if (++p->checks > CHECKS)
        p->unchecked += (size_t)ldexp(1, (int)fmin(40, (double)(p->checks - CHECKS) / 8));
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
