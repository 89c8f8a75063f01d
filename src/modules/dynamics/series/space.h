/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Vectors of delayed values, and the nearest of them. */
#pragma once

#include <hooke/base/numeric.h>
#include <hooke/data/series.h>

struct cancel;
struct series_exponent;

#define SPACE_DIMENSIONS 10
#define SPACE_NEAREST 4

/* Vector i: y[i], y[i + delay], ... */
struct delay_space {
    const double *y;
    size_t points; /* the first so many are neighbours */
    int delay;     /* [samples] */
    int dimensions;
    size_t apart;     /* [samples] neighbours are more than so many from each other */
    size_t n, *order; /* [n] all values of y, the smallest first */
    const struct cancel *cancel;
};

static inline double space_value(const struct delay_space *s, size_t i, int dimension)
{
    return s->y[i + (size_t)(dimension * s->delay)];
}

static inline double space_distance2(const struct delay_space *s, size_t i, size_t j)
{
    double sum = 0;
    for (int d = 0; d < s->dimensions; d++) {
        const double apart = space_value(s, i, d) - space_value(s, j, d);
        sum += apart * apart;
    }
    return sum;
}

/* Puts the values of the series in order; returns false if out of memory. */
bool space_sort(struct delay_space *space, size_t n, struct arena *arena);

struct neighbours {
    int count;
    uint32_t index[SPACE_NEAREST]; /* the nearest first */
    double square[SPACE_NEAREST];
};

/* Up to `wanted` vectors nearest to vector i, which may lie beyond the last of them; none at
 * distance 0. */
void space_nearest(const struct delay_space *space, size_t i, int wanted, struct neighbours *found);

/* The first sample after lag 0 that says least about the one before; in samples, at least 1. 0: no
 * memory, or cancelled. */
int choose_delay(const double *y, size_t n, const struct cancel *cancel, struct arena *arena);
/*
 * How many delayed values unfold the motion, which is then the space's; 0: no number up to the
 * most, *false_share: what is left then. -1: cancelled.
 */
int choose_dimensions(struct delay_space *space, size_t n, double sigma, double *false_share);
/* Error of what neighbours predict `ahead` samples behind the vectors, over that of the best linear
 * function of the same values. NAN: nothing to tell. */
double prediction_ratio(const struct delay_space *space, size_t n, size_t ahead);

/* ---- divergence.c: mean logarithms of distances ---- */

struct divergence {
    size_t steps, stride; /* [steps] of so many samples, from 0 on */
    double *mean;         /* [steps] of ln(distance) */
    double *part;         /* [DIVERGENCE_PARTS][steps] of successive parts of the series */
    size_t pairs;
    double last;  /* mean over the last quarter of the steps */
    double apart; /* mean logarithm of the distance between any two vectors, or that */
};

#define DIVERGENCE_PARTS 8

/* Neighbours are only vectors that can be followed for so long. False: no memory, or cancelled. */
bool divergence_find(const struct delay_space *space, size_t samples, struct arena *arena,
                     struct divergence *found);

struct even_growth {
    size_t first, last; /* steps */
    double slope;       /* a step */
    double error;       /* of it, NAN: no stretch */
    double halves[2];
};

/* The stretch in which they grow evenly; `begin`: not before [steps]. */
struct even_growth divergence_growth(const struct divergence *divergence, size_t begin);

/* ---- correlation_sum.c ---- */

/* Fills in dimension, distance, dimension_reason. False: no memory, or cancelled. */
bool correlation_dimension(const struct delay_space *space, size_t n, struct arena *arena,
                           struct series_exponent *found);
