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

/* Finds up to `wanted` vectors nearest to vector i, which may lie behind the last one. Vectors at
 * distance 0 do not count. */
void space_nearest(const struct delay_space *space, size_t i, int wanted, struct neighbours *found);

/* Returns the delay [samples], at least 1: the first minimum of the mutual information, or the lag
 * at which the correlation falls to 1/e. Returns 0 if out of memory or cancelled. */
int choose_delay(const double *y, size_t n, const struct cancel *cancel, struct arena *arena);
/*
 * Finds the number of delayed values that unfold the motion, sets it in the space and returns it.
 * Returns 0 if there is none up to the largest, -1 if cancelled. *false_share is the remaining
 * share of false neighbours.
 */
int choose_dimensions(struct delay_space *space, size_t n, double sigma, double *false_share);
/* Returns the error of predicting the value `ahead` samples behind a vector from its neighbours,
 * relative to that of the best linear function of the same values, or NAN if undefined. */
double prediction_ratio(const struct delay_space *space, size_t n, size_t ahead);

/* ---- mean logarithms of distances (divergence.c) ---- */

struct divergence {
    size_t steps, stride; /* [steps] of `stride` samples, from 0 on */
    double *mean;         /* [steps] mean of ln(distance) */
    double *part;         /* [DIVERGENCE_PARTS][steps] of successive parts of the series */
    size_t pairs;
    double last;  /* mean over the last quarter of the steps */
    double apart; /* mean logarithm of the distance between any two vectors, or that */
};

#define DIVERGENCE_PARTS 8

/* Computes the divergence. Only vectors that can be followed for `samples` are neighbours. Returns
 * false if out of memory or cancelled. */
bool divergence_find(const struct delay_space *space, size_t samples, struct arena *arena,
                     struct divergence *found);

struct even_growth {
    size_t first, last; /* steps */
    double slope;       /* slope per step */
    double error;       /* error of the slope, or NAN if there is no stretch */
    double halves[2];
};

/* Finds the stretch in which distances grow evenly, not before step `begin`. */
struct even_growth divergence_growth(const struct divergence *divergence, size_t begin);

/* ---- correlation_sum.c ---- */

/* Sets dimension, distance and dimension_reason. Returns false if out of memory or cancelled. */
bool correlation_dimension(const struct delay_space *space, size_t n, struct arena *arena,
                           struct series_exponent *found);
