/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What is known of the uncertainty of an adopted scene. */
#ifndef HOOKE_COMMAND_DATA_ADOPTED_H
#define HOOKE_COMMAND_DATA_ADOPTED_H

#include <hooke/session/subject.h>

/* y0 and v0 of the fit at its t0, or at rest at its amplitude, as a position about its middle. n:
 * how often that was differentiated to give what was fitted. */
void adopted_start(const struct fit *fit, int n, bool at_rest, struct measured start[2]);

/* The fit of what is `scale` times as large: of a position [m, rad] from a voltage [V] or a force
 * [N]. */
void adopted_scale(struct fit *fit, double scale);

/* Covariances of a scene's parameters from those of the fit of an oscillation; the mass counts as
 * exact, as it is one motion. starts: y0 and v0 are those of the fit. */
void adopted_motion(struct adopted_fit *adopted, const struct fit *fit, int n, bool at_rest,
                    bool starts);
/* Of those that were free in a fit of the scene. */
void adopted_free(struct adopted_fit *adopted, const bool *is_free,
                  const struct fit_covariance *covariance);

#endif
