/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A series prepared for analysis: its time grid, its noise, its spikes. */
#include "analysis/internal.h"
#include "analysis/fit/projection.h"

#include <hooke/data/even_times.h>

#include <math.h>
#include <string.h>

#define SPIKES_MAX 0.2 /* of the samples */
#define OUTLIER 6.0    /* standard deviations: a spike is no noise */

/* Puts the line through rounded stamps in their place: whoever reads x->t then has the times of the
 * samples. Returns false if out of memory. */
static bool even_out(struct samples *samples, const struct even_times *even, struct arena *arena)
{
    double *t = arena_array(arena, samples->n, sizeof *t);
    for (size_t i = 0; t && i < samples->n; i++)
        t[i] = even->first + (double)i * even->step;
    samples->t = t;
    return t != NULL;
}

bool series_is_uneven(const struct series *s)
{
    static const double short_step = 0.05, short_share_max = 0.1;
    const double mean = s->n > 1 ? (s->t[s->n - 1] - s->t[0]) / (double)(s->n - 1) : 0;
    size_t short_steps = 0;
    for (size_t i = 1; i < s->n; i++)
        short_steps += s->t[i] - s->t[i - 1] < short_step * mean;
    return (double)short_steps > short_share_max * (double)s->n;
}

bool samples_average(const struct samples *x, size_t each, struct arena *arena,
                     struct series *means)
{
    const size_t n = x->n / each;
    double *t = arena_array(arena, n + 1, sizeof *t), *y = arena_array(arena, n + 1, sizeof *y);
    *means = (struct series){.t = t, .y = y, .cancel = x->cancel};
    if (!t || !y)
        return false;
    for (size_t k = 0; k < n && !cancelled_at(x->cancel, k); k++) {
        double count = 0, time = 0, value = 0;
        for (size_t i = k * each; i < (k + 1) * each; i++)
            if (!x->use || x->use[i]) {
                count++;
                time += x->t[i];
                value += x->y[i];
            }
        if (count > 0) {
            t[means->n] = time / count;
            y[means->n++] = value / count;
        }
    }
    return true;
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
    if (even.even && even.resolution > 0 && !even_out(samples, &even, arena))
        return false;
    return !cancelled(series->cancel);
}

struct samples samples_part(const struct samples *samples, size_t from, size_t to)
{
    struct samples part = *samples;
    part.t += from;
    part.y += from;
    part.use += from;
    part.n = to - from;
    part.t0 += (double)from * samples->dt;
    return part;
}

/* Sizes of the sixth differences: a sine with m samples a period enters them only as (2 pi/m)^6,
 * white noise as sqrt(924). How many. */
static size_t sixth_differences(const struct samples *samples, double *size)
{
    const size_t count = samples->n < 8 ? 0 : samples->n - 6;
    for (size_t i = 0; i < count; i++) {
        const double *w = samples->y + i;
        size[i] = fabs((w[0] + w[6]) - 6 * (w[1] + w[5]) + 15 * (w[2] + w[4]) - 20 * w[3]);
    }
    return count;
}

/* Their median does not see single spikes. */
double samples_noise(const struct samples *samples, double *scratch)
{
    const size_t count = sixth_differences(samples, scratch);
    return count ? MAD_TO_SIGMA * quantile(scratch, count, 0.5) / sqrt(924.0) : NAN;
}

struct measured series_mean(const struct series *s)
{
    double area = 0, square = 0;
    for (size_t i = 1; i < s->n; i++) {
        const double dt = s->t[i] - s->t[i - 1];
        area += 0.5 * dt * (s->y[i] + s->y[i - 1]);
    }
    const double span = s->t[s->n - 1] - s->t[0], mean = area / span;
    for (size_t i = 1; i < s->n; i++) {
        const double a = s->y[i] - mean, b = s->y[i - 1] - mean;
        square += 0.5 * (s->t[i] - s->t[i - 1]) * (a * a + b * b);
    }
    return (struct measured){mean, sqrt(square / span)};
}

double series_noise(const struct series *series, struct arena *arena)
{
    struct samples samples;
    double *size = arena_array(arena, series->n, sizeof *size), sum = 0;
    size_t count = size && samples_init(&samples, series, arena) ? sixth_differences(&samples, size)
                                                                 : 0,
           used = 0;
    if (!count)
        return NAN;
    const double median = quantile(size, count, 0.5);
    for (size_t i = 0; i < count;
         i++) /* the median alone is one of few values where samples are rounded */
        if (size[i] <= OUTLIER * MAD_TO_SIGMA * median || median == 0) {
            sum += size[i] * size[i];
            used++;
        }
    return sqrt(sum / ((double)used * 924));
}

/*
 * Returns true if the flagged stretches come at even intervals and are all about as high: pulses,
 * not values that a sensor has missed. Stretches of one value alone are a sensor's, however often
 * they come.
 */
static bool spikes_recur(const struct samples *x, double middle, double *scratch)
{
    enum { SPIKES = 512, RECUR_MIN = 5 };
    static const double alike = 0.15, alike_share = 0.7;
    const size_t max = x->n / 2 < SPIKES ? x->n / 2 : SPIKES;
    double *height = scratch, *interval = scratch + max, value = NAN;
    size_t count = 0, last = 0, even = 0, equal = 0;
    bool differs = false;
    double tallest = 0;
    for (size_t i = 0; i < x->n; i++)
        tallest = x->use[i] ? tallest : fmax(tallest, fabs(x->y[i] - middle));
    for (size_t i = 0; i < x->n && count < max; i++) {
        double highest = 0;
        size_t top = i;
        for (; i < x->n && !x->use[i]; i++) {
            const double here = fabs(x->y[i] - middle);
            differs = differs || (isfinite(value) && x->y[i] != value);
            value = x->y[i];
            if (here > highest) {
                highest = here;
                top = i;
            }
        }
        if (!(highest > 0.5 * tallest)) /* noise */
            continue;
        interval[count] = (double)(top - last);
        height[count++] = highest;
        last = top;
    }
    if (!differs || count < RECUR_MIN)
        return false;
    /* quantile() changes the order */
    const double between = quantile(interval + 1, count - 1, 0.5),
                 high = quantile(height, count, 0.5);
    for (size_t k = 0; k < count; k++) {
        even += k > 0 && fabs(interval[k] / between - 1) < alike;
        equal += fabs(height[k] / high - 1) < 2 * alike;
    }
    return (double)even >= alike_share * (double)(count - 1) &&
           (double)equal >= alike_share * (double)count;
}

/*
 * A missed echo: the value leaves the middle by more than two thirds of the robust range (15 to 85
 * %) in one sample and comes back as fast within six samples, or the record ends there. Slow enough
 * for every oscillation with at least six samples a period; a coarse net that only protects the
 * spectrum: local fits decide later. Once forwards, once backwards: a bad first sample is seen from
 * behind only. Where many are found they are the oscillation itself, with few samples a period, or
 * its pulses.
 */
void samples_flag_spikes(struct samples *samples, double *scratch)
{
    enum { LONGEST = 6 };
    if (samples->n < 16 || samples->resampled) {
        return;
    }
    size_t n = samples->n, stride = n / 2048 + 1, count = 0, flagged = 0;
    for (size_t i = 0; i < n; i += stride) {
        scratch[count++] = samples->y[i];
    }
    double high = quantile(scratch, count, 0.85), low = quantile(scratch, count, 0.15),
           jump = 0.67 * (high - low);
    double middle = 0.5 * (high + low);
    if (!(jump > 0)) {
        return;
    }
    for (int backwards = 0; backwards < 2; backwards++) {
        const double *y = samples->y + (backwards ? n - 1 : 0);
        unsigned char *use = samples->use + (backwards ? n - 1 : 0);
        ptrdiff_t step = backwards ? -1 : 1;
        for (size_t i = 1; i < n; i++) {
            double before = y[(ptrdiff_t)(i - 1) * step], here = y[(ptrdiff_t)i * step],
                   away = here - before;
            if (fabs(away) <= jump || fabs(here - middle) <= fabs(before - middle)) {
                continue;
            }
            size_t back = i + 1;
            while (back < n && back <= i + LONGEST &&
                   copysign(1, away) *
                           (y[(ptrdiff_t)(back - 1) * step] - y[(ptrdiff_t)back * step]) <=
                       jump) {
                back++;
            }
            if (back <= i + LONGEST) {
                for (; i < back; i++) {
                    use[(ptrdiff_t)i * step] = 0;
                    flagged++;
                }
            }
        }
    }
    if ((double)flagged > SPIKES_MAX * (double)n || spikes_recur(samples, middle, scratch)) {
        memset(samples->use, 1, n);
    }
}

/* ---- for fits ---- */

bool enough_samples(const struct series *series, int parameters, struct error *error)
{
    return series->n > (size_t)parameters ||
           error_set(error, ERROR_COMMAND, "%zu samples cannot determine %d parameters", series->n,
                     parameters);
}

bool curve_part(const struct series *series, struct arena *arena, struct series *part)
{
    const size_t stride = series->n / CURVE_MANY + 1, n = series->n / stride;
    *part = *series;
    if (stride == 1)
        return true;
    double *t = arena_array(arena, n, sizeof *t), *y = arena_array(arena, n, sizeof *y);
    for (size_t i = 0; i < n && t && y; i++) {
        t[i] = series->t[i * stride];
        y[i] = series->y[i * stride];
    }
    part->t = t;
    part->y = y;
    part->n = n;
    return t && y;
}
