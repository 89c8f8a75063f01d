/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Many trajectories at once: what oscillators (lane/) and typed scenes
 * (typed_lanes.c) share. */
#ifndef HOOKE_METHOD_KERNEL_LANES_H
#define HOOKE_METHOD_KERNEL_LANES_H

#include "method/step/weights.h"

/* Evaluations of `each` a step, one of which is the next step's first: `again`. */
static inline int64_t lane_evals(int64_t steps, int each, bool again)
{
    return steps * (each - again) + (again && steps > 0);
}

/* Vectors of at most so many doubles, as an older processor has: for tests. */
enum { LANE_WIDEST = 8 };
void lanes_narrow(struct lanes *lanes, int most);

/* ---- turning points: a step across one is taken again alone ---- */

static inline bool lane_turns(double v0, double v1)
{
    return (v0 < 0 && v1 > 0) || (v0 > 0 && v1 < 0);
}

/*
 * step: at its start, all but `warm` set; its state becomes that after it, NaN where that fails.
 * slope [n]: the step's first one, afterwards the last. Returns the evaluations beyond those of a
 * step.
 */
static inline int64_t lane_turn(const struct method *method, struct step *step, double *slope)
{
    const struct tableau *tableau = method->tableau;
    const int n = step->system->n;
    double *last = step->work + (tableau->stages - 1) * n;
    memcpy(last, slope, (size_t)n * sizeof *slope);
    step->warm = tableau->fsal;
    const bool good = method_turning_step(method, step) == STEP_OK;
    memcpy(slope, last, (size_t)n * sizeof *slope);
    for (int i = 0; i < n && !good; i++)
        step->y[i] = NAN;
    return step->cost.evals - (tableau->stages - tableau->fsal);
}

/* ---- typed scenes ---- */

/* Adds a built-in force to a [LANES]; c [TERM_COEFFICIENTS][LANES], y [2][LANES] */
typedef void lane_term_function(const double *c, double t, const double *y, double *a);

/* lane/terms.c; NULL: not one of the oscillator's */
lane_term_function *lane_term(const struct term_row *row);

struct typed_lanes;

/* Is there room for such a system? */
bool typed_lanes_fit(const struct method *method, const struct system *system, enum drag drag);
void typed_lanes_destroy(struct typed_lanes *lanes);
/* For systems like this one; *lanes is made, or used again. False: no memory. */
bool typed_lanes_begin(struct typed_lanes **lanes, const struct method *method, enum drag drag,
                       const struct system *like, double h);
void typed_lanes_set(struct typed_lanes *lanes, int lane, const struct system *system, double h);
void typed_lanes_march(struct typed_lanes *lanes, int64_t count, double *row);
void typed_lanes_row(struct typed_lanes *lanes, double *row);
void typed_lanes_state(const struct typed_lanes *lanes, int lane, double *y);
int64_t typed_lanes_evals(const struct typed_lanes *lanes, int lane);

#endif
