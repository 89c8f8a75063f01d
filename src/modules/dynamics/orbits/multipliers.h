/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Multipliers of periodic orbits. */
#pragma once

#include "modules/dynamics/dynamics.h"

#include "modules/dynamics/orbits/continuation.h"

struct orbit_maps {
    int n, segments;
    const double *map; /* [segments][n][n] of each segment, in the order of time */
    /* [segments][n] where each begins; NULL if forced, so that none is trivial */
    const double *rate;
    double log_determinant; /* of their product */
};

struct multipliers {
    int count;                                /* without the trivial one: */
    struct eigenvalue value[FIELD_VARIABLES]; /* the largest first */
    double noise;                             /* what is smaller is not known */
    double trivial;                           /* distance from 1, or NAN if there is none */
    double log_determinant;                   /* of all together */
};

/* tol: relative, of the maps. */
bool orbit_multipliers(const struct orbit_maps *maps, double tol, struct multipliers *multipliers);
/* Functions that pass 0 where one is -1, or where the product of two is 1; NAN if unknown. */
double multipliers_doubling(const struct multipliers *multipliers);
double multipliers_torus(const struct multipliers *multipliers);
