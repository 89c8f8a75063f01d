/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Velocity and energy of a recording of positions. */
#ifndef HOOKE_COMMAND_DATA_MOTION_H
#define HOOKE_COMMAND_DATA_MOTION_H

#include "internal.h"

struct data_motion {
    size_t n;
    const double *t, *y;      /* [n] as recording_series gives them */
    double *v;                /* [n] [m/s] NAN: not known there */
    double *energy;           /* [n] [J] NAN: not known there; NULL: not asked for */
    double middle;            /* [m] equilibrium, in y */
    double omega;             /* [rad/s] of the oscillation; NAN: it has none */
    enum quantity quantity;   /* of v */
    double gain;              /* [1/s] standard deviation of v for positions with independent noise of 1 */
    double loss;              /* by which part v comes out too small; 0: of the sensor's own */
    struct measured mass, k;  /* of the energy */
    struct energy_noise noise;
    char how_v[160], how_k[160]; /* where they come from, in words */
};

/* series: of the recording; NULL: its window. */
bool data_motion(const struct session *session, const struct recording *recording, const struct series *series,
                 bool energy, struct arena *arena, struct data_motion *motion, struct error *error);
/* [rad/s] of the oscillation: of the fit, else of the largest peak of the spectrum; NAN: it has none. */
double motion_frequency(const struct session *session, const struct recording *recording, const struct series *series,
                        struct arena *arena);
/* The rows where v (energy: the energy) is known, as a series; from, to [s]. */
bool motion_series(const struct data_motion *motion, bool energy, double from, double to, struct arena *arena,
                   struct series *series, struct error *error);

#endif
