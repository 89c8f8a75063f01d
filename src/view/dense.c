/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Draws a recording that is too dense for marks as a line, which is interrupted where nothing was
 * recorded. */
#include "view/internal.h"

#define DENSE_SAMPLES 2 /* Samples per column from which a curve is dense. */

/* Returns a copy of a curve of points as a line, with a gap (NAN) wherever two samples are farther
 * apart in time than a column of the plot is wide. The copy is the arena's; NULL if out of
 * memory. */
static const struct curve *curve_with_gaps(struct arena *arena, const struct curve *source,
                                           int columns)
{
    const double *t = source->t ? source->t : source->x;
    const double longest = (t[source->n - 1] - t[0]) / columns;
    struct curve *curve = arena_array(arena, 1, sizeof *curve);
    double *x = arena_array(arena, 2 * source->n, sizeof *x),
           *y = arena_array(arena, 2 * source->n, sizeof *y);
    double *times = source->t ? arena_array(arena, 2 * source->n, sizeof *times) : NULL;
    if (!curve || !x || !y || (source->t && !times))
        return NULL;
    size_t n = 0;
    for (size_t i = 0; i < source->n; i++) {
        if (i > 0 && t[i] - t[i - 1] > longest) {
            x[n] = y[n] = NAN;
            if (times)
                times[n] = NAN;
            n++;
        }
        x[n] = source->x[i];
        y[n] = source->y[i];
        if (times)
            times[n] = t[i];
        n++;
    }
    *curve = *source;
    curve->points = false;
    curve->x = x;
    curve->y = y;
    curve->t = times;
    curve->n = n;
    return curve;
}

/* Replaces a figure's only curve by the line of curve_with_gaps() if it is one of points and has at
 * least DENSE_SAMPLES of them per column. Returns false if out of memory. */
bool curves_join_dense(struct arena *arena, int columns, struct figure *figure)
{
    if (figure->curves != 1 || !figure->curve[0].points ||
        figure->curve[0].n < DENSE_SAMPLES * (size_t)larger(columns, 1))
        return true;
    const struct curve *curve = curve_with_gaps(arena, &figure->curve[0], larger(columns, 1));
    figure->curve = curve ? curve : figure->curve;
    return curve != NULL;
}
