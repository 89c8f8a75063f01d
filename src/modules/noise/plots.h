/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions of the plots of the module noise, for plots.def. */
#pragma once

#include <hooke/plot.h>

/* Return true if a path, or an ensemble, is stored; make its figure, or return false with
 * d->error. */
bool noise_langevin_known(const struct session *session);
bool noise_ensemble_known(const struct session *session);
bool noise_langevin_figure(struct drawing *d, struct figure *figure);
bool noise_ensemble_figure(struct drawing *d, struct figure *figure);
