/* SPDX-License-Identifier: GPL-3.0-or-later */
/* attractor: the long-term behaviour in which a motion ends, and the type of the function that
 * finds it, by which basins and sweeps call the module `dynamics`. */
#pragma once

#include <hooke/scene/model.h>

struct cancel;

/* Largest number of variables of a scene whose attractors can be found. */
#define ATTRACTOR_VARIABLES 7

/* Kind of an attractor. */
enum basin_kind {
    /* A state of rest. */
    BASIN_EQUILIBRIUM,
    /* A limit cycle of a scene without a drive. */
    BASIN_ORBIT,
    BASIN_RESPONSE, /* Periodic with the drive's period or a multiple of it. */
    BASIN_IRREGULAR /* Does not repeat. */
};

/* An attractor, and the number of starts that lead to it. */
struct basin {
    enum basin_kind kind;
    double state[ATTRACTOR_VARIABLES]; /* A state on it [SI]. */
    double period; /* Period [s]; 0 for an equilibrium, NAN if the motion does not repeat. */
    int multiple;  /* Period as a multiple of the drive's. */
    /* Measure of stability. For a periodic motion the largest modulus of a Floquet multiplier other
     * than the trivial one; for an equilibrium the largest real part of an eigenvalue [1/s]. NAN if
     * unknown. */
    double growth;
    bool stable;   /* Small deviations decay. */
    int64_t count; /* Number of starts that end there. */
};

/* Result of find_attractor() for a motion that does not repeat. */
#define ATTRACTOR_IRREGULAR (-1)

/* Finds the attractor that the motion from the scene's own start reaches, and returns a number for
 * it: 0 for an equilibrium, 1 for a closed orbit; with a drive the number of drive periods after
 * which the response repeats; ATTRACTOR_IRREGULAR if it has not repeated within 1000 comparisons;
 * NAN if it escapes, if nothing attracts it, if the search was cancelled or could not begin. Unless
 * `basin` is NULL, a search that began fills *basin but for its count, or with BASIN_IRREGULAR and
 * zeros if it found nothing. `cancel` may be NULL. */
typedef double find_attractor(const struct scene *scene, const struct cancel *cancel,
                              struct basin *basin);
