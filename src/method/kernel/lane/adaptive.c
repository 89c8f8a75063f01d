/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Steps in lanes whose size follows the error: how they begin, and those that a lane takes alone,
 * by method_adapt() from where it is. */
#define UNROLL
#include "method/kernel/lane/state.h"
#include "method/kernel/lanes.h"
#include "method/control/adapt_body.h"

bool lanes_adapt_fit(const struct method *method, const struct system *system, enum drag drag,
                     double h)
{
    (void)drag; /* there is but one of these methods */
    const bool explicit_one = method->tableau && method->tableau->fsal,
               rosenbrock = method->rosenbrock && system->autonomous && !method->adapt &&
                            method->rosenbrock->stages <= ROSENBROCK_STAGES;
    return method->flags & METHOD_ADAPTIVE && (explicit_one || rosenbrock) && h > 0 &&
           !system->model->typed && system->switches == 0 && lane_shape_of(system) >= 0 &&
           system->oscillator.quadratic >= 0 && method_work_size(method, N) <= WORK_MOST;
}

/* As a run takes it. */
static double end_of_step(double t, double t_end)
{
    const double larger = fabs(t) > fabs(t_end) ? fabs(t) : fabs(t_end);
    return fabs(t - t_end) <= 4 * DBL_EPSILON * larger ? t_end : t;
}

static void step_alone(struct lanes *lanes, int lane, bool first)
{
    struct lane_control *const own = &lanes->control;
    const struct method *method = lanes->method;
    const int last = method->tableau ? (method->tableau->stages - 1) * N : 0;
    /* what a Rosenbrock method knows at a second attempt is not there */
    const bool twice = method->rosenbrock && own->rejected[lane];
    double y[N], work[WORK_MOST];
    struct step step = {
        .system = lanes->system[lane], .t = own->t[lane], .y = y, .work = work, .warm = !first};
    struct controller control = {.tol = own->tol[lane],
                                 .elapsed = own->elapsed[lane],
                                 .sampled = own->sampled[lane],
                                 .sampling = !first,
                                 .h = own->h[lane],
                                 .t_low = own->t_low[lane],
                                 .last = own->last[lane],
                                 .previous = own->previous[lane],
                                 .rejected = own->rejected[lane] != 0};
    for (int i = 0; i < N; i++) {
        y[i] = lanes->y[i][lane];
        work[last + i] = lanes->carried[i][lane];
        control.excess[i] = own->excess[i][lane];
    }
    method_choose_kernels(method, &step, true);
    const bool good = method_adapt(method, &step, &control, own->t_end) == STEP_OK && step.warm &&
                      fabs(y[0]) <= LANE_FAR && fabs(y[1]) <= LANE_FAR &&
                      !(fabs(control.h) < own->creep * fabs(step.t - own->t0));
    own->t[lane] = end_of_step(step.t, own->t_end);
    own->steps[lane]++;
    own->evals[lane] += step.cost.evals - twice;
    own->failed[lane] = -!good;
    own->running[lane] = -(good && own->t[lane] != own->t_end);
    own->elapsed[lane] = control.elapsed;
    own->sampled[lane] = control.sampled;
    own->h[lane] = control.h;
    own->t_low[lane] = control.t_low;
    own->last[lane] = control.last;
    own->previous[lane] = control.previous;
    own->rejected[lane] = 0;
    for (int i = 0; i < N; i++) {
        lanes->y[i][lane] = y[i];
        lanes->carried[i][lane] = work[last + i];
        own->excess[i][lane] = control.excess[i];
    }
}

void lanes_attempt_alone(struct lanes *lanes, int first, int count)
{
    for (int lane = first; lane < first + count; lane++)
        if (lanes->control.alone[lane])
            step_alone(lanes, lane, false);
}

void lanes_control(struct lanes *lanes, int used, const double *tol, double t_end, double creep)
{
    struct lane_control *const own = &lanes->control;
    const struct method *method = lanes->method;
    const int k = method->embedded + 1;
    const struct filter *filter = method->flags & METHOD_IMPLICIT ? &implicit : &explicit;
    *own = (struct lane_control){.t0 = lanes->t0,
                                 .t_end = t_end,
                                 .creep = lanes->system[0]->linear ? 0 : creep,
                                 .aims = by_aim(method),
                                 .by_error = -0.5 / k * filter->b1,
                                 .by_previous = -0.5 / k * filter->b2,
                                 .by_ratio = filter->a,
                                 .elementary = -0.5 / k};
    for (int lane = 0; lane < used; lane++) {
        const struct system *system = lanes->system[lane];
        const struct controller wanted = {.tol = tol[lane]};
        const double max = largest_estimate(method, tolerance(&wanted));
        own->tol[lane] = tol[lane];
        own->accepted[lane] = 1 / (N * max * max);
        own->t[lane] = lanes->t0;
        own->h[lane] = lanes->own_h[lane];
        for (int i = 0; i < N; i++) {
            const double given = system->atol[i] / tolerance(&wanted);
            own->min[i][lane] = system->scale[i];
            own->given[i][lane] = given < DBL_MAX ? given : DBL_MAX;
        }
        step_alone(lanes, lane, true);
    }
}

bool lanes_adapt(struct lanes *lanes, int64_t attempts, double *row)
{
    const struct lane_march march = {.count = attempts, .row = row};
    const struct lane_width width = lanes_width(lanes->most);
    int64_t any = 0;
    lane_kernel *const kernel = lanes->method->rosenbrock
                                    ? width.rosenbrocks[lanes->shape]
                                    : width.kernels[lanes->shape][LANE_ADAPTIVE];
    kernel(lanes, &march);
    for (int lane = 0; lane < LANES; lane++)
        any |= lanes->control.running[lane];
    return any != 0;
}

void lanes_adapted_row(const struct lanes *lanes, double *row)
{
    memcpy(row, lanes->control.t, sizeof lanes->control.t);
    memcpy(row + LANES, lanes->y, sizeof lanes->y);
}

bool lanes_adapted(const struct lanes *lanes, int lane, int64_t *steps, int64_t *evals)
{
    *steps = lanes->control.steps[lane];
    *evals = lanes->control.evals[lane];
    return !lanes->control.failed[lane] && !lanes->control.running[lane];
}
