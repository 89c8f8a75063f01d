/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The longest step that a method takes on a system at all, whether it would be stable or not. */
#pragma once

#include <hooke/method.h>

/* Returns the largest dt [s] that method_fits() accepts, HUGE_VAL if it accepts every one and 0 if
 * it accepts none. */
double plan_step_limit(const struct system *system, const struct method *method, enum drag drag);
