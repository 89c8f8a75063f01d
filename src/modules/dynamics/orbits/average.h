/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Means over time of series whose values are correlated, or of regular motion, with their
 * errors. */
#pragma once

#include <hooke/base/text.h>

#define AVERAGE_BATCHES 10 /* fewer batches do not tell the scatter */
#define AVERAGE_MOST 12    /* largest number of batches */

/* Averages of successive values, each of which is the mean over an equal time. */
struct average {
    double mean; /* mean with weights that rise and fall in the first and the last sixteenth */
    /* number of batches, at most AVERAGE_MOST; each lasts several times the correlation time
     * (initial sequence of Geyer 1992, 3.3) or the time between crossings of the mean */
    int batches;
    /* standard error of the mean by as many tapers, or NAN with fewer than AVERAGE_BATCHES
     * batches */
    double error;
    /*
     * `smooth` is the mean with the weights exp(-1/(u(1-u))), which for regular motion converges
     * faster than any power of the time (Das, Saiki, Sander, Yorke 2017). `spread` is the largest
     * difference between these means of the whole, of its halves and of its middle.
     */
    double smooth, spread;
    bool regular; /* true if these four means agree better than those of chaotic motion could */
};

/* Computes the averages of value [n]. scratch [n] is overwritten. `size` is the size of the values;
 * scatter below 1e-9 of it does not count. */
void average_find(const double *value, size_t n, double size, double *scratch,
                  struct average *average);
/* Returns the standard error of such a mean of value [n], estimated with `batches` tapers, at most
 * AVERAGE_MOST. */
double average_scatter(const double *value, size_t n, int batches);
