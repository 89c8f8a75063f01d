/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Finite-time singularities: solutions that go to infinity at a finite time t*, like x = 1/(t* - t) of x' = x^2.
 *
 * The equations are integrated once more, by an accurate adaptive method, from where they last had a start of their
 * own. Before a singularity its steps shrink in proportion to t* - t until they are lost in the rounding of t, which
 * puts its end within some ulps of t*; there the speed |y'| has to grow like a power of 1/(t* - t) over decades
 * (Goriely, Hyde 2000, J. Differ. Equ. 161:422). A method that is unstable fails where the solution itself goes on, and
 * what grows exponentially has no such time.
 */
#include "private.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#define TOL 1e-11
#define STEPS_MOST 20000
#define LAST 256      /* steps that are looked at */
#define ULPS 1e3      /* of t*: what is nearer is rounding */
#define NEAR 1e-6     /* of the time since the start: the nearest state has to be at least that close to t* */
#define DECADES 3.0   /* of t* - t over which the power holds */
#define POINTS 8
#define POWER_LEAST 0.3
#define AHEAD 0.1   /* of the time since the start: a method may fail that much earlier */
#define SCATTER 0.1 /* rms of log |y'| about the line */

struct approach {
    double t[LAST], speed[LAST];
    int64_t count;
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
                         struct approach *approach)
{
    const struct method *method =
        (const struct method *)(const void *)catalog_find(&method_catalog, TEXT("dop853"));
    double state[LIMIT_VARIABLES], *work = method ? malloc((method_work_size(method, system->n) + 1) * sizeof *work)
                                                  : NULL;
    struct step step = {.system = system, .y = state, .work = work, .t = *t};
    struct controller controller = {.tol = TOL};
    approach->count = 0;
    if (!work)
        return false;
    memcpy(state, y, (size_t)system->n * sizeof *state);
    bool moves = true;
    while (moves && step.t != end && approach->count < STEPS_MOST) {
        const int64_t place = approach->count % LAST;
        approach->t[place] = step.t;
        approach->speed[place] = speed_of(system, step.t, state);
        moves = isfinite(approach->speed[place]) &&
                method_adapt(method, &step, &controller, end) == STEP_OK && step.t != approach->t[place];
        approach->count++;
    }
    free(work);
    *t = step.t;
    return !moves;
}

struct line {
    double n, x, y, xx, xy, yy; /* sums */
};

/* log |y'| over log (at - t), where that is from low to high [s] */
static struct line line_over(const struct approach *approach, double at, double low, double high)
{
    struct line sum = {0};
    for (int64_t i = 0; i < approach->count && i < LAST; i++) {
        const double before = fabs(at - approach->t[i]), x = log(before), y = log(approach->speed[i]);
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

/* Whether |y'| ~ (at - t)^-q, q > POWER_LEAST, as near to it as t can tell. */
static bool is_singular(const struct approach *approach, double start, double at)
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
        if (before <= low * pow(10, 2 * DECADES)) /* farther away other things matter */
            high = fmax(high, before);
    }
    const struct line sum = line_over(approach, at, low, high);
    const double xx = sum.xx - sum.x * sum.x / sum.n, xy = sum.xy - sum.x * sum.y / sum.n,
                 yy = sum.yy - sum.y * sum.y / sum.n;
    return sum.n >= POINTS && low <= NEAR * fabs(at - start) && high >= low * pow(10, DECADES) &&
           -xy / xx > POWER_LEAST && sqrt(fmax(0, yy - xy * xy / xx) / sum.n) < SCATTER;
}

/* Natural sizes may have been taken from a solution on its way to infinity: at most those of where it starts. */
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

double system_singularity(const struct system *system, double t, const double *y, double end)
{
    struct approach *approach = system->linear ? NULL : malloc(sizeof *approach);
    const struct system scaled = with_start_scale(system, y);
    double at = t;
    const bool found = approach && approach_end(&scaled, &at, y, end, approach) && is_singular(approach, t, at);
    free(approach);
    return found ? at : NAN;
}

/* The first recorded state since its equations or its state were last changed from outside. */
static size_t own_start(const struct run *run)
{
    const struct run_private *p = run->private_state;
    int64_t step = p->epoch[p->epochs - 1].first;
    size_t row = 0;
    if (p->kicks > 0 && p->kick[p->kicks - 1].step > step)
        step = p->kick[p->kicks - 1].step;
    while (row + 1 < trace_count(run->trace) && (trace_step(run->trace, row) < step ||
                                                 (p->kicks > 0 && trace_step(run->trace, row + 1) == step)))
        row++;
    return row;
}

void run_diagnose(struct run *run)
{
    if (run->stop != STOP_DIVERGED && run->stop != STOP_STALLED && run->stop != STOP_NO_SOLUTION)
        return;
    const size_t row = own_start(run);
    const double from = trace_time(run->trace, row), way = run->t - from;
    const double ahead = AHEAD * fabs(way) + (run->plan.adaptive ? 0 : 16 * run->settings.dt);
    const bool back = run->plan.adaptive ? run->controller.h < 0 : trace_grid(run->trace)->h < 0;
    const double at = system_singularity(&run->system, from, trace_state(run->trace, row), run->t + (back ? -ahead : ahead));
    if (isnan(at))
        return;
    run->stop = STOP_SINGULAR;
    run->singular = at;
}
