/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The largest Lyapunov exponent and the correlation dimension of a series, from neighbours in the
 * space of its delayed values. */
#pragma once

#include <hooke/base/error.h>
#include <hooke/data/series.h>

/*
 * Largest Lyapunov exponent by mean logarithms of distances between neighbours (Rosenstein,
 * Collins, De Luca 1993; Kantz 1994) among vectors of delayed values (Takens 1981). The delay is
 * the first minimum of the mutual information (Fraser, Swinney 1986), or where the correlation has
 * fallen to 1/e; as many of them as leave less than 1 % false neighbours (Kennel, Brown, Abarbanel
 * 1992). Neighbours are no nearer in time than a mean period (Theiler 1986). The error is one
 * standard error: scatter over parts of the series, what halves of the stretch in which distances
 * grow evenly and more delays change, and of flows 8 % of what series of known exponents were off.
 * Of flows distances are taken across them: along them they neither grow nor shrink.
 *
 * It is not determined, with a reason, if there are fewer than EXPONENT_SAMPLES samples or 20
 * turns, if times are not evenly spaced, if the size of the motion changes, if no number of delays
 * unfolds it, if neighbours predict no better than a linear function (noise, smooth noise), if
 * distances do not grow (periodic and quasi-periodic motion, decay), or not exponentially by a
 * factor of EXPONENT_GROWTH.
 */
#define EXPONENT_SAMPLES 1000
#define EXPONENT_GROWTH 5.0

/* Result of series_exponent(). */
struct series_exponent {
    struct measured value; /* [1/s] NAN if not determined */
    bool determined;
    char reason[200];      /* reason if it is not determined */
    double delay;          /* [s] 0, as all members below, if the analysis ended before */
    int dimensions;        /* number of delayed values in a vector */
    double theiler_window; /* [s] smallest distance of neighbours in time (Theiler window) */
    /* [s] range of times, since two vectors were neighbours, in which distances grow
     * exponentially */
    double t_begin, t_end;
    double growth; /* factor by which they grow in it */
    size_t pairs;  /* number of pairs of neighbours */
    /* Correlation dimension (Grassberger, Procaccia 1983). The value is NAN if the sums are no
     * power of the distance over a factor of 4, or change with more delays. */
    struct measured dimension;
    double distance[2]; /* range of distances that it was found in, in units of y */
    char dimension_reason[200];
};

/* Determines the exponent and the dimension. 10 000 samples take about half a second. Returns true
 * even if they are not determined; false with *error if out of memory or cancelled. */
bool series_exponent(const struct series *series, struct arena *arena,
                     struct series_exponent *found, struct error *error);
