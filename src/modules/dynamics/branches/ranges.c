/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Ranges of the parameters of a branch, and the place where a curve leaves them. */
#include "modules/dynamics/branches/walk.h"

/* Returns the index of parameter `axis` among the unknowns. */
static int unknown_of(const struct curve_ranges *ranges, const struct curve_problem *problem,
                      int axis)
{
    return problem->n + 1 - ranges->count + axis;
}

/* Returns true if all parameters of a place are in their ranges. */
bool ranges_contain(const struct curve_ranges *ranges, const struct curve_problem *problem,
                    const struct curve_place *place)
{
    bool inside = true;
    for (int k = 0; k < ranges->count; k++) {
        const double value = place->u[unknown_of(ranges, problem, k)];
        inside = inside && value >= ranges->low[k] && value <= ranges->high[k];
    }
    return inside;
}

/* Interpolates to the edge that the chord from `start` to *edge_point meets first, and corrects
 * there with that parameter held fixed; the parameter is then set to the edge exactly, without the
 * rounding of the correction. */
bool ranges_step_to_edge(const struct curve_ranges *ranges, const struct curve_problem *problem,
                         const struct curve_place *start, struct curve_place *edge_point)
{
    double share = 1, bound = 0, guess[CURVE_MAX], direction[CURVE_MAX] = {0};
    int axis = problem->n;
    for (int k = 0; k < ranges->count; k++) {
        const int i = unknown_of(ranges, problem, k);
        const double a = start->u[i], b = edge_point->u[i],
                     edge = b < ranges->low[k] ? ranges->low[k] : ranges->high[k];
        if ((b < ranges->low[k] || b > ranges->high[k]) && (edge - a) / (b - a) <= share) {
            share = (edge - a) / (b - a);
            axis = i;
            bound = edge;
        }
    }
    for (int i = 0; i <= problem->n; i++)
        guess[i] = start->u[i] + share * (edge_point->u[i] - start->u[i]);
    guess[axis] = bound;
    direction[axis] = start->tangent[axis] < 0 ? -1 : 1; /* tests know which way the tangent goes */
    if (!curve_correct(problem, guess, direction, true, edge_point))
        return false;
    edge_point->u[axis] = bound;
    return true;
}
