/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Means with their errors: tapers for correlated values, smooth weights for regular motion. */
#include "modules/dynamics/orbits/average.h"

#include <hooke/base/numeric.h>

#include <math.h>

#define CORRELATION_SAMPLES 4096 /* largest number of values whose correlation is computed */
/* Length of a batch in correlation times or in times between crossings of the mean. */
#define BATCH_CORRELATION_TIMES 5
/* A batch mean must scatter by more than this part of the scatter of independent values. */
#define BATCH_SCATTER_RELATIVE 1e-2
#define VALUE_ROUNDING_RELATIVE 1e-9 /* rounding relative to the size of the values */

/* Returns the mean of n values, with compensated summation. */
static double mean_of(const double *value, size_t n)
{
    double sum = 0, low = 0; /* compensated (Kahan 1965) */
    for (size_t i = 0; i < n; i++) {
        const double y = value[i] - low, t = sum + y;
        low = (t - sum) - y;
        sum = t;
    }
    return n > 0 ? sum / (double)n : NAN;
}

/* ---- weights that rise from 0 and fall to it, u from 0 to 1 ----  Rates of growth are mostly
 * differences of some function along the motion, so that their sum depends on both ends: with equal
 * weights these ends would scatter more than the mean itself (batches of the Lorenz system would
 * have to be longer than 100 s). */

typedef double weight(double u);

/* Smooth weight: all derivatives are 0 at both ends. */
static double bump_weight(double u)
{
    return exp(-1 / (u * (1 - u)));
}

#define WINDOW_RAMP_FRACTION (1.0 / 16) /* part of the series in which weights rise or fall */

/* Weight of 1 with cosine ramps at both ends. */
static double trapezoid(double u)
{
    const double end = fmin(u, 1 - u) / WINDOW_RAMP_FRACTION;
    return end < 1 ? (1 - cos(PI * end)) / 2 : 1;
}

/* Returns the weighted mean of n values. Sets *square, unless NULL, to the sum of the squares of
 * the weights, which are scaled to a sum of 1. */
static double weighted_mean(const double *value, size_t n, weight *weight_function, double *square)
{
    double sum = 0, weights = 0, squares = 0;
    for (size_t i = 0; i < n; i++) {
        const double w = weight_function(((double)i + 0.5) / (double)n);
        sum += w * (value[i] - value[0]);
        weights += w;
        squares += w * w;
    }
    if (square)
        *square = squares / (weights * weights);
    return n > 0 ? value[0] + sum / weights : NAN;
}

/* Returns the autocovariance of n values at a lag. */
static double covariance(const double *value, size_t n, double mean, size_t lag)
{
    double sum = 0;
    for (size_t i = 0; i + lag < n; i++)
        sum += (value[i] - mean) * (value[i + lag] - mean);
    return sum / (double)n;
}

/* Returns the number of values that count as one independent value in a mean: 1 + 2 sum rho, where
 * pairs of neighbouring correlations are summed while they are positive and decrease. */
static double correlation_time(const double *value, size_t n, double mean)
{
    const double variance = covariance(value, n, mean, 0);
    double sum = 0, last = HUGE_VAL;
    for (size_t lag = 0; lag + 1 < n / 2 && variance > 0; lag += 2) {
        const double pair = covariance(value, n, mean, lag) + covariance(value, n, mean, lag + 1);
        if (!(pair > 0))
            break;
        last = fmin(last, pair);
        sum += last;
    }
    return variance > 0 ? fmax(2 * sum / variance - 1, 1) : 1;
}

/* Returns the mean number of values between two upward crossings of the mean. */
static double crossing_time(const double *value, size_t n, double mean)
{
    size_t count = 0;
    for (size_t i = 1; i < n; i++)
        count += value[i - 1] < mean && value[i] >= mean;
    return count > 0 ? (double)n / (double)count : (double)n;
}

/*
 * Returns the scatter of the mean from the lowest frequencies, by sines that are 0 at both ends
 * (Riedel, Sidorenko 1995). Each sees a constant, which is fitted, and independent noise.
 */
double average_scatter(const double *value, size_t n, int tapers)
{
    double seen[AVERAGE_MOST], constant[AVERAGE_MOST], dot = 0, length = 0, sum = 0, square;
    const double first = value[0], size = sqrt(2 / (double)n);
    for (int k = 0; k < tapers; k++) {
        seen[k] = constant[k] = 0;
        for (size_t i = 0; i < n; i++) {
            const double w = size * sin(PI * (k + 1) * ((double)i + 0.5) / (double)n);
            seen[k] += w * (value[i] - first);
            constant[k] += w;
        }
        dot += seen[k] * constant[k];
        length += constant[k] * constant[k];
    }
    for (int k = 0; k < tapers; k++) {
        const double rest = seen[k] - constant[k] * dot / length;
        sum += rest * rest;
    }
    weighted_mean(value, n, trapezoid, &square);
    return sqrt(sum / (tapers - 1) * square);
}

/* Averages neighbouring values until at most CORRELATION_SAMPLES remain, coarse [*count]. Returns
 * the number of values that make one. */
static size_t coarsen(const double *value, size_t n, double *coarse, size_t *count)
{
    const size_t each = (n + CORRELATION_SAMPLES - 1) / CORRELATION_SAMPLES;
    *count = each > 0 ? n / each : 0;
    for (size_t i = 0; i < *count; i++)
        coarse[i] = mean_of(value + i * each, each);
    return each;
}

/* The four smooth means are of the whole, of both halves, and of the middle. */
void average_find(const double *value, size_t n, double size, double *scratch,
                  struct average *average)
{
    *average = (struct average){
        .mean = weighted_mean(value, n, trapezoid, NULL), .error = NAN, .spread = NAN};
    average->smooth = weighted_mean(value, n, bump_weight, NULL);
    if (n < AVERAGE_BATCHES)
        return;
    const size_t half = n / 2;
    const double part[] = {average->smooth, weighted_mean(value, half, bump_weight, NULL),
                           weighted_mean(value + half, n - half, bump_weight, NULL),
                           weighted_mean(value + n / 4, half, bump_weight, NULL)};
    double low = part[0], high = part[0];
    for (int i = 1; i < 4; i++) {
        low = fmin(low, part[i]);
        high = fmax(high, part[i]);
    }
    average->spread = high - low;
    size_t count;
    const size_t each = coarsen(value, n, scratch, &count);
    const double time = (double)each * fmax(correlation_time(scratch, count, average->mean),
                                            crossing_time(scratch, count, average->mean));
    const double batches = fmin(floor((double)n / (BATCH_CORRELATION_TIMES * time)), AVERAGE_MOST);
    average->batches = (int)batches;
    if (average->batches >= AVERAGE_BATCHES)
        average->error = average_scatter(scratch, count, average->batches);
    const double independent = sqrt(covariance(value, n, average->mean, 0) / (double)n);
    average->regular = average->spread <=
                       fmax(BATCH_SCATTER_RELATIVE * independent, VALUE_ROUNDING_RELATIVE * size);
}
