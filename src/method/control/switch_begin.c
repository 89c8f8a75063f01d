/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The beginning of a step in a system with switches: finds the branches on which it begins and the
 * switches along which the motion slides. Guards and branches are explained in switch.c. */
#include <hooke/scene/typed.h>
#include "method/control/switch.h"

#include <float.h>

/* A guard below this part of its change over the probe (a short look ahead) is at its switch. */
#define GUARD_ZERO_RELATIVE 1e-4
#define AT_ONCE 1e-9 /* relative to the probe: switches closer than this are met at once */
/* Smallest step, in sizes of variables, over which arguments are differentiated. */
#define ARGUMENT_STEP_MIN 1e-6
/* Second derivatives are taken over an interval this many times as long. */
#define SECOND_DIFFERENCE_FACTOR 10
/* A rate that changes by less than this part of the second difference is 0. */
#define ZERO_RATE_RELATIVE 1e-5
#define PROBE_MIN_ULPS 1e5  /* Shortest probe in units of the last place of t. */
#define SHARE_ROUNDING 1e-9 /* Rounding of a sliding share that is computed by differences. */

/* Sets guard[] to the guards after h [s], which may be negative, from the state step->y by one step
 * of the midpoint rule of the system `frozen`. f [n] is the derivative at step->y. */
static void guards_after(const struct step *step, const struct system *frozen, const double *f,
                         double h, double *guard)
{
    double middle[LIMIT_VARIABLES], y[LIMIT_VARIABLES];
    for (int i = 0; i < frozen->n; i++)
        middle[i] = step->y[i] + h / 2 * f[i];
    system_derivative(frozen, step->t + h / 2, middle, y);
    for (int i = 0; i < frozen->n; i++)
        y[i] = step->y[i] + h * y[i];
    system_guards(frozen, step->t + h, y, guard);
}

/* Returns the time [s] in which the motion moves by a millionth of the sizes of variables, or 0 if
 * it does not move. */
static double short_time(const struct step *step, int n, const double *f)
{
    const double rate = sqrt(scaled_square(n, step_scale(step), f, step->y, step->y) / n);
    return rate > 0 ? ARGUMENT_STEP_MIN / rate : 0;
}

/* Computes the guards of frozen branches at the start of the step (now) and a moment later (soon).
 * Euler's rule is used, or the second derivative for guards whose rate is 0, which are marked in
 * still. */
static void guards_ahead(struct step *step, const struct system *frozen, double probe_step,
                         double *now, double *soon, bool *still)
{
    const int n = frozen->n;
    double f[LIMIT_VARIABLES], y[LIMIT_VARIABLES], guard_back[LIMIT_SWITCHES],
        guard_ahead[LIMIT_SWITCHES];
    system_guards(frozen, step->t, step->y, now);
    system_derivative(frozen, step->t, step->y, f);
    for (int i = 0; i < n; i++)
        y[i] = step->y[i] + probe_step * f[i];
    system_guards(frozen, step->t + probe_step, y, soon);
    step->cost.evals++;
    for (int i = 0; i < frozen->switches; i++)
        still[i] = false;
    if (frozen->sliding)
        return;
    const double min = PROBE_MIN_ULPS * DBL_EPSILON * fabs(step->t),
                 far = SECOND_DIFFERENCE_FACTOR * short_time(step, n, f);
    guards_after(step, frozen, f, -copysign(fmax(far, min), probe_step), guard_back);
    guards_after(step, frozen, f, copysign(fmax(far, min), probe_step), guard_ahead);
    step->cost.evals += 2;
    for (int i = 0; i < frozen->switches; i++) {
        const double second = (guard_ahead[i] - now[i]) - (now[i] - guard_back[i]);
        still[i] = fabs(guard_ahead[i] - guard_back[i]) <= ZERO_RATE_RELATIVE * fabs(second);
        if (still[i])
            soon[i] = now[i] + second / 2;
    }
}

/* Makes *frozen the system on its branches, or the sliding one if it slides along a switch. Returns
 * false if sliding has no solution. */
static bool freeze_or_slide(const struct step *step, const struct switches_state *state,
                            struct sliding *sliding, struct system *frozen)
{
    for (int i = 0; i < step->system->switches; i++)
        if (state->slides_along[i])
            return system_slide(step->system, state->branch, state->slides_along, state->slide_step,
                                sliding, frozen);
    system_freeze(step->system, state->branch, frozen);
    return true;
}

/* Marks the motion as sliding along switch i, and counts it. */
static void begin_sliding(struct step *step, struct switches_state *state,
                          const struct system *frozen, int i)
{
    double f[LIMIT_VARIABLES];
    system_derivative(frozen->sliding ? &frozen->sliding->side[0] : frozen, step->t, step->y, f);
    step->cost.evals++;
    state->branch[i] = system_lower_branch(frozen, i, step->t, step->y);
    state->slides_along[i] = true;
    state->slide_step = fmax(state->slide_step, short_time(step, frozen->n, f));
    if (state->slides++ == 0) {
        state->slid = step->t;
        state->first = i;
    }
}

/* Does the same as begin_sliding(). Returns false, with the state unchanged, if the motion crosses
 * the switch, as it does if the switch depends on time alone. */
static bool try_sliding(struct step *step, struct switches_state *state,
                        const struct system *frozen, int i)
{
    const struct switches_state was = *state;
    struct sliding sliding = {0};
    struct system sliding_system;
    begin_sliding(step, state, frozen, i);
    const bool passes = freeze_or_slide(step, state, &sliding, &sliding_system) &&
                        sliding_passes(&sliding, i, step->t, step->y, state->slide_step);
    sliding_free(&sliding);
    if (passes)
        *state = was;
    return !passes;
}

/* Returns true if a guard is at 0 (`now`) and falls: at the end of the step before (`ends`), at
 * rest, or by chance. */
static bool guard_falls(double now, double soon, bool ends)
{
    return soon < 0 && fabs(now) <= (ends ? GUARD_ZERO_RELATIVE : AT_ONCE) * fabs(soon - now);
}

/* Returns a switch along which the motion cannot slide, because one side pushes harder than the
 * other pushes back; -1 if there is none. */
static int find_unheld_switch(const struct switches_state *state, const double *guard, int count)
{
    for (int i = 0; i < count; i++)
        if (state->slides_along[i] && !(guard[i] >= -SHARE_ROUNDING))
            return i;
    return -1;
}

/* Lets the motion leave switch i to the side that it is pushed to. Returns false if it was sliding
 * along it before. */
static bool leave_switch(const struct step *step, struct switches_state *state,
                         const struct system *sliding, int i)
{
    const double branch = system_next_branch(sliding, i, step->t, step->y);
    if (state->slid_along[i] || state->slides == 0 || isnan(branch))
        return false;
    state->branch[i] = branch;
    state->slides_along[i] = false;
    state->slides--;
    return true;
}

/* Makes the branches of all switches consistent at the start of a step. A branch whose guard is
 * about to become negative, probed by an Euler step over probe_step [s], is changed to the next
 * branch, and if that does not help, to sliding. On success *frozen is the system with these
 * branches and *sliding its sliding motion. Returns false if no combination is found. */
static bool branches_settle(struct step *step, struct switches_state *state, double probe_step,
                            struct sliding *sliding, struct system *frozen)
{
    const int count = step->system->switches;
    bool passes[LIMIT_SWITCHES] = {false}, still[LIMIT_SWITCHES] = {false};
    int changed[LIMIT_SWITCHES] = {0};
    for (int i = 0; i < count; i++)
        changed[i] = state->fresh == i;
    state->slide_step = fabs(probe_step);
    for (int round = 0; round <= 4 * count; round++) {
        double now[LIMIT_SWITCHES] = {0}, soon[LIMIT_SWITCHES] = {0};
        if (!freeze_or_slide(step, state, sliding, frozen))
            return false;
        guards_ahead(step, frozen, probe_step, now, soon, still);
        int wrong = 0;
        while (wrong < count &&
               (passes[wrong] || wrong == state->released ||
                !guard_falls(now[wrong], soon[wrong], wrong == state->fresh || still[wrong])))
            wrong++;
        if (wrong == count) {
            const int pushed = find_unheld_switch(state, now, count);
            if (pushed < 0)
                return true;
            if (!leave_switch(step, state, frozen, pushed) || ++changed[pushed] > 3)
                return false;
            continue;
        }
        if (++changed[wrong] > 3)
            return false;
        if (changed[wrong] > 1 && !state->slides_along[wrong]) {
            passes[wrong] = !try_sliding(step, state, frozen, wrong);
            continue;
        }
        double y[LIMIT_VARIABLES], f[LIMIT_VARIABLES];
        system_derivative(frozen, step->t, step->y, f);
        for (int i = 0; i < frozen->n; i++)
            y[i] = step->y[i] + probe_step * f[i];
        state->branch[wrong] = system_next_branch(frozen, wrong, step->t + probe_step, y);
        state->slides_along[wrong] = false;
    }
    return false;
}

/* Starts sliding at once along every switch that has changed recently (state->recent), for motion
 * that would otherwise switch back and forth in ever shorter steps. Switches that the sliding
 * motion would cross are then released with their former branch. probe_step [s] is the length over
 * which sliding is tested. */
static void pile_up(struct step *step, struct switches_state *state, double probe_step)
{
    const struct switches_state was = *state;
    struct system frozen, sliding_system;
    struct sliding sliding = {0};
    system_freeze(step->system, state->branch, &frozen);
    state->slide_step = fabs(probe_step);
    for (int i = 0; i < frozen.switches; i++)
        if (state->recent[i] && !state->slides_along[i])
            begin_sliding(step, state, &frozen, i);
    if (system_slide(step->system, state->branch, state->slides_along, state->slide_step, &sliding,
                     &sliding_system)) {
        double guard[LIMIT_SWITCHES];
        system_guards(&sliding_system, step->t, step->y, guard);
        for (int i = 0; i < frozen.switches; i++)
            if (state->slides_along[i] && !was.slides_along[i] &&
                (guard[i] < 0 || sliding_passes(&sliding, i, step->t, step->y, was.block))) {
                state->slides_along[i] = false;
                state->branch[i] = was.branch[i];
            }
    }
    sliding_free(&sliding);
    state->piles++;
    state->piled = state->begins = false;
    state->shorter = 0;
}

/* Resets the state of the switches at time t [s]. The statistics stay: the numbers of slides, of
 * switches piled up and of crossings, and time and switch of the first slide. */
static void switches_reset(struct switches_state *state, double t)
{
    const struct switches_state was = *state;
    *state = (struct switches_state){.known = true,
                                     .fresh = -1,
                                     .released = -1,
                                     .t = t,
                                     .t_block = t,
                                     .begins = true,
                                     .slides = was.slides,
                                     .piles = was.piles,
                                     .crossings = was.crossings,
                                     .slid = was.slid,
                                     .first = was.first};
}

void switch_go_back(struct step *step, const struct system *frozen)
{
    if (frozen->sliding && sliding_return(frozen->sliding, step->t, step->y))
        step->warm = false;
}

/* Finds the branches at the start of a step and freezes the system on them; they are determined
 * anew if the state was changed since the last step. Returns false if none leads on. */
bool switch_begin(struct step *step, struct switches_state *state, double probe_step,
                  struct sliding *sliding, struct system *frozen)
{
    bool fine = true;
    if (!state->known || state->t != step->t) {
        switches_reset(state, step->t);
        system_branches(step->system, step->t, step->y, state->branch);
        step->warm = false;
    }
    if (state->piled)
        pile_up(step, state, probe_step);
    else if (state->begins)
        fine = branches_settle(step, state, probe_step, sliding, frozen);
    if (!fine || !freeze_or_slide(step, state, sliding, frozen)) {
        state->known = false;
        state->slid = state->crossings++ == 0 && state->slides == 0 ? step->t : state->slid;
        return false;
    }
    switch_go_back(step, frozen);
    return true;
}
