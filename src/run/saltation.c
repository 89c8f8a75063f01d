/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Response of events, and of the jumps that they cause, to a change of the state, for the second
 * solution of opinion.c. A solution that is off by d meets an event later by dt = -(grad g . d) /
 * (dg/dt), jumps from there, and is off by what it moved in between with the other velocity (the
 * saltation matrix; Aizerman, Gantmakher 1958, J. Appl. Math. Mech. 22:1065; Leine, Nijmeijer 2004,
 * Dynamics and Bifurcations of Non-Smooth Mechanical Systems, chapter 7). */
#include <hooke/scene/formula.h>

#include "run/event/watch.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* Distance of the two values of a central difference, as a fraction of a variable's size: the cube
 * root of the rounding error, a compromise of rounding and curvature. */
static const double difference = 6e-6;

void responses_free(struct responses *all)
{
    free(all->response);
    free(all->slope);
}

/* Returns the derivatives [n + 1] of response i by the variables and by time. */
static double *response_slopes(const struct run *run, size_t i)
{
    return run->private_state->responses.slope + i * (2 * (size_t)run->system.n + 1);
}

/* Returns the state [n] to which the derivatives of response i belong; for a jump that before
 * it. */
static const double *response_state(const struct run *run, size_t i)
{
    return response_slopes(run, i) + run->system.n + 1;
}

/* Appends a response with unknown derivatives, at this state [n]. Returns false if out of
 * memory. */
static bool response_append(struct run *run, const struct response *response, const double *state)
{
    struct responses *all = &run->private_state->responses;
    const int n = run->system.n;
    size_t capacity = all->capacity;
    if (!array_reserve(&all->response, sizeof *all->response, all->count, &capacity) ||
        !array_reserve(&all->slope, (2 * (size_t)n + 1) * sizeof *all->slope, all->count,
                       &all->capacity))
        return false;
    all->response[all->count++] = *response;
    double *slope = response_slopes(run, all->count - 1);
    for (int i = 0; i <= n; i++)
        slope[i] = NAN;
    copy_state(slope + n + 1, state, n);
    return true;
}

/* Records the jump; the caller sets its derivatives by run_set_jump_slopes(). */
bool responses_add_jump(struct run *run, int variable, double previous_value)
{
    double state[LIMIT_VARIABLES];
    if (!run->plan.adaptive)
        return true;
    copy_state(state, run->y, run->system.n);
    state[variable] = previous_value;
    return response_append(run, &(struct response){run->steps, run->t, run->y[variable], variable},
                           state);
}

void run_set_jump_slopes(struct run *run, const double *slope)
{
    const struct responses *all = &run->private_state->responses;
    if (all->count > 0 && all->response[all->count - 1].step == run->steps)
        memcpy(response_slopes(run, all->count - 1), slope,
               ((size_t)run->system.n + 1) * sizeof *slope);
}

/* Sets slope [n + 1] to the derivatives of the event's function by the n variables and by the time,
 * by central differences at time t and `state`. A function that jumps there has no derivative: if
 * it depends on one of them alone, the difference still tells how the moment of the event shifts;
 * otherwise all are NAN. */
static void find_moment_slopes(struct run *run, const struct watched *watched, double t,
                               const double *state, double *slope)
{
    struct event_watch *watch = run->private_state->watch;
    const int n = run->system.n;
    const double h = watch->path.inside.h;
    double y[LIMIT_VARIABLES], f[LIMIT_VARIABLES];
    double largest = 0, jump = 0;
    int moving = 0;
    copy_state(y, state, n);
    system_derivative(&run->system, t, y, f);
    const double here = events_watch_value(watch, watched, t, y);
    for (int i = 0; i <= n; i++) {
        const double size = i < n ? fmax(watch->size[i], fabs(h * f[i])) : fabs(h);
        const double rounding = i < n ? 0 : 4 * DBL_EPSILON * fabs(t) / difference;
        const double step = difference * (size > 0 ? fmax(size, rounding) : 1);
        double value[2];
        for (int side = 0; side < 2; side++) {
            const double shift = side ? step : -step;
            if (i < n)
                y[i] = state[i] + shift;
            value[side] = events_watch_value(watch, watched, i < n ? t : t + shift, y);
        }
        if (i < n)
            y[i] = state[i];
        slope[i] = (value[1] - value[0]) / (2 * step);
        moving += slope[i] != 0;
        largest = fmax(largest, fabs(value[1] - value[0]));
        jump = fmax(jump, fabs(value[1] - 2 * here + value[0]));
    }
    for (int i = 0; i <= n && moving > 1 && jump > largest / 2; i++)
        slope[i] = NAN;
}

/* Appends a response of an event, given by its index in the watch, with the derivatives of the
 * event's function at the state. Returns false if out of memory. */
static bool add_event_response(struct run *run, int event, const struct response *response,
                               const double *state)
{
    const struct watched *watched = &run->private_state->watch->event[event];
    if (!response_append(run, response, state))
        return false;
    find_moment_slopes(run, watched, response->t, state,
                       response_slopes(run, run->private_state->responses.count - 1));
    return true;
}

/* Records the event that stopped the run, with the second derivative of its function. */
bool responses_add_moment(struct run *run, int event)
{
    struct event_watch *watch = run->private_state->watch;
    const double h = watch->path.inside.h,
                 theta = fmin(fmax((run->t - watch->path.inside.t) / h, 0), 1);
    const struct interval bend =
        events_watch_bounds(watch, &watch->event[event], theta, theta).bend;
    const double mean = (bend.lo / 2 + bend.hi / 2) / (h * h);
    return add_event_response(run, event,
                              &(struct response){.step = run->steps,
                                                 .t = run->t,
                                                 .value = isfinite(mean) ? mean : 0,
                                                 .variable = RESPONSE_MOMENT},
                              run->y);
}

/* Records an event that nearly happened, with the value of its function there. */
bool responses_add_miss(struct run *run, int event, double theta)
{
    struct event_watch *watch = run->private_state->watch;
    const double t = path_time(&watch->path, theta);
    double y[LIMIT_VARIABLES];
    path_state(&watch->path, theta, y);
    return add_event_response(
        run, event,
        &(struct response){.step = run->steps,
                           .t = t,
                           .value = events_watch_value(watch, &watch->event[event], t, y),
                           .variable = RESPONSE_MISS},
        y);
}

/* Looks for a response at the present time that depends on a variable. */
bool responses_moment_moves(const struct run *run)
{
    const struct responses *all = &run->private_state->responses;
    bool moves = false;
    for (size_t i = all->count; i > 0 && all->response[i - 1].t == run->t; i--)
        for (int k = 0; k < run->system.n && all->response[i - 1].variable == RESPONSE_MOMENT; k++)
            moves = moves || response_slopes(run, i - 1)[k] != 0;
    return moves;
}

void responses_truncate(struct run *run)
{
    struct responses *all = &run->private_state->responses;
    while (all->count > 0 && all->response[all->count - 1].step > run->steps)
        all->count--;
}

/* ---- along the second solution ---- */

/* Returns sum_i slope_i (y_i - state_i) + slope_n moved: how much the event's function, or the
 * value after a jump, differs for a solution that is at y [n] and `moved` [s] later. */
static double response_difference(const struct run *run, size_t i, const double *y, double moved)
{
    const double *slope = response_slopes(run, i), *state = response_state(run, i);
    const int n = run->system.n;
    double sum = moved != 0 || isnan(slope[n]) ? slope[n] * moved : 0;
    for (int k = 0; k < n; k++)
        sum += slope[k] * (y[k] - state[k]);
    return sum;
}

/* Returns the possible error of the event's function of response i: each variable counts with the
 * largest distance that the solution has had so far, as the present one may be small by chance. */
static double function_error(const struct run *run, const struct saltation *saltation, size_t i,
                             const double *y)
{
    const double *slope = response_slopes(run, i), *state = response_state(run, i);
    double sum = 0;
    for (int k = 0; k < run->system.n; k++)
        if (slope[k] != 0)
            sum += fabs(slope[k]) * fmax(fabs(y[k] - state[k]), saltation->reach[k]);
    return sum;
}

/* Returns by how much later [s] the solution at y meets the event of response i, from the first and
 * second derivatives of the function along the motion. Returns NAN if the function has so small a
 * slope that, within the errors, it may not reach 0. */
static double moment_moved(const struct run *run, const struct saltation *saltation,
                           const struct system *system, size_t i, const double *y)
{
    static const double bent = 0.3; /* share of rate^2: errors twice as large still meet it */
    const double *slope = response_slopes(run, i), *state = response_state(run, i);
    const struct response *response = &run->private_state->responses.response[i];
    const int n = run->system.n;
    double f[LIMIT_VARIABLES], rate = slope[n];
    system_derivative(system, response->t, state, f);
    for (int k = 0; k < n; k++)
        rate += slope[k] * f[k];
    const double exact = response_difference(run, i, y, 0), bend = response->value;
    if (exact == 0 && rate == 0)
        return 0;
    /* The moment itself is rounded. */
    const double deviation = exact + copysign(DBL_EPSILON * fabs(response->t * rate), exact);
    if (!(2 * fabs(bend) * function_error(run, saltation, i, y) <= bent * rate * rate))
        return NAN;
    return -2 * deviation / (rate + copysign(sqrt(rate * rate - 2 * bend * deviation), rate));
}

/* Moves y [n] along the motion over sign times the time between the two moments (midpoint rule). */
static void saltation_shift(const struct saltation *saltation, const struct system *system,
                            double sign, double *y)
{
    double f[LIMIT_VARIABLES], middle[LIMIT_VARIABLES];
    const double shift = sign * saltation->moved;
    if (saltation->moved == 0)
        return;
    system_derivative(system, saltation->t, y, f);
    for (int i = 0; i < system->n; i++)
        middle[i] = y[i] + shift / 2 * f[i];
    system_derivative(system, saltation->t + shift / 2, middle, f);
    for (int i = 0; i < system->n; i++)
        y[i] += shift * f[i];
}

void saltation_note(struct saltation *saltation, int n, const double *run_state, const double *y)
{
    for (int i = 0; i < n; i++)
        saltation->reach[i] = fmax(saltation->reach[i], fabs(y[i] - run_state[i]));
}

/* Returns the next event that the run nearly met, up to the state after `step`, or NULL. */
const struct response *saltation_next_miss(const struct run *run, struct saltation *saltation,
                                           int64_t step)
{
    const struct responses *all = &run->private_state->responses;
    while (saltation->miss < all->count && all->response[saltation->miss].variable != RESPONSE_MISS)
        saltation->miss++;
    const bool due = saltation->miss < all->count && all->response[saltation->miss].step <= step;
    return due ? &all->response[saltation->miss] : NULL;
}

/* Decides by the errors of the event's function whether this solution may have met the event. */
bool saltation_pass_miss(const struct run *run, struct saltation *saltation, const double *y)
{
    static const double margin = 3; /* factor on errors, which are estimates */
    const size_t i = saltation->miss++;
    const struct response *miss = &run->private_state->responses.response[i];
    if (margin * function_error(run, saltation, i, y) < fabs(miss->value))
        return true;
    saltation->lost = miss->t;
    return false;
}

/* Finds by how much later this solution meets the event, and moves y to that time. */
bool saltation_enter(const struct run *run, struct saltation *saltation,
                     const struct system *system, double t, double *y)
{
    const struct responses *all = &run->private_state->responses;
    const double ahead = run->t - run->system.t0;
    if (!saltation->begun || saltation->t != t) {
        saltation->begun = true;
        saltation->t = t;
        saltation->moved = 0;
        while (saltation->next < all->count && (all->response[saltation->next].t - t) * ahead < 0)
            saltation->next++;
        const size_t i = saltation->next;
        if (i < all->count && all->response[i].t == t &&
            all->response[i].variable == RESPONSE_MOMENT) {
            saltation->moved = moment_moved(run, saltation, system, i, y);
            saltation_note(saltation, system->n, response_state(run, i), y);
            saltation->lost = isnan(saltation->moved) ? t : saltation->lost;
        }
    }
    saltation_shift(saltation, system, 1, y);
    return isfinite(saltation->moved);
}

/* Returns the typical rounding error of the value of jump i: a fraction of the value or of the
 * sum of its terms' magnitudes, if that is larger. Returns 0 if the value does not depend on the
 * state. */
static double jump_rounding(const struct run *run, size_t i)
{
    static const double typical = DBL_EPSILON / 4;
    const double *slope = response_slopes(run, i), *state = response_state(run, i);
    double sum = 0;
    for (int k = 0; k < run->system.n; k++)
        sum += slope[k] != 0 ? fabs(slope[k] * state[k]) : 0;
    const double value = fabs(run->private_state->responses.response[i].value);
    return sum > 0 ? typical * fmax(sum, value) : 0;
}

/* Adds the difference that the derivatives of the jump give to the run's value after it. */
bool saltation_jump(const struct run *run, const struct saltation *saltation, int64_t step,
                    double *y)
{
    const struct responses *all = &run->private_state->responses;
    for (size_t i = saltation->next; i < all->count && all->response[i].step <= step; i++) {
        const struct response *response = &all->response[i];
        if (response->step != step || response->variable < 0)
            continue;
        /* Both solutions are rounded alike, so their difference would not contain the rounding
         * error, which matters for a map that magnifies errors: it is added. */
        const double deviation = response_difference(run, i, y, saltation->moved);
        y[response->variable] =
            response->value + deviation + copysign(jump_rounding(run, i), deviation);
        return isfinite(y[response->variable]);
    }
    return false;
}

void saltation_leave(const struct saltation *saltation, const struct system *system, double *y)
{
    saltation_shift(saltation, system, -1, y);
}
