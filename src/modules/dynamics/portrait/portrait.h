/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the parts of a portrait share. */
#pragma once

#include "modules/dynamics/portrait.h"

#include "modules/dynamics/orbits/field.h"

struct cancel;

struct portrait_work {
    const struct portrait_request *request;
    struct portrait *portrait;
    struct vector_field field;
    const struct system *bounded; /* has bounds, or NULL if it has none */
};

bool polyline_gap(struct polyline *line);

/* Request for the lines f = 0 in the box by marching squares. `may_be_zero` tests the bounds of f
 * on a cell; if NULL, lines smaller than a cell may be missed. */
struct level_request {
    double (*value)(const void *context, double x, double y);
    bool (*may_be_zero)(const void *context, const double box[2][2]);
    const void *context;
    const double (*box)[2];
    const struct cancel *cancel;
};
bool level_lines(const struct level_request *request, struct polyline *line);

bool portrait_separatrices(struct portrait_work *work); /* Returns false if out of memory. */
