/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Values that fall below their tolerance and what becomes of them. Step control does not see such
 * values, so that a method may lose them, and so does the second solution: both agree on next to
 * nothing. Where the equations amplify small values later (a slow passage through a bifurcation)
 * the agreement means nothing.
 *
 * A displaced solution follows the run from where variables first stay below their tolerance. Its
 * distance is large enough for step control to see it, and is scaled back where it has grown or
 * shrunk (Benettin et al. 1980, Meccanica 15:9), so that its growth is that of small errors.
 */
#include <hooke/base/elementary.h>

#include "run/private.h"

#include <math.h>
#include <stdlib.h>

/* Rows of the run that are looked at for values below the tolerance. */
#define ROWS_LOOKED 4096
/* Number of those, one after the other, in which a value has to be that small. */
#define ROWS_BELOW 8
/* Fewer do where they are that share of the run. */
#define ROWS_BELOW_MIN 3
#define LASTING 0.01
/* Tolerances above which a value must have been before. */
#define ABOVE 10
/* Rows at which the displaced solution is compared with the run. */
#define ROWS_COMPARED 256
/* Factor by which the distance may change between two of them before it is scaled back. */
#define SPREAD 10
/* Logarithm of a growth that makes what comes later doubtful. */
#define DOUBTFUL 1

struct regrowth {
    struct run *run;
    size_t row;                 /* the first one where variables stay below their tolerance */
    bool sunk[LIMIT_VARIABLES]; /* those that do so anywhere */
    bool any;
    const struct method *method;
    struct system system;
    struct step step;
    struct controller controller;
    double y[LIMIT_VARIABLES]; /* the displaced state */
    /* its distance from the run, of the sizes of the variables, and the last one that was seen */
    double displacement, before;
};

static double tolerance_of(const struct run *run, int i)
{
    return run->controller.tol * run->controller.scale[i];
}

/* Finds where variable i fell below its tolerance and stayed there for some rows. */
static void find_sunk(struct regrowth *r, int i)
{
    const struct trace *trace = r->run->trace;
    const size_t rows = trace_count(trace), first = run_own_start(r->run),
                 by = 1 + (rows - first) / ROWS_LOOKED;
    const double tolerance = tolerance_of(r->run, i);
    const double way = fabs(r->run->t - trace_time(trace, first));
    bool was_above = false;
    size_t count = 0, began = 0;
    for (size_t row = first; row < rows; row += by) {
        const double size = fabs(trace_state(trace, row)[i]);
        was_above = was_above || size > ABOVE * tolerance;
        if (!was_above || !(size < tolerance) || size == 0) {
            count = 0;
            continue;
        }
        if (count++ == 0)
            began = row;
        const double time = fabs(trace_time(trace, row) - trace_time(trace, began));
        if (count < ROWS_BELOW && !(count >= ROWS_BELOW_MIN && time > LASTING * way))
            continue;
        r->sunk[i] = true;
        r->row = r->any && r->row < began ? r->row : began;
        r->any = true;
        return;
    }
}

/* Returns the largest distance of the variables that fell below their tolerance, in their sizes. */
static double distance(const struct regrowth *r, const double *own)
{
    double max = 0;
    for (int i = 0; i < r->run->system.n; i++)
        if (r->sunk[i])
            max = fmax(max, fabs(r->y[i] - own[i]) / r->run->controller.scale[i]);
    return max;
}

static void displace(struct regrowth *r, const double *own)
{
    copy_state(r->y, own, r->run->system.n);
    for (int i = 0; i < r->run->system.n; i++)
        if (r->sunk[i])
            r->y[i] += copysign(r->displacement * r->run->controller.scale[i], own[i]);
}

/* Scales the distance back to the displacement, along its direction. */
static void scale_back(struct regrowth *r, const double *own, double by)
{
    for (int i = 0; i < r->run->system.n; i++)
        r->y[i] = own[i] + by * (r->y[i] - own[i]);
}

static bool is_below(const struct regrowth *r, const double *own)
{
    for (int i = 0; i < r->run->system.n; i++)
        if (r->sunk[i] && !(fabs(own[i]) < tolerance_of(r->run, i)))
            return false;
    return true;
}

/* True also where a step fails, short of t: the displaced state is one that has no solution. */
static bool go_to(struct regrowth *r, double t, double max, const struct cancel *cancel)
{
    const struct cost *cost = &r->step.cost;
    while (r->step.t != t) {
        if (cancelled(cancel) || (double)(cost->evals + cost->jacobians) > max)
            return false;
        if (method_adapt(r->method, &r->step, &r->controller, t) != STEP_OK)
            break;
    }
    return true;
}

/* What has become of errors of the tolerance. */
struct growth {
    double log;   /* of the error over the tolerance */
    double began; /* [s] where errors were last no larger than it */
    double lost;  /* [s] where they are no longer small and the values still are; NAN: nowhere */
};

/* Values that have grown again are compared with those of the second solution. */
static void growth_add(struct growth *growth, double t, double change, bool is_below)
{
    growth->log += change;
    if (growth->log <= 0 || !is_below) { /* steps leave new errors of that size */
        growth->log = 0;
        growth->began = t;
    }
    if (growth->log < fixed_log(OPINION_WRONG))
        growth->lost = NAN;
    else if (isnan(growth->lost))
        growth->lost = t;
}

/* Compares at a row, from which the displaced solution goes on. */
static void compare(struct regrowth *r, struct growth *growth, const double *own, double t)
{
    const bool failed = r->step.t != t;
    const double now = failed ? 0 : distance(r, own);
    if (!failed)
        growth_add(growth, t, now > 0 ? fixed_log(now / r->before) : -HUGE_VAL, is_below(r, own));
    r->before = now;
    if (!(now > 0))
        displace(r, own);
    else if (now > SPREAD * r->displacement || now < r->displacement / SPREAD)
        scale_back(r, own, r->displacement / now);
    else
        return;
    r->before = r->displacement;
    r->step.t = t;
    r->step.warm = r->step.again = false;
}

/* Follows the displaced solution to the end of the run. Returns false if that takes too long. */
static bool follow(struct regrowth *r, struct growth *growth, double max,
                   const struct cancel *cancel)
{
    const struct trace *trace = r->run->trace;
    const size_t rows = trace_count(trace) - 1 - r->row,
                 count = rows < ROWS_COMPARED ? rows : ROWS_COMPARED;
    *growth = (struct growth){.began = trace_time(trace, r->row), .lost = NAN};
    for (size_t k = 1; k <= count; k++) {
        const size_t row = r->row + (size_t)((double)k * (double)rows / (double)count);
        if (!go_to(r, trace_time(trace, row), max, cancel))
            return false;
        compare(r, growth, trace_state(trace, row), trace_time(trace, row));
    }
    return true;
}

static bool begin(struct regrowth *r, double *work)
{
    const struct run *run = r->run;
    r->system = run->system;
    system_turn_at_kinks(&r->system);
    r->step = (struct step){
        .system = &r->system, .y = r->y, .work = work, .t = trace_time(run->trace, r->row)};
    method_choose_kernels(r->method, &r->step, true);
    r->controller.tol = run->opinion.tol;
    r->before = r->displacement = sqrt(run->controller.tol);
    displace(r, trace_state(run->trace, r->row));
    return method_begin(r->method, &r->step);
}

static bool look_by(struct regrowth *r, const struct method *method, struct growth *growth,
                    double max, const struct cancel *cancel)
{
    double *work =
        method ? calloc(method_work_size(method, r->run->system.n) + 1, sizeof *work) : NULL;
    bool done = false;
    r->method = method;
    if (!work)
        return false;
    if (begin(r, work)) {
        done = follow(r, growth, max, cancel);
        method_end(method, &r->step);
    }
    free(work);
    return done;
}

void regrowth_look(struct run *run, const struct cancel *cancel)
{
    struct regrowth r = {.run = run};
    struct growth growth = {.lost = NAN};
    const int n = run->system.n;
    struct opinion *opinion = &run->opinion;
    if (!opinion->by || isnan(opinion->t) || !isnan(opinion->lost))
        return;
    for (int i = 0; i < n; i++)
        find_sunk(&r, i);
    if (!r.any)
        return;
    const double max = fmax(OPINION_BUDGET_DOUBT / n,
                            OPINION_DOUBT * (double)(run->cost.evals + run->cost.jacobians)),
                 sunk = trace_time(run->trace, r.row), way = fabs(sunk - run->system.t0);
    /* The other one where dop853 has to take short steps for its stability. */
    if (look_by(&r, method_find("dop853"), &growth, max / 2, cancel) ||
        look_by(&r, method_find("rodas5p"), &growth, max / 2, cancel)) {
        if (isnan(growth.lost))
            return;
        run->private_state->sunk = growth.began;
        opinion->lost = growth.lost;
    } else if (growth.log > DOUBTFUL && way < fabs(opinion->t - run->system.t0)) {
        opinion->t = sunk; /* what comes later is not known */
    }
}
