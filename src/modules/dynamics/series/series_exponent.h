/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The largest Lyapunov exponent and the correlation dimension of a series, from neighbours in the
 * space of its delays. */
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
    struct measured value; /* [1/s] NAN if not determined */
    bool determined;
    char reason[200]; /* reason if it is not determined */
    double delay;     /* [s] 0, as all below, if the analysis ended earlier */
    int dimensions;   /* number of delayed values in a vector */
    double apart;     /* [s] smallest distance of neighbours in time */
    /* [s] range, since they were neighbours, in which distances grow evenly, */
    double t_begin, t_end;
    double growth; /* and the factor by which they grow */
    size_t pairs;
    /* Correlation dimension (Grassberger, Procaccia 1983). The value is NAN if the sums are no
     * power of the distance over a factor of 4, or change with more delays. */
    struct measured dimension;
    double distance[2]; /* range of distances, in units of y */
    char dimension_reason[200];
};

/* Determines the exponent and the dimension. 10 000 samples take about half a second. Returns false
 * if out of memory or cancelled. */
bool series_exponent(const struct series *series, struct arena *arena,
                     struct series_exponent *found, struct error *error);
