/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period from the autocorrelation: the lags of its peaks, that is the shifts at which a series
 * resembles itself most, against their number. Also the autocorrelation as a table, for plots. */
#include "modules/recording/series/internal.h"

#include <hooke/base/cancel.h>
#include <hooke/data/even_times.h>

#include <math.h>
#include <string.h>

enum {
    /* Number of peaks (periods of lag) used at most. */
    PEAKS_MAX = 8,
    /* Smallest number of samples per period; finer samples are averaged. */
    SAMPLES_A_PERIOD = 32,
    /* A long recording is represented by this number of blocks, */
    BLOCKS = 4,
    /* each with at least this number of samples and */
    BLOCK_MIN = 1024,
    /* and with no fewer periods than this. */
    PERIODS_IN_BLOCK = 4 * PEAKS_MAX,
};

/* A recording on an even time grid with its mean subtracted: one block with all of it or, if it is
 * long, several blocks spread over it. */
struct blocks {
    double *y; /* [count][length] */
    size_t count, length;
    size_t begin;  /* first sample of each block that the correlation sums */
    double step;   /* [s] between samples */
    double period; /* [samples] */
    /* [samples] length over which the correlation sums, a multiple of the period; 0 takes as many
     * periods as fit. */
    double whole;
    const struct cancel *cancel;
};

/* Sets block[length] to means of `each` neighbouring samples on the even grid, starting with the
 * mean that has index `first`. work [each] is scratch space. Returns the sum of the means. */
static double fill_block(const struct series *s, const struct even_times *even, size_t each,
                         size_t first, size_t length, double *work, double *block)
{
    const double t0 = s->t[0] + (double)(first * each) * even->step;
    double sum = 0;
    if (each == 1 && !even->even)
        return series_fill_grid(s, t0, even->step, length, block);
    for (size_t i = 0; i < length; i++) {
        double group_sum = 0;
        const double *y = s->y + (first + i) * each;
        if (!even->even) {
            series_fill_grid(s, t0 + (double)(i * each) * even->step, even->step, each, work);
            y = work;
        }
        for (size_t k = 0; k < each; k++)
            group_sum += y[k];
        sum += block[i] = group_sum / (double)each;
    }
    return sum;
}

/* Fills *b with averaged samples of the series on its even time grid; period is the known one [s].
 * Returns false if out of memory. */
static bool fill_blocks(const struct series *s, const struct even_times *even, double period,
                        struct arena *arena, struct blocks *b)
{
    const size_t each = (size_t)fmax(period / (SAMPLES_A_PERIOD * even->step), 1), n = s->n / each;
    double sum = 0;
    *b = (struct blocks){.count = 1,
                         .length = n,
                         .step = (double)each * even->step,
                         .period = period / ((double)each * even->step),
                         .cancel = s->cancel};
    const double min = fmax(BLOCK_MIN, PERIODS_IN_BLOCK * b->period);
    if (BLOCKS * min < (double)n) {
        b->count = BLOCKS;
        b->length = (size_t)min;
    }
    const size_t all = b->count * b->length;
    b->y = arena_array(arena, all, sizeof *b->y);
    double *work = arena_array(arena, each, sizeof *work);
    if (!b->y || !work)
        return false;
    for (size_t k = 0; k < b->count; k++) {
        const size_t first = b->count > 1 ? (n - b->length) * k / (b->count - 1) : 0;
        sum += fill_block(s, even, each, first, b->length, work, b->y + k * b->length);
    }
    for (size_t i = 0; i < all; i++)
        b->y[i] -= sum / (double)all;
    return true;
}

typedef double four __attribute__((vector_size(32), aligned(8), may_alias));

/* Adds the sums of x y, x x and y y over n samples, times weight, to sum[0], sum[1] and sum[2]. */
CLONES static void add_products(const double *x, const double *y, size_t n, double weight,
                                double sum[3])
{
    four xy = {0, 0, 0, 0}, xx = xy, yy = xy;
    size_t i = 0;
    for (; i + 4 <= n; i += 4) {
        const four a = *(const four *)(const void *)(x + i),
                   b = *(const four *)(const void *)(y + i);
        xy += a * b;
        xx += a * a;
        yy += b * b;
    }
    for (; i < n; i++) {
        xy[0] += x[i] * y[i];
        xx[0] += x[i] * x[i];
        yy[0] += y[i] * y[i];
    }
    sum[0] += weight * ((xy[0] + xy[1]) + (xy[2] + xy[3]));
    sum[1] += weight * ((xx[0] + xx[1]) + (xx[2] + xx[3]));
    sum[2] += weight * ((yy[0] + yy[1]) + (yy[2] + yy[3]));
}

/* Returns the correlation coefficient of the blocks with themselves, shifted by that number of
 * samples. It sums over whole periods, because a fraction of a period would shift the peaks; the
 * last sample is weighted by its share in them. */
static double correlation(const struct blocks *b, size_t shift)
{
    const double most = (double)(b->length - 1 - shift),
                 whole = floor(most / b->period) * b->period;
    const double periods = whole > 0 ? whole : most;
    const double used = b->whole > 0 && b->whole <= most ? b->whole : periods;
    const size_t n = (size_t)used;
    double sum[3] = {0};
    for (const double *y = b->y + b->begin; y < b->y + b->count * b->length; y += b->length) {
        add_products(y, y + shift, n, 1, sum);
        add_products(y + n, y + n + shift, 1, used - (double)n, sum);
    }
    return sum[0] / sqrt(sum[1] * sum[2]);
}

/* Climbs from *shift to the next maximum of the correlation. Returns true with the correlations one
 * sample before, at and after the maximum in v; returns false if it reaches the limits low or high,
 * or if cancelled. */
static bool climb_to_peak(const struct blocks *b, size_t low, size_t high, size_t *shift,
                          double v[3])
{
    for (size_t k = 0; k < 3; k++)
        v[k] = correlation(b, *shift + k - 1);
    while (!(v[1] >= v[0] && v[1] >= v[2])) {
        const bool is_rising = v[2] > v[0];
        *shift = is_rising ? *shift + 1 : *shift - 1;
        if (*shift <= low || *shift >= high || cancelled(b->cancel))
            return false;
        memmove(&v[!is_rising], &v[is_rising], 2 * sizeof *v);
        v[2 * is_rising] = correlation(b, is_rising ? *shift + 1 : *shift - 1);
    }
    return true;
}

/* Returns the distance [samples] of the maximum from the middle one of three neighbouring
 * correlations, by interpolation with a cosine. Sets *doubt to the distance to a parabola's
 * maximum. */
static double top_between(const double value[3], double period, double *doubt)
{
    const double angle = TWO_PI / period,
                 parabola = 0.5 * (value[0] - value[2]) / (value[0] - 2 * value[1] + value[2]),
                 cosine = atan((value[2] - value[0]) / (2 * value[1] * sin(angle))) / angle;
    *doubt = fabs(cosine - parabola);
    return cosine;
}

/* Returns the shift [samples] of the correlation's maximum within a quarter of a period of the
 * expected `shift`, or NAN if it lies on the border. Sets *doubt to an estimate of the
 * interpolation error. */
static double peak_near_lag(struct blocks *b, double shift, double *doubt)
{
    const size_t low = (size_t)fmax(shift - 0.25 * b->period, 1),
                 high = (size_t)fmin(shift + 0.25 * b->period, (double)b->length - 3);
    double value[3], later_doubt;
    if (low + 2 > high)
        return NAN;
    size_t top = (size_t)fmin(fmax(nearbyint(shift), (double)low + 1), (double)high - 1);
    /* Neighbouring shifts are compared over the same samples. */
    b->whole = floor(((double)b->length - 1 - shift - 0.5 * b->period) / b->period) * b->period;
    b->begin = 0;
    if (!climb_to_peak(b, low, high, &top, value))
        return NAN;
    const double cosine = top_between(value, b->period, doubt);
    if (!(b->whole > 0))
        return (double)top + cosine;
    /* A changing amplitude shifts the top; a quarter period later it does so the other way. */
    b->begin = (size_t)(0.25 * b->period);
    for (size_t k = 0; k < 3; k++)
        value[k] = correlation(b, top + k - 1);
    b->begin = 0;
    const double later = top_between(value, b->period, &later_doubt);
    *doubt += 0.25 * fabs(later - cosine);
    return (double)top + 0.5 * (cosine + later);
}

/* Returns the variance of the period from the peaks, relative to that from a straight line through
 * all phases. In white noise n about y, the lag of peak k is off by the sum of n y' over the first
 * k periods minus that over the last k: everything between cancels. Peaks share these samples,
 * blocks do not. `samples` is the number of samples of the whole recording. */
static double variance_of_peaks(const struct blocks *b, double samples, int peaks)
{
    const double length = (double)b->length, period = b->period,
                 of_line = 12 * period * period / (samples * samples * samples);
    double sum = 0, kk = 0;
    for (int k = 1; k <= peaks; k++) {
        kk += (double)k * k;
        for (int j = 1; j <= peaks; j++)
            sum += (double)j * k * period * (j < k ? j : k) /
                   ((length - j * period) * (length - k * period));
    }
    return 2 * sum / (kk * kk) / (double)b->count / of_line;
}

/* Computes the period [s] from the lags of up to PEAKS_MAX peaks of the autocorrelation; `known` is
 * the period measured otherwise. Returns false if there are fewer than two peaks. */
bool series_correlation_period(const struct series *series, const struct period *known,
                               struct arena *arena, struct measured *period)
{
    *period = (struct measured){NAN, NAN};
    struct even_times even;
    even_times_find(series->t, series->y, series->n, series->cancel, &even);
    const double span = even.step * (double)(series->n - 1), T = known->period.value,
                 periods = span / T;
    double lags[PEAKS_MAX], kk = 0, kt = 0, square = 0, doubts = 0, doubt = NAN;
    struct blocks blocks;
    if (!(even.step > 0) || !(periods > 0) || !fill_blocks(series, &even, T, arena, &blocks))
        return false;
    int peaks = 0;
    while (peaks < PEAKS_MAX && 2 * (peaks + 1) <= periods) {
        const double shift = peak_near_lag(&blocks, (peaks + 1) * blocks.period, &doubt);
        if (!isfinite(shift))
            break;
        lags[peaks++] = shift * blocks.step;
        kk += (double)peaks * peaks;
        kt += peaks * lags[peaks - 1];
        doubts += peaks * doubt * blocks.step;
    }
    if (peaks < 2)
        return false;
    period->value = kt / kk;
    for (int k = 0; k < peaks; k++)
        square += (lags[k] - (k + 1) * period->value) * (lags[k] - (k + 1) * period->value);
    /* Three independent contributions: scatter of the lags, noise, and interpolation. */
    const double scatter = sqrt(square / (peaks - 1) / kk),
                 noise = known->period.uncertainty *
                         sqrt(variance_of_peaks(&blocks, span / blocks.step, peaks));
    period->uncertainty = hypot(hypot(scatter, noise), doubts / kk);
    *period = measured_at_pace(*period, hypot(series->pace, even.pace));
    return true;
}

/* Sets *part to the means of `each` successive samples, about `rows` of them, from a part of the
 * series with motion near its middle. Returns false if out of memory. */
bool series_lively_part(const struct series *series, size_t each, size_t rows, struct arena *arena,
                        struct series *part)
{
    enum { PLACES = 9, MIDDLE = PLACES / 2 };
    /* Takes the stretches that show a motion that dies out or begins late; otherwise what lasts
     * counts, not how it began. */
    static const double lively_share = 0.2;
    const size_t wanted = each * rows, all = wanted < series->n ? wanted : series->n,
                 used = all / each * each;
    double spread[PLACES], most = 0;
    size_t first = 0;
    for (size_t k = 0; k < PLACES && all < series->n; k++) {
        spread[k] = values_variance(series->y + (series->n - all) * k / (PLACES - 1), all);
        most = fmax(most, spread[k]);
    }
    for (size_t k = 0; k < PLACES && all < series->n; k++) {
        /* order from the middle outwards */
        const size_t place = k % 2 ? MIDDLE + (k + 1) / 2 : MIDDLE - k / 2;
        if (spread[place] >= lively_share * most) {
            first = (series->n - all) * place / (PLACES - 1);
            break;
        }
    }
    struct series means;
    const struct samples stretch = {
        .t = series->t + first, .y = series->y + first, .n = used, .cancel = series->cancel};
    if (!samples_average(&stretch, each, arena, &means))
        return false;
    *part = *series;
    part->t = means.t;
    part->y = means.y;
    part->n = means.n;
    return true;
}

/* Sets result [n] to the normalised autocorrelation of y [n] at all lags, as the Fourier transform
 * of its power spectrum (Wiener 1930, Khinchin 1934). Zeros are appended so that ends do not
 * overlap. Returns false if out of memory or cancelled. */
static bool autocorrelation_fill(const double *y, size_t n, const struct cancel *cancel,
                                 struct arena *arena, double *result)
{
    size_t all = 4;
    while (all < 2 * n)
        all *= 2;
    double *data = arena_array(arena, all, sizeof *data),
           *work = arena_array(arena, all, sizeof *work), first = 0, second = 0;
    if (!data || !work)
        return false;
    memcpy(data, y, n * sizeof *data);
    if (!transform_real(data, all, work, cancel))
        return false;
    data[0] *= data[0];
    data[all / 2] *= data[all / 2];
    for (size_t k = 1; k < all / 2; k++)
        data[k] = data[all - k] = data[k] * data[k] + data[all - k] * data[all - k];
    if (!transform_real(data, all, work, cancel))
        return false;
    for (size_t i = 0; i < n; i++)
        first += y[i] * y[i];
    second = first;
    for (size_t i = 0; i < n; i++) {
        const double power = fmax(first, 0) * fmax(second, 0); /* rounding can make them negative */
        result[i] = power > 0 ? data[i] / (double)all / sqrt(power) : 0;
        second -= y[i] * y[i];
        first -= y[n - 1 - i] * y[n - 1 - i];
    }
    return true;
}

/* Returns the autocorrelation of the series at all lags, in the arena, after subtracting its line;
 * *grid becomes the series on an even grid. Returns NULL if out of memory or cancelled. */
double *series_correlations(const struct series *series, struct arena *arena, double **grid)
{
    const size_t n = series->n;
    double *result = arena_array(arena, n, sizeof *result), *y = arena_array(arena, n, sizeof *y),
           moment = 0, square = 0;
    if (!result || !y)
        return NULL;
    const double dt = (series->t[n - 1] - series->t[0]) / (double)(n - 1),
                 mean = series_fill_grid(series, series->t[0], dt, n, y) / (double)n,
                 middle = 0.5 * (double)(n - 1);
    for (size_t i = 0; i < n; i++) {
        moment += ((double)i - middle) * (y[i] - mean);
        square += ((double)i - middle) * ((double)i - middle);
    }
    /* The regression line is subtracted, as a drift would correlate at all lags. */
    for (size_t i = 0; i < n; i++)
        y[i] -= mean + moment / square * ((double)i - middle);
    *grid = y;
    return autocorrelation_fill(y, n, series->cancel, arena, result) ? result : NULL;
}
