/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Boundaries of the regions in which methods are stable, as rows of a table for plots: call
 * region_trace(), read the rows by region_columns(), call region_free(). */
#pragma once

#include <math.h>

#include "modules/comparison/compute/stability.h"

/* Planes in which boundaries are drawn. */
enum region_plane {
    REGION_Z,      /* plane of z = lambda dt: a step does not grow */
    REGION_STARS,  /* plane of z: a step grows less than the exact solution (order star) */
    REGION_DAMPED, /* zeta and omega dt of a damped oscillator */
};

/* A point of the plane. Points of one line follow each other; a row with x and y NAN ends a
 * line. */
struct region_row {
    const char *part;  /* "boundary", "scene" (its eigenvalues times dt), "limit" (times dt_max) */
    const char *curve; /* name of the method, or what the point is */
    double x, y;       /* Re z and Im z, or zeta and omega dt */
    /* [s] longest stable step of the method on this scene, or NAN if the row belongs to no
     * method */
    double dt_max;
};

struct region {
    struct region_row *row; /* [rows] owned, release with region_free() */
    size_t rows, capacity;
};

extern const struct catalog
    region_catalog; /* names and explanations of the planes, indexed by enum region_plane */
/* Returns the columns of struct region_row in that plane. */
const struct result_columns *region_columns(enum region_plane plane);

/* Appends the boundaries of the studied methods, the eigenvalues of the scene times dt and those
 * times dt_max. The region is zeroed at first. Returns false with an error if out of memory or
 * cancelled; region_free() must be called in any case. */
bool region_trace(enum region_plane plane, const struct stability *stability, int count,
                  const struct cancel *cancel, struct region *region, struct error *error);
/* Frees the rows and zeroes the structure. */
void region_free(struct region *region);

/* Returns the limit if it is positive and finite, and otherwise the other value. */
static inline double finite_or(double limit, double otherwise)
{
    return isfinite(limit) && limit > 0 ? limit : otherwise;
}
