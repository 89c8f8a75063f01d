/* SPDX-License-Identifier: GPL-3.0-or-later */
/* opinion: questions about the estimated error of an adaptive run (struct opinion in <hooke/run.h>)
 * at its current time. Call run_second_opinion() before. */
#pragma once

#include <hooke/run.h>

/* Returns the error at the run's current time; NAN if the second solution did not get there. */
double run_opinion_error(const struct run *run);
/* Work that OPINION_BRIEF allows at first: this fraction of the run's own, or this number of
 * evaluations if that is more. */
#define OPINION_BRIEF_SHARE 0.23
#define OPINION_BRIEF_MIN 300
/* Error, relative to the sizes of the variables, above which no digit is reliable. */
#define OPINION_LOST 0.5

/* Returns the time [s] from which errors are unknown to both solutions, because variables that had
 * come to rest within the tolerance grow again; NAN if there is none. */
double run_opinion_sunk(const struct run *run);
/* Returns the time [s] of an event that happens or not within the error, so that everything after
 * it is unknown; NAN if there is none. */
double run_opinion_event(const struct run *run);
