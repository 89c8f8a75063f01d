/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recognises columns of times by their numbers if neither a name nor a unit identifies them. */
#include "modules/recording/table/table.h"

#include <math.h>

/* Returns true if the n values rise, nine in ten of the steps within half of the mean step, as
 * those of a clock. */
bool rises_evenly(const double *value, size_t n)
{
    static const double even_share = 0.9;
    if (n < 3 || !isfinite(value[0]) || !isfinite(value[n - 1]))
        return false;
    const double mean = (value[n - 1] - value[0]) / (double)(n - 1);
    size_t even = 0;
    for (size_t i = 1; i < n; i++) {
        if (!(value[i] > value[i - 1]))
            return false;
        even += fabs(value[i] - value[i - 1] - mean) <= 0.5 * mean;
    }
    return (double)even >= even_share * (double)(n - 1);
}

/* Returns true if the n values follow a straight line, as a clock whose stamps may repeat: within 2
 * % of their range or the longest step. */
bool is_along_line(const double *value, size_t n)
{
    /* largest distance from the line, relative to the range */
    static const double distance_max = 0.02;
    /* largest step relative to the range; a clock has more than four stamps */
    static const double step_max = 0.25;
    if (n < 8 || !isfinite(value[0]) || !(value[n - 1] > value[0]))
        return false;
    const double range = value[n - 1] - value[0];
    double longest = 0;
    for (size_t i = 1; i < n; i++) {
        const double step = value[i] - value[i - 1];
        if (!(step >= 0 && step <= step_max * range))
            return false;
        longest = fmax(longest, step);
    }
    for (size_t i = 1; i < n; i++) {
        const double line = value[0] + range * (double)i / (double)(n - 1);
        if (fabs(value[i] - line) > fmax(distance_max * range, longest))
            return false;
    }
    return true;
}

/* Returns true if the n values fall somewhere, and only from their highest to their lowest value,
 * as a counter that overflows. */
bool count_wraps(const double *value, size_t n)
{
    double low = HUGE_VAL, high = -HUGE_VAL;
    bool falls = false;
    for (size_t i = 0; i < n; i++) {
        low = fmin(low, value[i]);
        high = fmax(high, value[i]);
    }
    for (size_t i = 1; i < n; i++) {
        const bool fall = value[i] < value[i - 1];
        if (fall && (value[i] != low || value[i - 1] != high))
            return false;
        falls |= fall;
    }
    return falls;
}
