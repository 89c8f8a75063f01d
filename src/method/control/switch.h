/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Switches in steps; switch.c explains guards and sliding. Each step calls switch_begin(), steps
 * the frozen system, calls switch_step() to end it at a switch, and switch_next() if it is
 * accepted. */
#pragma once

#include "method/step/step.h"

/*
 * Finds the branches at the start of a step, and freezes the system on them; `probe_step` is about
 * the size of the planned step. Returns false if no branch leads on and the motion does not slide.
 */
bool switch_begin(struct step *step, struct switches_state *state, double probe_step,
                  struct sliding *sliding, struct system *frozen);
/* Moves the state onto the switches along which it slides, from which rounding has moved it. */
void switch_go_back(struct step *step, const struct system *frozen);

/* Ends a step of the frozen system from y_begin at t. A step across the end of a branch is taken
 * again, up to that end; step->h is then shorter and *ended the switch, else *ended is -1. low
 * holds step->low as it was before, if there is one. */
enum step_status switch_step(const struct method *method, struct step *step, double t,
                             const double *y_begin, const double *low, int *ended);

/* Takes one step of step->h of a system with switches, in segments that meet at them
 * (switch_fixed.c). On failure the state is unchanged. */
enum step_status switched_step(const struct method *method, struct step *step);

/* Does the same as method_turning_march(), for typed equations with switches. */
int64_t switched_march(const struct method *method, const struct march *march,
                       enum step_status *status);

/* Returns true if the equations are defined where a step on frozen branches has ended. Tests this
 * only where they may be undefined. */
bool switch_is_there(struct step *step);
/* Prepares the state of the switches for the next step after an accepted one that ended at switch
 * `ended`, or at none (-1). */
void switch_next(struct step *step, struct switches_state *state, int ended);
