/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Finite-time singularities: solutions that go to infinity at a finite time t*, like x = 1/(t* - t)
 * of x' = x^2.
 *
 * The equations are integrated once more, by an accurate adaptive method, from where they last had
 * a start of their own. Before a singularity its steps shrink in proportion to t* - t until they
 * are lost in the rounding of t, which puts its end within some ulps of t*; there the speed |y'|
 * has to grow like a power of 1/(t* - t) over decades (Goriely, Hyde 2000, J. Differ. Equ.
 * 161:422). A method that is unstable fails where the solution itself goes on, and what grows
 * exponentially has no such time.
 */
#include <hooke/base/elementary.h>

#include "run/private.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#define TOL 1e-11
#define STEPS_MOST 20000
#define LAST 256 /* steps that are looked at */
#define ULPS 1e3 /* of t*: what is nearer is rounding */
/* of the time since the start: the nearest state has to be at least that close to t* */
#define NEAR 1e-6
#define DECADES 3.0 /* of t* - t over which the power holds */
#define POINTS 8
#define POWER_MIN 0.3
#define AHEAD 0.1         /* of the time since the start: a method may fail that much earlier */
#define SCATTER 0.1       /* rms of log |y'| about the line */
#define POWER_FINITE 0.95 /* |y'| may be integrated up to there: y stays finite */
#define SHORTLY 1e-3      /* of that time */
/* of the accurate method, where a step looks strange; and two for each step of the run */
#define STEPS_FIRST 1000
#define ROWS_LOOKED 4096 /* of an explicit method, whose step costs no more than a look */
#define CHANGE_MIN 0.1   /* of y in a step: less is passed over */
#define STEEPER 8        /* times: the slope after a step that grows without bound */
#define OFF 0.1          /* of y: what a step and the mean of its slopes, or these, may differ by */
#define STEPS_BEYOND 16  /* where a step looks strange: a method may pass too early, or soon */
/* times the time to a singularity: who gets there in another way has shown that it is none */
#define BEYOND 1.01
#define LOOK_EACH 512 /* steps and rows between two looks at the flag of Ctrl-C */

struct approach {
    double t[LAST], speed[LAST];
    int64_t count;
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

/* Goes on until `end` or until no step is possible. True: the latter; *t is then where. */
static bool approach_end(const struct system *system, double *t, const double *y, double end,
                         int64_t max, struct approach *approach)
{
    const struct method *method = method_find("dop853");
    double state[LIMIT_VARIABLES],
        *work = method ? malloc((method_work_size(method, system->n) + 1) * sizeof *work) : NULL;
    struct step step = {.system = system, .y = state, .work = work, .t = *t};
    struct controller controller = {.tol = TOL};
    approach->count = 0;
    if (!work)
        return false;
    memcpy(state, y, (size_t)system->n * sizeof *state);
    bool moves = true;
    while (moves && step.t != end && approach->count < max) {
        if (approach->count % LOOK_EACH == 0 && cancelled(approach->cancel))
            break;
        const int64_t index = approach->count % LAST;
        approach->t[index] = step.t;
        approach->speed[index] = speed_of(system, step.t, state);
        moves = isfinite(approach->speed[index]) &&
                method_adapt(method, &step, &controller, end) == STEP_OK &&
                step.t != approach->t[index];
        approach->count++;
    }
    free(work);
    *t = step.t;
    return !moves && !cancelled(approach->cancel);
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

/* The q of |y'| ~ (at - t)^-q, as near to it as t can tell; NAN: q <= POWER_MIN, or it is not such
 * a power. */
static double power_of(const struct approach *approach, double start, double at)
{
    const double ulps = ULPS * (nextafter(fabs(at), HUGE_VAL) - fabs(at));
    double low = HUGE_VAL, high = 0;
    for (int64_t i = 0; i < approach->count && i < LAST; i++) {
        const double before = fabs(at - approach->t[i]);
        if (before >= ulps)
            low = fmin(low, before);
    }
    for (int64_t i = 0; i < approach->count && i < LAST; i++) {
        const double before = fabs(at - approach->t[i]);
        if (before <= low * fixed_pow(10, 2 * DECADES)) /* farther away other things matter */
            high = fmax(high, before);
    }
    const struct line_sums sum = line_over(approach, at, low, high);
    const double xx = sum.xx - sum.x * sum.x / sum.n, xy = sum.xy - sum.x * sum.y / sum.n,
                 yy = sum.yy - sum.y * sum.y / sum.n;
    const bool is_power = sum.n >= POINTS && low <= NEAR * fabs(at - start) &&
                          high >= low * fixed_pow(10, DECADES) && -xy / xx > POWER_MIN &&
                          sqrt(fmax(0, yy - xy * xy / xx) / sum.n) < SCATTER;
    return is_power ? -xy / xx : NAN;
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

static struct singularity look_for(const struct system *system, double t, const double *y,
                                   double end, int64_t max, const struct cancel *cancel)
{
    struct approach *approach = system->linear ? NULL : malloc(sizeof *approach);
    const struct system scaled = with_start_scale(system, y);
    double at = t, power = NAN;
    if (approach)
        approach->cancel = cancel;
    if (approach && approach_end(&scaled, &at, y, end, max, approach))
        power = power_of(approach, t, at);
    free(approach);
    return (struct singularity){.t = isnan(power) ? NAN : at, .finite = power < POWER_FINITE};
}

struct singularity system_singularity(const struct system *system, double t, const double *y,
                                      double end, const struct cancel *cancel)
{
    return look_for(system, t, y, end, STEPS_MOST, cancel);
}

const char *singularity_text(const struct singularity *singularity)
{
    return singularity->finite ? "ends with an infinite slope" : "goes to infinity";
}

/* ---- runs ---- */

/* The first recorded state since its equations or its state were last changed from outside. */
static size_t own_start(const struct run *run)
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

/*
 * Before `end`, in at most so many steps of the accurate method: from the start, whose solution it
 * is about, and where that is too far away from shortly before t.
 */
static struct singularity singular_before(const struct run *run, double t, double end, int64_t max)
{
    const size_t first = own_start(run);
    const double from = trace_time(run->trace, first);
    struct singularity found =
        look_for(&run->system, from, trace_state(run->trace, first), end, max, run->cancel);
    const size_t near = row_before(run, first, t);
    if (isnan(found.t) && near > first) {
        found = look_for(&run->system, trace_time(run->trace, near), trace_state(run->trace, near),
                         end, max, run->cancel);
        /* Is it the solution, or only what the method had made of it? */
        if (!isnan(found.t) &&
            run_solve(&run->system, from, trace_state(run->trace, first),
                      from + BEYOND * (found.t - from), RUN_SOLVE_STIFF, RUN_SOLVE_TOL, NULL))
            found.t = NAN;
    }
    return found;
}

static bool end_singular(struct run *run, struct singularity found)
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
    if (run->system.linear || !(fabs(run->controller.h) < RUN_CREEP * fabs(way)))
        return false;
    const struct singularity found =
        singular_before(run, run->t, run->t + copysign(AHEAD * way, run->controller.h), run->steps);
    if (cancelled(run->cancel)) /* not known: the look is repeated */
        p->look = run->steps;
    return end_singular(run, found);
}

/* ---- steps across ---- */

/*
 * Does what happened to a variable in a step of h look as if a singularity lay there? Where it
 * passed through infinity it changed against its slope at both ends, or far less than these want,
 * or its sign and that of its slope; where it did not yet, it has grown, and its slope far more.
 */
static bool looks_across(double h, double y, double slope, double middle_slope, double end,
                         double end_slope)
{
    const double change = end - y, size = fmax(fabs(y), fabs(end)),
                 wanted = slope * end_slope > 0 ? h * slope : 0;
    const double min = fmin(fabs(h * slope), fabs(h * end_slope));
    if (!(fabs(change - h * (slope + end_slope) / 2) <= OFF * size) ||
        !(fabs(h * (middle_slope - (slope + end_slope) / 2)) <=
          OFF * size)) /* which a trapezoid does not see */
        return true;
    if (change * wanted < 0 && fabs(change) > CHANGE_MIN * size)
        return true;
    if (wanted != 0 && min > size && fabs(change) < CHANGE_MIN * min)
        return true;
    return fabs(change) > CHANGE_MIN * size &&
           ((y * end < 0 && slope * end_slope < 0) ||
            (fabs(end) > 2 * fabs(y) && fabs(end_slope) > STEEPER * fabs(slope)));
}

/* Rows i and i + 1. */
static bool row_across(const struct run *run, size_t i)
{
    const struct trace *trace = run->trace;
    const double *y = trace_state(trace, i), *end = trace_state(trace, i + 1);
    const double t = trace_time(trace, i), t_end = trace_time(trace, i + 1);
    double slope[LIMIT_VARIABLES], end_slope[LIMIT_VARIABLES], middle[LIMIT_VARIABLES],
        middle_slope[LIMIT_VARIABLES];
    if (trace_step(trace, i + 1) != trace_step(trace, i) + 1 || t_end == t)
        return false;
    system_derivative(&run->system, t, y, slope);
    system_derivative(&run->system, t_end, end, end_slope);
    for (int k = 0; k < run->system.n; k++)
        middle[k] = hermite(0.5, t_end - t, y[k], slope[k], end[k], end_slope[k]);
    system_derivative(&run->system, t + (t_end - t) / 2, middle, middle_slope);
    for (int k = 0; k < run->system.n; k++)
        if (looks_across(t_end - t, y[k], slope[k], middle_slope[k], end[k], end_slope[k]))
            return true;
    return false;
}

/* The rows since the last call: all of them where a step is dear, else at most ROWS_LOOKED. */
static bool went_across(struct run *run)
{
    struct run_private *p = run->private_state;
    const size_t rows = trace_count(run->trace), first = own_start(run);
    if (p->looked >= rows) /* it went back */
        p->looked = p->across = p->unchecked = p->checks = 0;
    size_t i = p->looked > first ? p->looked : first;
    const size_t by = run->method->flags & METHOD_IMPLICIT || run->method->rosenbrock
                          ? 1
                          : 1 + (rows - i) / ROWS_LOOKED;
    p->looked = rows - 1;
    for (; i + 1 < rows; i += by) {
        if (i % (by * LOOK_EACH) < by && cancelled(run->cancel)) {
            p->looked = i; /* the rest next time */
            return false;
        }
        if ((i < p->across && i < p->unchecked) || !row_across(run, i))
            continue;
        if (i >= p->unchecked)
            run_check_step(run, i);
        if (i < p->across)
            continue;
        p->across = 2 * i + 1; /* the next look goes as far as all before together */
        const double t = trace_time(run->trace, i + 1);
        const double beyond = t + STEPS_BEYOND * (t - trace_time(run->trace, i));
        const double end = fabs(run->t - t) < fabs(beyond - t) ? run->t : beyond;
        if (end_singular(run, singular_before(run, trace_time(run->trace, i), end,
                                              STEPS_FIRST + 2 * (int64_t)i)))
            return true;
    }
    return false;
}

static void diagnose_failure(struct run *run)
{
    const size_t row = own_start(run);
    const double from = trace_time(run->trace, row), way = run->t - from;
    const double ahead = AHEAD * fabs(way) + (run->plan.adaptive ? 0 : 16 * run->settings.dt);
    const bool back = run->plan.adaptive ? run->controller.h < 0 : trace_grid(run->trace)->h < 0;
    end_singular(run, singular_before(run, run->t, run->t + (back ? -ahead : ahead), STEPS_MOST));
}

void run_diagnose(struct run *run)
{
    if (run->stop == STOP_SINGULAR || run->system.linear || (run->steps > 0 && went_across(run)))
        return;
    if (run->stop == STOP_DIVERGED || run->stop == STOP_STALLED || run->stop == STOP_NO_SOLUTION)
        diagnose_failure(run);
}
