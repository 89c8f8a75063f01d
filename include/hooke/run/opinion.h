/* SPDX-License-Identifier: GPL-3.0-or-later */
/* opinion: queries about the opinion on an adaptive run: the estimate of its error, found by
 * comparison with the closed form or, if none is known, with a second solution of the same scene by
 * another method at a smaller tolerance (struct opinion in <hooke/run.h>). Call
 * run_second_opinion() first. */
#pragma once

#include <hooke/run.h>

/* Returns the estimated error at the run's current time, relative to the sizes of the variables;
 * NAN if the second solution did not get to that time. */
double run_opinion_error(const struct run *run);
/* OPINION_BRIEF is the smallest effort of run_second_opinion() (enum opinion_effort). It first
 * allows a number of evaluations for the second solution that is the fraction OPINION_BRIEF_SHARE
 * of those of the run, but at least OPINION_BRIEF_MIN. */
#define OPINION_BRIEF_SHARE 0.23
#define OPINION_BRIEF_MIN 300
/* Error, relative to the sizes of the variables, above which no digit is reliable. */
#define OPINION_LOST 0.5

/* Returns the time [s] at which variables that had sunk below the tolerance (decayed to a value
 * that is smaller than the error allowed) begin to grow again. The values to which they then grow
 * come from errors, so that both solutions are unreliable. Returns NAN if this does not happen. */
double run_opinion_sunk(const struct run *run);
/* Returns the time [s] of the first event for which the error decides whether it happens at all, so
 * that all later values are unknown; NAN if there is none. */
double run_opinion_event(const struct run *run);
