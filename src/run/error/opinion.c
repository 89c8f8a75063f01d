/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * A second opinion on an adaptive run: its distance from the closed form, or from a second solution
 * of another kind at a hundredth of the tolerance (Skeel 1986, Math. Comput. Modelling; Shampine
 * 2005, J. Sci. Comput. 25:3). The step control bounds errors of steps only; what becomes of them
 * on the way is the equations' affair.
 *
 * The second solution is by dop853 where stability lets its steps be long, else by a Rosenbrock
 * method, or by radau5 where the run itself is by one. It ends steps at the recorded states that it
 * is compared with, so that nothing is interpolated, and follows changes of the scene and of the
 * state on the way; at events it has moments of its own (saltation.c). Its work is limited by
 * counts, not by the clock: the same run always gets the same opinion.
 */
#include <hooke/base/cancel.h>
#include <hooke/base/elementary.h>
#include <hooke/run/opinion.h>

#include "run/error/follower.h"
#include "run/price/evaluation.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

/* Factors of the run's tolerance for the second solution. Another method may err ten times as much
 * at the same one; a stiff one, of fifth order, takes 1.6 times as many steps for a tenth. */
#define OPINION_TOLERANCE_FACTOR 0.01
#define TIGHTER_STIFF 0.1
#define TOL_EXPLICIT 2e-14 /* smallest tolerance, because of rounding */
#define TOL_IMPLICIT 1e-13
#define OPINION_ROWS_MAX 256 /* Largest number of rows compared in one call. */
/* dop853 is not used if stability alone costs it more than this part of the run's evaluations. */
#define STIFF_EVALS_FRACTION 0.5
/* Evaluations of dop853 per unit of |J| dt where stability limits its steps: 12 in a step of 6. */
#define EVALS_A_UNIT 2.
#define EVALS_FREE 1000 /* evaluations of dop853 that are allowed in any case */
/* Steps of the second solution are at most this part of the run if forces depend on time, because
 * of pulses; those of a brief opinion may be as long as the run's own in the mean. */
#define RUN_PARTS 512
/* A lost run is followed no more after this part of the time until it was lost. */
#define LOST_CONFIRMATION 0.2
/* The part of the run's work that rows of the closed form may take. */
#define CLOSED_FORM_SHARE 0.2
/* Least ratio of two step numbers at which errors are kept: the earlier one is about halfway. */
#define OPINION_STEP_RATIO 1.4
/* Errors that grow faster than this power of time are taken to grow exponentially. */
#define POWER_MAX 3
/* The growth of an error is trusted if it was seen over at least 1/BRIEF_TELLS of the run. */
#define BRIEF_TELLS 10
/* Smallest mean error of a lost run since then; an error that is large only in jumps is no loss. */
#define LOST_MEAN_MIN 0.1

/* Distances of the run from the other solution so far. */
struct distances {
    double size[LIMIT_VARIABLES]; /* largest magnitudes of the run, the units of errors */
    size_t sized;                 /* number of rows that were searched for them */
    double t;                     /* [s] time of the last comparison */
    /* [s] integrals of the distance over time, since the start and since `lost` */
    double sum, lost_sum;
    double lost; /* [s] time at which it first was OPINION_LOST; NAN if it was not */
};

/* The second solution, or the closed form if follower.method is NULL; of the members below
 * `compared_step` the closed form uses `saltation` only. */
struct second {
    struct follower follower;
    struct distances distances;
    int64_t compared_step; /* step of the run that it was last compared with */
    size_t epoch, kick;    /* indices of the run's next changes of scene and state */
    struct saltation saltation;
    /* opinion.error at the last two steps of the run whose ratio is OPINION_STEP_RATIO or more. */
    struct {
        int64_t step;
        double error;
    } past[2];
    int parts;            /* its steps are no longer than 1/parts of the run, see RUN_PARTS */
    struct system system; /* last, because it is large and second_create() does not clear it */
};

/* Allocates a second solution, all members 0 but for the system; returns NULL if out of memory. */
static struct second *second_create(void)
{
    struct second *second = malloc(sizeof *second);
    if (second)
        memset(second, 0, offsetof(struct second, system));
    return second;
}

void opinion_forget(struct run *run)
{
    struct second *second = run->private_state->second;
    run->private_state->sunk = NAN;
    run->opinion = (struct opinion){.error = NAN, .max = NAN, .t = NAN, .lost = NAN};
    if (!second)
        return;
    follower_end(&second->follower);
    free(second);
    run->private_state->second = NULL;
}

/* ---- distances ---- */

/* Takes the rows that are new into the sizes of the run. */
static void add_new_rows(const struct run *run, struct distances *d)
{
    const size_t rows = trace_count(run->trace);
    run_sizes_add(run, d->sized, rows, d->size);
    d->sized = rows;
}

/* Returns the unit of a distance of variable i: its largest value, or its natural size if it has
 * hardly moved and the distance is comparable to what it moved, which may be errors alone. */
static double error_unit(const struct run *run, const struct distances *d, int i, double distance)
{
    static const double at_rest = 0.01, unknown = 0.1;
    const double natural = run->controller.scale[i];
    return d->size[i] >= at_rest * natural || distance < unknown * d->size[i] ? d->size[i]
                                                                              : natural;
}

/* Compares state y with the run's `own` state at t, and updates the opinion. */
static void opinion_compare(struct run *run, struct distances *d, double t, const double *own,
                            const double *y)
{
    struct opinion *opinion = &run->opinion;
    const double elapsed = fabs(t - d->t), way = fabs(t - run->system.t0);
    double here = 0;
    for (int i = 0; i < run->system.n; i++) {
        const double distance = fabs(own[i] - y[i]);
        opinion->end[i] = distance;
        if (distance > 0)
            here = fmax(here, distance / error_unit(run, d, i, distance));
    }
    d->t = t;
    d->sum += elapsed * here;
    if (!isnan(d->lost)) {
        d->lost_sum += elapsed * here;
    } else if (here >= OPINION_LOST) {
        d->lost = t;
        d->lost_sum = 0;
    }
    const double lost_duration = fabs(t - d->lost);
    const bool lost =
        lost_duration > 0 ? d->lost_sum >= LOST_MEAN_MIN * lost_duration : here >= OPINION_LOST;
    opinion->lost = lost ? d->lost : NAN;
    opinion->error = fmax(here, way > 0 ? d->sum / way : 0);
    opinion->max = fmax(opinion->max, here);
    opinion->t = t;
}

/* Returns the first row that was not yet compared; the last one if all were. */
static size_t next_row(const struct run *run, const struct second *second)
{
    const size_t found =
        second->compared_step > 0 ? trace_row_from(run->trace, second->compared_step + 1) : 1;
    const size_t rows = trace_count(run->trace);
    return found < rows ? found : rows - 1;
}

/* Returns false if the closed form may have met an event before `step` that the run only came
 * near. */
static bool closed_form_misses(const struct run *run, struct saltation *saltation, int64_t step)
{
    double exact[LIMIT_VARIABLES], floor[LIMIT_VARIABLES];
    for (const struct response *miss;
         (miss = saltation_next_miss(run, saltation, step)) && isnan(saltation->lost);) {
        const struct epoch *epoch = run_epoch(run, step);
        system_exact(&epoch->system, epoch->t, epoch->start, miss->t, exact, floor);
        saltation_pass_miss(run, saltation, exact);
    }
    return isnan(saltation->lost);
}

size_t opinion_brief_rows(const struct system *system, const struct method *method, double evals)
{
    const double own = evals * solver_evaluation_price(system, method, true);
    return (size_t)fmin(OPINION_ROWS_MAX, 1 + CLOSED_FORM_SHARE * own / exact_state_price(system));
}

/* Returns how many rows are compared with the closed form: the last one at least. */
static size_t closed_form_rows(const struct run *run, enum opinion_effort effort)
{
    return effort == OPINION_BRIEF
               ? opinion_brief_rows(&run->system, run->method, run_evaluations(run))
               : OPINION_ROWS_MAX;
}

/* Compares the rows since the last call with the closed form. */
static void against_closed_form(struct run *run, enum opinion_effort effort)
{
    struct run_private *p = run->private_state;
    const struct trace *trace = run->trace;
    if (!p->second && !(p->second = second_create()))
        return;
    struct second *second = p->second;
    double exact[LIMIT_VARIABLES], floor[LIMIT_VARIABLES];
    if (second->compared_step == 0) {
        second->distances = (struct distances){.t = run->system.t0, .lost = NAN};
        second->saltation.lost = NAN;
    }
    add_new_rows(run, &second->distances);
    const size_t first = next_row(run, second), rows = trace_count(trace) - first,
                 max = closed_form_rows(run, effort), count = rows < max ? rows : max;
    for (size_t k = 0; k < count; k++) {
        const size_t row = run_spread_row(run, first, k, count);
        const struct epoch *epoch = run_epoch(run, trace_step(trace, row));
        if (!closed_form_misses(run, &second->saltation, trace_step(trace, row)))
            return;
        system_exact(&epoch->system, epoch->t, epoch->start, trace_time(trace, row), exact, floor);
        saltation_note(&second->saltation, run->system.n, trace_state(trace, row), exact);
        opinion_compare(run, &second->distances, trace_time(trace, row), trace_state(trace, row),
                        exact);
    }
    second->compared_step = trace_step(trace, trace_count(trace) - 1);
}

/* ---- the second solution ---- */

/* Returns a method for stiff or for smooth equations, by the run's Jacobian, or the `other` one. */
static const struct method *choose_method(const struct run *run, bool other)
{
    const double evals = (double)run->cost.evals;
    const bool stiff =
        !(EVALS_A_UNIT * run_stiffness(run) <= fmax(STIFF_EVALS_FRACTION * evals, EVALS_FREE));
    if (stiff == other)
        return method_find("dop853");
    return method_find(run->method->rosenbrock ? "radau5" : "rodas5p");
}

/* Starts the second solution at the run's first row. Returns false if that fails. */
static bool second_begin(struct run *run, bool other, enum opinion_effort effort)
{
    const struct epoch *epoch = run->private_state->epoch;
    struct second *second = second_create();
    const struct method *method = second ? choose_method(run, other) : NULL;
    if (!method) {
        free(second);
        return false;
    }
    system_copy(&second->system, &epoch->system);
    system_turn_at_kinks(&second->system);
    const bool stiff = method->flags & METHOD_IMPLICIT || method->rosenbrock;
    /* a run of a higher order may be far better than its tolerance */
    const double tighter =
        run->method->order > method->order
            ? OPINION_TOLERANCE_FACTOR * OPINION_TOLERANCE_FACTOR * OPINION_TOLERANCE_FACTOR
            : OPINION_TOLERANCE_FACTOR;
    const double tol = stiff ? fmax(TIGHTER_STIFF * run->controller.tol, TOL_IMPLICIT)
                             : fmax(tighter * run->controller.tol, TOL_EXPLICIT);
    if (!follower_begin(&second->follower, run, 0, method, &second->system, tol)) {
        free(second);
        return false;
    }
    second->distances = (struct distances){.t = epoch->t, .lost = NAN};
    second->saltation.lost = NAN;
    second->epoch = 1;
    second->parts = effort == OPINION_BRIEF ? (int)fmin(RUN_PARTS, (double)run->steps) : RUN_PARTS;
    run->private_state->second = second;
    run->opinion = (struct opinion){
        .error = NAN, .max = NAN, .t = NAN, .lost = NAN, .method = method, .tol = tol};
    return true;
}

/* Advances to t_end within `max` work. Returns false if the solver fails or has used that up. */
static bool second_go(const struct run *run, struct second *second, double t_end, double max,
                      const struct cancel *cancel)
{
    struct follower *follower = &second->follower;
    const double t_begin = follower->step.t,
                 longest = fabs(run->t - run->system.t0) / second->parts;
    const int parts = second->system.autonomous
                          ? 1
                          : (int)fmin(second->parts, 1 + fabs(t_end - t_begin) / longest);
    for (int part = 1; part <= parts; part++) {
        const double next = part < parts ? t_begin + (t_end - t_begin) * part / parts : t_end;
        if (follower_go(follower, next, max, cancel) != FOLLOWER_ARRIVED)
            return false;
    }
    return follower_work(follower) <= max;
}

/* Advances across the events, jumps and changes of the scene before the state after `step`. */
static bool second_cross(const struct run *run, struct second *second, int64_t step, double max,
                         const struct cancel *cancel)
{
    const struct run_private *p = run->private_state;
    for (;;) {
        const struct epoch *epoch = second->epoch < p->epochs ? &p->epoch[second->epoch] : NULL;
        const struct kick *kick = second->kick < p->kicks ? &p->kick[second->kick] : NULL;
        const bool bind = epoch && epoch->first < step, jump = kick && kick->step <= step;
        const bool first = bind && !(jump && kick->step <= epoch->first);
        const struct response *miss = saltation_next_miss(run, &second->saltation, step);
        double t;
        if (first)
            t = epoch->t;
        else
            t = jump ? kick->t : NAN;
        if (miss && !((miss->t - t) * (run->t - run->system.t0) > 0)) {
            if (!second_go(run, second, miss->t, max, cancel) ||
                !saltation_pass_miss(run, &second->saltation, second->follower.y))
                return false;
            continue;
        }
        if (!bind && !jump)
            return true;
        if (!second_go(run, second, t, max, cancel) ||
            !saltation_enter(run, &second->saltation, &second->system, t, second->follower.y))
            return false;
        if (first) {
            system_copy(&second->system, &epoch->system);
            system_turn_at_kinks(&second->system);
            method_choose_kernels(second->follower.method, &second->follower.step, true);
            second->epoch++;
        } else if (saltation_jump(run, &second->saltation, kick->step, second->follower.y)) {
            second->kick++;
        } else {
            return false;
        }
        saltation_leave(&second->saltation, &second->system, second->follower.y);
        follower_state_changed(&second->follower);
        second->follower.controller = (struct controller){.tol = second->follower.controller.tol};
    }
}

/* Returns true if the run has been lost for so long that it need not be followed any further. */
static bool is_lost(const struct run *run)
{
    const struct opinion *opinion = &run->opinion;
    return fabs(opinion->t - opinion->lost) >
           LOST_CONFIRMATION * fabs(opinion->lost - run->system.t0);
}

/* Continues to the run's state and compares on the way; `max` limits the work. With `lost` it stops
 * once the result is_lost(). Returns false if the end was not reached. */
static bool second_follow(struct run *run, double max, bool lost, const struct cancel *cancel)
{
    struct second *second = run->private_state->second;
    const struct trace *trace = run->trace;
    add_new_rows(run, &second->distances);
    const size_t found =
        second->compared_step > 0 ? trace_row_from(trace, second->compared_step) : 1;
    const size_t first = found < trace_count(trace) ? found : trace_count(trace) - 1;
    const size_t rows = trace_count(trace) - first,
                 count = rows < OPINION_ROWS_MAX ? rows : OPINION_ROWS_MAX;
    for (size_t k = 0; k < count; k++) {
        const size_t row = run_spread_row(run, first, k, count);
        const double t = trace_time(trace, row),
                     ahead = (t - second->follower.step.t) * (run->t - run->system.t0);
        if (ahead < 0)
            continue;
        if (!second_cross(run, second, trace_step(trace, row), max, cancel) ||
            !second_go(run, second, t, max, cancel))
            return false;
        second->compared_step = trace_step(trace, row);
        opinion_compare(run, &second->distances, t, trace_state(trace, row), second->follower.y);
        saltation_note(&second->saltation, run->system.n, trace_state(trace, row),
                       second->follower.y);
        if ((double)second->compared_step >= OPINION_STEP_RATIO * (double)second->past[1].step) {
            second->past[0] = second->past[1];
            second->past[1].step = second->compared_step;
            second->past[1].error = run->opinion.error;
        }
        if (lost && is_lost(run))
            return false;
    }
    return true;
}

/*
 * Predicts the error at the end from its growth since half of the way that the second solution
 * came, or less. The way is counted in steps of the run: where a stiff run's steps grow with time,
 * what happens in a step stays alike. Only decides whether the second solution is worth more work;
 * no user sees it.
 */
static double error_extrapolate(const struct run *run, const struct second *second)
{
    const double way = (double)second->compared_step, whole = (double)run->steps,
                 error = run->opinion.error;
    const double earlier_step = (double)second->past[0].step, was = second->past[0].error;
    if (!(was > 0) || !(error > was))
        return error * whole / way;
    const double growth = fixed_log(error / was), power = growth / fixed_log(way / earlier_step);
    return error * (power > POWER_MAX ? fixed_exp(growth * (whole - way) / (way - earlier_step))
                                      : fixed_pow(whole / way, fmax(power, 1)));
}

/* Returns the work that the second solution may do at first, in evaluations of its own method. */
static double first_budget(const struct run *run, enum opinion_effort effort)
{
    const double own = run_evaluations(run);
    if (effort == OPINION_WHOLE)
        return HUGE_VAL;
    if (effort == OPINION_DEMANDED)
        return fmax(OPINION_BUDGET / run->system.n, OPINION_SHARE * own);
    return fmax(OPINION_BRIEF_MIN, OPINION_BRIEF_SHARE * own) *
           solver_evaluation_price(&run->system, run->method, true) /
           solver_evaluation_price(&run->system, run->opinion.method, true);
}

/* Follows the run as far as its budget, *max, allows, and again with the other method if the first
 * one fails in its first call. Returns false if the end was not reached. */
static bool second_try(struct run *run, enum opinion_effort effort, double *max,
                       const struct cancel *cancel)
{
    struct run_private *p = run->private_state;
    for (int try = p->second ? 1 : 0; try < 2; try++) {
        if (!p->second && !second_begin(run, try > 0, effort))
            return false;
        *max = first_budget(run, effort);
        if (second_follow(run, *max, false, cancel))
            return true;
        assert(p->second); /* following does not free it */
        if (follower_work(&p->second->follower) > *max || cancelled(cancel) ||
            !isnan(p->second->saltation.lost))
            return false;
        if (try == 0)
            opinion_forget(run);
    }
    return false;
}

/* Compares with the second solution, beyond the first budget only if the error may be large. */
static void against_second(struct run *run, enum opinion_effort effort, const struct cancel *cancel)
{
    const double own = run_evaluations(run);
    double max = 0;
    if (second_try(run, effort, &max, cancel) || isnan(run->opinion.t))
        return;
    const struct second *second = run->private_state->second;
    const bool is_brief = effort == OPINION_BRIEF, spent = follower_work(&second->follower) > max,
               tells =
                   !is_brief || BRIEF_TELLS * (double)second->compared_step > (double)run->steps;
    const double doubtful = is_brief ? OPINION_LOST : OPINION_WRONG * run->controller.tol;
    if (spent && tells && error_extrapolate(run, second) > doubtful)
        second_follow(run, fmax(OPINION_BUDGET_DOUBT / run->system.n, OPINION_DOUBT * own), true,
                      cancel);
}

void run_second_opinion(struct run *run, enum opinion_effort effort, const struct cancel *cancel)
{
    if (!run->plan.adaptive || run->steps == 0 || stop_is_failure(run->stop) ||
        run->opinion.t == run->t)
        return;
    const struct run_private *p = run->private_state;
    if (p->second &&
        run->plan.exact_known != !p->second->follower.method) /* the scene was changed on the way */
        opinion_forget(run);
    if (p->second && p->second->follower.method && effort > OPINION_BRIEF &&
        p->second->parts < RUN_PARTS)
        opinion_forget(run);
    if (p->second && !isnan(p->second->saltation.lost))
        return;
    if (run->plan.exact_known) {
        against_closed_form(run, effort);
        return;
    }
    if (effort < OPINION_DEMANDED && run_asks_small_values(run))
        effort = OPINION_DEMANDED;
    const bool regrows = regrowth_is_likely(run);
    against_second(run, effort, cancel);
    run->opinion.work = p->second ? follower_work(&p->second->follower) : 0;
    if (regrows)
        regrowth_look(run, cancel);
}

bool run_opinion_known(const struct run *run)
{
    const struct opinion *opinion = &run->opinion;
    const struct burst *missed = &run->missed;
    const bool known = isfinite(opinion->error) && !isnan(opinion->t);
    const bool passed =
        missed->t_begin != missed->t_end && (missed->t_begin < run->t) == (run->system.t0 < run->t);
    const bool blind =
        opinion->method && passed && !(opinion->error > OPINION_WRONG * run->controller.tol);
    return known && !blind && isnan(run_opinion_sunk(run));
}

double opinion_size(const struct run *run, int i)
{
    const struct second *second = run->private_state->second;
    const bool known = second && !isnan(run_opinion_error(run));
    return known ? error_unit(run, &second->distances, i, run->opinion.end[i]) : HUGE_VAL;
}

double run_opinion_sunk(const struct run *run)
{
    return run->private_state->sunk;
}

double run_opinion_event(const struct run *run)
{
    const struct second *second = run->private_state->second;
    return second ? second->saltation.lost : NAN;
}

double run_opinion_error(const struct run *run)
{
    return run_opinion_known(run) && run->opinion.t == run->t ? run->opinion.error : NAN;
}
