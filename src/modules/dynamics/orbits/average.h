/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Means over time of series that are correlated, or regular. */
#pragma once

#include <hooke/base/text.h>

#define AVERAGE_BATCHES 10 /* without so many nothing is known of the scatter */
#define AVERAGE_MOST 12

/* Values one after another, each the mean over an equal time. */
struct average {
    double mean; /* with weights that rise and fall in the first and last sixteenth */
    /* each several times as long as the values stay correlated, by Geyer's initial sequence (1992,
     * 3.3), or turn back to the mean */
    int batches;  /* at most AVERAGE_MOST */
    double error; /* standard error of the mean by as many tapers, or NAN below AVERAGE_BATCHES */
    /*
     * Mean with the weights exp(-1/(u(1-u))), which of regular motion converges faster than any
     * power of the time (Das, Saiki, Sander, Yorke 2017). spread: largest difference between those
     * of the whole, of its halves and of its middle.
     */
    double smooth, spread;
    bool regular; /* the four agree as those of chaotic motion would not */
};

/* scratch [n]; size: of the values, below 1e-9 of which nothing counts as scatter. */
void average_find(const double *value, size_t n, double size, double *scratch,
                  struct average *average);
/* Standard error of such a mean by so many tapers, at most AVERAGE_MOST. */
double average_scatter(const double *value, size_t n, int batches);
