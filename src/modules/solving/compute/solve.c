/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Solves of a scene without recording, with states sampled on the common grid. */
#include <hooke/base/cancel.h>
#include "modules/solving/compute/solve.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

/* Returns true if the solve chooses its steps by their errors. */
static bool is_adaptive(const struct method *method, const struct run_settings *settings)
{
    return settings->tol > 0 && method->flags & METHOD_ADAPTIVE;
}

/* Returns the kernel for plain fixed steps, or NULL if there is none. */
static march_function *march_of(const struct system *system, const struct method *method,
                                const struct run_settings *settings)
{
    const bool plain = settings->kernel != KERNEL_GENERAL && !is_adaptive(method, settings) &&
                       !settings->compensated;
    return plain ? method_kernel(method, system, settings->drag) : NULL;
}

/* Returns the code that a solve runs: specialised or general, never the propagator. */
enum kernel study_path(const struct system *system, const struct method *method,
                       const struct run_settings *settings)
{
    const bool special = is_adaptive(method, settings) ? settings->kernel != KERNEL_GENERAL &&
                                                             method_step_kernel(method, system)
                                                       : march_of(system, method, settings) != NULL;
    return special ? KERNEL_SPECIALISED : KERNEL_GENERAL;
}

/* Prepares solves of `system` over span [s], negative for backwards, from its t0. Returns false if
 * out of memory; nothing is to be freed then. */
bool solver_init(struct solver *solver, const struct system *system, const struct method *method,
                 const struct run_settings *settings, double span)
{
    const size_t size = method_work_size(method, system->n) + 1;
    *solver = (struct solver){.system = system,
                              .method = method,
                              .dt = settings->dt,
                              .tol = is_adaptive(method, settings) ? settings->tol : 0,
                              .span = span,
                              .compensated = settings->compensated};
    double *work = malloc(2 * size * sizeof *work);
    if (!work)
        return false;
    solver->turns =
        solver->tol == 0 && (method_turns(method, system) || method_meets_switches(method, system));
    solver->kernel = march_of(system, method, settings);
    solver->side = work + size;
    solver->step = (struct step){.system = system, .drag = settings->drag, .work = work};
    method_choose_kernels(method, &solver->step, settings->kernel != KERNEL_GENERAL);
    solver_start(solver);
    if (method_begin(method, &solver->step))
        return true;
    solver_free(solver);
    return false;
}

void solver_free(struct solver *solver)
{
    method_end(solver->method, &solver->step);
    free(solver->step.work);
    solver->step.work = solver->side = NULL;
}

/* Resets state and counts to those at t0. */
void solver_start(struct solver *solver)
{
    const size_t size = (size_t)solver->system->n * sizeof(double);
    memcpy(solver->y, solver->system->start, size);
    memset(solver->low, 0, size);
    solver->steps = 0;
    solver->step.cost = (struct cost){0};
}

int64_t solver_cost(const struct solver *solver)
{
    const struct cost *cost = &solver->step.cost;
    return cost->evals + cost->jacobians + cost->solves;
}

/* Returns the reason for stopping that belongs to the status of a step. */
enum stop solver_stop(enum step_status status)
{
    if (status == STEP_OK)
        return STOP_END;
    if (status == STEP_NONFINITE)
        return STOP_DIVERGED;
    return status == STEP_NO_SOLUTION ? STOP_NO_SOLUTION : STOP_STALLED;
}

/* ---- the common grid ---- */

/* Samples states at the grid times that a solve passes. */
struct sampler {
    struct solver *solver;
    double *grid; /* [STUDY_TIMES][n], or NULL if no states are wanted */
    int next;     /* index of the next grid time */
};

/* Returns grid time k [s]. */
static double grid_time(const struct solver *solver, int k)
{
    return solver->system->t0 + solver->span * k / (STUDY_TIMES - 1);
}

/* Computes the state y [n] at time t inside of a step of length h from y_begin at t_begin: by the
 * method's dense output, or by a shorter step from the beginning. A multistep method without dense
 * output leaves y unchanged, as the error of an interpolation would dominate. Sets y to NAN if the
 * step fails. */
static void sample_inside(const struct solver *s, const double *y_begin, double t_begin, double h,
                          double t, double *y)
{
    const int n = s->system->n;
    if (s->method->dense && !s->turns) {
        method_dense(s->method, &s->step, y_begin, (t - t_begin) / h, y);
        return;
    }
    if (s->method->flags & METHOD_MULTISTEP)
        return;
    struct step step = s->step;
    step.t = t_begin;
    step.h = t - t_begin;
    step.y = y;
    step.work = s->side;
    step.error = step.low = NULL;
    step.warm = step.again = false;
    memcpy(y, y_begin, (size_t)n * sizeof *y);
    if (method_turning_step(s->method, &step) != STEP_OK)
        for (int i = 0; i < n; i++)
            y[i] = NAN;
}

/* Stores in sampler->grid the states at the grid times, from number sampler->next on, that lie more
 * than `tolerance` [s] before the end of a step of h [s] from t_begin [s], and advances `next`.
 * Takes one variable after the other, because its dense polynomial then is prepared once. Values
 * have the same bits as those of method_dense(). */
static void sample_whole(struct sampler *sampler, double t_begin, double h, double tolerance)
{
    const struct solver *s = sampler->solver;
    const int n = s->system->n;
    struct dense_polynomial polynomial;
    int end = sampler->next;
    while (end < STUDY_TIMES && (grid_time(s, end) - s->step.t) * copysign(1, h) < -tolerance)
        end++;
    for (int i = 0; i < n && end > sampler->next; i++) {
        method_polynomial(s->method, &s->step, i, &polynomial);
        for (int k = sampler->next; k < end; k++)
            sampler->grid[k * n + i] =
                dense_polynomial_at(&polynomial, (grid_time(s, k) - t_begin) / h);
    }
    sampler->next = end;
}

/* Samples all grid times up to the end of a step of h [s], which began at `t_begin` in the state
 * `y_begin`. A time within rounding of the step's end gets the state there. */
static void sample(struct sampler *sampler, const double *y_begin, double t_begin, double h)
{
    struct solver *s = sampler->solver;
    const int n = s->system->n;
    const double t_end = s->step.t, tolerance = 1e-9 * fabs(h);
    if (s->method->dense && s->method->tableau && !s->turns)
        sample_whole(sampler, t_begin, h, tolerance);
    for (; sampler->next < STUDY_TIMES; sampler->next++) {
        const double t = grid_time(s, sampler->next);
        double *y = sampler->grid + sampler->next * n;
        if ((t - t_end) * copysign(1, h) > tolerance)
            return;
        if (fabs(t - t_end) <= tolerance)
            memcpy(y, s->y, (size_t)n * sizeof *y);
        else
            sample_inside(s, y_begin, t_begin, h, t, y);
    }
}

/* Returns true if the limit of the cost is exceeded. */
static bool spent(const struct solver *s)
{
    return s->max > 0 && (solver_cost(s) > s->max || s->steps > s->max);
}

/* Makes one step: with a controller an adaptive one, which ends at time `end` [s] at the latest,
 * without (NULL) one of fixed length. Counts it and, if sampler->grid is set, stores the states at
 * the grid times within it. Returns the status of the step. */
static enum step_status solver_step(struct solver *s, struct controller *controller, double end,
                                    struct sampler *sampler)
{
    double y_begin[LIMIT_VARIABLES];
    const double t_begin = s->step.t;
    if (sampler->grid)
        memcpy(y_begin, s->y, (size_t)s->system->n * sizeof *y_begin);
    const enum step_status status = controller ? method_adapt(s->method, &s->step, controller, end)
                                               : method_turning_step(s->method, &s->step);
    s->steps += status == STEP_OK;
    if (status == STEP_OK && sampler->grid)
        sample(sampler, y_begin, t_begin, s->step.h);
    return status;
}

/* Solves with adaptive steps to the end of the span. Returns the reason of the stop. Ctrl-C and the
 * limit of work are checked every 64 steps. */
static enum stop run_adaptive(struct solver *s, struct sampler *sampler,
                              const struct cancel *cancel)
{
    struct controller controller = {.tol = s->tol, .h = copysign(s->dt, s->span)};
    const double end = s->system->t0 + s->span;
    while (s->step.t != end) {
        enum step_status status = STEP_OK;
        if (!sampler->grid && method_adapts_many(&s->step, &controller))
            s->steps +=
                method_adapt_many(&s->step, &controller, end, 64 - (s->steps & 63), NULL, &status);
        else
            status = solver_step(s, &controller, end, sampler);
        if (status != STEP_OK)
            return solver_stop(status);
        if ((s->steps & 63) == 0 && (spent(s) || cancelled(cancel)))
            return cancelled(cancel) ? STOP_CANCELLED : STOP_FULL;
    }
    return STOP_END;
}

#define ROW_DOUBLES 1024 /* size of the states that a kernel stores in one call [double] */

/* Makes `steps` fixed steps by a kernel, which makes many per call. `each` is the number of steps
 * between two grid times, all of which are ends of steps, or 0 without a grid. Returns the reason
 * of the stop. */
static enum stop run_kernel(struct solver *s, int64_t steps, int64_t each, struct sampler *sampler,
                            const struct cancel *cancel)
{
    const int n = s->system->n;
    const int64_t max = ROW_DOUBLES / n;
    double row[ROW_DOUBLES];
    for (int64_t i = 0; i < steps;) {
        const int64_t end = each > 0 ? each * sampler->next : steps;
        const struct march march = {&s->step, s->system->t0, i, end - i < max ? end - i : max, row};
        enum step_status status;
        if (method_turning_march(s->method, s->kernel, &march, &status) < march.count)
            return solver_stop(status);
        for (int k = 0; k < n; k++)
            if (!isfinite(s->y[k]))
                return STOP_DIVERGED;
        i += march.count;
        s->steps += march.count;
        if (each > 0 && i == end)
            memcpy(sampler->grid + sampler->next++ * n, s->y, (size_t)n * sizeof *s->y);
        if (spent(s) || cancelled(cancel))
            return cancelled(cancel) ? STOP_CANCELLED : STOP_FULL;
    }
    return STOP_END;
}

/* Solves with fixed steps and, unless the span is a multiple of dt, a last shorter one. Returns the
 * reason of the stop. */
static enum stop run_fixed(struct solver *s, struct sampler *sampler, const struct cancel *cancel)
{
    const double ratio = fabs(s->span) / s->dt, t0 = s->system->t0, h = copysign(s->dt, s->span);
    const bool whole = fabs(ratio - nearbyint(ratio)) <= 4 * DBL_EPSILON * ratio;
    const int64_t all = (int64_t)(whole ? nearbyint(ratio) : floor(ratio));
    const int64_t steps = s->part > 0 && s->part < all ? s->part : all;
    /* every grid time is the end of a step */
    const bool met = whole && steps == all && all % (STUDY_TIMES - 1) == 0;
    const bool bulk = s->kernel && (!sampler->grid || met);
    s->step.h = h;
    const int64_t each = sampler->grid ? all / (STUDY_TIMES - 1) : 0;
    const enum stop stop = bulk ? run_kernel(s, steps, each, sampler, cancel) : STOP_END;
    for (int64_t i = 0; i < steps && !bulk; i++) {
        s->step.t = t0 + (double)i * h;
        const enum step_status status = solver_step(s, NULL, 0, sampler);
        if (status != STEP_OK)
            return solver_stop(status);
        if ((i & 255) == 255 && (spent(s) || cancelled(cancel)))
            return cancelled(cancel) ? STOP_CANCELLED : STOP_FULL;
    }
    if (whole || steps < all || stop != STOP_END)
        return stop;
    s->step.t = t0 + (double)steps * h;
    s->step.h = t0 + s->span - s->step.t;
    s->step.warm = false;
    return solver_stop(solver_step(s, NULL, 0, sampler));
}

/* Solves from the state solver->y at t0 to the end of the span; grid [STUDY_TIMES][n], unless NULL,
 * receives states at equally spaced times, NAN where not reached. Returns the reason of the
 * stop. */
enum stop solver_run(struct solver *solver, double *grid, const struct cancel *cancel)
{
    const int n = solver->system->n;
    struct sampler sampler = {solver, grid, 1};
    for (int i = 0; grid && i < STUDY_TIMES * n; i++)
        grid[i] = i < n ? solver->y[i] : NAN;
    solver->step.t = solver->system->t0;
    solver->step.warm = solver->step.again = false;
    solver->step.tol = 0;
    solver->step.y = solver->y; /* set here: the solver may have moved since */
    solver->step.low = solver->compensated && solver->tol == 0 ? solver->low : NULL;
    return (solver->tol > 0 ? run_adaptive : run_fixed)(solver, &sampler, cancel);
}
