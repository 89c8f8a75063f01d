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

/* An attractor together with the number of starts that lead to it, which measures the size of its
 * basin of attraction. */
struct basin {
    enum basin_kind kind;
    double state[ATTRACTOR_VARIABLES]; /* A state on it [SI]. */
    double period; /* Period [s]; 0 for an equilibrium, NAN if the motion does not repeat. */
    int multiple;  /* Number of drive periods after which a BASIN_RESPONSE repeats. */
    /* Measure of stability. For a periodic motion the largest modulus of a Floquet multiplier other
     * than the trivial one; for an equilibrium the largest real part of an eigenvalue [1/s]. NAN if
     * unknown. */
    double growth;
    bool stable; /* Small deviations decay. */
    /* Number of starts whose motion ends on this attractor; find_attractor() leaves it at 0. */
    int64_t count;
};

/* Result of find_attractor() for a motion that does not repeat. */
#define ATTRACTOR_IRREGULAR (-1)

/* Finds the attractor that the motion from the initial state of the scene reaches, and returns a
 * number for it: 0 for an equilibrium; 1 for a closed orbit; with a drive, the number of drive
 * periods after which the response repeats; ATTRACTOR_IRREGULAR if the motion has not repeated
 * after 1000 comparisons of its state with earlier ones; NAN if the motion escapes, if no attractor
 * was found, if the search was cancelled or could not begin. Unless `basin` is NULL, a search that
 * began fills *basin, whose kind is BASIN_IRREGULAR, with zeros in all other members, if no
 * attractor was found. `cancel` may be NULL. */
typedef double find_attractor(const struct scene *scene, const struct cancel *cancel,
                              struct basin *basin);
