/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Switches in adaptive steps (switch.c). */
#pragma once

#include "method/step/step.h"

/*
 * Finds the branches at the start of a step, and freezes the system on them; `probe_step` is about
 * the size of the planned step. Returns false if no branch leads on and the motion does not slide.
 */
bool switch_begin(struct step *step, struct switches_state *state, double probe_step,
                  struct sliding *sliding, struct system *frozen);
/* The state is put on the switches along which it slides. */
void switch_go_back(struct step *step, const struct system *frozen);

/*
 * Ends a step of the frozen system from `y_begin` at t. A step across the end of a branch is taken
 * again, up to there; then step->h is less and *ended the switch, else it is -1.
 */
enum step_status switch_step(const struct method *method, struct step *step, double t,
                             const double *y_begin, const double *low, int *ended);

/* One step of step->h of a system with pieces (switch_fixed.c). */
enum step_status switched_step(const struct method *method, struct step *step);

/* As method_turning_march(), where typed equations switch. */
int64_t switched_march(const struct method *method, const struct march *march,
                       enum step_status *status);

/* Returns true if the equations are defined where a step on frozen branches has ended. Tests this
 * only where they may be undefined. */
bool switch_is_there(struct step *step);
/* Takes note of an accepted step. */
void switch_next(struct step *step, struct switches_state *state, int ended);
