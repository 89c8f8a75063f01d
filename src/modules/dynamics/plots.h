/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions of the plots of the module dynamics, for plots.def, which make the figure of each and
 * tell when it is offered. */
#pragma once

#include <hooke/plot.h>

extern const struct plane_row portrait_plane;

/* Returns true if the model has two variables or more. */
bool portrait_fits(const struct model *model);
/* Returns true if the session's scene can have a portrait. */
bool portrait_offered(const struct session *session);
/* Makes the figure of the phase portrait; returns false with d->error. */
bool portrait_figure(struct drawing *d, struct figure *figure);
/* Replies separatrices, with the points at which they cross the lines through equilibria, and what
 * the portrait cost (portrait.c). */
void reply_portrait(const struct session *session, const struct figure_request *request,
                    struct reply *reply);
/* Returns true if there is a branch; makes the figure of branches over their parameter. */
bool branches_known(const struct session *session);
bool branches_figure(struct drawing *d, struct figure *figure);
/* Returns true if there is a map of basins; makes the figure of the last one. */
bool basins_known(const struct session *session);
bool basins_figure(struct drawing *d, struct figure *figure);
