/* SPDX-License-Identifier: GPL-3.0-or-later */
/* States inside of the step just taken, for rows at even times and for events. */
#include <hooke/scene/typed.h>
#include "run/private.h"

/* Dense output would cover only the last part of a step that was made in parts, so it is not
 * used. */
struct inside inside_of(struct run *run, bool cold, double t, double h)
{
    struct inside inside = {run, *run->method, t, h};
    if (cold && (method_meets_switches(run->method, &run->system) ||
                 method_turns(run->method, &run->system)))
        inside.method.dense = NULL;
    return inside;
}

/* Returns the last step with the system that it was made with, perhaps frozen on branches. */
struct step inside_step(const struct inside *inside, struct sliding *sliding, struct system *frozen)
{
    const struct run *run = inside->run;
    struct step last = run->private_state->step;
    if (run->plan.adaptive)
        last.system = method_adapted(&run->system, &run->controller, sliding, frozen);
    return last;
}

/* Makes a step of the method from the beginning of the last one over its fraction theta, into y
 * [n], with memory of its own, so that the run is not changed. Returns false if it fails. */
static bool side_step(const struct inside *inside, const struct step *last, double theta, double *y)
{
    struct run *run = inside->run;
    struct run_private *p = run->private_state;
    struct step step = *last;
    step.kernel = last->system == &run->system ? last->kernel : NULL;
    step.t = inside->t;
    step.h = theta * inside->h;
    step.y = y;
    step.work = p->side;
    step.error = step.low = NULL;
    step.switches = NULL;
    step.warm = step.again = false;
    copy_state(y, p->previous_state, run->system.n);
    const enum step_status status = method_turning_step(run->method, &step);
    p->step.cost = step.cost;
    return status == STEP_OK;
}

/* Moves y, the state at the fraction theta of a step of a multistep method, by theta times the gap:
 * side_step() does not know the steps before, so it ends beside the step that was taken. The gap is
 * found once for each step. */
static void close_gap(const struct inside *inside, const struct step *last, double theta, double *y)
{
    const struct run *run = inside->run;
    struct run_private *p = run->private_state;
    if (!p->gap_known) {
        const bool fine = side_step(inside, last, 1, p->gap);
        for (int i = 0; i < run->system.n; i++)
            p->gap[i] = fine ? run->y[i] - p->gap[i] : 0;
        p->gap_known = true;
    }
    for (int i = 0; i < run->system.n; i++)
        y[i] += theta * p->gap[i];
}

/* Methods of high order without dense output get a shorter step of their own, because a cubic
 * through the ends of a long step would be far less accurate. */
void inside_state(const struct inside *inside, double theta, double *y)
{
    const struct run *run = inside->run;
    const struct run_private *p = run->private_state;
    struct sliding sliding = {0};
    struct system frozen;
    const struct step last = inside_step(inside, &sliding, &frozen);
    if (!p->side || !side_step(inside, &last, theta, y))
        method_dense(&inside->method, &last, p->previous_state, theta, y);
    else if (run->method->flags & METHOD_MULTISTEP)
        close_gap(inside, &last, theta, y);
    sliding_free(&sliding);
}
