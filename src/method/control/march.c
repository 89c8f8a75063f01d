/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Many steps of one size: as many as a kernel takes, the others one by one. */
#include "method/step/step.h"

/* Takes the steps of a march, as many as possible by the kernel. Returns how many; the step at
 * which a kernel ended early is tried once more, which gives the reason in *status. */
int64_t method_march(const struct method *method, march_function *kernel, const struct march *march,
                     enum step_status *status)
{
    struct step *step = march->step;
    int n = step->system->n;
    *status = STEP_OK;
    /* The next step alone gives the reason if a kernel ends early. */
    for (int64_t i = kernel ? kernel(method, march) : 0; i < march->count; i++) {
        step->t = march->origin + (double)(march->first + i) * step->h;
        *status = method_step(method, step);
        if (*status != STEP_OK)
            return i;
        memcpy(march->row + i * n, step->y, (size_t)n * sizeof *step->y);
    }
    return march->count;
}
