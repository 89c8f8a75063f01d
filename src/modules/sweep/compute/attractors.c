/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Lists and describes the attractors that the numbers of measure=attractor denote. */
#include "modules/sweep/compute/worker.h"

/* Returns the entry for attractor `number` in found [*count], which is in ascending order; a new
 * number is inserted and *count raised. Returns NULL if there is no room for it. */
static struct sweep_attractor *sweep_attractor_take(struct sweep_attractor *found, int *count,
                                                    double number)
{
    for (int k = 0; k < *count; k++)
        if (found[k].number == number)
            return &found[k];
    if (*count == SWEEP_ATTRACTORS)
        return NULL;
    int k = (*count)++;
    for (; k > 0 && found[k - 1].number > number; k--)
        found[k] = found[k - 1];
    found[k] = (struct sweep_attractor){.number = number, .first = -1};
    return &found[k];
}

/* Lists the attractors among the values of measure number `measure` (attractors' numbers), with
 * their counts and first points, and finds each once more at that point to describe it.
 * found[k].known is false if that gives another attractor. Returns their number. */
int sweep_attractors(const struct sweep_request *request, const struct sweep *sweep, int measure,
                     struct sweep_attractor found[SWEEP_ATTRACTORS])
{
    int count = 0;
    for (int64_t i = 0; i < sweep->count; i++) {
        const double number = sweep->value[i * sweep->measures + measure];
        struct sweep_attractor *one =
            isnan(number) ? NULL : sweep_attractor_take(found, &count, number);
        if (!one)
            continue;
        one->count++;
        one->first = one->first < 0 ? i : one->first;
    }
    for (int k = 0; k < count; k++) {
        struct scene scene;
        struct run_settings settings;
        struct error ignored = {0};
        sweep_common(request, &scene, &settings);
        found[k].known = sweep_point(request, sweep, found[k].first, &scene, &settings, &ignored) &&
                         request->measure[measure].attractor(&scene, request->cancel,
                                                             &found[k].basin) == found[k].number;
    }
    return count;
}
