/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The first point of a branch (branch_begin). */
#include <string.h>

#include "modules/dynamics/branches/walk.h"

#define SAME_SOLUTION_DISTANCE 1e-6 /* distance below which a solution is the start itself */
/* Distance from the start beyond which a solution belongs to another branch. */
#define START_DISTANCE_MAX 0.3
/* Distance from a crossing at which a branch begins beside it, where the range is 1. */
#define NEIGHBOUR_PARAM_STEP 0.005

/* Finds the first place near the unknowns u if the start is a special point, at which the curve
 * cannot be corrected at a fixed parameter. At a fold a variable is held fixed instead, each in
 * turn; at a crossing the walk begins beside it, NEIGHBOUR_PARAM_STEP away and within the range.
 * side (1 or -1) is the direction of the walk. Returns false if none is found. */
static bool begin_at_special(const struct branch_request *r, struct solution_curve *path,
                             const double *u, int side, struct curve_place *first)
{
    const int n = path->problem->n;
    const double psize = r->high - r->low;
    for (int i = 0; i < path->field.n; i++) {
        double direction[CURVE_MAX] = {0};
        direction[i] = side;
        if (curve_correct(path->problem, u, direction, true, first) &&
            curve_distance(n + 1, u, first->u) < SAME_SOLUTION_DISTANCE)
            return true;
    }
    for (int way = -1; way <= 1; way += 2) {
        double neighbour[CURVE_MAX];
        memcpy(neighbour, u, sizeof neighbour);
        neighbour[n] += way * NEIGHBOUR_PARAM_STEP;
        if (neighbour[n] * psize >= r->low && neighbour[n] * psize <= r->high &&
            solutions_correct_at(path, neighbour, side, first) &&
            curve_distance(n + 1, u, first->u) < START_DISTANCE_MAX)
            return true;
    }
    return false;
}

/* Returns true with *error if no branch can pass through the start: orbits on which the equations
 * jump, equilibria of driven scenes. */
static bool cannot_begin(const struct branch_request *r, struct solution_curve *path,
                         struct error *error)
{
    struct vector_field *field = &path->field;
    const double period = r->start->kind == SOLUTION_RESPONSE
                              ? r->start->multiple * field_drive(field)
                              : r->start->period;
    if (path->kind != SOLUTION_EQUILIBRIUM) {
        if (!field_jumps(field, field->system.t0, r->start->state, period))
            return false;
        error_set(error, ERROR_COMMAND, BRANCH_JUMP ": no branch passes there");
    } else if (!field->system.autonomous) {
        error_set(error, ERROR_COMMAND, "a driven scene has no equilibria");
        error_hint(error, "'of response' follows the periodic response to the drive");
    } else {
        return false;
    }
    return true;
}

bool branch_starts_in_family(const struct branch_request *r)
{
    return r->start->kind == SOLUTION_ORBIT && solution_ones(r->start) > 0;
}

bool branch_refuse_family(struct error *error)
{
    error_set(error, ERROR_COMMAND,
              "this orbit belongs to a family (a multiplier is 1), so at other parameter values "
              "there are many such orbits and no single branch");
    return error_hint(error, "'orbit period=T' finds the orbit with a given period; with damping "
                             "and a drive a single orbit remains, which a branch can follow");
}

/* Begins on the branch that leaves r->leave, or corrects r->start at its parameter, or beside it if
 * it is a special point. Returns false with *error if there is none. */
bool branch_begin(const struct branch_request *r, int side, double psize,
                  struct solution_curve *path, struct curve_place *first, struct error *error)
{
    if (r->leave)
        return solutions_leave(path, r->scene, r->param, psize, r->leave, side, r->cancel, first,
                               error);
    double u[CURVE_MAX];
    if (!solutions_begin(path, r->scene, r->param, psize, r->start, r->cancel, u, error))
        return false;
    if (cannot_begin(r, path, error)) {
        solutions_end(path);
        return false;
    }
    const int sign = r->forward ? 1 : side;
    if (solutions_correct_at(path, u, sign, first) || begin_at_special(r, path, u, sign, first))
        return true;
    solutions_end(path);
    if (branch_starts_in_family(r))
        return branch_refuse_family(error);
    return error_set(error, ERROR_COMMAND, "there is no such %s at the start",
                     r->start->kind == SOLUTION_EQUILIBRIUM ? "equilibrium" : "orbit");
}
