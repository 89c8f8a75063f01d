/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Removes echoes that a distance sensor missed: samples far from their neighbours, which do not
 * belong to the course of a curve. */
#include "modules/words/internal.h"

#include <hooke/base/numeric.h>

#include <math.h>

/* number of samples on each side of one; one or two echoes in a row are found */
#define ECHO_NEIGHBOURS 2
#define ECHO_POINTS_MIN 50 /* fewer points are not examined */
/* A sample is an echo if it deviates from the median around it by this many times the deviation
 * that 95 % of the samples do not exceed (Hampel 1974). */
#define ECHO_DISTANCE_FACTOR 8.0

/* Returns the median of a sample and its neighbours. */
static double median_about(const struct points *points, size_t i)
{
    double y[2 * ECHO_NEIGHBOURS + 1];
    for (size_t k = 0; k < COUNT_OF(y); k++)
        y[k] = points->y[i - ECHO_NEIGHBOURS + k];
    return values_quantile(y, COUNT_OF(y), 0.5);
}

/* Returns how far a sample is from the median around it, 0 at the ends. */
static double off_median(const struct points *points, size_t i)
{
    return i < ECHO_NEIGHBOURS || i + ECHO_NEIGHBOURS >= points->n
               ? 0
               : fabs(points->y[i] - median_about(points, i));
}

/* Returns the distance beyond which a sample is an echo, from a few thousand samples spread over
 * the curve. */
static double echo_distance(const struct points *points)
{
    enum { LOOKED_AT = 4096 };
    const size_t each = points->n / LOOKED_AT + 1;
    double distance[LOOKED_AT];
    size_t n = 0;
    for (size_t i = 0; points_go_on(points, i); i += each)
        distance[n++] = off_median(points, i);
    return ECHO_DISTANCE_FACTOR * values_quantile(distance, n, 0.95);
}

/* Removes single samples that are far from their neighbours (false echoes of a sensor), unless they
 * are more than a twentieth of all. *points then owns nothing: its new arrays are in the arena.
 * Returns false if out of memory. */
bool drop_echoes(struct points *points, struct arena *arena)
{
    const size_t n = points->n;
    if (n < ECHO_POINTS_MIN)
        return true;
    const double far = echo_distance(points);
    size_t echoes = 0, kept = 0;
    for (size_t i = 0; far > 0 && points_go_on(points, i); i++)
        echoes += off_median(points, i) > far;
    /* many outliers mean a curve with steps, not a fault of the sensor */
    if (echoes == 0 || echoes > n / 20)
        return true;
    double *x = arena_array(arena, n, sizeof *x), *y = arena_array(arena, n, sizeof *y);
    if (!x || !y)
        return false;
    for (size_t i = 0; points_go_on(points, i); i++)
        if (!(off_median(points, i) > far)) {
            x[kept] = points->x[i];
            y[kept++] = points->y[i];
        }
    *points = (struct points){x, y, kept, points->noise, points->measured, points->cancel};
    return true;
}
