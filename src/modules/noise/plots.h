/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions of the module's plots. */
#pragma once

#include <hooke/plot.h>

/* Returns true after a command langevin, or ensemble. */
bool noise_langevin_known(const struct session *session);
bool noise_ensemble_known(const struct session *session);
bool noise_langevin_figure(struct drawing *d, struct figure *figure);
bool noise_ensemble_figure(struct drawing *d, struct figure *figure);
