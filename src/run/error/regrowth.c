/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Variables that come to rest within the tolerance, at 0 or elsewhere, and what becomes of them.
 * Step control does not see what is left of their motion, so that a method may lose it, and so does
 * the second solution: both agree on next to nothing. Where the equations amplify small values
 * later (a slow passage through a bifurcation) the agreement means nothing.
 *
 * Two more solutions, from there and from a displaced state, show how errors grow. Their distance
 * is large enough for step control to see it, and is scaled back where it has grown (Benettin et
 * al. 1980, Meccanica 15:9), so that its growth is that of small errors. Times the tolerance of the
 * second solution it bounds how well that one knows these variables. (Growth along the run itself
 * would end too early where the run has regrown from errors of its own.)
 */
#include <hooke/base/cancel.h>
#include <hooke/base/elementary.h>
#include <hooke/base/numeric.h>

#include "run/error/follower.h"
#include "run/price/evaluation.h"

#include <math.h>
#include <stdlib.h>

/* Number of rows, one after the other, in which a value has to be below the tolerance, or an error
 * large. */
#define ROWS_LASTING 8
/* A variable rests if this many rows, over more than this share of the run, are within its
 * tolerance. */
#define ROWS_AT_REST_MIN 3
#define REST_RUN_SHARE 0.01
/* It rests at 0 within this many tolerances, to which errors of steps add up, but at most this
 * share of its size; and it must have been farther away than AWAY_TOLERANCES before. */
#define REST_TOLERANCES 50
#define REST_MAX 0.01
#define AWAY_TOLERANCES 100
/* Rows from which two solutions start, and times at which they are compared. */
#define ROWS_COMPARED 256
/* Factor by which the distance may grow between two rows before it is scaled back. */
#define DISPLACEMENT_GROWTH_MAX 10
/* Error of the second solution, in sizes of the variables, that leaves no digit certain, unless the
 * run and the base have come this near to each other, as a share of how far the run has grown. */
#define ERROR_LOST 0.1
#define GROWTH_AGREEMENT 0.1
/* Logarithm of what counts as growth. */
#define GROWTH_MIN 0.1

struct regrowth {
    struct run *run;
    size_t row; /* first row in which a variable rests; both solutions start there */
    bool resting[LIMIT_VARIABLES]; /* variables that rest at some time */
    bool any;                      /* one of them is set */
    /* The run has jumps or changes of its scene: both solutions start anew from each of its rows.
     */
    bool follows_jumps;
    double scale[LIMIT_VARIABLES];      /* sizes of the variables when they came to rest */
    double rest[LIMIT_VARIABLES];       /* their values there; 0 at 0 */
    double rest_width[LIMIT_VARIABLES]; /* uncertainties of these values */
    double size[LIMIT_VARIABLES];       /* largest magnitudes in the run */
    /* distance of the two solutions to which it is scaled back, and the last one, in these sizes */
    double displacement, previous_distance;
    /* Used only if variables rest; not cleared before, because they are large. */
    struct system system;
    struct follower base, displaced;
};

/* Size of a variable along the run, as step control had it at each row (struct controller). */
struct scale_mean {
    double sum, previous_t; /* [s] integral of the fourth root of the size; time of the last row */
};

/* Adds a row to the mean size of variable i, and returns that size. */
static double scale_add(struct scale_mean *mean, const struct run *run, size_t row, int i)
{
    const double y = fabs(trace_state(run->trace, row)[i]), min = run->system.scale[i],
                 t = trace_time(run->trace, row), way = fabs(t - run->system.t0);
    if (run->system.atol[i] > 0)
        return run->system.atol[i] / run->controller.tol;
    mean->sum += fabs(t - mean->previous_t) * (y > min ? sqrt(sqrt(y / min)) : 1);
    mean->previous_t = t;
    const double root = mean->sum / way,
                 scale = way > 0 ? min * ((root * root) * (root * root)) : min;
    return isfinite(scale) ? scale : min;
}

/* Consecutive rows in which a variable stays within its tolerance of a value. */
struct rest {
    double value;
    size_t count, first_row;
};

/* Adds the next row, in which the variable has this distance from the value. Returns true if it has
 * rested there for more than min_time [s]. */
static bool rest_add(struct rest *rest, const struct trace *trace, size_t row, double distance,
                     double tolerance, double min_time)
{
    if (!(distance < tolerance)) {
        rest->count = 0;
        return false;
    }
    if (rest->count++ == 0)
        rest->first_row = row;
    const double time = fabs(trace_time(trace, row) - trace_time(trace, rest->first_row));
    return rest->count >= ROWS_AT_REST_MIN && time > min_time;
}

/* Returns how many rows find_rest() examines: as many as take some percent of the run's work. */
static size_t rows_looked(const struct run *run)
{
    static const double evals_a_row = 128, rows_min = 32, rows_max = 4096;
    return (size_t)fmin(rows_max, fmax(rows_min, run_evaluations(run) / evals_a_row));
}

/* Finds out whether variable i came to rest within its tolerance, at 0 or elsewhere, after it had
 * been away from there; then sets the members of r for it. */
static void find_rest(struct regrowth *r, int i)
{
    const struct trace *trace = r->run->trace;
    const size_t rows = trace_count(trace), first = run_own_start(r->run),
                 stride = 1 + (rows - first) / rows_looked(r->run);
    const double min_time = REST_RUN_SHARE * fabs(r->run->t - trace_time(trace, first));
    struct scale_mean mean = {.previous_t = r->run->system.t0};
    struct rest zero = {0}, any = {.value = trace_state(trace, first)[i]};
    double min = any.value, max = any.value;
    for (size_t row = first; row < rows; row += stride) {
        const double y = trace_state(trace, row)[i];
        min = y < min ? y : min; /* fmin() is a call */
        max = y > max ? y : max;
        r->scale[i] = scale_add(&mean, r->run, row, i);
        const double error = r->run->controller.tol * r->scale[i],
                     rest_max = error > REST_MAX * r->scale[i] ? error : REST_MAX * r->scale[i],
                     many = REST_TOLERANCES * error;
        const double tolerance = many < rest_max ? many : rest_max, away = AWAY_TOLERANCES * error;
        const bool small = rest_add(&zero, trace, row, fabs(y), tolerance, min_time),
                   still = rest_add(&any, trace, row, fabs(y - any.value), error, min_time);
        if (any.count == 0)
            any = (struct rest){.value = y, .count = 1, .first_row = row};
        const bool was_small = small && (max > away || -min > away),
                   was_still = still && (max - any.value > away || any.value - min > away);
        if (!was_small && !was_still)
            continue;
        const size_t began = was_small ? zero.first_row : any.first_row;
        r->resting[i] = true;
        if (!was_small && fabs(any.value) > tolerance) {
            r->rest[i] = any.value;
            r->rest_width[i] = 2 * error;
        }
        r->row = r->any && r->row < began ? r->row : began;
        r->any = true;
        return;
    }
}

/* Returns the largest distance of the two solutions in a resting variable, in r->size. */
static double solutions_distance(const struct regrowth *r)
{
    double max = 0;
    for (int i = 0; i < r->run->system.n; i++)
        if (r->resting[i])
            max = fmax(max, fabs(r->displaced.y[i] - r->base.y[i]) / r->size[i]);
    return max;
}

/* Displaces resting variables in which the two solutions are nearer than r->displacement, up to
 * that. */
static void solutions_displace(struct regrowth *r)
{
    for (int i = 0; i < r->run->system.n; i++) {
        const double base = r->base.y[i], displacement = r->displaced.y[i] - base,
                     min = r->displacement * r->size[i];
        if (r->resting[i] && fabs(displacement) < min)
            r->displaced.y[i] = base + copysign(min, displacement != 0 ? displacement : base);
    }
}

/* Multiplies the distance by a factor, along its direction, and moves both so that the base is at
 * new_base. */
static void rescale_displacement(struct regrowth *r, const double *new_base, double factor)
{
    for (int i = 0; i < r->run->system.n; i++) {
        r->displaced.y[i] = new_base[i] + factor * (r->displaced.y[i] - r->base.y[i]);
        r->base.y[i] = new_base[i];
    }
}

/* Growth of an error that is as large as the second solution's tolerance at first. */
struct growth {
    double log;     /* logarithm of the error over the tolerance */
    double error;   /* the error, in sizes of the variables */
    double began;   /* [s] time at which it was last no larger than the tolerance */
    double large;   /* [s] time at which it became ERROR_LOST, */
    int large_rows; /* this many rows ago */
    double lost;    /* [s] time from which no digit is certain; NAN if there is none */
    double t;       /* [s] time up to which it was followed */
    /* [s] time at which the run last grew as the base did; NAN if there is none */
    double agreed;
};

/* ---- finding out whether anything grows ---- */

/* Returns at how many rows rest_is_unstable() evaluates the Jacobian: as many as take some percent
 * of the run's work. */
static size_t jacobians_looked(const struct run *run)
{
    static const double share = 0.02, count_min = 2, a_product = 500;
    const double n = run->system.n,
                 own = run_evaluations(run) *
                       solver_evaluation_price(&run->system, run->method, true),
                 look = (n + 1) * evaluation_price_called(&run->system) + a_product * n * n * n;
    return (size_t)fmin(ROWS_COMPARED, fmax(count_min, share * own / look));
}

/* Replaces v [n] by the direction of exp(a) v. Returns log |exp(a) v| / |v| in the maximum norm,
 * -HUGE_VAL where nothing is left. Destroys a; work has 2 n^2 doubles. */
static double exponential_apply(int n, double *a, double *v, double *work)
{
    double result[LIMIT_VARIABLES], initial_size = 0, size = 0;
    const double power = matrix_exponential(n, a, work);
    for (int i = 0; i < n; i++) {
        result[i] = 0;
        for (int j = 0; j < n; j++)
            result[i] += a[i * n + j] * v[j];
        initial_size = fmax(initial_size, fabs(v[i]));
        size = fmax(size, fabs(result[i]));
    }
    for (int i = 0; i < n && size > 0; i++)
        v[i] = result[i] / size;
    return size > 0 ? power * fixed_log(2) + fixed_log(size / initial_size) : -HUGE_VAL;
}

/* Advances v [n], in sizes along the run, by dt [s] with the Jacobian of a row. Returns the
 * logarithm of its growth, 0 where that is rounding of the Jacobian. work has 3 n^2 doubles. */
static double frozen_growth(const struct regrowth *r, size_t row, double dt, double *v,
                            double *work)
{
    static const double rounding = 1e-11;
    const struct trace *trace = r->run->trace;
    const int n = r->run->system.n;
    system_jacobian(&r->run->system, trace_time(trace, row), trace_state(trace, row), work);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            work[i * n + j] *= dt * r->scale[j] / r->scale[i];
    const double noise = rounding * matrix_norm(n, work),
                 log = exponential_apply(n, work, v, work + n * n);
    return fabs(log) > noise ? log : 0;
}

/* Returns false if all variables that came to rest are stable there, so that errors in them cannot
 * grow: a displacement of them is carried from row to row by exponentials of Jacobians, which are
 * exact for what changes slowly, however fast it oscillates. Returns true if it grows by more than
 * growth_max, or if that is not known. */
static bool rest_is_unstable(const struct regrowth *r)
{
    static const double growth_max = 2; /* e-foldings, far below those that errors need */
    const struct trace *trace = r->run->trace;
    const int n = r->run->system.n;
    const size_t rows = trace_count(trace) - 1 - r->row, max = jacobians_looked(r->run),
                 count = rows < max ? rows : max;
    double v[LIMIT_VARIABLES] = {0}, size = 0, grown = 0,
           *work = malloc(3 * (size_t)n * (size_t)n * sizeof *work);
    bool unstable = !work;
    for (size_t k = 0; k <= count && count > 0 && !unstable; k++) {
        const size_t last = k > 0 ? k - 1 : 0;
        const size_t next = k < count ? k + 1 : count;
        const double dt = (trace_time(trace, r->row + next * rows / count) -
                           trace_time(trace, r->row + last * rows / count)) /
                          2;
        double resting = 0;
        for (int i = 0; i < n && grown <= 0; i++)
            v[i] = r->resting[i] ? copysign(1, v[i]) : 0;
        size = grown <= 0 ? 0 : size;
        size += frozen_growth(r, r->row + k * rows / count, dt, v, work);
        for (int i = 0; i < n; i++)
            resting = r->resting[i] ? fmax(resting, fabs(v[i])) : resting;
        grown = resting > 0 ? size + fixed_log(resting) : -HUGE_VAL;
        unstable = grown > growth_max || isnan(grown);
    }
    free(work);
    return unstable;
}

/* Adds the growth up to t, the logarithm `change` of the distance's ratio. An error below the
 * tolerance starts again from it, because steps leave new errors of that size. */
static void growth_add(struct growth *growth, double t, double change, double tol)
{
    growth->log += change;
    growth->t = t;
    if (growth->log < GROWTH_MIN) {
        growth->log = 0;
        growth->began = t;
    }
    growth->error = growth->log > 0 ? tol * fixed_exp(growth->log) : 0;
}

/* Returns true if the run has grown as the base has, in the variables in which errors
 * grow: then the regrowth is real. Values that two methods have lost grow differently, from errors
 * of their own. */
static bool run_agrees(const struct regrowth *r, const double *run_state)
{
    double run_distance = 0, grown = 0;
    for (int i = 0; i < r->run->system.n && !r->follows_jumps; i++) {
        const double difference = fabs(r->displaced.y[i] - r->base.y[i]) / r->size[i];
        if (!r->resting[i] || difference < GROWTH_AGREEMENT * r->previous_distance)
            continue;
        run_distance = fmax(run_distance, fabs(run_state[i] - r->base.y[i]) / r->size[i]);
        grown = fmax(grown, (fabs(run_state[i] - r->rest[i]) - r->rest_width[i]) / r->size[i]);
    }
    return run_distance < GROWTH_AGREEMENT * grown;
}

/* Adds the growth of the distance up to t. Then continues both from new_base (the base itself, or
 * the run's state), with their distance scaled back if it has become large. */
static void solutions_compare(struct regrowth *r, struct growth *growth, const double *new_base,
                              double t)
{
    double now = 0, factor = 1;
    const bool failed = r->base.step.t != t || r->displaced.step.t != t; /* no solution there */
    if (failed) {
        r->base.step.t = r->displaced.step.t = t;
        copy_state(r->displaced.y, r->base.y, r->run->system.n);
    } else {
        now = solutions_distance(r);
        growth_add(growth, t, now > 0 ? fixed_log(now / r->previous_distance) : -HUGE_VAL,
                   r->base.controller.tol);
    }
    if (now > DISPLACEMENT_GROWTH_MAX * r->displacement)
        factor = r->displacement / now;
    rescale_displacement(r, new_base, factor);
    if (growth->log <= 0 || now == 0)
        solutions_displace(r);
    r->previous_distance = solutions_distance(r);
    follower_state_changed(&r->base);
    follower_state_changed(&r->displaced);
}

/* Takes the row at time t into the judgement of an error that grows back; `agrees` tells that both
 * solutions agree there. Sets growth->lost to the time from which the error has been ERROR_LOST for
 * ROWS_LASTING rows, or at the last one (is_last). Shorter large errors are those of the times of
 * jumps. */
static void growth_judge(struct growth *growth, double t, bool agrees, bool is_last)
{
    if (growth->error > 0 && agrees)
        growth->agreed = t;
    if (agrees || growth->error < ERROR_LOST) {
        growth->large_rows = 0;
        return;
    }
    if (growth->large_rows++ == 0)
        growth->large = t;
    if (growth->large_rows == ROWS_LASTING || is_last)
        growth->lost = growth->large;
}

/* Advances both solutions to t_end, the time of the next row, in parts no longer than `longest`
 * [s], in which growth is added. Returns false if their work exceeds `max`. */
static bool follow_row(struct regrowth *r, struct growth *growth, double t_end, double longest,
                       double max, const struct cancel *cancel)
{
    const double t = r->base.step.t;
    const int parts = (int)fmin(ROWS_COMPARED, 1 + fabs(t_end - t) / longest);
    for (int part = 1; part <= parts; part++) {
        const double next = part < parts ? t + (t_end - t) * part / parts : t_end;
        if (follower_go(&r->base, next, max / 2, cancel) == FOLLOWER_SPENT ||
            follower_go(&r->displaced, next, max / 2, cancel) == FOLLOWER_SPENT)
            return false;
        if (part < parts)
            solutions_compare(r, growth, r->base.y, next);
    }
    return true;
}

/* Follows both until no digit is certain, or to the end of the run. Returns false if their work
 * exceeds `max`. */
static bool regrowth_follow(struct regrowth *r, struct growth *growth, double max,
                            const struct cancel *cancel)
{
    const struct trace *trace = r->run->trace;
    const size_t rows = trace_count(trace) - 1 - r->row,
                 count = rows < ROWS_COMPARED ? rows : ROWS_COMPARED;
    const double start = trace_time(trace, r->row),
                 longest = fabs(r->run->t - start) / ROWS_COMPARED;
    *growth = (struct growth){.began = start, .t = start, .lost = NAN, .agreed = NAN};
    for (size_t k = 1; k <= count && isnan(growth->lost); k++) {
        const size_t row = r->row + (size_t)((double)k * (double)rows / (double)count);
        const double t = trace_time(trace, row);
        if (!follow_row(r, growth, t, longest, max, cancel))
            return false;
        solutions_compare(r, growth, r->follows_jumps ? trace_state(trace, row) : r->base.y, t);
        growth_judge(growth, t, run_agrees(r, trace_state(trace, row)),
                     row + 1 == trace_count(trace));
    }
    return true;
}

/* Displaces the second of the two solutions, which have just begun, and follows both; returns false
 * as regrowth_follow() does. */
static bool solutions_follow(struct regrowth *r, struct growth *growth, double max,
                             const struct cancel *cancel)
{
    r->displacement = sqrt(r->run->controller.tol);
    copy_state(r->size, r->scale, r->run->system.n);
    run_sizes_add(r->run, 0, trace_count(r->run->trace), r->size);
    solutions_displace(r);
    r->previous_distance = solutions_distance(r);
    return regrowth_follow(r, growth, max, cancel);
}

/* Follows the growth by one method. Returns false if it cannot begin or its work exceeds `max`. */
static bool growth_follow_by(struct regrowth *r, const struct method *method, struct growth *growth,
                             double max, const struct cancel *cancel)
{
    const double tol = r->run->opinion.tol;
    bool done = false;
    if (follower_begin(&r->base, r->run, r->row, method, &r->system, tol) &&
        follower_begin(&r->displaced, r->run, r->row, method, &r->system, tol))
        done = solutions_follow(r, growth, max, cancel);
    r->run->private_state->regrowth_work += follower_work(&r->base) + follower_work(&r->displaced);
    follower_end(&r->base);
    follower_end(&r->displaced);
    return done;
}

/* Finds the variables that came to rest, and sets the members of r for them. Returns true if there
 * are any. */
static bool find_resting(struct regrowth *r, struct run *run)
{
    memset(r, 0, offsetof(struct regrowth, system));
    r->run = run;
    for (int i = 0; i < run->system.n; i++)
        find_rest(r, i);
    return r->any;
}

bool regrowth_is_likely(struct run *run)
{
    struct regrowth r;
    return find_resting(&r, run) && rest_is_unstable(&r);
}

/* Follows errors of resting variables, and corrects the opinion if these may have grown unseen. */
void regrowth_look(struct run *run, const struct cancel *cancel)
{
    struct regrowth r;
    struct growth growth = {.lost = NAN};
    const int n = run->system.n;
    struct opinion *opinion = &run->opinion;
    if (!opinion->method || isnan(opinion->t) || !isnan(opinion->lost) || !find_resting(&r, run))
        return;
    struct run_private *p = run->private_state;
    r.follows_jumps = p->kicks > 0 || p->epochs > 1;
    r.system = run->system;
    system_turn_at_kinks(&r.system);
    r.base = r.displaced = (struct follower){0};
    p->regrowth_work = 0;
    const double max = fmax(OPINION_BUDGET_DOUBT / n, OPINION_DOUBT * run_evaluations(run));
    /* rodas5p is for stiff equations, in which dop853 has to take short steps for its stability. */
    const bool followed = growth_follow_by(&r, method_find("dop853"), &growth, max / 2, cancel) ||
                          growth_follow_by(&r, method_find("rodas5p"), &growth, max / 2, cancel);
    if (!isnan(growth.lost)) {
        p->sunk = growth.began;
        opinion->lost = growth.lost;
        return;
    }
    if (!followed && fabs(growth.t - run->system.t0) < fabs(opinion->t - run->system.t0))
        opinion->t = growth.t; /* nothing is known about later times */
    if (growth.agreed == growth.t)
        return;
    opinion->error = fmax(opinion->error, growth.error);
    opinion->max = fmax(opinion->max, growth.error);
    for (int i = 0; i < n; i++)
        if (r.resting[i])
            opinion->end[i] = fmax(opinion->end[i], growth.error * r.size[i]);
}
