/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions behind `plot sweep`, which plots.def names. */
#pragma once

#include <hooke/plot.h>

/* Returns true if a sweep has been made whose table is kept. */
bool sweep_known(const struct session *session);
/* Draws the last sweep into *figure: a curve, an orbit diagram, or a map over two parameters.
 * Returns false with an error if there is none or if it cannot be drawn. */
bool sweep_figure(struct drawing *d, struct figure *figure);
