/* SPDX-License-Identifier: GPL-3.0-or-later */
/* States inside of the step just taken. */
#include <hooke/scene/typed.h>
#include "run/private.h"

struct inside inside_of(struct run *run, bool cold, double t, double h)
{
    struct inside inside = {run, *run->method, t, h};
    if (cold && (method_meets_switches(run->method, &run->system) ||
                 method_turns(run->method, &run->system)))
        inside.method.dense = NULL;
    return inside;
}

struct step inside_step(const struct inside *inside, struct sliding *sliding, struct system *frozen)
{
    const struct run *run = inside->run;
    struct step last = run->private_state->step;
    if (run->plan.adaptive)
        last.system = method_adapted(&run->system, &run->controller, sliding, frozen);
    return last;
}

/* Steps of an adaptive method may be so long that a cubic through their ends says little: a shorter
 * step does. */
void inside_state(const struct inside *inside, double theta, double *y)
{
    struct run *run = inside->run;
    struct run_private *p = run->private_state;
    struct sliding sliding = {0};
    struct system frozen;
    const struct step last = inside_step(inside, &sliding, &frozen);
    if (p->side) {
        struct step step = last;
        step.kernel = last.system == &run->system ? last.kernel : NULL;
        step.t = inside->t;
        step.h = theta * inside->h;
        step.y = y;
        step.work = p->side;
        step.error = step.low = NULL;
        step.switches = NULL;
        step.warm = step.again = false;
        copy_state(y, p->before, run->system.n);
        const enum step_status status = method_turning_step(run->method, &step);
        p->step.cost = step.cost;
        if (status == STEP_OK) {
            sliding_free(&sliding);
            return;
        }
    }
    method_dense(&inside->method, &last, p->before, theta, y);
    sliding_free(&sliding);
}
