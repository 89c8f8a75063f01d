/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Switches in adaptive steps: the end of a step. A step is taken on frozen branches, on which
 * everything is smooth. If the guard of a branch (an expression that is positive while the branch
 * holds) falls below 0, the step is taken again up to that point, and the next one begins on the
 * other branch. If both branches lead back to the switch, the motion slides along it until one of
 * them leads away. If switches follow each other in ever shorter times they pile up, and the motion
 * slides along all of them.
 */
#include <hooke/scene/typed.h>
#include "method/control/switch.h"

#include <float.h>

/* Number of equal parts of a step at which a guard is tested for a value below 0. */
#define GUARD_CHECKS 8
#define SWITCH_STEPS_MAX 12 /* Steps towards a switch; two or three are usually enough. */
/* A switch within this part of (tolerance times step) is where the step ends. */
#define SWITCH_DISTANCE_MAX 1e-3
/* Part of the planned step ahead at which a guard's direction is evaluated. */
#define PROBE_STEP_FRACTION 1e-4
/* Number of switches whose total time is compared with that of the previous block. */
#define PILE_BLOCK_SWITCHES 16
/* Switches pile up if this many blocks in a row are each much shorter than the one before. */
#define PILE_BLOCKS 4
/* A block is much shorter if it takes less than this part of the previous one's time. */
#define PILE_SHRINK_MAX 0.1
/* Switches also pile up if a block takes less than this part of t. */
#define PILE_TIME_RELATIVE 1e-12
/* [ulp of t] In a step as short as this, a guard that begins at 0 may stay below it by rounding. */
#define BRIEF_ULPS 64
/* Speed, as a part of the natural one, below which a turning point is near. */
#define TURNING_SPEED 0.05
/* A step without a turning point may deviate from its mean speed by this part of its length. */
#define MEAN_SPEED_TOLERANCE 0.1

/* A step from y_begin at t over h, in which ends of branches are searched. */
struct switch_search {
    const struct method *method;
    struct step *step; /* its y is the state at the end */
    const double *y_begin;
    double t, h; /* [s] */
};

/* Computes the state at t + theta h by a shorter step, for methods of high order without dense
 * output, since a cubic through the ends is too inaccurate for them. Returns false if the dense
 * output or the cubic is to be used, or if the step fails. */
static bool state_by_shorter_step(const struct switch_search *search, double theta, double *y)
{
    const struct method *method = search->method;
    /* order 0 means that the method is exact */
    const bool cubic = method->order > 0 && method->order <= 4;
    if (method->dense || cubic || method->flags & METHOD_MULTISTEP || theta <= 0)
        return false;
    struct step part = *search->step;
    memcpy(y, search->y_begin, (size_t)part.system->n * sizeof *y);
    part.y = y;
    part.t = search->t;
    part.h = theta * search->h;
    part.error = part.low = NULL;
    part.warm = false;
    part.again = true;
    const bool fine = method_step(method, &part) == STEP_OK;
    search->step->cost = part.cost;
    search->step->warm = false; /* work holds values of the shorter step */
    return fine;
}

/* Computes all guards at t + theta h. */
static void guards_at(const struct switch_search *search, double theta, double *guard)
{
    double y[LIMIT_VARIABLES];
    if (theta >= 1)
        memcpy(y, search->step->y, (size_t)search->step->system->n * sizeof *y);
    else if (!state_by_shorter_step(search, theta, y))
        method_dense(search->method, search->step, search->y_begin, theta, y);
    system_guards(search->step->system, search->t + theta * search->h, y, guard);
}

/* Returns guard i at t + theta h. */
static double guard_at(const struct switch_search *search, int i, double theta)
{
    double guard[LIMIT_SWITCHES];
    guards_at(search, theta, guard);
    return guard[i];
}

/* Context of guard_function(). */
struct one_guard {
    const struct switch_search *search;
    int i;
};

/* Returns one guard at t + theta h, for root_between(); 0 counts as positive, since a branch still
 * holds there. */
static double guard_function(void *context, double theta)
{
    const struct one_guard *one = context;
    const double guard = guard_at(one->search, one->i, theta);
    return guard == 0 ? DBL_MIN : guard; /* a branch holds up to there */
}

/* Returns the zero of the guard between a, where it is above 0, and b, where it is below. */
static double guard_root(const struct switch_search *search, int i, double a, double fa, double b,
                         double fb)
{
    struct one_guard one = {search, i};
    return root_between(guard_function, &one, a, fa, b, fb, DBL_EPSILON);
}

/* Returns a point before theta where guard i is positive, or theta if none was found. */
static double point_inside_branch(const struct switch_search *search, int i, double theta)
{
    double x = theta / 2;
    while (x > 1e-12 && !(guard_at(search, i, x) > 0))
        x /= 4;
    return x > 1e-12 ? x : theta;
}

/* Searches the minimum of a guard that is positive at m - apart, m and m + apart (values fa, fm,
 * fb), lowest at m, by parabolas. Returns a point where the guard is negative, or NAN if there is
 * none. */
static double guard_minimum(const struct switch_search *search, int i, double m, double apart,
                            double fa, double fm, double fb)
{
    for (int k = 0; k < 6; k++) {
        const double curve = fa - 2 * fm + fb,
                     x = curve > 0 ? m + apart / 2 * (fa - fb) / curve : m;
        const double f = guard_at(search, i, x);
        if (f < 0)
            return x;
        if (!(fm - (fa - fb) * (fa - fb) / (8 * curve) < 0.1 * fm))
            return NAN;
        apart /= 4;
        m = fmin(fmax(x, apart), 1 - apart);
        fm = guard_at(search, i, m);
        fa = guard_at(search, i, m - apart);
        fb = guard_at(search, i, m + apart);
        if (fm < 0)
            return m;
        if (fa < 0 || fb < 0)
            return fa < 0 ? m - apart : m + apart;
    }
    return NAN;
}

/* Returns the first point (0 to 1) of the step where guard i falls below 0, or 2 if it does not;
 * guard holds its values at GUARD_CHECKS + 1 points. A branch begins within rounding of its switch,
 * perhaps before it: while its guard rises from there, in a step as short as rounding, the branch
 * has not ended. */
static double first_branch_end(const struct switch_search *search, int i,
                               double (*guard)[LIMIT_SWITCHES])
{
    bool ahead = guard[0][i] < 0 && fabs(search->h) <= BRIEF_ULPS * DBL_EPSILON * fabs(search->t);
    for (int k = 1; k <= GUARD_CHECKS; k++) {
        const double a = (double)(k - 1) / GUARD_CHECKS, b = (double)k / GUARD_CHECKS,
                     fa = guard[k - 1][i], fb = guard[k][i];
        ahead = ahead && fb < 0 && fb >= fa;
        if (fb < 0 && !ahead) {
            const double bracket_begin = fa > 0 && k > 1 ? a : point_inside_branch(search, i, b);
            return bracket_begin == b ? 0
                                      : guard_root(search, i, bracket_begin,
                                                   guard_at(search, i, bracket_begin), b, fb);
        }
        const bool lowest = k < GUARD_CHECKS && fb < fa && fb < guard[k + 1][i];
        const double low =
            lowest && guard[k + 1][i] >= 0
                ? guard_minimum(search, i, b, 1. / GUARD_CHECKS, fa, fb, guard[k + 1][i])
                : NAN;
        if (!isnan(low)) {
            double bracket_begin;
            if (low > b)
                bracket_begin = b;
            else
                bracket_begin = a > 0 ? a : point_inside_branch(search, i, low);
            return guard_root(search, i, bracket_begin, guard_at(search, i, bracket_begin), low,
                              guard_at(search, i, low));
        }
    }
    return 2;
}

/* Takes the step again over x [s]. Sets *guard to guard i at its end. */
static enum step_status retake_step(const struct switch_search *search, struct step *step,
                                    const double *low, double x, int i, double *guard)
{
    const size_t size = (size_t)step->system->n * sizeof *step->y;
    memcpy(step->y, search->y_begin, size);
    if (step->low)
        memcpy(step->low, low, size);
    step->t = search->t;
    step->h = x;
    step->warm = false;
    step->again = true;
    const enum step_status status = method_step(search->method, step);
    double all[LIMIT_SWITCHES] = {0};
    if (status == STEP_OK)
        system_guards(step->system, search->t + x, step->y, all);
    *guard = all[i];
    return status;
}

/* Returns true if no branch can end in the step, because dry friction is the only switch and the
 * velocity is far from 0 throughout. */
static bool cannot_switch(const struct system *system, double h, const double *y_begin,
                          const double *y)
{
    const double v0 = y_begin[1], v1 = y[1], min = fmin(fabs(v0), fabs(v1)),
                 mean = h * (v0 + v1) / 2;
    return system->dry && system->switches == 1 && !system->sliding && v0 * v1 > 0 &&
           min > fmax(TURNING_SPEED * system->scale[1], fabs(v1 - v0)) &&
           fabs(y[0] - y_begin[0] - mean) <= MEAN_SPEED_TOLERANCE * fabs(mean);
}

/* Ends a step at the first branch that ends in it: takes the step again over secant estimates of
 * that time until the guard is 0 within the tolerance. */
enum step_status switch_step(const struct method *method, struct step *step, double t,
                             const double *y_begin, const double *low, int *ended)
{
    const struct switch_search search = {method, step, y_begin, t, step->h};
    const int count = step->system->switches;
    double guard[GUARD_CHECKS + 1][LIMIT_SWITCHES], theta = 2;
    *ended = -1;
    if (cannot_switch(step->system, step->h, y_begin, step->y))
        return STEP_OK;
    system_guards(step->system, t, y_begin, guard[0]);
    for (int k = 1; k <= GUARD_CHECKS; k++)
        guards_at(&search, (double)k / GUARD_CHECKS, guard[k]);
    for (int i = 0; i < count; i++) {
        const double root_theta = first_branch_end(&search, i, guard);
        if (root_theta < theta) {
            theta = root_theta;
            *ended = i;
        }
    }
    if (*ended < 0)
        return STEP_OK;
    const double h = step->h, ulps = 2 * DBL_EPSILON * fmax(fabs(t), fabs(t + h));
    const double tolerance = fmax(ulps, SWITCH_DISTANCE_MAX * step->tol * fabs(h));
    const double ahead = fmin(1, theta + 1e-3), rise = (guard_at(&search, *ended, ahead) -
                                                        guard_at(&search, *ended, ahead - 2e-3)) /
                                                       (2e-3 * h);
    double x = theta * h, slope = rise, last_x = NAN, last = NAN;
    if (!(fabs(x) >
          ulps)) /* the branch ends at once: the step is as short as rounding, so that t moves */
        x = copysign(2 * ulps, h);
    for (int k = 0; k < SWITCH_STEPS_MAX; k++) {
        double value;
        const enum step_status status = retake_step(&search, step, low, x, *ended, &value);
        if (status != STEP_OK)
            return status;
        if (!isnan(last) && last != value)
            slope = (value - last) / (x - last_x);
        const double move = slope != 0 ? -value / slope : 0;
        if (!(fabs(move) > tolerance) || !((x + move) / h > 0) ||
            fabs(x + move) > 2 * fabs(theta * h) + ulps)
            break;
        last_x = x;
        last = value;
        x += move;
    }
    return STEP_OK;
}

/* ---- between two steps ---- */

/* Tests the derivative only for equations that are undefined beyond a switch. */
bool switch_is_there(struct step *step)
{
    double rate[LIMIT_VARIABLES];
    bool there = true;
    if (!step->system->extended)
        return true;
    step->cost.evals++;
    system_derivative(step->system, step->t, step->y, rate);
    for (int i = 0; i < step->system->n; i++)
        there = there && isfinite(rate[i]);
    return there;
}

/* Notes an accepted step: chooses the branch on the other side of the switch that ended it, and
 * counts switches to recognise piling up. */
void switch_next(struct step *step, struct switches_state *state, int ended)
{
    memcpy(state->taken, state->branch, sizeof state->taken);
    memcpy(state->slid_along, state->slides_along, sizeof state->slid_along);
    state->t = step->t;
    state->begins = ended >= 0;
    state->fresh = ended;
    state->released = -1;
    switch_go_back(step, step->system);
    if (ended < 0)
        return;
    system_end_at_switch(step->system, ended, step->y);
    double y[LIMIT_VARIABLES], f[LIMIT_VARIABLES];
    system_derivative(step->system, step->t, step->y, f);
    /* the direction of the motion decides if the branch of a rounding function goes up or down */
    for (int i = 0; i < step->system->n; i++)
        y[i] = step->y[i] + PROBE_STEP_FRACTION * step->h * f[i];
    state->branch[ended] =
        system_next_branch(step->system, ended, step->t + PROBE_STEP_FRACTION * step->h, y);
    if (state->slides_along[ended])
        state->released = ended;
    state->slides_along[ended] = false;
    state->recent[ended] = true;
    if (++state->count % PILE_BLOCK_SWITCHES != 0)
        return;
    const double passed = fabs(step->t - state->t_block);
    state->shorter = passed < PILE_SHRINK_MAX * state->block ? state->shorter + 1 : 0;
    state->piled = state->shorter >= PILE_BLOCKS - 1 || passed < PILE_TIME_RELATIVE * fabs(step->t);
    state->t_block = step->t;
    state->block = passed;
    for (int i = 0; i < step->system->switches && !state->piled; i++)
        state->recent[i] = false;
}

/* Returns the system on the branches of the last adaptive step, in *frozen, or the system
 * itself. */
const struct system *method_adapted(const struct system *system,
                                    const struct controller *controller, struct sliding *sliding,
                                    struct system *frozen)
{
    const struct switches_state *state = &controller->switches;
    if (system->switches == 0 || !state->known)
        return system;
    const bool fine =
        system_slide(system, state->taken, state->slid_along, state->slide_step, sliding, frozen);
    return fine ? frozen : system;
}
