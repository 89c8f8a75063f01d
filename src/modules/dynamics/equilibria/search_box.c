/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Chooses the region of state space in which equilibria are searched if the user gives none. */
#include <hooke/run.h>
#include <hooke/base/numeric.h>
#include "modules/dynamics/dynamics_results.h"

#include <math.h>

/* The region extends beyond the visited range by this fraction on each side. */
#define BOX_MARGIN_FRACTION 0.5
#define SIZE_MIN_FRACTION 1e-6 /* sizes below this part of the largest become the largest */

/* Extends a range to include a value. */
static void include(double range[2], double value)
{
    range[0] = fmin(range[0], value);
    range[1] = fmax(range[1], value);
}

/* The range from -size to size of each variable is extended by the scene's start and the rows of
 * its run, then by a margin on both sides. Angles get a full turn, -pi to pi. */
bool dynamics_search_box(const struct session *session, const struct system *system,
                         struct arena *arena, double box[][2], struct error *error)
{
    const struct run *run = session_run(session);
    const bool same = run && run->scene.model == system->model;
    const size_t rows = same ? trace_count(run->trace) : 0;
    double *column = arena_array(arena, rows + 1, sizeof *column);
    if (!column)
        return error_memory(error);
    double most = 0;
    for (int i = 0; i < system->n; i++)
        most = fmax(most, system->scale[i]);
    for (int i = 0; i < system->n; i++) {
        /* A variable that is 0 at the scene's start has no size of its own. */
        const double size = system->scale[i] < SIZE_MIN_FRACTION * most ? most : system->scale[i];
        double range[] = {-size, size};
        include(range, system->start[i]);
        if (rows > 0)
            run_variable_column(run, i, column);
        for (size_t k = 0; k < rows; k++)
            if (isfinite(column[k]))
                include(range, column[k]);
        const bool angle = variable_is_angle(system, i);
        const double margin = BOX_MARGIN_FRACTION * (range[1] - range[0]);
        box[i][0] = angle ? -PI : range[0] - margin;
        box[i][1] = angle ? PI : range[1] + margin;
    }
    return true;
}
