/* SPDX-License-Identifier: GPL-3.0-or-later */
/* step_limit: the longest step that a method can take on a system, whether or not the solution is
 * stable. */
#pragma once

#include <hooke/method.h>

/* Returns the largest dt [s] for which method_fits() (<hooke/method.h>) is true for this system,
 * method and variant of drag: the method can take steps of this size at all. Splittings of higher
 * order have a limit, because their backward substeps are unstable with strong drag. Returns
 * HUGE_VAL if every dt is possible, 0 if none is. */
double plan_step_limit(const struct system *system, const struct method *method, enum drag drag);
