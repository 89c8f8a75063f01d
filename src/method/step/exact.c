/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The exact solution as a method: each step evaluates it from the present state. */
#include "method/step/step.h"

/* Evaluates the exact solution at the end of the step. */
enum step_status exact_step(const struct method *method, struct step *step)
{
    (void)method;
    /* starts from 0 if nothing depends on time, since (t + h) - t would lose digits of h */
    double t = step->system->autonomous ? 0 : step->t;
    system_exact(step->system, t, step->y, t + step->h, step->work, NULL);
    step->cost.solves++;
    return step_finish(step, step->work);
}
