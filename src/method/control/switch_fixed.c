/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Steps of fixed size in a scene with switches. A step is divided into segments that meet at the
 * switches, also where a body under dry friction turns, sticks and breaks away. Each segment is
 * taken on frozen branches as adaptive steps are (switch.c).
 */
#include <hooke/scene/typed.h>
#include "method/control/switch.h"

#include <float.h>

/* Largest number of segments that switches may divide a step into. */
#define STEP_SEGMENTS_MAX 64
/* Part of the remaining step ahead at which a guard's direction is evaluated. */
#define PROBE_STEP_FRACTION 1e-4
/* A state within this distance of a switch, relative to sizes of variables, is at it. */
#define SWITCH_ROUNDING_RELATIVE 1e-14

/* Prepares the state of switches at the start of a step. A motion that is at a switch within
 * rounding begins there, so that sliding is recognised; under dry friction alone a velocity that is
 * not 0 decides the branch, and memory of the last step stays valid. */
static void switches_state_init(struct step *step, struct switches_state *state)
{
    *state = (struct switches_state){.known = true,
                                     .fresh = -1,
                                     .released = -1,
                                     .t = step->t,
                                     .t_block = step->t,
                                     .begins = step->system->dry && step->y[1] == 0};
    if (step->switches) {
        const struct switches_state *was = step->switches;
        state->slides = was->slides;
        state->piles = was->piles;
        state->crossings = was->crossings;
        state->slid = was->slid;
        state->first = was->first;
    }
    system_branches(step->system, step->t, step->y, state->branch);
    if (step->system->switches > step->system->dry) {
        double perturbed[LIMIT_VARIABLES], argument[LIMIT_SWITCHES],
            perturbed_argument[LIMIT_SWITCHES];
        struct system frozen;
        system_freeze(step->system, state->branch, &frozen);
        system_guards(&frozen, step->t, step->y, argument);
        for (int i = 0; i < frozen.n; i++) {
            const double size = fmax(fabs(step->y[i]), step->system->scale[i]);
            /* different perturbations, since a guard may be the difference of two variables */
            perturbed[i] = step->y[i] + SWITCH_ROUNDING_RELATIVE * (1 + 0.3 * (i % 4)) * size;
        }
        system_guards(&frozen, step->t * (1 + 0.7 * SWITCH_ROUNDING_RELATIVE), perturbed,
                      perturbed_argument);
        for (int i = 0; i < frozen.switches; i++)
            state->begins =
                state->begins || fabs(argument[i]) <= fabs(perturbed_argument[i] - argument[i]);
    }
    step->warm = step->warm && !state->begins;
}

/* Returns true if a rate of the system seems to grow without bound towards t, the time of a switch
 * at the end of a step over h [s] (a pole). Compares the rates at three distances from t, each the
 * same factor nearer: a logarithm or a negative power of the distance changes at least about as
 * much from the second to the third as from the first to the second. A step that ended at a pole
 * would take its slope from rounding. */
static bool ends_at_pole(struct step *step, double t, double h)
{
    enum { DISTANCES = 3 };
    /* A bounded rate changes far less near the switch than farther away. */
    static const double farthest = 1e-2, nearest = 1e-12, nearest_ulps = 256, same_growth = 0.7,
                        change_min = 1e-3;
    const double near_distance = fmax(nearest * fabs(h), nearest_ulps * DBL_EPSILON * fabs(t)),
                 far = farthest * fabs(h);
    double rate[DISTANCES][LIMIT_VARIABLES];
    if (step->system->autonomous || !(near_distance < far / 1e4))
        return false;
    const double distance[DISTANCES] = {far, sqrt(far * near_distance), near_distance};
    for (int k = 0; k < DISTANCES; k++)
        system_derivative(step->system, t - copysign(distance[k], h), step->y, rate[k]);
    step->cost.evals += DISTANCES;
    for (int i = 0; i < step->system->n; i++) {
        const double first = rate[1][i] - rate[0][i], second = rate[2][i] - rate[1][i];
        if (first * second > 0 && fabs(second) > same_growth * fabs(first) &&
            fabs(first) > change_min * fabs(rate[0][i]))
            return true;
    }
    return false;
}

/* Takes a segment of a step, at most `rest` [s] long, that ends at the first switch in it. On
 * return step->h is the length of the segment and *ended the index of the switch, or -1 if the
 * segment fills `rest`. With `last` set, switches are not looked for, since no further segment is
 * allowed. If a pole of the force lies at the switch, the whole of `rest` is stepped without ending
 * there. Returns the status of the method's step. */
static enum step_status step_segment(const struct method *method, struct step *step,
                                     struct switches_state *state, double rest, bool last,
                                     int *ended)
{
    const struct system *whole = step->system;
    const size_t size = (size_t)whole->n * sizeof *step->y;
    const double t_begin = step->t;
    double y_begin[LIMIT_VARIABLES], low[LIMIT_VARIABLES];
    struct system frozen;
    struct sliding sliding = {0};
    *ended = -1;
    step->h = rest;
    if (!switch_begin(step, state, PROBE_STEP_FRACTION * rest, &sliding, &frozen)) {
        sliding_free(&sliding);
        return method_step(method, step);
    }
    memcpy(y_begin, step->y, size);
    if (step->low)
        memcpy(low, step->low, size);
    step->system = &frozen;
    enum step_status status = method_step(method, step);
    if (status == STEP_OK && !last)
        status = switch_step(method, step, t_begin, y_begin, low, ended);
    const bool is_pole =
        status == STEP_OK && *ended >= 0 && ends_at_pole(step, t_begin + step->h, step->h);
    if (status == STEP_OK && !is_pole) {
        step->t = t_begin + step->h;
        switch_next(step, state, *ended);
    }
    step->system = whole;
    if (is_pole) {
        memcpy(step->y, y_begin, size);
        if (step->low)
            memcpy(step->low, low, size);
        step->t = t_begin;
        step->h = rest;
        step->warm = false;
        step->cost.poles++;
        *ended = -1;
        status = method_step(method, step);
    }
    sliding_free(&sliding);
    if (*ended >= 0)
        step->warm = false;
    return status;
}

/* Takes a step in segments that meet at switches, until they fill it; on failure the state at its
 * start is restored. */
enum step_status switched_step(const struct method *method, struct step *step)
{
    const size_t size = (size_t)step->system->n * sizeof *step->y;
    const double t = step->t, h = step->h;
    step_function *kernel = step->kernel;
    double start[LIMIT_VARIABLES], start_low[LIMIT_VARIABLES], rest = h;
    struct switches_state state;
    memcpy(start, step->y, size);
    if (step->low)
        memcpy(start_low, step->low, size);
    switches_state_init(step, &state);
    step->kernel = NULL;
    enum step_status status = STEP_OK;
    for (int segments = 1, ended = 0; status == STEP_OK && ended >= 0 && rest * h > 0; segments++) {
        status = step_segment(method, step, &state, rest, segments == STEP_SEGMENTS_MAX, &ended);
        rest -= step->h;
        step->cost.turns += status == STEP_OK && ended >= 0;
    }
    step->kernel = kernel;
    step->h = h;
    step->t = t + h;
    if (status == STEP_OK && !switch_is_there(step))
        status = STEP_NONFINITE;
    if (status == STEP_OK && step->switches)
        *step->switches = state;
    if (status == STEP_OK)
        return STEP_OK;
    memcpy(step->y, start, size);
    if (step->low)
        memcpy(step->low, start_low, size);
    step->t = t;
    return status;
}

/* Takes the steps of a march one by one, since no kernel knows switches of typed equations. Returns
 * how many. */
int64_t switched_march(const struct method *method, const struct march *march,
                       enum step_status *status)
{
    struct step *step = march->step;
    const size_t n = (size_t)step->system->n;
    *status = STEP_OK;
    for (int64_t i = 0; i < march->count; i++) {
        step->t = march->origin + (double)(march->first + i) * step->h;
        *status = switched_step(method, step);
        if (*status != STEP_OK)
            return i;
        memcpy(march->row + (size_t)i * n, step->y, n * sizeof *step->y);
    }
    return march->count;
}
