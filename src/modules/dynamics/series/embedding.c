/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Chooses the delay and the number of delayed values of an embedding, searches neighbours, and
 * measures how well these predict. */
#include <hooke/base/cancel.h>
#include "modules/dynamics/series/space.h"

#include <gsl/gsl_sort.h>
#include <math.h>
#include <string.h>

#define INFORMATION_BINS 16         /* number of bins of values for the mutual information */
#define MOST_DELAY 1000             /* [samples] largest delay */
#define LOOKED_AT 50000             /* largest number of values that are examined */
#define EXAMINED_VECTORS 1000       /* number of vectors whose neighbours are examined */
#define FALSE_NEIGHBOUR_FACTOR 10   /* A neighbour is false if its distance grows by this factor, */
#define NEIGHBOUR_DISTANCE_SIGMAS 2 /* unless it was this number of standard deviations before. */
#define DISTANCE_MIN_SIGMAS 1e-6    /* smallest distance in standard deviations */
#define FALSE_SHARE 0.01 /* share of false neighbours below which the motion is unfolded */

/* ---- neighbours ---- */

/* Adds vector j to the neighbours of vector i, which are sorted by distance, unless `wanted` ones
 * are nearer, it is at distance 0, or within the Theiler window. The sum of squares is given up
 * once it is too large. */
static void consider_neighbour(const struct delay_space *s, size_t i, size_t j, int wanted,
                               struct neighbours *f)
{
    const double most = f->count == wanted ? f->square[f->count - 1] : HUGE_VAL;
    double square = 0;
    for (int d = 0; d < s->dimensions && square < most; d++) {
        const double difference = space_value(s, i, d) - space_value(s, j, d);
        square += difference * difference;
    }
    if (!(square > 0 && square < most) || (j > i ? j - i : i - j) <= s->theiler_window)
        return;
    int k = f->count < wanted ? f->count++ : f->count - 1;
    for (; k > 0 && f->square[k - 1] > square; k--) {
        f->square[k] = f->square[k - 1];
        f->index[k] = f->index[k - 1];
    }
    f->square[k] = square;
    f->index[k] = (uint32_t)j;
}

bool space_sort(struct delay_space *s, size_t n, struct arena *arena)
{
    s->n = n;
    s->order = arena_array(arena, n, sizeof *s->order);
    if (s->order)
        gsl_sort_index(s->order, s->y, 1, n);
    return s->order;
}

/* Finds up to `wanted` nearest vectors. Searches outwards among the sorted values (s->order) from
 * that of vector i, until the difference in this value alone is too large. */
void space_nearest(const struct delay_space *s, size_t i, int wanted, struct neighbours *found)
{
    const double y = s->y[i];
    size_t low = 0, high = s->n;
    found->count = 0;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (s->y[s->order[middle]] < y)
            low = middle + 1;
        else
            high = middle;
    }
    while (low > 0 || high < s->n) {
        const double lower_distance = low > 0 ? y - s->y[s->order[low - 1]] : HUGE_VAL;
        const double upper_distance = high < s->n ? s->y[s->order[high]] - y : HUGE_VAL;
        const double distance = fmin(lower_distance, upper_distance);
        const size_t j = s->order[lower_distance < upper_distance ? --low : high++];
        if (found->count == wanted && distance * distance >= found->square[wanted - 1])
            return;
        if (j < s->points)
            consider_neighbour(s, i, j, wanted, found);
    }
}

/* ---- the delay ---- */

/* Sets bin[i] to the number, 0 to INFORMATION_BINS - 1, of the bin of y[i], of n values; all bins
 * hold equal numbers of values. Returns false if out of memory. */
static bool put_into_bins(const double *y, size_t n, struct arena *arena, unsigned char *bin)
{
    double *sorted = arena_array(arena, n, sizeof *sorted), edge[INFORMATION_BINS];
    if (!sorted)
        return false;
    for (int b = 1; b < INFORMATION_BINS; b++) {
        memcpy(sorted, y, n * sizeof *y);
        edge[b] = values_quantile(sorted, n, (double)b / INFORMATION_BINS);
    }
    for (size_t i = 0; i < n; i++) {
        bin[i] = 0;
        for (int b = 1; b < INFORMATION_BINS; b++)
            bin[i] = (unsigned char)(bin[i] + (y[i] >= edge[b]));
    }
    return true;
}

/* Returns the mutual information [nat] of values that are `lag` samples apart, from the bin of each
 * of the n samples: the mean of ln(p(a, b) / p(a) / p(b)). */
static double mutual_information(const unsigned char *bin, size_t n, size_t lag)
{
    int count[INFORMATION_BINS][INFORMATION_BINS] = {{0}}, first[INFORMATION_BINS] = {0},
        second[INFORMATION_BINS] = {0};
    const double pairs = (double)(n - lag);
    double sum = 0;
    for (size_t i = 0; i + lag < n; i++) {
        count[bin[i]][bin[i + lag]]++;
        first[bin[i]]++;
        second[bin[i + lag]]++;
    }
    for (int a = 0; a < INFORMATION_BINS; a++)
        for (int b = 0; b < INFORMATION_BINS; b++)
            if (count[a][b] > 0)
                sum += count[a][b] * log(count[a][b] * pairs / first[a] / second[b]);
    return sum / pairs;
}

/* Returns the autocovariance of y at a lag [samples]. */
static double autocovariance(const double *y, size_t n, double mean, size_t lag)
{
    double sum = 0;
    for (size_t i = 0; i + lag < n; i++)
        sum += (y[i] - mean) * (y[i + lag] - mean);
    return sum / (double)(n - lag);
}

/* Increases the lag [sample] until the information rises again or the correlation has fallen to
 * 1/e, in the first LOOKED_AT samples, and at most to MOST_DELAY or a twentieth of them. Returns 0
 * if out of memory or cancelled. */
int choose_delay(const double *y, size_t n, const struct cancel *cancel, struct arena *arena)
{
    const size_t looked = n < LOOKED_AT ? n : LOOKED_AT;
    const size_t most = looked / 20 < MOST_DELAY ? looked / 20 : MOST_DELAY;
    unsigned char *bin = arena_alloc(arena, looked);
    if (!bin || !put_into_bins(y, looked, arena, bin))
        return 0;
    double mean = 0, previous = HUGE_VAL;
    for (size_t i = 0; i < looked; i++)
        mean += y[i] / (double)looked;
    const double variance = autocovariance(y, looked, mean, 0);
    for (size_t lag = 1; lag < most; lag++) {
        if (lag % 16 == 0 && cancelled(cancel))
            return 0;
        const double now = mutual_information(bin, looked, lag);
        if (now > previous)
            return (int)lag - 1;
        if (autocovariance(y, looked, mean, lag) < variance / exp(1))
            return (int)lag;
        previous = now;
    }
    return (int)most;
}

/* ---- the number of delays ---- */

/* Returns the number of vectors behind which `ahead` more samples exist. */
static size_t vector_count(size_t n, const struct delay_space *s, size_t ahead)
{
    const size_t window = (size_t)((s->dimensions - 1) * s->delay) + ahead;
    return n > window ? n - window : 0;
}

/* Returns the share of nearest neighbours that one more delayed value separates (Kennel, Brown,
 * Abarbanel 1992), or NAN if cancelled. sigma is the standard deviation of y. */
static double false_neighbours(const struct delay_space *s, double sigma)
{
    const size_t stride = s->points / EXAMINED_VECTORS + 1;
    size_t asked = 0, wrong = 0;
    for (size_t i = 0; i < s->points; i += stride) {
        struct neighbours nearest;
        space_nearest(s, i, 1, &nearest);
        if (nearest.count == 0)
            continue;
        const double distance = fmax(sqrt(nearest.square[0]), DISTANCE_MIN_SIGMAS * sigma),
                     growth = fabs(space_value(s, i, s->dimensions) -
                                   space_value(s, nearest.index[0], s->dimensions));
        asked++;
        wrong += growth > FALSE_NEIGHBOUR_FACTOR * distance ||
                 hypot(distance, growth) > NEIGHBOUR_DISTANCE_SIGMAS * sigma;
        if (asked % 64 == 0 && cancelled(s->cancel))
            return NAN;
    }
    return asked > 0 ? (double)wrong / (double)asked : 0;
}

/* Adds delayed values until less than FALSE_SHARE of the nearest neighbours are false. Returns the
 * number of values, 0 if none up to SPACE_DIMENSIONS - 2 is enough or there are too few vectors, or
 * -1 if cancelled. *false_share is that of the last number examined. */
int choose_dimensions(struct delay_space *s, size_t n, double sigma, double *false_share)
{
    for (s->dimensions = 1; s->dimensions < SPACE_DIMENSIONS - 1; s->dimensions++) {
        s->points = vector_count(n, s, (size_t)s->delay);
        if (s->points < EXAMINED_VECTORS / 2)
            break;
        *false_share = false_neighbours(s, sigma);
        if (isnan(*false_share))
            return -1;
        if (*false_share < FALSE_SHARE)
            return s->dimensions;
    }
    return 0;
}

/* ---- prediction ---- */

enum { UNKNOWNS = SPACE_DIMENSIONS + 1 }; /* coefficients of a linear function and its constant */

/* Returns the mean square error with which the best linear function of a delay vector predicts the
 * value `ahead` samples later, over the first `vectors` vectors (a subset if there are many).
 * Returns NAN if the function is not unique. The first pass fits the function, the second one
 * evaluates it. */
static double linear_error(const struct delay_space *s, size_t ahead, size_t vectors)
{
    const int n = s->dimensions + 1;
    const size_t target_offset = (size_t)((s->dimensions - 1) * s->delay) + ahead;
    const size_t stride = vectors / LOOKED_AT + 1;
    double a[UNKNOWNS * UNKNOWNS] = {0}, b[UNKNOWNS] = {0}, l[UNKNOWNS * UNKNOWNS], sum = 0;
    size_t count = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < vectors; i += stride) {
            double v[UNKNOWNS];
            for (int d = 0; d < n; d++)
                v[d] = d == n - 1 ? 1 : space_value(s, i, d);
            double residual = s->y[i + target_offset];
            for (int d = 0; d < n; d++) {
                for (int e = 0; e <= d && pass == 0; e++)
                    a[d * UNKNOWNS + e] += v[d] * v[e];
                if (pass == 0)
                    b[d] += v[d] * residual;
            }
            for (int d = 0; d < n && pass == 1; d++)
                residual -= b[d] * v[d];
            sum += pass == 1 ? residual * residual : 0;
            count += (size_t)pass;
        }
        if (pass == 0) {
            if (!matrix_cholesky(n, UNKNOWNS, a, 1e-14, l))
                return NAN;
            cholesky_forward(n, UNKNOWNS, l, b);
            cholesky_backward(n, UNKNOWNS, l, b);
        }
    }
    return sum / (double)count;
}

/* Returns the root mean square error of about EXAMINED_VECTORS predictions, `ahead` samples ahead,
 * by the mean of what followed SPACE_NEAREST neighbours, in units of that of the best linear
 * function; NAN if unknown. n is the number of samples. */
double prediction_ratio(const struct delay_space *s, size_t n, size_t ahead)
{
    const size_t vectors = vector_count(n, s, ahead), stride = vectors / EXAMINED_VECTORS + 1,
                 target_offset = (size_t)((s->dimensions - 1) * s->delay) + ahead;
    const double linear = linear_error(s, ahead, vectors);
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < vectors; i += stride) {
        struct neighbours nearest;
        double mean = 0;
        int used = 0;
        space_nearest(s, i, SPACE_NEAREST, &nearest);
        for (int k = 0; k < nearest.count; k++)
            if (nearest.index[k] < vectors) {
                mean += s->y[nearest.index[k] + target_offset];
                used++;
            }
        if (used == 0)
            continue;
        const double residual = s->y[i + target_offset] - mean / used;
        sum += residual * residual;
        count++;
    }
    return count > 0 && linear > 0 ? sqrt(sum / (double)count / linear) : NAN;
}
