/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Shared by the files that compute a phase portrait: portrait.c, levels.c (lines f = 0),
 * separatrix.c (trajectories). */
#pragma once

#include "modules/dynamics/portrait.h"

#include "modules/dynamics/orbits/field.h"

struct cancel;

/* A portrait that is being computed. */
struct portrait_work {
    const struct portrait_request *request;
    struct portrait *portrait;
    struct vector_field field;
    const struct system *bounded; /* has bounds, or NULL if it has none */
};

/* Appends a gap. Returns false if out of memory. */
bool polyline_gap(struct polyline *line);

/* Request for the lines f = 0 in a box by marching squares. may_be_zero() tells whether the bounds
 * of f on a cell contain 0; if it is NULL, closed lines smaller than a cell may be missed. */
struct level_request {
    double (*value)(const void *context, double x, double y);
    bool (*may_be_zero)(const void *context, const double box[2][2]);
    const void *context;
    const double (*box)[2];
    const struct cancel *cancel;
};
/* Appends the lines f = 0. Returns false if out of memory; if cancelled, lines are incomplete. */
bool level_lines(const struct level_request *request, struct polyline *line);

/* Follows the separatrices of all saddles. Returns false if out of memory. */
bool portrait_separatrices(struct portrait_work *work);
