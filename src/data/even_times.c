/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Finds the even grid of times behind stamps that were rounded when they were printed.
 *
 * Instruments print i/60 s as 0.017 0.033 0.050. The first and the last stamp alone are wrong by up
 * to half a digit, which is 8 standard deviations of the period in a video of 10 s. The slopes of
 * all lines that pass within half a digit of every stamp form an interval: its middle is the step,
 * and its width says how well the stamps determine it (O'Rourke, Commun. ACM 24 (1981) 574).
 */
#include <hooke/base/cancel.h>
#include <hooke/data/even_times.h>

#include <hooke/base/numeric.h>

#include <float.h>
#include <math.h>

/* Stamps so close to an even grid, relative to its step, carry no rounding that matters. */
static const double exact_deviation = 1e-9;
/* A stamp may miss its own rounding by this much: decimal fractions are not exact in binary. */
static const double rounding_tolerance = 0.01;
/* A dropped or a repeated row moves the stamps beside it at least half a step off any line. A
 * rounding finer than this part of the step cannot be taken for it. */
static const double dropped_row_deviation = 0.45;
/* The line by least squares through evenly numbered stamps deviates at most 1 + 5/3 times as much
 * as the best line (5/3 is the norm of the projection), here with room for the tolerance. */
static const double least_squares_excess = 2.7;
/* The stamps of an even grid of which fewer than this many differ do not determine its step. */
enum { STAMPS_DIFFERENT_MIN = 4, DIGITS_MIN = 2, DIGITS_MAX = 8, NEWTON_MAX = 60 };

/* Rounding of printed stamps: to a number of significant digits, or to a number of decimals. */
struct stamp_rounding {
    double decimal;  /* [s] the last decimal place; 0 where `digits` holds */
    int digits;      /* significant ones */
    double smallest; /* [s] magnitude below which no more places are counted */
};

/* Time stamps that are examined, with the values at them. */
struct stamps {
    const double *t, *y; /* y may be NULL */
    size_t n;
    const struct cancel *cancel;
};

/* Returns the unit [s] of the last printed place of the stamp t. */
static double stamp_resolution(const struct stamp_rounding *rounding, double t)
{
    if (rounding->decimal > 0)
        return rounding->decimal;
    const double magnitude = fmax(fabs(t), rounding->smallest);
    return pow(10, floor(log10(magnitude) + 1e-12) + 1 - rounding->digits);
}

/* Returns true if every stamp is a multiple of its resolution. */
static bool stamps_are_multiples(const struct stamps *s, const struct stamp_rounding *rounding)
{
    for (size_t i = 0; i < s->n; i++) {
        if (cancelled_at(s->cancel, i))
            return false;
        const double multiple = s->t[i] / stamp_resolution(rounding, s->t[i]);
        if (!(fabs(multiple - nearbyint(multiple)) < 1e-6 + 1e-12 * fabs(multiple)))
            return false;
    }
    return true;
}

/* Fits the line first + i step by least squares, with each stamp weighted by its resolution; a NULL
 * rounding weights all alike. Returns the variance of the slope that the scatter about the line
 * implies. */
static double line_through(const struct stamps *s, const struct stamp_rounding *rounding,
                           double *first, double *step)
{
    double w = 0, wx = 0, wt = 0, xx = 0, xt = 0, square = 0;
    const double middle = 0.5 * (double)(s->n - 1), t0 = s->t[0];
    for (int pass = 0; pass < 3; pass++)
        for (size_t i = 0; i < s->n; i++) {
            const double r = rounding ? stamp_resolution(rounding, s->t[i]) : 1,
                         weight = 1 / (r * r), x = (double)i - middle, t = s->t[i] - t0;
            if (pass == 0) {
                w += weight;
                wx += weight * x;
                wt += weight * t;
            } else if (pass == 1) {
                xx += weight * (x - wx / w) * (x - wx / w);
                xt += weight * (x - wx / w) * (t - wt / w);
            } else {
                const double deviation = t - wt / w - xt / xx * (x - wx / w);
                square += weight * deviation * deviation;
            }
        }
    *step = xt / xx;
    *first = t0 + wt / w - *step * (wx / w + middle);
    return square / (double)(s->n - 2) / xx;
}

/* Returns the largest distance [s] of a stamp from the line first + i step. */
static double largest_deviation(const struct stamps *s, double first, double step)
{
    double deviation = 0;
    for (size_t i = 0; i < s->n; i++) {
        const double here = fabs(s->t[i] - (first + (double)i * step));
        deviation = here > deviation ? here : deviation;
    }
    return deviation;
}

/* Finds how the stamps were rounded and stores the rule in *rounding. Tries multiples of powers of
 * ten first, from coarse to fine, but not finer than `deviation`, the largest distance of a stamp
 * from the even grid with this step; then a number of significant digits, the fewest first. Returns
 * false if neither explains the stamps. */
static bool find_rounding(const struct stamps *s, double step, double deviation,
                          struct stamp_rounding *rounding)
{
    const double span = s->t[s->n - 1] - s->t[0];
    *rounding = (struct stamp_rounding){.smallest = DBL_MIN};
    for (int place = (int)floor(log10(span / STAMPS_DIFFERENT_MIN));; place--) {
        rounding->decimal = pow(10, place);
        if (!(rounding->decimal * (1 + rounding_tolerance) >= deviation))
            break;
        if (stamps_are_multiples(s, rounding))
            return true;
    }
    rounding->decimal = 0;
    const double largest = fmax(fabs(s->t[0]), fabs(s->t[s->n - 1]));
    for (rounding->digits = DIGITS_MIN; rounding->digits <= DIGITS_MAX; rounding->digits++) {
        if (stamp_resolution(rounding, largest) * least_squares_excess < deviation)
            return false;
        if (stamps_are_multiples(s, rounding))
            break;
    }
    rounding->smallest =
        step; /* one stamp that happens to lie near 0 does not outweigh the others */
    return rounding->digits <= DIGITS_MAX;
}

/* Returns by how much the best line with slope `step` through the stamps misses one of their
 * rounding intervals, which reach half a digit up and down; the result is <= 0 if a line passes
 * through all of them. As a function of the slope it is convex, and *derivative is set to its
 * derivative. Computed as the largest lower end minus the smallest upper end of the intervals,
 * relative to the line. */
static double slope_miss(const struct stamps *s, const struct stamp_rounding *rounding, double step,
                         double *derivative)
{
    double low = -HUGE_VAL, high = HUGE_VAL;
    size_t low_at = 0, high_at = 0;
    for (size_t i = 0; i < s->n; i++) {
        const double half = (0.5 + 1e-6) * stamp_resolution(rounding, s->t[i]),
                     deviation = s->t[i] - s->t[0] - step * (double)i;
        if (deviation - half > low) {
            low = deviation - half;
            low_at = i;
        }
        if (deviation + half < high) {
            high = deviation + half;
            high_at = i;
        }
    }
    *derivative = (double)high_at - (double)low_at;
    return low - high;
}

/* Returns the lower (side -1) or upper (side 1) end of the interval of slopes of lines within half
 * a digit of every stamp, by Newton's method from outside. Returns NAN if no such line exists. */
static double slope_limit(const struct stamps *s, const struct stamp_rounding *rounding,
                          double step, int side)
{
    const double coarse =
        fmax(stamp_resolution(rounding, s->t[0]), stamp_resolution(rounding, s->t[s->n - 1]));
    double slope = step + side * 4 * coarse / (double)(s->n - 1), derivative;
    for (int k = 0; k < NEWTON_MAX && !cancelled(s->cancel); k++) {
        const double miss = slope_miss(s, rounding, slope, &derivative);
        if (!(miss > 1e-6 * coarse))
            return slope;
        if (!(side * derivative > 0))
            return NAN;
        slope -= miss / derivative;
    }
    return NAN;
}

/* Returns true if only a few steps are longer (or shorter) than all others. Then rows are more
 * likely lost or repeated than stamps rounded, since a rounding makes steps differ regularly. */
static bool few_steps_differ(const struct stamps *s, double step, double resolution)
{
    size_t longer = 0;
    for (size_t i = 1; i < s->n; i++)
        longer += s->t[i] - s->t[i - 1] > (floor(step / resolution) + 0.5) * resolution;
    const size_t shorter = s->n - 1 - longer;
    return (longer < shorter ? longer : shorter) < STAMPS_DIFFERENT_MIN;
}

/* Returns the square of the distance of the middle sample from the cubic through the two samples on
 * either side, at the given times; NAN if a value is missing. */
static double cubic_miss(const double t[5], const double y[5])
{
    double at_middle = 0;
    for (int j = 0; j < 5; j++) {
        double weight = j == 2 ? 0 : 1;
        for (int k = 0; k < 5 && j != 2; k++)
            if (k != j && k != 2)
                weight *= (t[2] - t[k]) / (t[j] - t[k]);
        at_middle += weight * y[j];
    }
    return (y[2] - at_middle) * (y[2] - at_middle);
}

/* Returns true if steps are of one and of two units and the values are much smoother at the printed
 * times than at even times: then rows are lost, and no stamp is rounded. */
static bool rows_are_lost(const struct stamps *s, double resolution)
{
    static const double even[5] = {0, 1, 2, 3, 4}, smoother = 0.25;
    double printed_sum = 0, even_sum = 0;
    size_t compared_rows = 0;
    for (size_t i = 1; i < s->n; i++) {
        const double units = (s->t[i] - s->t[i - 1]) / resolution;
        if (!s->y || !(fabs(units - 1) < 0.1 || fabs(units - 2) < 0.1) ||
            cancelled_at(s->cancel, i))
            return false;
    }
    for (size_t i = 2; i + 2 < s->n; i++) {
        const double *t = s->t + i - 2;
        const double printed = cubic_miss(t, s->y + i - 2),
                     at_even = cubic_miss(even, s->y + i - 2);
        if (t[4] - t[0] < 4.5 * resolution || !isfinite(printed))
            continue;
        printed_sum += printed;
        even_sum += at_even;
        compared_rows++;
    }
    return compared_rows >= 2 * STAMPS_DIFFERENT_MIN && printed_sum < smoother * even_sum;
}

/* Fits an even grid to stamps that may be rounded. Leaves result unchanged if no rounding, lost
 * rows or jitter explain them better. */
static void fit_rounded(const struct stamps *s, struct even_times *result)
{
    struct stamp_rounding rounding;
    double first, step;
    line_through(s, NULL, &first, &step);
    if (!(step > 0) || !find_rounding(s, step, largest_deviation(s, first, step), &rounding))
        return;
    const double variance = line_through(s, &rounding, &first, &step);
    for (size_t i = 0; i < s->n; i++) {
        const double r = stamp_resolution(&rounding, s->t[i]);
        if (!(fabs(s->t[i] - (first + (double)i * step)) <= (1 + rounding_tolerance) * r))
            return;
        result->resolution = fmax(result->resolution, r);
    }
    const double low = slope_limit(s, &rounding, step, -1),
                 high = slope_limit(s, &rounding, step, 1);
    /* no line passes through the roundings of all stamps if there is jitter, too */
    const bool possible = isfinite(low) && isfinite(high);
    /* a rounding as coarse as a step could as well be lost or repeated rows */
    if (result->resolution > dropped_row_deviation * step * (possible ? 2 : 1) &&
        (!possible || (rounding.decimal > 0 && few_steps_differ(s, step, result->resolution))))
        return;
    if (rounding.decimal > 0 && rows_are_lost(s, result->resolution))
        return;
    result->even = true;
    /* a shift of all times by half a digit has no meaning, so that the first stamp stays */
    result->first = s->t[0];
    result->step = step;
    result->pace = sqrt(variance) / step;
    if (possible) {
        result->step = 0.5 * (low + high);
        /* standard deviation of a triangular distribution, as fewer lines have slopes near the ends
         */
        result->pace = 0.5 * (high - low) / sqrt(6) / result->step;
    }
}

/* Starts with the mean step, then tests if the stamps are even, exactly or after rounding. */
void even_times_find(const double *t, const double *y, size_t n, const struct cancel *cancel,
                     struct even_times *result)
{
    *result = (struct even_times){.first = n > 0 ? t[0] : NAN, .step = NAN};
    if (n < 2)
        return;
    const struct stamps stamps = {t, y, n, cancel};
    result->step = (t[n - 1] - t[0]) / (double)(n - 1);
    if (!(result->step > 0) || !isfinite(result->step))
        return;
    double odd = 0;
    for (size_t i = 0; i < n; i++)
        odd += t[i] - t[i]; /* NAN if a stamp is not finite */
    if (odd != 0 || cancelled(cancel))
        return;
    const double deviation = largest_deviation(&stamps, t[0], result->step);
    result->even = deviation <= exact_deviation * result->step + 4e-16 * fabs(t[n - 1]);
    if (!result->even && n > STAMPS_DIFFERENT_MIN)
        fit_rounded(&stamps, result);
    if (cancelled(cancel))
        result->even = false;
}
