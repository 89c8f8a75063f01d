/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Multipliers of periodic orbits. */
#pragma once

#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/orbits/continuation.h"

struct orbit_maps {
    int n, segments;
    const double *map; /* [segments][n][n] maps in the order of time */
    /* [segments][n] rate at each start; NULL if driven, when no multiplier is trivial */
    const double *rate;
    double log_determinant; /* logarithm of the determinant of their product */
};

struct multipliers {
    int count;                                /* number of multipliers without the trivial one */
    struct eigenvalue value[FIELD_VARIABLES]; /* the largest first */
    double noise;                             /* Multipliers smaller than this are not known. */
    /* Distance of the trivial one from 1, or NAN if there is none. */
    double trivial;
    double log_determinant; /* logarithm of the determinant of the whole map */
};

/* Computes the multipliers of an orbit. `tol` is the relative error of the maps. Returns false if
 * no eigenvalues are found. */
bool orbit_multipliers(const struct orbit_maps *maps, double tol, struct multipliers *multipliers);
/* Functions that pass 0 where one is -1, or where the product of two is 1; NAN if unknown. */
double multipliers_doubling(const struct multipliers *multipliers);
double multipliers_torus(const struct multipliers *multipliers);
