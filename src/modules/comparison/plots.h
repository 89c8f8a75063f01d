/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions behind the plots of the module, which plots.def names: the diagram of `precision`, and
 * the studies that `plot NAME METHOD..` makes first. */
#pragma once

#include <hooke/plot.h>

/* Returns true if a precision study has been made. */
bool precision_known(const struct session *session);
/* Draws the diagram of the last precision study into *figure. Returns false with an error if there
 * is none or if out of memory. */
bool precision_plot(struct drawing *d, struct figure *figure);
/* Turns letters into names for a picture, which has room for them: in the labels, guides and notes
 * of a *figure that precision_plot() has made. Returns false if out of memory. */
bool precision_name_curves(const struct session *session, struct arena *arena,
                           struct figure *figure, struct error *error);
/* Appends the letters of the curves with their methods, in lines of `width` [cells]. */
void precision_plot_legend(const struct session *session, int width, struct buffer *text);

/* Make a study for `plot NAME METHOD..` and store its table as a result, from which the figure is
 * then drawn: measured orders, boundaries of stability in the plane of lambda dt, order stars,
 * boundaries over zeta and omega dt, errors along the run. Without methods the latest study, or the
 * session's own method, is shown. Return false with an error if nothing can be shown or if
 * cancelled. */
typedef bool plot_study(struct session *session, const struct row *const *method, int methods,
                        struct reply *reply, struct error *error);
plot_study order_study, boundary_study, stars_study, region_study, along_study;
