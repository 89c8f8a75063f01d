/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Long-term behaviour in which a motion ends. */
#pragma once

#include <hooke/scene/model.h>

struct cancel;

/* Largest number of variables of a scene whose attractors can be found. */
#define ATTRACTOR_VARIABLES 7

enum basin_kind {
    BASIN_EQUILIBRIUM,
    BASIN_ORBIT,
    BASIN_RESPONSE, /* periodic with the drive's period, or a multiple of it */
    BASIN_IRREGULAR /* does not repeat */
};

struct basin {
    enum basin_kind kind;
    double state[ATTRACTOR_VARIABLES]; /* SI, on it */
    double period; /* [s]; 0 for an equilibrium, NAN if the motion does not repeat */
    int multiple;  /* period as a multiple of the drive's */
    /* Largest modulus of a multiplier, without the trivial one; for an equilibrium the largest real
     * part [1/s]; NAN if it is not known. */
    double growth;
    bool stable;
    int64_t count; /* starts that end there */
};

/*
 * Returns a number for the attractor that the motion from the scene's own start reaches. 0 stands
 * for an equilibrium and 1 for a closed orbit; with a drive it is the number of drive periods after
 * which the response repeats. ATTRACTOR_IRREGULAR means that it has not repeated within 1000 looks,
 * and NAN that it escapes, that nothing attracts, that the search was cancelled, or that it could
 * not begin. Unless basin is NULL, a search that began fills *basin with the attractor, except for
 * its count, or with BASIN_IRREGULAR and zeros if none was found.
 */
#define ATTRACTOR_IRREGULAR (-1)
typedef double find_attractor(const struct scene *scene, const struct cancel *cancel,
                              struct basin *basin);
