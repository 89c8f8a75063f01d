/* SPDX-License-Identifier: GPL-3.0-or-later */
/* opinion: what the second opinion of a run (struct opinion) says of its present time. */
#pragma once

#include <hooke/run.h>

/* The error at the run's present time; NAN if the second solution did not go there: struct
 * opinion's error is that at opinion.t, and nothing is known of what comes later. */
double run_opinion_error(const struct run *run);
/* Share of the run's work that a brief opinion may take at first, or that many of the run's
 * evaluations where these are more. */
#define OPINION_BRIEF_SHARE 0.23
#define OPINION_BRIEF_MIN 300
/* Error, in sizes of the variables, from which on no digit is certain. */
#define OPINION_LOST 0.5

/* Returns the time [s] from which on errors of variables that came to rest within the tolerance are
 * multiplied, so that neither solution knows them from opinion.lost on; NAN if there is none. */
double run_opinion_sunk(const struct run *run);
/* Returns the time [s] of an event that is met or missed by less than the error, so that everything
 * after it is unknown, or NAN if there is none. */
double run_opinion_event(const struct run *run);
