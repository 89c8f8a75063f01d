/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The functions of the module's plots: its figures, and when each is offered. */
#pragma once

#include <hooke/plot.h>

extern const struct plane_row portrait_plane;

bool portrait_fits(const struct model *model);
bool portrait_offered(const struct session *session);
bool portrait_figure(struct drawing *d, struct figure *figure);
/* Adds the points at which separatrices cross the lines through equilibria (portrait.c). */
void reply_portrait(const struct session *session, const struct figure_request *request,
                    struct reply *reply);
/* Branches over their parameter. */
bool branches_known(const struct session *session);
bool branches_figure(struct drawing *d, struct figure *figure);
/* The last map of basins. */
bool basins_known(const struct session *session);
bool basins_figure(struct drawing *d, struct figure *figure);
