/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The share of pairs of vectors that are nearer than a distance, and as what power of it it goes.
 */
#include <hooke/base/cancel.h>
#include "modules/dynamics/series/space.h"

#include "modules/dynamics/series/series_exponent.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define REFERENCE_VECTORS 1000 /* each with */
#define COMPARED_VECTORS 20000
#define EXTRA_DELAYS 2    /* delays more than unfold the motion */
#define BINS_PER_OCTAVE 4 /* bins per factor of two */
/* Least significant bits of a double below a bin: bin edges are 1, 1.25, 1.5, 1.75 times 2^k. */
#define CELL_BITS 50
#define OCTAVES_MAX 40
#define DISTANCE_BINS (BINS_PER_OCTAVE * OCTAVES_MAX)
#define SMALLEST_DISTANCE_PAIRS 300        /* pairs below the smallest distance */
#define LARGEST_DISTANCE_PAIR_FRACTION 0.1 /* part of all pairs below the largest distance */
#define SLOPE_BINS 8                       /* bins of a stretch: a factor of four */
/* Slopes of known attractors (Lorenz, Roessler, Henon) are off by this part beyond their
 * scatter. */
#define SYSTEMATIC_ERROR_RELATIVE 0.05
#define SLOPE_UNCERTAINTY_MAX 0.15 /* largest relative uncertainty of a slope */

struct pair_counts {
    double log_count[EXTRA_DELAYS + 1][DISTANCE_BINS]; /* ln of pairs below the upper edge */
    double log_edge[DISTANCE_BINS];
    double pairs;
};

static uint64_t bits_of(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits >> CELL_BITS;
}

static double edge_of(uint64_t cell)
{
    double x;
    cell <<= CELL_BITS;
    memcpy(&x, &cell, sizeof x);
    return x;
}

/* Largest differences of values (the norm that needs no roots) of each vector with the others. */
static void count_pairs(const struct delay_space *s, size_t i, size_t stride, uint64_t first,
                        int64_t count[EXTRA_DELAYS + 1][DISTANCE_BINS])
{
    for (size_t j = i % stride; j < s->points; j += stride) {
        double most = 0;
        if ((j > i ? j - i : i - j) <= s->apart)
            continue;
        for (int d = 0; d < s->dimensions - 1; d++)
            most = fmax(most, fabs(space_value(s, i, d) - space_value(s, j, d)));
        for (int k = 0; k <= EXTRA_DELAYS; k++) {
            const int d = s->dimensions - 1 + k;
            most = fmax(most, fabs(space_value(s, i, d) - space_value(s, j, d)));
            const uint64_t cell = bits_of(most);
            const uint64_t bin = cell < first ? 0 : cell - first;
            count[k][bin < DISTANCE_BINS ? bin : DISTANCE_BINS - 1]++;
        }
    }
}

static bool find_sums(const struct delay_space *s, double size, struct pair_counts *sums)
{
    int64_t count[EXTRA_DELAYS + 1][DISTANCE_BINS] = {{0}};
    const uint64_t first = bits_of(ldexp(size, 4 - OCTAVES_MAX));
    const size_t stride = s->points / COMPARED_VECTORS + 1,
                 each = s->points / REFERENCE_VECTORS + 1;
    for (size_t i = 0; i < s->points; i += each) {
        count_pairs(s, i, stride, first, count);
        if (cancelled(s->cancel))
            return false;
    }
    for (int k = 0; k <= EXTRA_DELAYS; k++) {
        int64_t sum = 0;
        for (int b = 0; b < DISTANCE_BINS; b++) {
            sum += count[k][b];
            sums->log_count[k][b] = sum > 0 ? log((double)sum) : -1;
            sums->log_edge[b] = log(edge_of(first + (uint64_t)b + 1));
        }
        sums->pairs = (double)sum;
    }
    return true;
}

static double slope_between(const struct pair_counts *sums, int k, int first, int last)
{
    double x = 0, y = 0, xy = 0, xx = 0;
    const double n = last - first + 1;
    for (int b = first; b <= last; b++) {
        x += sums->log_edge[b] / n;
        y += sums->log_count[k][b] / n;
    }
    for (int b = first; b <= last; b++) {
        xy += (sums->log_edge[b] - x) * (sums->log_count[k][b] - y);
        xx += (sums->log_edge[b] - x) * (sums->log_edge[b] - x);
    }
    return xy / xx;
}

/* Returns by how much the slope differs between halves of a stretch and with more delays. */
static double open_part(const struct pair_counts *sums, int first, double slope)
{
    const int last = first + SLOPE_BINS, middle = first + SLOPE_BINS / 2;
    double deviation =
        fabs(slope_between(sums, 0, first, middle) - slope_between(sums, 0, middle, last)) / 2;
    for (int k = 1; k <= EXTRA_DELAYS; k++)
        deviation = fmax(deviation, fabs(slope_between(sums, k, first, last) - slope));
    return deviation;
}

/* The median over all stretches that hold enough pairs, not too many; ends [2]: of these. *error:
 * what is left open, and half of what the middle 80 % differ. */
static double median_slope(const struct pair_counts *sums, double *error, int *ends)
{
    double slope[DISTANCE_BINS], deviation[DISTANCE_BINS];
    size_t count = 0;
    for (int b = 0; b + SLOPE_BINS < DISTANCE_BINS; b++) {
        if (sums->log_count[EXTRA_DELAYS][b] < log(SMALLEST_DISTANCE_PAIRS) ||
            sums->log_count[0][b + SLOPE_BINS] > log(LARGEST_DISTANCE_PAIR_FRACTION * sums->pairs))
            continue;
        ends[0] = count == 0 ? b : ends[0];
        ends[1] = b + SLOPE_BINS;
        slope[count] = slope_between(sums, 0, b, b + SLOPE_BINS);
        deviation[count] = open_part(sums, b, slope[count]);
        count++;
    }
    const double middle = values_quantile(slope, count, 0.9) - values_quantile(slope, count, 0.1);
    *error = hypot(values_quantile(deviation, count, 0.5), middle / 2);
    return values_quantile(slope, count, 0.5);
}

bool correlation_dimension(const struct delay_space *space, size_t n, struct arena *arena,
                           struct series_exponent *found)
{
    struct pair_counts *sums = arena_alloc(arena, sizeof *sums);
    struct delay_space s = *space;
    const size_t window = (size_t)((s.dimensions + EXTRA_DELAYS - 1) * s.delay);
    double low = HUGE_VAL, high = -HUGE_VAL, error;
    int ends[2] = {0, 0};
    if (!sums || n <= window + 1)
        return sums;
    s.points = n - window;
    for (size_t i = 0; i < n; i++) {
        low = fmin(low, s.y[i]);
        high = fmax(high, s.y[i]);
    }
    if (!find_sums(&s, high - low, sums))
        return false;
    const double slope = median_slope(sums, &error, ends);
    if (isnan(slope))
        snprintf(found->dimension_reason, sizeof found->dimension_reason,
                 "too few pairs of neighbours");
    else if (!(error < SLOPE_UNCERTAINTY_MAX * slope))
        snprintf(found->dimension_reason, sizeof found->dimension_reason,
                 "the correlation sum does not follow one power of the distance over a factor of "
                 "4, or changes with more delays");
    else {
        found->dimension =
            (struct measured){slope, hypot(error, SYSTEMATIC_ERROR_RELATIVE * slope)};
        found->distance[0] = exp(sums->log_edge[ends[0]]);
        found->distance[1] = exp(sums->log_edge[ends[1]]);
    }
    return true;
}
