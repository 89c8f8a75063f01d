/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Step bodies made for one method and one kind of scene. */
#include "step.h"

march_function *method_kernel(const struct method *method, const struct system *system, enum drag drag)
{
    (void)method, (void)system, (void)drag;
    return NULL;
}
