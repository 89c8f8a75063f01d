/* SPDX-License-Identifier: GPL-3.0-or-later */
/* bursts: the search of system_bursts() (<hooke/scene/model.h>) with a limit on its cost. A burst
 * is a short interval in which a force changes so fast that an adaptive step could miss it. */
#pragma once

#include <hooke/scene/model.h>

/* Does the same as system_bursts(), and examines at most *allowed intervals in time; subtracts from
 * *allowed the number that it examined. */
int bursts_within(const struct system *system, const double t[2], const double *y_begin,
                  const double *y_end, bool sure, int64_t *allowed, struct burst *burst, int count,
                  int max);
