/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * How events, and the jumps that they cause, answer to another state. A solution that is off by d
 * meets an event later by dt = -(grad g . d) / (dg/dt), jumps from there, and is off by what it
 * moved in between with the other velocity (the saltation matrix; Aizerman, Gantmakher 1958, J.
 * Appl. Math. Mech. 22:1065; Leine, Nijmeijer 2004, Dynamics and Bifurcations of Non-Smooth
 * Mechanical Systems, chapter 7).
 */
#include "run/event/watch.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

/* What a derivative is taken over, as a share of a size: a compromise of rounding and curvature. */
static const double difference = 6e-6;

static bool reserve_response(struct responses *all, int n)
{
    const size_t width = 2 * (size_t)n + 1;
    if (all->count < all->capacity)
        return true;
    const size_t capacity = all->capacity ? 2 * all->capacity : 16;
    struct response *at = realloc(all->at, capacity * sizeof *at);
    all->at = at ? at : all->at;
    double *slope = at ? realloc(all->slope, capacity * width * sizeof *slope) : NULL;
    all->slope = slope ? slope : all->slope;
    if (!slope)
        return false;
    all->capacity = capacity;
    return true;
}

void responses_free(struct responses *all)
{
    free(all->at);
    free(all->slope);
}

static double *slopes_of(const struct run *run, size_t i)
{
    return run->private_state->responses.slope + i * (2 * (size_t)run->system.n + 1);
}

/* Returns the state to which response i belongs, before the jump. */
static const double *state_of(const struct run *run, size_t i)
{
    return slopes_of(run, i) + run->system.n + 1;
}

static bool add_response(struct run *run, const struct response *response, const double *state)
{
    struct responses *all = &run->private_state->responses;
    const int n = run->system.n;
    if (!reserve_response(all, n))
        return false;
    all->at[all->count++] = *response;
    double *slope = slopes_of(run, all->count - 1);
    for (int i = 0; i <= n; i++)
        slope[i] = NAN;
    copy_state(slope + n + 1, state, n);
    return true;
}

bool responses_add_jump(struct run *run, int variable, double before)
{
    double state[LIMIT_VARIABLES];
    if (!run->plan.adaptive)
        return true;
    copy_state(state, run->y, run->system.n);
    state[variable] = before;
    return add_response(run, &(struct response){run->steps, run->t, run->y[variable], variable},
                        state);
}

void run_set_jump_slopes(struct run *run, const double *slope)
{
    const struct responses *all = &run->private_state->responses;
    if (all->count > 0 && all->at[all->count - 1].step == run->steps)
        memcpy(slopes_of(run, all->count - 1), slope, ((size_t)run->system.n + 1) * sizeof *slope);
}

bool responses_add_moment(struct run *run, int event, double h)
{
    struct event_watch *watch = run->private_state->watch;
    const struct watched *watched = &watch->event[event];
    const int n = run->system.n;
    if (!add_response(run, &(struct response){run->steps, run->t, 0, -1}, run->y))
        return false;
    double *slope = slopes_of(run, run->private_state->responses.count - 1);
    double y[LIMIT_VARIABLES], f[LIMIT_VARIABLES];
    copy_state(y, run->y, n);
    system_derivative(&run->system, run->t, y, f);
    for (int i = 0; i <= n; i++) {
        const double size = i < n ? fmax(watch->size[i], fabs(h * f[i])) : fabs(h);
        const double rounding = i < n ? 0 : 4 * DBL_EPSILON * fabs(run->t) / difference;
        const double by = difference * (size > 0 ? fmax(size, rounding) : 1);
        double value[2];
        for (int side = 0; side < 2; side++) {
            const double off = side ? by : -by;
            if (i < n)
                y[i] = run->y[i] + off;
            value[side] = events_watch_value(watch, watched, i < n ? run->t : run->t + off, y);
        }
        if (i < n)
            y[i] = run->y[i];
        slope[i] = (value[1] - value[0]) / (2 * by);
    }
    return true;
}

bool responses_moment_moves(const struct run *run)
{
    const struct responses *all = &run->private_state->responses;
    bool moves = false;
    for (size_t i = all->count; i > 0 && all->at[i - 1].t == run->t; i--)
        for (int k = 0; k < run->system.n && all->at[i - 1].variable < 0; k++)
            moves = moves || slopes_of(run, i - 1)[k] != 0;
    return moves;
}

void responses_truncate(struct run *run)
{
    struct responses *all = &run->private_state->responses;
    while (all->count > 0 && all->at[all->count - 1].step > run->steps)
        all->count--;
}

/* ---- along the second solution ---- */

/* Returns sum_i slope_i (y_i - state_i) + slope_n moved: the difference that response i makes. */
static double difference_by(const struct run *run, size_t i, const double *y, double moved)
{
    const double *slope = slopes_of(run, i), *state = state_of(run, i);
    const int n = run->system.n;
    double sum = moved != 0 || isnan(slope[n]) ? slope[n] * moved : 0;
    for (int k = 0; k < n; k++)
        sum += slope[k] * (y[k] - state[k]);
    return sum;
}

/* Returns by how much later the solution at y meets the event of response i. */
static double moment_moved(const struct run *run, const struct system *system, size_t i,
                           const double *y)
{
    const double *slope = slopes_of(run, i), *state = state_of(run, i);
    const int n = run->system.n;
    double f[LIMIT_VARIABLES], rate = slope[n];
    system_derivative(system, run->private_state->responses.at[i].t, state, f);
    for (int k = 0; k < n; k++)
        rate += slope[k] * f[k];
    const double off = difference_by(run, i, y, 0);
    return off == 0 ? 0 : -off / rate;
}

static void move(const struct saltation *saltation, const struct system *system, double sign,
                 double *y)
{
    double f[LIMIT_VARIABLES];
    if (saltation->moved == 0)
        return;
    system_derivative(system, saltation->t, y, f);
    for (int i = 0; i < system->n; i++)
        y[i] += sign * saltation->moved * f[i];
}

bool saltation_enter(const struct run *run, struct saltation *saltation,
                     const struct system *system, double t, double *y)
{
    const struct responses *all = &run->private_state->responses;
    const double ahead = run->t - run->system.t0;
    if (!saltation->begun || saltation->t != t) {
        saltation->begun = true;
        saltation->t = t;
        saltation->moved = 0;
        while (saltation->next < all->count && (all->at[saltation->next].t - t) * ahead < 0)
            saltation->next++;
        const size_t i = saltation->next;
        if (i < all->count && all->at[i].t == t && all->at[i].variable < 0)
            saltation->moved = moment_moved(run, system, i, y);
    }
    move(saltation, system, 1, y);
    return isfinite(saltation->moved);
}

bool saltation_jump(const struct run *run, const struct saltation *saltation, int64_t step,
                    double *y)
{
    const struct responses *all = &run->private_state->responses;
    for (size_t i = saltation->next; i < all->count && all->at[i].step <= step; i++) {
        const struct response *response = &all->at[i];
        if (response->step != step || response->variable < 0)
            continue;
        y[response->variable] = response->value + difference_by(run, i, y, saltation->moved);
        return isfinite(y[response->variable]);
    }
    return false;
}

void saltation_leave(const struct saltation *saltation, const struct system *system, double *y)
{
    move(saltation, system, -1, y);
}
