/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Times of steps: the grids of a trace, one for each change of the step, and the number of steps
 * that an interval of time takes. */
#include "run/private.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

double grid_time(const struct time_grid *grid, int64_t step)
{
    return grid->origin + (double)(step - grid->first) * grid->h;
}

const struct time_grid *trace_grid(const struct trace *trace)
{
    return &trace->grid[trace->grids - 1];
}

/* Finds the last grid that begins at or before the step, by bisection. */
const struct time_grid *trace_grid_of(const struct trace *trace, int64_t step)
{
    size_t low = 0, high = trace->grids;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (trace->grid[middle].first <= step)
            low = middle;
        else
            high = middle;
    }
    return &trace->grid[low];
}

/* Makes room for `more` grids, so that beginning one cannot fail later. */
bool trace_reserve_grids(struct trace *trace, size_t more)
{
    if (trace->grids + more <= trace->grid_capacity)
        return true;
    size_t capacity = 2 * trace->grid_capacity + more;
    struct time_grid *grid = realloc(trace->grid, capacity * sizeof *grid);
    if (!grid)
        return false;
    trace->grid = grid;
    trace->grid_capacity = capacity;
    return true;
}

void trace_regrid(struct trace *trace, struct time_grid grid)
{
    if (trace->grids > 0 && trace_grid(trace)->first == grid.first)
        trace->grids--;
    trace->grid[trace->grids++] = grid;
}

/* Counts the steps of dt between two times; a remainder within rounding counts as none. */
struct stretch stretch_measure(double t_begin, double t_end, double dt)
{
    double ratio = fabs(t_end - t_begin) / dt;
    if (!(ratio <= LIMIT_STEPS))
        return (struct stretch){.ratio = ratio, .whole = (int64_t)LIMIT_STEPS};
    /* The difference carries the rounding of both times, which is what the second bound allows for.
     */
    double nearest = round(ratio), size = fmax(fabs(t_begin), fabs(t_end)) / dt;
    if (fabs(ratio - nearest) <= 4 * DBL_EPSILON * fmax(nearest, size))
        return (struct stretch){.ratio = ratio, .whole = (int64_t)nearest, .exact = true};
    double whole = floor(ratio);
    return (struct stretch){.ratio = ratio,
                            .whole = (int64_t)whole,
                            .partial = t_end - (t_begin + whole * copysign(dt, t_end - t_begin))};
}
