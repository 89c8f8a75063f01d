/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Finite-time singularities: solutions that go to infinity at a finite time t*, like x = 1/(t* - t)
 * of x' = x^2, or whose slope does.
 *
 * Before a singularity adaptive steps shrink in proportion to t* - t until they are lost in the
 * rounding of t, which puts their end within some ulps of t*; there the speed |y'| has to grow like
 * a power of 1/(t* - t) over decades (Goriely, Hyde 2000, J. Differ. Equ. 161:422). What grows
 * exponentially has no such time.
 *
 * A run that got where it should is not looked into, unless one of its fixed steps looks strange.
 * Of a run that failed the equations are integrated once more, by an accurate adaptive method, from
 * where they last had a start of their own: an unstable method, or a loose tolerance, fails where
 * the solution itself goes on. If that takes too long the steps of the run itself have to do.
 */
#include <hooke/base/elementary.h>

#include "run/private.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#define TOL 1e-11
#define STEPS_MOST 20000
#define LAST 256    /* steps that are looked at */
#define CREEP 1e-11 /* of the way: shorter steps do not get on */
#define SHORTER 0.8
#define LONGER 4
#define ULPS 1e3 /* of t*: what is nearer is rounding */
#define POINTS 8
#define POWER_MIN 0.3
#define AHEAD 0.1         /* of the time since the start: a method may fail that much earlier */
#define SCATTER 0.1       /* rms of log |y'| about the line */
#define POWER_FINITE 0.95 /* |y'| may be integrated up to there: y stays finite */
#define SHORTLY 1e-3      /* of that time */
#define ROW_POINTS 10     /* of a run's own rows, for each decade of t* - t */
#define ROW_DECADES 16
/* of the largest state that a run may have: a solution that got there leaves the range of numbers
 */
#define LARGE 1e-30
/* times the time to a singularity: who gets there in another way has shown that it is none */
#define BEYOND 1.01
#define LOOK_EACH 512 /* steps and rows between two looks at the flag of Ctrl-C */

/* How far a power has to hold: to within `near` of the time since the start, over so many decades
 * of t* - t. */
struct evidence {
    double near, decades;
};
static const struct evidence sure = {1e-6, 3}, hint = {0.1, 1};

/* What steps have met on their way to a point: where they got shorter. */
struct approach {
    double t[LAST], speed[LAST];
    int64_t count;
    double step; /* [s] length of the last one that was added */
    const struct cancel *cancel;
};

static double speed_of(const struct system *system, double t, const double *y)
{
    double f[LIMIT_VARIABLES], sum = 0;
    system_derivative(system, t, y, f);
    for (int i = 0; i < system->n; i++)
        sum += f[i] / system->scale[i] * (f[i] / system->scale[i]);
    return sqrt(sum);
}

/* Adds a step over h from t if it is shorter than those before; longer ones begin anew. */
static void approach_add(struct approach *approach, double t, double h, double speed)
{
    if (approach->count > 0 && h > SHORTER * approach->step && h < LONGER * approach->step)
        return;
    if (approach->count > 0 && h >= LONGER * approach->step)
        approach->count = 0;
    approach->t[approach->count % LAST] = t;
    approach->speed[approach->count % LAST] = speed;
    approach->count++;
    approach->step = h;
}

/* Integrates from (*t, y) until `end`, or until no step is possible; *t is then where. */
static enum solution_fate approach_end(const struct system *system, double *t, const double *y,
                                       double end, int64_t max, struct approach *approach)
{
    const struct method *method = method_find("dop853");
    double state[LIMIT_VARIABLES],
        *work = method ? malloc((method_work_size(method, system->n) + 1) * sizeof *work) : NULL;
    struct step step = {.system = system, .y = state, .work = work, .t = *t};
    struct controller controller = {.tol = TOL};
    approach->count = 0;
    if (!work)
        return SOLUTION_UNKNOWN;
    memcpy(state, y, (size_t)system->n * sizeof *state);
    bool moves = true, large = false;
    for (int64_t steps = 0; moves && step.t != end && steps < max; steps++) {
        if (steps % LOOK_EACH == 0 && cancelled(approach->cancel))
            break;
        const double from = step.t, speed = speed_of(system, from, state);
        moves = isfinite(speed) && method_adapt(method, &step, &controller, end) == STEP_OK &&
                fabs(step.t - from) > CREEP * fabs(step.t - *t);
        approach_add(approach, from, fabs(step.t - from), speed);
    }
    for (int i = 0; i < system->n; i++)
        large = large || !(fabs(state[i]) <= LARGE * run_bound(system, i));
    free(work);
    *t = step.t;
    if (large)
        return SOLUTION_GROWS;
    if (!moves && !cancelled(approach->cancel))
        return SOLUTION_ENDS;
    return step.t == end ? SOLUTION_GOES_ON : SOLUTION_UNKNOWN;
}

struct line_sums {
    double n, x, y, xx, xy, yy; /* sums */
};

/* log |y'| over log (at - t), where that is from low to high [s] */
static struct line_sums line_over(const struct approach *approach, double at, double low,
                                  double high)
{
    struct line_sums sum = {0};
    for (int64_t i = 0; i < approach->count && i < LAST; i++) {
        const double before = fabs(at - approach->t[i]), x = fixed_log(before),
                     y = fixed_log(approach->speed[i]);
        if (!(before >= low && before <= high) || !isfinite(y))
            continue;
        sum.n++;
        sum.x += x;
        sum.y += y;
        sum.xx += x * x;
        sum.xy += x * y;
        sum.yy += y * y;
    }
    return sum;
}

/* Returns the q of |y'| ~ (at - t)^-q over decades of at - t from `floor` [s] on, or NAN if that is
 * no such power or q <= POWER_MIN. */
static double power_from(const struct approach *approach, double start, double at, double floor,
                         const struct evidence *evidence)
{
    double low = HUGE_VAL, high = 0;
    for (int64_t i = 0; i < approach->count && i < LAST; i++) {
        const double before = fabs(at - approach->t[i]);
        if (before >= floor)
            low = fmin(low, before);
    }
    for (int64_t i = 0; i < approach->count && i < LAST; i++) {
        const double before = fabs(at - approach->t[i]);
        if (before <=
            low * fixed_pow(10, 2 * evidence->decades)) /* farther away other things matter */
            high = fmax(high, before);
    }
    const struct line_sums sum = line_over(approach, at, low, high);
    const double xx = sum.xx - sum.x * sum.x / sum.n, xy = sum.xy - sum.x * sum.y / sum.n,
                 yy = sum.yy - sum.y * sum.y / sum.n;
    const bool is_power = sum.n >= POINTS && low <= evidence->near * fabs(at - start) &&
                          high >= low * fixed_pow(10, evidence->decades) && -xy / xx > POWER_MIN &&
                          sqrt(fmax(0, yy - xy * xy / xx) / sum.n) < SCATTER;
    return is_power ? -xy / xx : NAN;
}

/* The same as near to `at` as the points can tell: steps may have ended before it, or gone to and
 * fro across it, so that what is nearest says nothing. */
static double power_of(const struct approach *approach, double start, double at,
                       const struct evidence *evidence)
{
    double power = NAN;
    const double ulps = ULPS * (nextafter(fabs(at), HUGE_VAL) - fabs(at));
    for (double floor = ulps; isnan(power) && floor <= evidence->near * fabs(at - start);
         floor *= 10)
        power = power_from(approach, start, at, floor, evidence);
    return power;
}

/* Natural sizes may have been taken from a solution on its way to infinity: at most those of where
 * it starts. */
static struct system with_start_scale(const struct system *system, const double *y)
{
    struct system scaled = *system;
    double size = 0;
    for (int i = 0; i < system->n; i++)
        size = fmax(size, fabs(y[i]) / system->scale[i]);
    for (int i = 0; i < system->n && size > 0 && size < 1; i++)
        scaled.scale[i] *= size;
    return scaled;
}

bool run_is_never_singular(const struct system *system)
{
    return system->linear && (system->autonomous || system->oscillator.whole);
}

/* The singularity of the solution through (t, y) before `end`; *fate: what became of it. */
static struct singularity look_for(const struct system *system, double t, const double *y,
                                   double end, int64_t max, const struct cancel *cancel,
                                   enum solution_fate *fate)
{
    struct approach *approach = run_is_never_singular(system) ? NULL : malloc(sizeof *approach);
    const struct system scaled = with_start_scale(system, y);
    double singular_t = t, power = NAN;
    *fate = SOLUTION_UNKNOWN;
    if (approach) {
        approach->cancel = cancel;
        *fate = approach_end(&scaled, &singular_t, y, end, max, approach);
        if (*fate == SOLUTION_ENDS || *fate == SOLUTION_GROWS)
            power = power_of(approach, t, singular_t, &sure);
        if (!isnan(power))
            *fate = SOLUTION_ENDS;
        else if (*fate == SOLUTION_ENDS)
            *fate = SOLUTION_UNKNOWN;
    }
    free(approach);
    return (struct singularity){.t = isnan(power) ? NAN : singular_t,
                                .finite = power < POWER_FINITE};
}

struct singularity system_singularity(const struct system *system, double t, const double *y,
                                      double end, const struct cancel *cancel)
{
    enum solution_fate ignored;
    return look_for(system, t, y, end, STEPS_MOST, cancel, &ignored);
}

const char *singularity_text(const struct singularity *singularity)
{
    return singularity->finite ? "gets an infinite slope" : "goes to infinity";
}

/* ---- runs ---- */

/* The first recorded state since its equations or its state were last changed from outside. */
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

/* The last recorded row, not before `first`, that is SHORTLY before t or earlier. */
static size_t row_before(const struct run *run, size_t first, double t)
{
    const double way = t - trace_time(run->trace, first);
    size_t low = first, high = trace_count(run->trace);
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if ((t - trace_time(run->trace, middle)) / way >= SHORTLY)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Where steps shrink to, if they go on as from the last row whose step was twice as long: an
 * estimate of t* from (t, h), steps being proportional to t* - t. */
static double shrinks_to(const struct run *run, size_t first)
{
    const struct trace *trace = run->trace;
    const size_t rows = trace_count(trace);
    if (rows < first + 3)
        return run->t;
    const double last = trace_time(trace, rows - 1) - trace_time(trace, rows - 2);
    for (size_t back = 2; rows - 1 >= first + back; back *= 2) {
        const double t = trace_time(trace, rows - 1 - back),
                     h = t - trace_time(trace, rows - 2 - back);
        if (fabs(h) >= 2 * fabs(last) && h * last > 0)
            return run->t + last * (run->t - t) / (h - last);
        if (rows - 1 - back == first)
            break;
    }
    return run->t;
}

/* The power law of the run's own adaptive steps before its present time, from rows at even
 * logarithms of the time to it. */
static struct singularity singular_by_steps(const struct run *run, const struct evidence *evidence)
{
    const struct trace *trace = run->trace;
    const size_t first = run_own_start(run), rows = trace_count(trace);
    const double from = trace_time(trace, first), way = run->t - from;
    struct approach approach = {.count = 0};
    size_t last = rows;
    for (int k = 0; k <= ROW_POINTS * ROW_DECADES; k++) {
        const size_t row =
            trace_row_at(trace, run->t - way * fixed_pow(10, -(double)k / ROW_POINTS));
        if (row < first || row == last || row + 1 >= rows)
            continue;
        const double *y = trace_state(trace, row), *next = trace_state(trace, row + 1);
        const double t = trace_time(trace, row), h = trace_time(trace, row + 1) - t;
        double sum = 0;
        for (int i = 0; i < run->system.n; i++)
            sum +=
                (next[i] - y[i]) / run->system.scale[i] * ((next[i] - y[i]) / run->system.scale[i]);
        approach.t[approach.count] = t + h / 2;
        approach.speed[approach.count++] = sqrt(sum) / fabs(h);
        last = row;
    }
    double t = shrinks_to(run, first), power = power_of(&approach, from, t, evidence);
    if (isnan(power))
        power = power_of(&approach, from, t = run->t, evidence);
    return (struct singularity){.t = isnan(power) ? NAN : t, .finite = power < POWER_FINITE};
}

/*
 * Before `end`, in at most so many steps of the accurate method: from the start, whose solution it
 * is about, and where that is too far away from shortly before t.
 */
struct singularity run_singular_before(struct run *run, double t, double end, int64_t max)
{
    const size_t first = run_own_start(run);
    const double from = trace_time(run->trace, first);
    enum solution_fate *fate = &run->private_state->fate, near_fate;
    struct singularity found =
        look_for(&run->system, from, trace_state(run->trace, first), end, max, run->cancel, fate);
    const size_t near = row_before(run, first, t);
    if (*fate != SOLUTION_UNKNOWN || cancelled(run->cancel) || near == first)
        return found;
    found = look_for(&run->system, trace_time(run->trace, near), trace_state(run->trace, near), end,
                     max, run->cancel, &near_fate);
    /* Is it the solution, or only what the method had made of it? */
    if (!isnan(found.t) && run_solve(&run->system, from, trace_state(run->trace, first),
                                     from + BEYOND * (found.t - from), RUN_SOLVE_STIFF,
                                     RUN_SOLVE_TOL, NULL, run->cancel)) {
        found.t = NAN;
        *fate = SOLUTION_GOES_ON;
    }
    if (near_fate == SOLUTION_GOES_ON && run->plan.adaptive)
        *fate = SOLUTION_GOES_ON;
    return found;
}

bool run_end_singular(struct run *run, struct singularity found)
{
    if (isnan(found.t))
        return false;
    run->stop = STOP_SINGULAR;
    run->singular = found;
    return true;
}

bool run_creeps(struct run *run)
{
    struct run_private *p = run->private_state;
    if (run->steps < p->look)
        return false;
    p->look = 2 * run->steps;
    const double way = run->t - p->epoch[p->epochs - 1].t;
    trace_present(run->trace, run->steps, run->t, run->y);
    if (!(fabs(run->controller.h) < RUN_CREEP * fabs(way)) ||
        isnan(singular_by_steps(run, &hint).t))
        return false;
    const struct singularity found = run_singular_before(
        run, run->t, run->t + copysign(AHEAD * way, run->controller.h), run->steps);
    if (cancelled(run->cancel)) /* not known: the look is repeated */
        p->look = run->steps;
    return run_end_singular(run, found);
}

static void diagnose_failure(struct run *run)
{
    const size_t row = run_own_start(run);
    const double from = trace_time(run->trace, row), way = run->t - from;
    const double ahead = AHEAD * fabs(way) + (run->plan.adaptive ? 0 : 16 * run->settings.dt);
    const bool back = run->plan.adaptive ? run->controller.h < 0 : trace_grid(run->trace)->h < 0;
    struct singularity found =
        run_singular_before(run, run->t, run->t + (back ? -ahead : ahead), STEPS_MOST);
    if (isnan(found.t) && run->plan.adaptive && run->private_state->fate == SOLUTION_UNKNOWN)
        found = singular_by_steps(run, &sure);
    run_end_singular(run, found);
}

void run_diagnose(struct run *run)
{
    const bool failed =
        run->stop == STOP_DIVERGED || run->stop == STOP_STALLED || run->stop == STOP_NO_SOLUTION;
    run->private_state->fate = SOLUTION_UNKNOWN;
    if (!failed)
        run_check_first_steps(run);
    if (run->stop == STOP_SINGULAR || run_is_never_singular(&run->system))
        return;
    if (!run->plan.adaptive && run->steps > 0 && run_went_across(run))
        return;
    if (failed)
        diagnose_failure(run);
}
