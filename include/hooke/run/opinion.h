/* SPDX-License-Identifier: GPL-3.0-or-later */
/* opinion: what the second opinion of a run (struct opinion) says of its present time. */
#ifndef HOOKE_OPINION_H
#define HOOKE_OPINION_H

#include <hooke/run.h>

/* The error at the run's present time; NAN if the second solution did not go there: struct
 * opinion's error is that at opinion.t, and nothing is known of what comes later. */
double run_opinion_error(const struct run *run);
/* [s] From there on errors of the tolerance grow, and were 100 times as large at opinion.lost,
 * where the variables are still below it: neither solution knows them. NAN: nowhere. */
double run_opinion_sunk(const struct run *run);

#endif
