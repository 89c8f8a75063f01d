/* SPDX-License-Identifier: GPL-3.0-or-later */
/* bursts: the search for bursts of system_bursts() (<hooke/scene/model.h>) with a limit on its
 * cost. A burst is a short interval in time in which a force of a typed equation changes so fast
 * that an adaptive step could miss it. */
#pragma once

#include <hooke/scene/model.h>

/* Finds the bursts between t[0] and t[1] [s]. The motion from the state y_begin [n] at t[0] to
 * y_end [n] at t[1] is assumed to be smooth; bounds of the typed equations on each interval are
 * compared with samples in it. Examines at most *allowed intervals, and subtracts from *allowed the
 * number that it examined. With `sure`, an interval is a burst only if samples in it differ from
 * what the motion around it predicts, so that smooth forces give none; without it, smooth forces
 * may give some, too, which costs only additional steps. The array burst [max] contains `count`
 * bursts from earlier calls; a new one is merged with those that it overlaps, else appended, or
 * dropped if the array is full. Returns the new number of bursts. A scene without typed equations
 * has none. */
int bursts_within(const struct system *system, const double t[2], const double *y_begin,
                  const double *y_end, bool sure, int64_t *allowed, struct burst *burst, int count,
                  int max);
