/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rate of change of a series: the slope of the least-squares parabola through neighbouring samples
 * (Savitzky & Golay 1964), at the samples' true times. For even steps h and `points` = 2 p + 1
 * samples it equals sum(i y_i)/(h sum(i^2)), i = -p…p. */
#include "modules/recording/series/analysis.h"
#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <math.h>

/* A time step longer than this number of median steps is a gap, across which no parabola is
 * fitted. */
#define GAP_MEDIAN_STEPS 1.5

/* Returns the median time step [s]; work [n] is scratch space. */
static double median_step(const struct series *s, double *work)
{
    for (size_t i = 0; i + 1 < s->n; i++)
        work[i] = s->t[i + 1] - s->t[i];
    return values_quantile(work, s->n - 1, 0.5);
}

/* Returns the slope at t[row] of the parabola through the samples begin to end - 1. Sets *gain to
 * the factor [1/s] by which it multiplies independent noise. */
static double slope_at(const struct series *s, size_t begin, size_t end, size_t row, double *gain)
{
    /* Orthogonal polynomials on these times: 1, u = t - mean, and q = u^2 minus its projections on
     * both. */
    double n = (double)(end - begin), mean = 0, uu = 0, uuu = 0, qq = 0, line = 0, curve = 0;
    for (size_t i = begin; i < end; i++)
        mean += (s->t[i] - s->t[row]) / n;
    for (size_t i = begin; i < end; i++) {
        const double u = s->t[i] - s->t[row] - mean;
        uu += u * u;
        uuu += u * u * u;
    }
    for (size_t i = begin; i < end; i++) {
        const double u = s->t[i] - s->t[row] - mean, q = u * u - uuu / uu * u - uu / n;
        qq += q * q;
        line += u * (s->y[i] - s->y[row]);
        curve += q * (s->y[i] - s->y[row]);
    }
    const double turn = -2 * mean - uuu / uu; /* dq/du at t[row] */
    const bool curved = end - begin > 2 && qq > 0;
    *gain = sqrt(1 / uu + (curved ? turn * turn / qq : 0));
    return line / uu + (curved ? turn * curve / qq : 0);
}

/* Computes the rate of change at each sample by a parabola through `points` samples around it (an
 * odd number), within stretches that have no gap; NAN in stretches of less than three samples.
 * Returns false with the error. */
bool series_derivative(const struct series *series, int points, struct arena *arena,
                       struct derivative *derivative, struct error *error)
{
    const size_t n = series->n, reach = (size_t)(points / 2);
    if (points < 3 || points % 2 == 0 || n < (size_t)points)
        return error_set(
            error, ERROR_COMMAND,
            "a rate needs an odd number of points, at least 3, and at least that many samples");
    double *value = arena_array(arena, n, sizeof *value),
           *gain = arena_array(arena, n, sizeof *gain);
    if (!value || !gain)
        return error_memory(error);
    const double longest = GAP_MEDIAN_STEPS * median_step(series, gain);
    size_t begin = 0, end = 0, known = 0; /* begin to end - 1 is a stretch without gap */
    for (size_t i = 0; i < n; i++) {
        if (cancelled_at(series->cancel, i))
            return error_set(error, ERROR_CANCELLED, "stopped");
        if (i == end) {
            begin = i;
            for (end = i + 1; end < n && series->t[end] - series->t[end - 1] <= longest;)
                end++;
        }
        /* The same samples serve several times at the ends of a stretch. Stretches with fewer than
         * three samples give no value. */
        size_t first = i >= begin + reach ? i - reach : begin;
        size_t stop = first + 2 * reach + 1;
        if (stop > end) {
            stop = end;
            first = end - begin > 2 * reach ? end - 2 * reach - 1 : begin;
        }
        value[i] = stop - first >= 3 ? slope_at(series, first, stop, i, &gain[known]) : NAN;
        known += stop - first >= 3;
    }
    static const enum quantity rate_of[QUANTITY_COUNT] = {
        [QUANTITY_LENGTH] = QUANTITY_VELOCITY,
        [QUANTITY_VELOCITY] = QUANTITY_ACCELERATION,
        [QUANTITY_ANGLE] = QUANTITY_ANGULAR_FREQUENCY,
        [QUANTITY_ANGULAR_FREQUENCY] = QUANTITY_ANGULAR_ACCELERATION};
    const enum quantity rate = rate_of[series->quantity];
    *derivative = (struct derivative){.value = value,
                                      .known = known,
                                      .gain = values_quantile(gain, known, 0.5),
                                      .points = points,
                                      .step = longest / GAP_MEDIAN_STEPS,
                                      .quantity = rate == QUANTITY_NUMBER ? QUANTITY_OTHER : rate};
    return true;
}

/* Compares the filter's response to a sine with omega. */
double derivative_loss(const struct derivative *derivative, double omega)
{
    const int p = derivative->points / 2;
    double sum = 0, squares = 0, x = omega * derivative->step;
    for (int i = 1; i <= p; i++) {
        sum += i * sin(i * x);
        squares += (double)i * i;
    }
    return 1 - sum / (x * squares);
}
