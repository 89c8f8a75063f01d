/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Mean logarithms of distances between neighbours over time, and the range in which they grow
 * exponentially. */
#include <hooke/base/cancel.h>
#include "modules/dynamics/series/space.h"

#include <math.h>

#define NEIGHBOUR_PAIRS 4000     /* approximate number of pairs that are followed */
#define CURVE_STEPS_MAX 600      /* largest number of steps of the curve */
#define ROUNDED_LOG_DISTANCE -40 /* ln of a distance that is 0 but for rounding */
/* The range of growth ends this far, in ln, below the mean distance between any two vectors. */
#define SATURATION_LOG_MARGIN 1.5

/* Returns the logarithm of the distance between two vectors. */
static double log_distance(const struct delay_space *s, size_t i, size_t j)
{
    const double square = space_distance2(s, i, j);
    return square > 0 ? log(square) / 2 : ROUNDED_LOG_DISTANCE;
}

/* Returns the mean logarithm of the distance between random vectors: where growth must end. */
static double mean_log_distance(const struct delay_space *s)
{
    uint64_t seed = 1;
    double sum = 0;
    for (int k = 0; k < NEIGHBOUR_PAIRS; k++)
        sum += log_distance(s, (size_t)(random_fraction(&seed) * (double)s->points),
                            (size_t)(random_fraction(&seed) * (double)s->points));
    return sum / NEIGHBOUR_PAIRS;
}

/*
 * Returns the logarithm of the distance across the flow through vector i: along the flow it neither
 * grows nor shrinks, which would hide slow growth. The vector that passes there is followed: *j
 * moves by single samples, at most a delay from `centre` and up to `most`.
 */
static double log_across(const struct delay_space *s, size_t i, size_t centre, size_t most,
                         size_t *j)
{
    for (int pass = 0;; pass++) {
        double square = 0, projection = 0, speed = 0;
        for (int d = 0; d < s->dimensions; d++) {
            const double v = (space_value(s, i + 1, d) - space_value(s, i - 1, d)) / 2,
                         difference = space_value(s, *j, d) - space_value(s, i, d);
            square += difference * difference;
            projection += difference * v;
            speed += v * v;
        }
        size_t next = *j;
        if (fabs(projection) > speed / 2)
            next = projection > 0 ? *j - 1 : *j + 1;
        if (next != *j && *j > 0 && next <= most && pass < 2 &&
            (next > centre ? next - centre : centre - next) <= (size_t)s->delay) {
            *j = next;
            continue;
        }
        square -= speed > 0 ? projection * projection / speed : 0;
        return square > 0 ? log(square) / 2 : ROUNDED_LOG_DISTANCE;
    }
}

/* Follows the pair of vectors i and j for the time of the curve, and adds their ln(distance) to
 * `mean` [steps]. */
static void follow_pair(const struct delay_space *s, size_t i, size_t j, size_t samples,
                        const struct divergence *d, double *mean)
{
    const size_t most = s->points + samples - 1;
    const bool flows = s->delay > 1 && i > 0; /* a map has no direction of flow */
    size_t neighbour = j;
    for (size_t k = 0; k < d->steps; k++) {
        const size_t shift = k * d->stride;
        mean[k] += flows ? log_across(s, i + shift, j + shift, most, &neighbour)
                         : log_distance(s, i + shift, j + shift);
        neighbour = neighbour + d->stride < most ? neighbour + d->stride : most;
    }
}

/* Divides the sums of the logarithm of distances by the numbers of pairs: of each part of the
 * series (count [DIVERGENCE_PARTS]) and of all parts together, as d->mean. Sets d->last to the mean
 * over the last quarter of the steps, and d->saturation to the level that distances cannot exceed.
 */
static void put_means(const struct delay_space *s, const size_t *count, struct divergence *d)
{
    for (size_t k = 0; k < d->steps; k++) {
        d->mean[k] = 0;
        for (size_t p = 0; p < DIVERGENCE_PARTS; p++) {
            d->mean[k] += d->part[p * d->steps + k] / (double)d->pairs;
            d->part[p * d->steps + k] /= (double)count[p];
        }
    }
    d->last = 0;
    for (size_t k = d->steps - d->steps / 4; k < d->steps; k++)
        d->last += d->mean[k] / (double)(d->steps / 4);
    d->saturation = fmin(mean_log_distance(s), d->last);
}

/* Follows about NEIGHBOUR_PAIRS vectors and the nearest neighbour of each for `samples` samples,
 * sorted by time into DIVERGENCE_PARTS parts, whose scatter later gives the error. d->stride is the
 * number of samples per step of the curve. Returns false if out of memory or cancelled. */
bool divergence_find(const struct delay_space *s, size_t samples, struct arena *arena,
                     struct divergence *d)
{
    d->stride = samples / CURVE_STEPS_MAX + 1;
    d->steps = samples / d->stride;
    d->mean = arena_array(arena, d->steps, sizeof *d->mean);
    d->part = arena_array(arena, d->steps * DIVERGENCE_PARTS, sizeof *d->part);
    d->pairs = 0;
    if (!d->mean || !d->part)
        return false;
    const size_t stride = s->points / NEIGHBOUR_PAIRS + 1;
    size_t count[DIVERGENCE_PARTS] = {0};
    for (size_t k = 0; k < d->steps * DIVERGENCE_PARTS; k++)
        d->part[k] = 0;
    for (size_t i = 0; i < s->points; i += stride) {
        const size_t part = i * DIVERGENCE_PARTS / s->points;
        struct neighbours nearest;
        space_nearest(s, i, 1, &nearest);
        if (nearest.count == 0)
            continue;
        if (i / stride % 64 == 0 && cancelled(s->cancel))
            return false;
        follow_pair(s, i, nearest.index[0], samples, d, d->part + part * d->steps);
        count[part]++;
        d->pairs++;
    }
    put_means(s, count, d);
    return true;
}

/* Returns the slope of a line through y[first] to y[last], per step. */
static double slope_of(const double *y, size_t first, size_t last)
{
    const double middle = (double)(first + last) / 2;
    double xy = 0, xx = 0;
    for (size_t k = first; k <= last; k++) {
        xy += ((double)k - middle) * y[k];
        xx += ((double)k - middle) * ((double)k - middle);
    }
    return xx > 0 ? xy / xx : NAN;
}

/* The range of even growth is from step `begin` to the last one before distances come within
 * SATURATION_LOG_MARGIN of the saturation. The slope is per step; its error is the scatter of the
 * slopes of successive parts, NAN (as the slope is) if the range is too short. */
struct even_growth divergence_growth(const struct divergence *d, size_t begin)
{
    struct even_growth g = {.first = begin, .error = NAN, .slope = NAN, .halves = {NAN, NAN}};
    g.last = begin;
    while (g.last < d->steps && d->mean[g.last] < d->saturation - SATURATION_LOG_MARGIN)
        g.last++;
    if (g.last > 0)
        g.last--;
    if (g.last < begin + 2)
        return g;
    const size_t middle = (g.first + g.last) / 2;
    double sum = 0, square = 0;
    g.slope = slope_of(d->mean, g.first, g.last);
    g.halves[0] = slope_of(d->mean, g.first, middle);
    g.halves[1] = slope_of(d->mean, middle, g.last);
    for (size_t p = 0; p < DIVERGENCE_PARTS; p++) {
        const double slope = slope_of(d->part + p * d->steps, g.first, g.last);
        sum += slope;
        square += slope * slope;
    }
    const double mean = sum / DIVERGENCE_PARTS,
                 scatter = fmax(square / DIVERGENCE_PARTS - mean * mean, 0);
    g.error = sqrt(scatter / (DIVERGENCE_PARTS - 1));
    return g;
}
