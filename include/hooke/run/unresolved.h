/* SPDX-License-Identifier: GPL-3.0-or-later */
/* unresolved: detects fixed steps that are too long to see how a force changes in time. */
#pragma once

#include <hooke/run.h>

/* A force counts as constant in time if its changes (as a root mean square) are below this fraction
 * of the largest magnitudes of the derivatives. */
#define FORCE_VARIES_MIN 1e-3
/* Steps are too long if they miss more than this fraction of the changes of the force in time (both
 * as root mean squares). */
#define FORCE_MISSED_SHARE 0.5

/* Returns true if the steps of a run do not resolve how a force changes in time: the values at the
 * beginning, middle and end of each step do not show it. Either the steps are too long, or they are
 * a multiple of the force's period (all steps see the same phase), or a pulse lies inside one of
 * them. Sets *dt to a step [s] that resolves the force, or to NAN if none was found. Returns false
 * for adaptive runs, for exact solutions, and if steps end at the jumps of a force. */
bool run_force_unresolved(const struct run *run, double *dt);

/* Returns true if a typed force depends on time, and so may have pulses; a built-in drive is a
 * cosine. */
bool run_force_may_pulse(const struct system *system);
/* Returns true if no force depends on time, or only a built-in drive with a phase of less than 1
 * rad in a step of h [s]. */
bool run_force_is_slow(const struct system *system, double h);

/* Returns the number of steps of a run that are searched for pulses, and sets *probes to the number
 * of points inside each step at which the force is evaluated, in addition to 3 points of the step
 * itself. `steps` and `evals` are the numbers of steps and of evaluations of the run. */
int64_t run_probed_steps(const struct system *system, int64_t steps, int64_t evals, int *probes);
