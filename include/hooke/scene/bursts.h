/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The search of typed equations for bursts, within a number of looks. */
#pragma once

#include <hooke/scene/model.h>

/* Does the same as system_bursts(), and looks at no more than *allowed stretches, from which it
 * subtracts those that it looked at. */
int bursts_within(const struct system *system, const double t[2], const double *y_begin,
                  const double *y_end, bool sure, int64_t *allowed, struct burst *burst, int count,
                  int max);
