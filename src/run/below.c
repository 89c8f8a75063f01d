/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Values below the tolerance of an adaptive run: numbers without a right digit. */
#include "private.h"

#include <float.h>
#include <math.h>

#define ADDED_UP 10   /* errors of steps come to about so many tolerances in a run */
#define PASSING 0.01 /* of the run: what would be above the tolerance within so long passes through 0 */

int run_below_tolerance(const struct run *run, bool *below)
{
    const struct system *system = &run->system;
    const double soon = PASSING * fabs(run->t - system->t0), tol = fmax(run->controller.tol, 10 * DBL_EPSILON);
    double slope[LIMIT_VARIABLES];
    int count = 0;
    memset(below, 0, (size_t)system->n * sizeof *below);
    if (!run->plan.adaptive || run->steps == 0 || stop_is_failure(run->stop))
        return 0;
    system_derivative(system, run->t, run->y, slope);
    for (int i = 0; i < system->n; i++) {
        const double allowed = ADDED_UP * tol * run->controller.scale[i];
        below[i] = run->y[i] != 0 && fabs(run->y[i]) < allowed && fabs(slope[i]) * soon < allowed;
        count += below[i];
    }
    return count;
}
