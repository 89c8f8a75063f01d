/* SPDX-License-Identifier: GPL-3.0-or-later */
/* step_limit: the longest step that a method can take on a system at all, stable or not. */
#pragma once

#include <hooke/method.h>

/* Returns the largest dt [s] that method_fits() accepts for this system, method and treatment of
 * drag: HUGE_VAL if it accepts every dt, 0 if it accepts none. */
double plan_step_limit(const struct system *system, const struct method *method, enum drag drag);
