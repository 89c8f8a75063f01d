/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The correlation dimension: the power of the distance with which the number of pairs of vectors
 * that are nearer than it grows (Grassberger, Procaccia 1983). */
#include <hooke/base/cancel.h>
#include "modules/dynamics/series/space.h"

#include "modules/dynamics/series/series_exponent.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define REFERENCE_VECTORS 1000 /* number of vectors that are each compared with */
#define COMPARED_VECTORS 20000 /* this number of others */
#define EXTRA_DELAYS 2         /* number of delays beyond those that unfold the motion */
#define BINS_PER_OCTAVE 4      /* bins per factor of two */
/* Least significant bits of a double below a bin: bin edges are 1, 1.25, 1.5, 1.75 times 2^k. */
#define CELL_BITS 50
#define OCTAVES_MAX 40 /* factors of two from the smallest to the largest distance */
#define DISTANCE_BINS (BINS_PER_OCTAVE * OCTAVES_MAX)
#define SMALLEST_DISTANCE_PAIRS 300        /* pairs below the smallest distance */
#define LARGEST_DISTANCE_PAIR_FRACTION 0.1 /* part of all pairs below the largest distance */
#define SLOPE_BINS 8                       /* bins of a stretch: a factor of four */
/* Slopes of known attractors (Lorenz, Roessler, Henon) are off by this part beyond their
 * scatter. */
#define SYSTEMATIC_ERROR_RELATIVE 0.05
#define SLOPE_UNCERTAINTY_MAX 0.15 /* largest relative uncertainty of a slope */

/* Correlation sums for each number of delays. */
struct pair_counts {
    double log_count[EXTRA_DELAYS + 1][DISTANCE_BINS]; /* ln of pairs below the upper edge */
    double log_edge[DISTANCE_BINS];                    /* ln of the upper edge of each bin */
    double pairs;                                      /* number of all pairs */
};

/* Returns the bin of a distance, which is given by the leading bits of the double. */
static uint64_t distance_bin(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits >> CELL_BITS;
}

/* Returns the lower edge of a bin. */
static double bin_lower_edge(uint64_t cell)
{
    double x;
    cell <<= CELL_BITS;
    memcpy(&x, &cell, sizeof x);
    return x;
}

/* Counts the distances of vector i from every stride-th other one, except those within the Theiler
 * window, in bins from number `first` on; those outside go to the outermost bins. The distance is
 * the largest difference of two values; count [k] is for k more delays than the space has. */
static void count_pairs(const struct delay_space *s, size_t i, size_t stride, uint64_t first,
                        int64_t count[EXTRA_DELAYS + 1][DISTANCE_BINS])
{
    for (size_t j = i % stride; j < s->points; j += stride) {
        double most = 0;
        if ((j > i ? j - i : i - j) <= s->theiler_window)
            continue;
        for (int d = 0; d < s->dimensions - 1; d++)
            most = fmax(most, fabs(space_value(s, i, d) - space_value(s, j, d)));
        for (int k = 0; k <= EXTRA_DELAYS; k++) {
            const int d = s->dimensions - 1 + k;
            most = fmax(most, fabs(space_value(s, i, d) - space_value(s, j, d)));
            const uint64_t cell = distance_bin(most);
            const uint64_t bin = cell < first ? 0 : cell - first;
            count[k][bin < DISTANCE_BINS ? bin : DISTANCE_BINS - 1]++;
        }
    }
}

/* Computes the correlation sums of a motion of that size (largest minus smallest value): the
 * logarithm of the number of pairs closer than each edge, or -1 if there are none. Only some
 * vectors are compared if there are many. Returns false if cancelled. */
static bool count_all_pairs(const struct delay_space *s, double size, struct pair_counts *sums)
{
    int64_t count[EXTRA_DELAYS + 1][DISTANCE_BINS] = {{0}};
    const uint64_t first = distance_bin(ldexp(size, 4 - OCTAVES_MAX));
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
            sums->log_edge[b] = log(bin_lower_edge(first + (uint64_t)b + 1));
        }
        sums->pairs = (double)sum;
    }
    return true;
}

/* Returns the slope of ln(pairs) over ln(distance) by a line through bins first to last, with k
 * extra delays. */
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

/* Returns the uncertainty of the slope of the range from bin `first` on: how much it differs
 * between its halves and with more delays. */
static double slope_uncertainty(const struct pair_counts *sums, int first, double slope)
{
    const int last = first + SLOPE_BINS, middle = first + SLOPE_BINS / 2;
    double deviation =
        fabs(slope_between(sums, 0, first, middle) - slope_between(sums, 0, middle, last)) / 2;
    for (int k = 1; k <= EXTRA_DELAYS; k++)
        deviation = fmax(deviation, fabs(slope_between(sums, k, first, last) - slope));
    return deviation;
}

/* Returns the median of the slopes of all ranges that hold enough pairs but not too many, or NAN if
 * there is none. Sets ends to the first and last bin of these ranges, and *error to half of the
 * spread of the middle 80 % with the median of slope_uncertainty(). */
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
        deviation[count] = slope_uncertainty(sums, b, slope[count]);
        count++;
    }
    const double middle = values_quantile(slope, count, 0.9) - values_quantile(slope, count, 0.1);
    *error = hypot(values_quantile(deviation, count, 0.5), middle / 2);
    return values_quantile(slope, count, 0.5);
}

/* Fills found->dimension and distance, or the reason why there is none; a series too short for the
 * delays leaves the reason as it is. `n` is the number of samples. Returns false if out of memory
 * or cancelled. */
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
    if (!count_all_pairs(&s, high - low, sums))
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
