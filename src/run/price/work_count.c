/* SPDX-License-Identifier: GPL-3.0-or-later */
/* run_work_count(): counts the steps and evaluations of a run for `plan`, and tries its first steps
 * where they cannot be known beforehand. */
#include <hooke/run/price.h>

#include "run/private.h"

#include <math.h>

enum { TRIAL_STEPS = 2000 }; /* Steps tried, over the number of variables: some milliseconds. */

/* Returns evaluations and Jacobians together. */
static double evaluations(const struct cost *cost)
{
    return (double)(cost->evals + cost->jacobians);
}

/* Returns true if the work is not known beforehand: evaluations of iterations, of starting steps of
 * multistep methods, and of steps that end at turning points, and the number of adaptive steps. */
static bool has_unknown_work(const struct run_scenario *s)
{
    return s->plan->adaptive || method_turns(s->method, s->system) ||
           s->method->flags & (METHOD_IMPLICIT | METHOD_MULTISTEP);
}

/* Counts the work of the second opinion by having one of the trial run; `scale` is the ratio of the
 * whole run to the trial. Does nothing if none is wanted. */
static void count_second(const struct run_scenario *s, struct run *trial, double scale,
                         struct run_work *work)
{
    if (!s->plan->adaptive || s->opinion == 0)
        return;
    if (s->plan->exact_known) {
        work->second_rows =
            fmin((double)opinion_brief_rows(s->system, s->method, work->evals), work->steps);
        return;
    }
    run_second_opinion(trial, s->opinion == 2 ? OPINION_WHOLE : OPINION_BRIEF, s->cancel);
    work->second_evals = scale * trial->opinion.work;
    work->rest_evals = trial->private_state->regrowth_work;
    work->second = trial->opinion.method;
}

/* Runs up to TRIAL_STEPS first steps, and extrapolates steps and evaluations to the whole span.
 * Leaves *work as it is if no run can be created. */
static void try_steps(const struct run_scenario *s, struct run_work *work)
{
    const int64_t max = TRIAL_STEPS / s->system->n;
    const double t_end = s->system->t0 + (isfinite(s->span) ? s->span : HUGE_VAL);
    struct run_target target = {.t = t_end, .steps = max};
    struct run_settings settings = *s->settings;
    struct error ignored;
    if (!s->plan->adaptive) {
        settings.record = (struct recording_rule){RECORD_EVERY, INT64_MAX, 0};
        settings.unbalanced = true;
        if (s->plan->steps < (double)max)
            target.steps = (int64_t)s->plan->steps;
        target.t = copysign(HUGE_VAL, s->span);
    }
    struct run *trial =
        run_create(s->scene, s->method, &settings, (double)max * s->settings->dt, &ignored);
    if (!trial)
        return;
    run_advance(trial, &target, 0, s->cancel);
    work->tried = trial->steps;
    work->failed = trial->steps == 0;
    double scale = 1;
    if (trial->steps > 0) {
        /* The trial was the whole run if it stopped by itself or reached the end. */
        work->whole =
            trial->stop != STOP_END || trial->t == t_end || (double)trial->steps >= s->plan->steps;
        if (!work->whole)
            scale = s->plan->adaptive ? (t_end - s->system->t0) / (trial->t - s->system->t0)
                                      : s->plan->steps / (double)trial->steps;
        work->steps = scale * (double)trial->steps;
        work->evals = scale * evaluations(&trial->cost);
        work->force_evals = scale * (double)trial->cost.evals;
        count_second(s, trial, scale, work);
    }
    run_destroy(trial);
}

/* Counts evaluations by the method's number, or tries the first steps. */
void run_work_count(const struct run_scenario *s, struct run_work *work)
{
    const double evals = s->plan->propagates ? 0 : s->plan->steps * s->method->evals;
    *work = (struct run_work){.steps = s->plan->steps, .evals = evals, .force_evals = evals};
    if (!s->plan->propagates && (s->plan->adaptive || s->plan->steps >= 1) && has_unknown_work(s))
        try_steps(s, work);
}
