/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fixed steps that do not see how a force changes in time. */
#pragma once

#include <hooke/run.h>

/* Relative size below which changes of a force in time are of no interest. */
#define FORCE_VARIES_MIN 1e-3
/* Share of the force's changes in time, as a root mean square, that steps may miss. */
#define FORCE_MISSED_SHARE 0.5

/* Returns true if inside of the steps of a run the force changes in time by other values than the
 * beginning, middle and end of each step show: the steps are too long for it, or a multiple of its
 * period, so that every step sees the same, or there is a pulse in one of them. Then *dt [s] is a
 * step that sees it, NAN if none was found. False for adaptive runs, for exact solutions and where
 * steps end at the jumps of a force.
 */
bool run_force_unresolved(const struct run *run, double *dt);

/* Returns true if a force that was typed depends on time: a scene's own drive is a cosine. */
bool run_force_may_pulse(const struct system *system);
/* Returns true if no force depends on time, or only a drive by less than a radian in a step of h.
 */
bool run_force_is_slow(const struct system *system, double h);

/* Returns how many steps of a run are looked at for pulses, each by 3 evaluations and *probes. */
int64_t run_probed_steps(const struct system *system, int64_t steps, int64_t evals, int *probes);
