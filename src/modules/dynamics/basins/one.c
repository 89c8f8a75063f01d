/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the attractor of a single motion, from the scene's own start (attractor_of). */
#include "modules/dynamics/basins/basins.h"

#include <math.h>

#define CHECKS_PER_ATTEMPT 64 /* looks between attempts to find an orbit */
/* Points within this distance, in sizes, approach the same point. */
#define SAME_APPROACH_SIZES 1e-4

/* Returns a request for the scene's start alone. Its ranges around the start determine the sizes
 * and the time between looks. */
static struct basins_request request_of(const struct scene *scene, const struct system *system,
                                        const struct cancel *cancel)
{
    struct basins_request request = {.scene = scene, .cancel = cancel};
    for (int a = 0; a < 2; a++) {
        const int i = a < system->n ? a : 0;
        request.axis[a].variable = i;
        request.axis[a].low = system->start[i] - system->scale[i];
        request.axis[a].high = system->start[i] + system->scale[i];
        request.axis[a].count = 2;
    }
    return request;
}

/* Follows the motion from the scene's start until it has an attractor, which is learned from the
 * motion itself. Returns the attractor's index, BASIN_ESCAPES, BASIN_UNDECIDED if none was
 * recognized, or BASIN_MISSING if cancelled or out of memory. */
static int follow_start(struct basin_walk *walk, const struct cancel *cancel)
{
    struct stepper *stepper = stepper_create(walk);
    struct walker walker;
    int fate = BASIN_MISSING;
    walker_start(walk, &walker, walk->field.system.start);
    while (stepper && fate == BASIN_MISSING && !cancelled(cancel)) {
        stepper_advance(stepper, &walker, 1);
        if (cancelled(cancel)) /* it may have ended anywhere */
            break;
        fate = walker_check(walk, &walker);
        const bool tries = fate == BASIN_MISSING && walker.checks % CHECKS_PER_ATTEMPT == 0;
        if (walker.checks < WALK_CHECKS_MAX && (tries || fate == BASIN_UNDECIDED))
            fate = walk_learn(walk, &walker);
    }
    stepper_free(stepper);
    return fate;
}

/* Returns the number of drive periods after which the attractor repeats. Near a period doubling a
 * motion approaches half as many points slowly, from both sides: looks a few apart agree before
 * neighbouring ones do. */
static int periods_of(const struct basin_walk *walk, const struct attractor *a)
{
    int periods = a->basin.multiple;
    while (periods % 2 == 0 && periods > 0 &&
           field_distance(&walk->field, a->point, a->point + periods / 2 * walk->n) <
               SAME_APPROACH_SIZES)
        periods /= 2;
    return periods;
}

/* Returns the number of drive periods after which the attractor repeats (1 for an orbit, 0 for an
 * equilibrium), ATTRACTOR_IRREGULAR, or NAN if there is none. Sets *basin, unless NULL, to the
 * attractor. */
double attractor_of(const struct scene *scene, const struct cancel *cancel, struct basin *basin)
{
    struct basin_walk walk;
    struct system system;
    struct error ignored = {0};
    if (!scene_bind_motion(scene, &system, &ignored))
        return NAN;
    const struct basins_request request = request_of(scene, &system, cancel);
    if (!walk_init(&walk, &request, false, &ignored))
        return NAN;
    const int fate = follow_start(&walk, cancel);
    double value = fate == BASIN_UNDECIDED ? ATTRACTOR_IRREGULAR : NAN;
    struct basin found = {.kind = BASIN_IRREGULAR};
    if (fate >= 0) {
        found = walk.attractor[fate].basin;
        if (found.kind == BASIN_RESPONSE) {
            found.multiple = periods_of(&walk, &walk.attractor[fate]);
            found.period = found.multiple * walk.strobe;
        }
        if (found.kind == BASIN_IRREGULAR)
            value = ATTRACTOR_IRREGULAR;
        else /* an orbit counts as one period, an equilibrium as none */
            value = found.kind == BASIN_ORBIT ? 1 : found.multiple;
    }
    if (basin)
        *basin = found;
    walk_free(&walk);
    return value;
}
