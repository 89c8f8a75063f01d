/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds a rest before the end of a recording (motion_quiet(), motion_rest()). */
#include "modules/recording/clean/clean.h"

#include <hooke/base/numeric.h>

#include <math.h>

/* [periods] Smallest duration of a rest, and of the motion before it. */
#define PERIODS_MIN 2.0
/* Largest scatter in a rest, relative to the scatter at the start. */
#define REST_SCATTER_FRACTION 0.2
/* Largest scatter of half a period in a rest, relative to the scatter at the end. */
#define HALF_PERIOD_SCATTER_RATIO_MAX 1.5
/* The motion has stopped if less than this part of the amplitude of an exponential decay
 * remains. */
#define FADED_AMPLITUDE_FRACTION 0.4
#define AMPLITUDE_CLEAR_SIGMAS 3.0 /* standard deviations of a certain amplitude */
#define SAMPLES_MIN 8.0            /* samples of a stretch whose amplitude is estimated */

/* Mean, standard deviation and number of values. */
struct spread {
    double mean, deviation, count;
};

/* Computes the statistics of rows begin to end - 1 that count. */
static struct spread spread_of(const struct motion_rows *x, size_t begin, size_t end)
{
    struct spread s = {0};
    for (size_t i = begin; i < end; i++)
        if (x->mask[i] == x->wanted) { /* Welford 1962 */
            const double difference = x->y[i] - s.mean;
            s.mean += difference / ++s.count;
            s.deviation += difference * (x->y[i] - s.mean);
        }
    s.deviation = s.count > 1 ? sqrt(s.deviation / (s.count - 1)) : NAN;
    return s;
}

/* Returns the amplitude of a sine of this period in rows begin to end - 1, or NAN if they do not
 * determine it. Sets *count to the number of rows that count. */
static double amplitude_of(const struct motion_rows *x, size_t begin, size_t end, double period,
                           double *count)
{
    double n = 0, mean[3] = {0}, square[3][3] = {{0}};
    for (size_t i = begin; i < end; i++) {
        if (x->mask[i] != x->wanted)
            continue;
        const double phase = TWO_PI * (x->t[i] - x->t[begin]) / period,
                     v[3] = {cos(phase), sin(phase), x->y[i]};
        double deviation[3];
        n++;
        for (int j = 0; j < 3; j++) {
            deviation[j] = v[j] - mean[j];
            mean[j] += deviation[j] / n;
            for (int k = 0; k <= j; k++)
                square[j][k] += deviation[j] * (v[k] - mean[k]);
        }
    }
    *count = n;
    const double cc = square[0][0], cs = square[1][0], ss = square[1][1], det = cc * ss - cs * cs;
    if (!(n >= 4 && det > 0.01 * n * n))
        return NAN;
    return hypot(ss * square[2][0] - cs * square[2][1], cc * square[2][1] - cs * square[2][0]) /
           det;
}

/* Returns true if the amplitude from row `rest` on is smaller than the decay before explains. The
 * logarithms of the amplitudes of intervals of `stretch` [s], from the largest on, lie on a
 * straight line for a damped sine; the line is weighted by their certainty and extrapolated.
 * `noise` is the standard deviation of a sample. */
static bool motion_stops(const struct motion_rows *x, size_t rest, double period, double stretch,
                         double noise)
{
    const double t_begin = x->t[rest] + 0.5 * stretch;
    double w = 0, mean_t = 0, mean_l = 0, tt = 0, tl = 0, largest = 0, count;
    for (double t = x->t[0]; t + stretch <= x->t[rest]; t += stretch) {
        const double a = amplitude_of(x, first_from(x->t, x->n, t),
                                      first_from(x->t, x->n, t + stretch), period, &count);
        const double weight = a * a * count, off_t = t - mean_t, off_l = log(a) - mean_l;
        if (!(a > AMPLITUDE_CLEAR_SIGMAS * noise * sqrt(2 / count)))
            continue;
        if (a > largest) { /* the amplitude grew before this stretch: by a hand or a release */
            w = weight;
            mean_t = t;
            mean_l = log(a);
            tt = tl = 0;
            largest = a;
            continue;
        }
        w += weight;
        mean_t += weight / w * off_t;
        mean_l += weight / w * off_l;
        tt += weight * off_t * (t - mean_t);
        tl += weight * off_t * (log(a) - mean_l);
    }
    const double a = amplitude_of(x, first_from(x->t, x->n, t_begin),
                                  first_from(x->t, x->n, t_begin + stretch), period, &count);
    const double left = exp(mean_l + (tt > 0 ? fmin(tl / tt, 0) : 0) * (t_begin - mean_t));
    return w > 0 && count > 0 && left > AMPLITUDE_CLEAR_SIGMAS * noise * sqrt(2 / count) &&
           (isnan(a) ? 0 : a) + AMPLITUDE_CLEAR_SIGMAS * noise * sqrt(2 / count) <
               FADED_AMPLITUDE_FRACTION * left;
}

/* Returns a duration [s] of whole periods with at least SAMPLES_MIN samples; with few samples per
 * period also long enough for their pattern against the sine to repeat. */
static double stretch_of(const struct motion_rows *x, double period)
{
    const double step = (x->t[x->n - 1] - x->t[0]) / (double)(x->n - 1);
    const double pattern = 1 / fabs(1 / step - 2 / period), min = fmax(SAMPLES_MIN * step, period);
    return period * ceil(fmax(min, period < SAMPLES_MIN * step ? pattern : 0) / period - 1e-9);
}

/* Returns the row from which on the body is at rest, or x->n if it does not come to rest or never
 * moved. Goes backward from the end by half stretches as long as scatter and mean are those of the
 * end. */
size_t motion_quiet(const struct motion_rows *x, double period)
{
    if (!(period > 0) || x->n < 2)
        return x->n;
    const double first = x->t[0], last = x->t[x->n - 1], stretch = stretch_of(x, period);
    const double min = PERIODS_MIN * stretch;
    if (!(last - first >= 2 * min))
        return x->n;
    const struct spread start = spread_of(x, 0, first_from(x->t, x->n, first + min));
    const struct spread end = spread_of(x, first_from(x->t, x->n, last - min), x->n);
    if (!(end.count > 4) || !(end.deviation < REST_SCATTER_FRACTION * start.deviation))
        return x->n;
    size_t rest = first_from(x->t, x->n, last - min), row_end = rest;
    int moves = 0; /* half stretches in a row: a single one may be chance */
    double t = last - min - 0.5 * stretch;
    while (t > first + min) {
        const size_t row_begin = first_from(x->t, x->n, t);
        const struct spread s = spread_of(x, row_begin, row_end);
        const double difference = fabs(s.mean - end.mean);
        moves = s.count > 1 && (s.deviation > HALF_PERIOD_SCATTER_RATIO_MAX * end.deviation ||
                                difference > end.deviation)
                    ? moves + 1
                    : 0;
        if (moves == 2)
            return rest;
        row_end = row_begin;
        t -= 0.5 * stretch;
        rest = moves == 0 ? row_begin : rest;
    }
    return x->n; /* it never moved */
}

/* Finds the rest, and tests that the decay before does not explain it. */
size_t motion_rest(const struct motion_rows *x, double period)
{
    const size_t rest = motion_quiet(x, period);
    if (rest >= x->n)
        return x->n;
    const struct spread resting = spread_of(x, rest, x->n);
    return motion_stops(x, rest, period, stretch_of(x, period), resting.deviation) ? rest : x->n;
}
