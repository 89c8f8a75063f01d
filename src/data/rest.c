/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Where a motion comes to rest before its recording ends. */
#include "clean.h"

#include <math.h>

#define PERIODS_LEAST 2.0 /* of rest, and of motion before it */
#define QUIET 0.2  /* of the scatter at the start: so small must that at the end be */
#define ALIKE 1.5  /* times the scatter at the end: so large may that of half a period be */

struct spread {
    double mean, deviation, count;
};

static struct spread spread_of(const struct motion_rows *x, size_t from, size_t to)
{
    struct spread s = {0};
    for (size_t i = from; i < to; i++)
        if (x->mask[i] == x->wanted) { /* Welford 1962 */
            const double off = x->y[i] - s.mean;
            s.mean += off / ++s.count;
            s.deviation += off * (x->y[i] - s.mean);
        }
    s.deviation = s.count > 1 ? sqrt(s.deviation / (s.count - 1)) : NAN;
    return s;
}

size_t first_row(const struct motion_rows *x, double t)
{
    size_t low = 0, high = x->n;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (x->t[middle] < t)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

size_t motion_rest(const struct motion_rows *x, double period)
{
    const double first = x->t[0], last = x->t[x->n - 1], least = PERIODS_LEAST * period;
    if (!(period > 0) || last - first < 2 * least)
        return x->n;
    const struct spread start = spread_of(x, 0, first_row(x, first + least));
    const struct spread end = spread_of(x, first_row(x, last - least), x->n);
    if (!(end.count > 4) || !(end.deviation < QUIET * start.deviation))
        return x->n;
    size_t rest = first_row(x, last - least), to = rest;
    int moves = 0; /* half periods in a row: a single one may be chance */
    for (double t = last - least - 0.5 * period; t > first + least; t -= 0.5 * period) {
        const size_t from = first_row(x, t);
        const struct spread s = spread_of(x, from, to);
        const double off = fabs(s.mean - end.mean);
        moves = s.count > 1 && (s.deviation > ALIKE * end.deviation || off > end.deviation) ? moves + 1 : 0;
        if (moves == 2)
            return rest;
        to = from;
        rest = moves == 0 ? from : rest;
    }
    return x->n; /* it never moved */
}
