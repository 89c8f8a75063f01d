/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Floquet multipliers of periodic orbits, from the maps of the orbit's segments. */
#pragma once

#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/orbits/continuation.h"

/* The derivatives of the flow over each segment of an orbit. */
struct orbit_maps {
    int n, segments;
    const double *map; /* [segments][n][n] maps in the order of time */
    /* [segments][n] rate at each start; NULL if driven, when no multiplier is trivial */
    const double *rate;
    double log_determinant; /* logarithm of the determinant of their product */
};

/* The multipliers of an orbit. */
struct multipliers {
    int count;                                /* number of multipliers without the trivial one */
    struct eigenvalue value[FIELD_VARIABLES]; /* the largest first */
    double noise; /* multipliers smaller than this are below the errors of the maps */
    /* Distance of the trivial one from 1, or NAN if there is none. */
    double trivial;
    double log_determinant; /* logarithm of the determinant of the whole map */
};

/* Computes the multipliers of an orbit. `tol` is the relative error of the maps. Returns false if
 * no eigenvalues are found. */
bool orbit_multipliers(const struct orbit_maps *maps, double tol, struct multipliers *multipliers);
/* Returns a function that passes 0 where a multiplier is -1, or NAN if its sign is unknown. */
double multipliers_doubling(const struct multipliers *multipliers);
/* Returns a function that passes 0 where the product of two multipliers is 1, or NAN if its sign is
 * unknown. */
double multipliers_torus(const struct multipliers *multipliers);
