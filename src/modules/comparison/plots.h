/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions of the module's plot. */
#pragma once

#include <hooke/plot.h>

/* Returns true if a precision study has been made. */
bool precision_known(const struct session *session);
bool precision_plot(struct drawing *d, struct figure *figure);
bool precision_name_curves(const struct session *session, struct arena *arena,
                           struct figure *figure, struct error *error);
void precision_plot_legend(const struct session *session, int width, struct buffer *text);

/* Make the tables of `plot NAME METHOD..`: measured orders, boundaries of stability in the plane of
 * lambda dt, order stars, boundaries over zeta and omega dt, errors along the
 * run. */
typedef bool plot_study(struct session *session, const struct row *const *method, int methods,
                        struct reply *reply, struct error *error);
plot_study order_study, boundary_study, stars_study, region_study, along_study;
