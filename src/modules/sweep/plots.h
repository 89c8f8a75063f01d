/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions of the module's plot. */
#pragma once

#include <hooke/plot.h>

/* Returns true if a sweep has been made whose table is kept. */
bool sweep_known(const struct session *session);
bool sweep_figure(struct drawing *d, struct figure *figure);
