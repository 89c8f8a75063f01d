/* SPDX-License-Identifier: GPL-3.0-or-later */
/* opinion: queries about the estimated error of an adaptive run, which is found by comparison with
 * a second solution (struct opinion in <hooke/run.h>). Call run_second_opinion() first. */
#pragma once

#include <hooke/run.h>

/* Returns the estimated error, relative to the sizes of the variables, at the run's current time;
 * NAN if the second solution did not get that far. */
double run_opinion_error(const struct run *run);
/* Work on the second solution that OPINION_BRIEF allows at first: this fraction of the run's own
 * evaluations, or OPINION_BRIEF_MIN evaluations if that is more. */
#define OPINION_BRIEF_SHARE 0.23
#define OPINION_BRIEF_MIN 300
/* Error, relative to the sizes of the variables, above which no digit is reliable. */
#define OPINION_LOST 0.5

/* Returns the time [s] at which variables that had come to rest, below the tolerance, begin to grow
 * again. From then on their values have grown from errors, and neither solution can tell how large
 * these are. Returns NAN if this does not happen. */
double run_opinion_sunk(const struct run *run);
/* Returns the time [s] of the first event for which the error decides whether it happens at all, so
 * that all later values are unknown; NAN if there is none. */
double run_opinion_event(const struct run *run);
