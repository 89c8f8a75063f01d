/* SPDX-License-Identifier: GPL-3.0-or-later */
/* unresolved: detects fixed steps that are too long to see how a force changes in time. */
#pragma once

#include <hooke/run.h>

/* Relative size below which changes of a force in time are ignored. */
#define FORCE_VARIES_MIN 1e-3
/* Fraction of the changes of the force in time, as a root mean square, that steps may miss. */
#define FORCE_MISSED_SHARE 0.5

/* Returns true if the steps of a run do not resolve how a force changes in time, so that the
 * beginning, middle and end of each step do not show its values. Either the steps are too long, or
 * they are a multiple of its period (all of them see the same phase), or a pulse lies inside one of
 * them. Sets *dt to a step [s] that resolves it, or to NAN if none was found. Returns false for
 * adaptive runs, for exact solutions, and if steps end at the jumps of a force. */
bool run_force_unresolved(const struct run *run, double *dt);

/* Returns true if a typed force depends on time, and so may have pulses; a built-in drive is a
 * cosine. */
bool run_force_may_pulse(const struct system *system);
/* Returns true if no force depends on time, or only a built-in drive with a phase of less than 1
 * rad in a step of h [s]. */
bool run_force_is_slow(const struct system *system, double h);

/* Returns the number of steps of a run that are searched for pulses, each by 3 evaluations and
 * *probes more. `steps` and `evals` are those of the run. */
int64_t run_probed_steps(const struct system *system, int64_t steps, int64_t evals, int *probes);
