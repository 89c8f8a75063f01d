/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a sensor missed: samples far off those about them say nothing about how a curve goes. */
#include "figure/describe/internal.h"

#include <hooke/base/numeric.h>

#include <math.h>

#define ABOUT 2   /* samples on each side: one or two echoes in a row are seen */
#define FEWEST 50 /* points: of fewer each counts */
#define FAR 8.0   /* times what 95 % of the samples are off the median about them (Hampel 1974) */

static double median_about(const struct points *points, size_t i)
{
    double y[2 * ABOUT + 1];
    for (size_t k = 0; k < COUNT_OF(y); k++)
        y[k] = points->y[i - ABOUT + k];
    return quantile(y, COUNT_OF(y), 0.5);
}

bool drop_echoes(struct points *points, struct arena *arena)
{
    const size_t n = points->n;
    if (n < FEWEST)
        return true;
    double *off = arena_array(arena, n, sizeof *off),
           *sorted = arena_array(arena, n, sizeof *sorted), *x = arena_array(arena, n, sizeof *x),
           *y = arena_array(arena, n, sizeof *y);
    if (!off || !sorted || !x || !y)
        return false;
    for (size_t i = 0; points_go_on(points, i); i++)
        sorted[i] = off[i] =
            i < ABOUT || i + ABOUT >= n ? 0 : fabs(points->y[i] - median_about(points, i));
    const double far = FAR * quantile(sorted, n, 0.95);
    size_t kept = 0;
    for (size_t i = 0; points_go_on(points, i); i++)
        if (!(off[i] > far)) {
            x[kept] = points->x[i];
            y[kept++] = points->y[i];
        }
    /* where many are, it is no sensor's fault but a curve with steps */
    if (far > 0 && kept >= n - n / 20)
        *points = (struct points){x, y, kept, points->noise, points->measured, points->cancel};
    return true;
}
