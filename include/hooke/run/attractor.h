/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a motion ends in. */
#ifndef HOOKE_RUN_ATTRACTOR_H
#define HOOKE_RUN_ATTRACTOR_H

#include <hooke/scene/model.h>

struct cancel;

#define ATTRACTOR_VARIABLES 7 /* of a scene whose attractors can be found */

enum basin_kind {
    BASIN_EQUILIBRIUM,
    BASIN_ORBIT,
    BASIN_RESPONSE, /* with the drive's period, or a multiple of it */
    BASIN_IRREGULAR /* does not repeat */
};

struct basin {
    enum basin_kind kind;
    double state[ATTRACTOR_VARIABLES]; /* SI, on it */
    double period;                     /* [s] 0: equilibrium; NAN: it does not repeat */
    int multiple;                      /* of the drive's period */
    double growth; /* largest modulus of a multiplier, without the trivial one; of an equilibrium
                    * largest real part [1/s]; NAN: not known */
    bool stable;
    int64_t count; /* starts that end there */
};

/*
 * What the motion from the scene's own start ends in, by a number: 0 an equilibrium, 1 a closed
 * orbit, of a drive how many of its periods the response has, ATTRACTOR_IRREGULAR: has not come
 * again in 1000 looks. NAN: escapes, nothing attracts, or cancelled. basin: that attractor, but for
 * its count; NULL.
 */
#define ATTRACTOR_IRREGULAR (-1)
typedef double find_attractor(const struct scene *scene, const struct cancel *cancel,
                              struct basin *basin);

#endif
