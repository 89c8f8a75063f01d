/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Methods made of one implicit Euler stage. work: two states, then the solver's own. */
#include "step.h"

enum step_status backward_euler_step(const struct method *method, struct step *step)
{
    (void)method;
    double *z = step->work, *own = z + 2 * step->system->n;
    enum step_status status = implicit_euler_solve(step, step->t + step->h, step->h, step->y, z, own);
    return status == STEP_OK ? step_finish(step, z) : status;
}

/* An implicit half step to the middle, an explicit one from there. */
enum step_status implicit_midpoint_step(const struct method *method, struct step *step)
{
    (void)method;
    int n = step->system->n;
    double h = step->h, *z = step->work, *own = z + 2 * n;
    enum step_status status = implicit_euler_solve(step, step->t + h / 2, h / 2, step->y, z, own);
    if (status != STEP_OK)
        return status;
    for (int i = 0; i < n; i++)
        z[i] = 2 * z[i] - step->y[i];
    return step_finish(step, z);
}

/* An explicit half step to the middle, an implicit one from there. */
enum step_status trapezoid_step(const struct method *method, struct step *step)
{
    (void)method;
    int n = step->system->n;
    double h = step->h, *z = step->work, *middle = z + n, *own = middle + n;
    system_derivative(step->system, step->t, step->y, middle);
    step->cost.evals++;
    for (int i = 0; i < n; i++)
        middle[i] = step->y[i] + h / 2 * middle[i];
    enum step_status status = implicit_euler_solve(step, step->t + h, h / 2, middle, z, own);
    return status == STEP_OK ? step_finish(step, z) : status;
}
