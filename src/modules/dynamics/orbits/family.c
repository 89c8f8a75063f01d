/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Follows a family of periodic orbits (of conservative motion) to the member with a wanted period:
 * the period changes step by step, and each orbit is closed from the previous one with its period
 * held and the least change of everything else. */
#include <math.h>

#include "modules/dynamics/orbits/solutions.h"

/* Longest step, as the logarithm of the ratio of two periods, and the step below which the search
 * is given up. */
static const double longest_step = 0.03, shortest_step = 1e-6;
/* A closed orbit is not the next of the family if its start has moved by more than this part of the
 * extent, or if its extent has changed by more than this factor. */
static const double moved_max = 0.5, extent_change_max = 2;
/* Two periods are the same if they differ by less than this part. */
static const double same_period = 1e-12;
enum { STEPS_MAX = 1000 };

/* Closes the orbit with that period from the last one. Returns false if it is not the next one of
 * the family. */
static bool close_next(struct orbit_search *s, const struct found_orbit *last, double period,
                       struct found_orbit *next)
{
    const struct vector_field *field = &s->field;
    struct orbit_search alone = *s;
    const double extent = orbit_extent(field, &last->solution);
    double held[FIELD_VARIABLES + 1] = {0};
    held[field->n] = 1;
    alone.extent = 0;
    *next = (struct found_orbit){.samples = 0};
    const bool closed = orbit_close(&alone, last->solution.state, period, 0, held, next);
    s->field.evals = alone.field.evals;
    if (!closed || fabs(next->solution.period / period - 1) > same_period)
        return false;
    const double change = orbit_extent(field, &next->solution) / extent;
    double moved = 0;
    for (int i = 0; i < field->n; i++)
        moved = fmax(moved, fabs(next->solution.state[i] - last->solution.state[i]) /
                                (field->size[i] * extent));
    return moved < moved_max && change < extent_change_max && change > 1 / extent_change_max;
}

/* Follows the family from *found as far as it goes, at most to the wanted period. */
static void follow_family(struct orbit_search *s, double wanted, struct found_orbit *found)
{
    struct found_orbit next;
    double step = longest_step;
    const int sense = wanted > found->solution.period ? 1 : -1;
    for (int k = 0; k < STEPS_MAX && step > shortest_step && !cancelled(s->request->cancel); k++) {
        const double left = fabs(log(wanted / found->solution.period)),
                     log_step = sense * fmin(step, left);
        if (left == 0)
            return;
        if (s->request->progress)
            s->request->progress(s->request->context, 0);
        const double period = step < left ? found->solution.period * exp(log_step) : wanted;
        if (!close_next(s, found, period, &next)) {
            step /= 2;
            continue;
        }
        step = fmin(1.5 * step, longest_step);
        *found = next;
    }
}

/* If the family does not change its period in the wanted direction, the other one is tried to learn
 * whether its period changes at all. */
bool orbit_of_period(struct orbit_search *s, double wanted, struct error *error)
{
    const double first = s->found->solution.period;
    struct found_orbit away = *s->found;
    if (fabs(first / wanted - 1) < same_period)
        return true;
    follow_family(s, wanted, s->found);
    const double last = s->found->solution.period;
    s->found->family_from = first;
    if (last == wanted)
        return true;
    if (cancelled(s->request->cancel))
        return error_set(error, ERROR_CANCELLED, "cancelled");
    if (last == first)
        follow_family(s, first * first / wanted, &away);
    if (away.solution.period == first && last == first)
        return error_set(error, ERROR_COMMAND, "every orbit of this family has the period %.10g s",
                         first);
    return error_set(error, ERROR_COMMAND,
                     "no orbit of this family with the period %.6g s was found: it was followed "
                     "from %.6g s to %.6g s",
                     wanted, first, last);
}
