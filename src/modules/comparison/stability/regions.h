/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Boundaries of stability, as rows of a table. */
#pragma once

#include <math.h>

#include "modules/comparison/compute/stability.h"

/* Planes in which boundaries are drawn. */
enum region_plane {
    REGION_Z,      /* plane of z = lambda dt: a step does not grow */
    REGION_STARS,  /* plane of z: a step grows less than the exact solution (order star) */
    REGION_DAMPED, /* zeta and omega dt of a damped oscillator */
};

/* A point of the plane; of one part and curve they follow each other, with a gap, both NAN, behind
 * each line. */
struct region_row {
    const char *part;  /* "boundary", "scene" (its eigenvalues times dt), "limit" (times dt_max) */
    const char *curve; /* name of the method, or what the point is */
    double x, y;       /* Re z and Im z; zeta and omega dt */
    double dt_max;     /* [s] of the method on this scene, NAN where it is of no method */
};

struct region {
    struct region_row *row; /* [rows] owned: region_free() */
    size_t rows, capacity;
};

extern const struct catalog region_catalog; /* kinds of tables, at the enum's place */
/* Columns of struct region_row in each plane. */
const struct result_columns *region_columns(enum region_plane plane);

/* Traces the boundaries of methods, and places the eigenvalues of the scene at dt. Returns false if
 * out of memory or cancelled. */
bool region_trace(enum region_plane plane, const struct stability *stability, int count,
                  const struct cancel *cancel, struct region *region, struct error *error);
void region_free(struct region *region);

/* Returns the limit if it is positive and finite, and otherwise the other value. */
static inline double finite_or(double limit, double otherwise)
{
    return isfinite(limit) && limit > 0 ? limit : otherwise;
}
