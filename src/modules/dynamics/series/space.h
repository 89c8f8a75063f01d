/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Delay embedding of a series (Takens 1981): vectors of delayed values, nearest neighbours among
 * them, and what is computed from these. Call choose_delay(), space_sort(), choose_dimensions(),
 * then divergence_find() and correlation_dimension(). */
#pragma once

#include <hooke/base/numeric.h>
#include <hooke/data/series.h>

struct cancel;
struct series_exponent;

#define SPACE_DIMENSIONS 10 /* largest number of delayed values in a vector */
#define SPACE_NEAREST 4     /* largest number of neighbours that are searched */

/* The vectors of a series: vector i is y[i], y[i + delay], … */
struct delay_space {
    const double *y;
    size_t points;         /* number of vectors, from the first on, that may be neighbours */
    int delay;             /* [samples] */
    int dimensions;        /* number of values in a vector */
    size_t theiler_window; /* [samples] Theiler window: neighbours are farther apart in time */
    size_t n, *order;      /* [n] indices of the values of y in ascending order, see space_sort() */
    const struct cancel *cancel;
};

/* Returns one value of vector i. */
static inline double space_value(const struct delay_space *s, size_t i, int dimension)
{
    return s->y[i + (size_t)(dimension * s->delay)];
}

/* Returns the square of the distance between two vectors. */
static inline double space_distance2(const struct delay_space *s, size_t i, size_t j)
{
    double sum = 0;
    for (int d = 0; d < s->dimensions; d++) {
        const double difference = space_value(s, i, d) - space_value(s, j, d);
        sum += difference * difference;
    }
    return sum;
}

/* Sets n and order; all values of y are sorted. Returns false if out of memory. */
bool space_sort(struct delay_space *space, size_t n, struct arena *arena);

/* The vectors that are nearest to some vector. */
struct neighbours {
    int count;
    uint32_t index[SPACE_NEAREST]; /* the nearest first */
    double square[SPACE_NEAREST];  /* squares of their distances */
};

/* Finds up to `wanted` vectors nearest to vector i, which need not be among the first `points`.
 * Vectors at distance 0 or within the Theiler window do not count. Needs space_sort(). */
void space_nearest(const struct delay_space *space, size_t i, int wanted, struct neighbours *found);

/* Returns the delay [samples], at least 1: the first minimum of the mutual information, or the lag
 * at which the correlation falls to 1/e. Returns 0 if out of memory or cancelled. */
int choose_delay(const double *y, size_t n, const struct cancel *cancel, struct arena *arena);
/* Finds the number of delayed values that unfold the motion, so that fewer than FALSE_SHARE of the
 * neighbours are false, sets it in the space and returns it. Returns 0 if there is none up to the
 * largest, -1 if cancelled. Sets *false_share to the remaining share; sigma is the standard
 * deviation of y [n]. */
int choose_dimensions(struct delay_space *space, size_t n, double sigma, double *false_share);
/* Returns the error of predicting the value `ahead` samples behind a vector from its neighbours,
 * relative to that of the best linear function of the same values, or NAN if undefined. */
double prediction_ratio(const struct delay_space *space, size_t n, size_t ahead);

/* ---- mean logarithms of distances (divergence.c) ---- */

/* Mean logarithm of the distance between neighbours over the time since they were nearest. */
struct divergence {
    size_t steps, stride; /* number of times, and [samples] from one to the next */
    double *mean;         /* [steps] mean of ln(distance) */
    double *part;         /* [DIVERGENCE_PARTS][steps] of successive parts of the series */
    size_t pairs;         /* number of pairs of neighbours */
    double last;          /* mean over the last quarter of the steps */
    double saturation; /* mean ln(distance) between random vectors, or `last` if that is smaller */
};

#define DIVERGENCE_PARTS 8

/* Follows pairs of neighbours for `samples`; space->points must leave room for that. Returns false
 * if out of memory or cancelled. */
bool divergence_find(const struct delay_space *space, size_t samples, struct arena *arena,
                     struct divergence *found);

/* The range of times in which distances grow exponentially. */
struct even_growth {
    size_t first, last; /* the range, in steps of the divergence */
    double slope;       /* growth of ln(distance) per step */
    double error;       /* standard error of the slope, or NAN if there is no such range */
    double halves[2];   /* slopes of the first and the second half */
};

/* Finds the range of exponential growth from step `begin` on. */
struct even_growth divergence_growth(const struct divergence *divergence, size_t begin);

/* ---- correlation_sum.c ---- */

/* Sets dimension and distance, or dimension_reason, of *found. Returns false if out of memory or
 * cancelled. */
bool correlation_dimension(const struct delay_space *space, size_t n, struct arena *arena,
                           struct series_exponent *found);
