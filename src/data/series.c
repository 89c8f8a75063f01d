/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Series of values over time: windows, even grids behind their times, and their noise. */
#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>
#include <hooke/data/even_times.h>
#include <hooke/data/series.h>

#include <math.h>
#include <string.h>

/* [standard deviation] Differences beyond this are spikes and not counted as noise. */
#define NOISE_OUTLIER_SIGMAS 6.0

/* Returns the part of the series within [t_begin, t_end], which shares its memory. */
struct series series_window(struct series series, double t_begin, double t_end)
{
    size_t first = first_from(series.t, series.n, t_begin),
           last = first_from(series.t, series.n, t_end);
    while (last < series.n && series.t[last] <= t_end) {
        last++;
    }
    series.t += first;
    series.y += first;
    series.n = last > first ? last - first : 0;
    return series;
}

/* Interpolates the series linearly at t0 + i dt; beyond the ends the nearest value is used. Returns
 * the sum of the samples. */
double series_fill_grid(const struct series *s, double t0, double dt, size_t length,
                        double *samples)
{
    double sum = 0;
    size_t row = first_from(s->t, s->n, t0);
    row = row > 0 ? row - 1 : 0;
    for (size_t i = 0; i < length; i++) {
        const double t = t0 + (double)i * dt;
        while (row + 2 < s->n && s->t[row + 1] < t)
            row++;
        const double part = (t - s->t[row]) / (s->t[row + 1] - s->t[row]);
        samples[i] = s->y[row] + fmin(fmax(part, 0), 1) * (s->y[row + 1] - s->y[row]);
        sum += samples[i];
    }
    return sum;
}

/* Replaces rounded stamps by the times of the line through them, so that readers of samples->t see
 * the times at which samples were taken. Returns false if out of memory. */
static bool use_even_times(struct samples *samples, const struct even_times *even,
                           struct arena *arena)
{
    double *t = arena_array(arena, samples->n, sizeof *t);
    for (size_t i = 0; t && i < samples->n; i++)
        t[i] = even->first + (double)i * even->step;
    samples->t = t;
    return t != NULL;
}

/* Returns true if more than a tenth of the steps are far shorter than the mean step. */
bool series_is_uneven(const struct series *s)
{
    static const double short_step = 0.05, short_share_max = 0.1;
    const double mean = s->n > 1 ? (s->t[s->n - 1] - s->t[0]) / (double)(s->n - 1) : 0;
    size_t short_steps = 0;
    for (size_t i = 1; i < s->n; i++)
        short_steps += s->t[i] - s->t[i - 1] < short_step * mean;
    return (double)short_steps > short_share_max * (double)s->n;
}

/* Replaces very uneven samples by as many on an even grid, by straight lines. Rows that crowd where
 * the motion is fast would weigh that part more than all the others together. Returns false if out
 * of memory. */
static bool samples_resample(struct samples *samples, const struct series *series,
                             struct arena *arena)
{
    const size_t n = series->n;
    double *t = arena_array(arena, n, sizeof *t), *y = arena_array(arena, n, sizeof *y);
    if (!t || !y)
        return false;
    samples->t0 = series->t[0];
    samples->dt = (series->t[n - 1] - series->t[0]) / (double)(n - 1);
    samples->uniform = true;
    samples->resampled = true;
    samples->pace = series->pace;
    series_fill_grid(series, samples->t0, samples->dt, n, y);
    for (size_t i = 0; i < n; i++)
        t[i] = samples->t0 + (double)i * samples->dt;
    samples->t = t;
    samples->y = y;
    return true;
}

/* Prepares samples of a series for fits. Very uneven ones are replaced by samples on an even grid,
 * and rounded stamps of even times by the even times; samples->pace then also has the uncertainty
 * of their spacing. Returns false if out of memory or if cancelled. */
bool samples_init(struct samples *samples, const struct series *series, struct arena *arena)
{
    *samples =
        (struct samples){.t = series->t, .y = series->y, .n = series->n, .cancel = series->cancel};
    samples->use = arena_alloc(arena, series->n + 1);
    if (!samples->use) {
        return false;
    }
    memset(samples->use, 1, series->n);
    if (series->n < 2) {
        return true;
    }
    if (series_is_uneven(series))
        return samples_resample(samples, series, arena) && !cancelled(series->cancel);
    struct even_times even;
    even_times_find(series->t, series->y, series->n, series->cancel, &even);
    samples->t0 = even.first;
    samples->dt = even.step;
    samples->uniform = even.even;
    samples->pace = hypot(even.pace, series->pace);
    if (even.even && even.resolution > 0 && !use_even_times(samples, &even, arena))
        return false;
    return !cancelled(series->cancel);
}

/* Sets size[] to the absolute sixth differences. A sine with m samples a period enters them only as
 * (2 pi/m)^6, white noise as sqrt(924). Returns how many there are, 0 for fewer than 8 samples. */
static size_t sixth_differences(const struct samples *samples, double *size)
{
    const size_t count = samples->n < 8 ? 0 : samples->n - 6;
    for (size_t i = 0; i < count; i++) {
        const double *w = samples->y + i;
        size[i] = fabs((w[0] + w[6]) - 6 * (w[1] + w[5]) + 15 * (w[2] + w[4]) - 20 * w[3]);
    }
    return count;
}

/* Returns the standard deviation of the noise by the median of the sixth differences, which single
 * spikes do not change; NAN for too few samples. */
double samples_noise(const struct samples *samples, double *scratch)
{
    const size_t count = sixth_differences(samples, scratch);
    return count ? MAD_TO_SIGMA * values_quantile(scratch, count, 0.5) / sqrt(924.0) : NAN;
}

/* Returns the standard deviation of the noise by the mean square of the sixth differences without
 * spikes; NAN for too few samples or if out of memory. */
double series_noise(const struct series *series, struct arena *arena)
{
    struct samples samples;
    double *size = arena_array(arena, series->n, sizeof *size), sum = 0;
    size_t count = size && samples_init(&samples, series, arena) ? sixth_differences(&samples, size)
                                                                 : 0,
           used = 0;
    if (!count)
        return NAN;
    const double median = values_quantile(size, count, 0.5);
    /* the median alone would be one of few values if samples are rounded */
    for (size_t i = 0; i < count; i++)
        if (size[i] <= NOISE_OUTLIER_SIGMAS * MAD_TO_SIGMA * median || median == 0) {
            sum += size[i] * size[i];
            used++;
        }
    return sqrt(sum / ((double)used * 924));
}
