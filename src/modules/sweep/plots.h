/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions of the module's plot. */
#ifndef HOOKE_MODULES_SWEEP_PLOTS_H
#define HOOKE_MODULES_SWEEP_PLOTS_H

#include <hooke/plot.h>

/* Returns true if a sweep has been made whose table is kept. */
bool sweep_known(const struct session *session);
bool sweep_figure(struct drawing *d, struct figure *figure);

#endif
