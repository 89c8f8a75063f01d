/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Whether a series is chaotic, as far as it alone can tell: how fast neighbours in the space of its
 * delays go apart, and how many of them there are. */
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
 * It is not determined, with the reason: of less than EXPONENT_SAMPLES samples or 20 turns, of
 * times that are no even grid, where the size of the motion changes, where no number of delays
 * unfolds it, where neighbours predict no better than a line does (noise, smooth noise), where they
 * do not go apart (periodic and quasi-periodic motion, decay), or not evenly for a factor of
 * EXPONENT_GROWTH.
 */
#define EXPONENT_SAMPLES 1000
#define EXPONENT_GROWTH 5.0

struct series_exponent {
    struct measured value; /* [1/s] NAN: not determined */
    bool determined;
    char reason[200];      /* reason if not */
    double delay;          /* [s] 0: as far as this it did not come; so are those below */
    int dimensions;        /* delayed values of a vector */
    double apart;          /* [s] neighbours are no nearer in time */
    double t_begin, t_end; /* [s] since they were neighbours: where distances grow evenly, */
    double growth;         /* by this factor */
    size_t pairs;
    /* Correlation dimension (Grassberger, Procaccia 1983); value NAN: its sums are no power of the
     * distance over a factor of 4, or no same one with more delays. */
    struct measured dimension;
    double distance[2]; /* where they are, as y */
    char dimension_reason[200];
};

/* False: no memory, or cancelled. Of 10 000 samples it takes about half a second. */
bool series_exponent(const struct series *series, struct arena *arena,
                     struct series_exponent *found, struct error *error);
