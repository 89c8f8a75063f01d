/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The lag at which a series resembles itself most: the shortest one at which the normalised
 * autocorrelation is as high as anywhere (McLeod & Wyvill, A smarter way to find pitch, ICMC
 * 2005). */
#include "modules/recording/period/cycle.h"

#include <math.h>

enum {
    LAG_SHORTEST = 4,   /* samples */
    MULTIPLES_MAX = 12, /* largest multiple of a period that is tested */
};

/* Correlations that differ by less are equal: the error of interpolating between lags, for pulses
 * of two samples. */
static const double correlation_resolution = 0.02;
/* Standard deviations up to which a difference is chance. */
static const double correlation_sigmas = 4;
/* Multiples above few_multiples count only if the correlation after one period is below alike_min:
 * otherwise they are beats or sway. */
static const double alike_min = 0.8;
static const int few_multiples = 3;

/* Sets weight [2 SINC_REACH] for interpolating the value `part` of a sample after one sample, from
 * the samples SINC_REACH - 1 before it on (sinc kernel with Lanczos' window). */
static void sinc_weights(double part, double *weight)
{
    double sum = 0;
    for (int j = 0; j < 2 * SINC_REACH; j++) {
        const double x = 0.5 * TWO_PI * (part + SINC_REACH - 1 - j);
        weight[j] = fabs(x) < 1e-9 ? 1 : sin(x) * sin(x / SINC_REACH) * SINC_REACH / (x * x);
        sum += weight[j];
    }
    for (int j = 0; j < 2 * SINC_REACH; j++)
        weight[j] /= sum;
}

/* Returns true if the series consists of pulses of a few samples: its correlation [n lags] at a few
 * samples is much smaller than the best one at larger lags. The positions of such pulses between
 * samples matter more than their similarity. */
static bool is_narrow(const double *correlation, size_t n)
{
    enum { NEAR = 4, FAR = 16 };
    static const double near_max = 0.4, early_max = 0.5;
    double early = 0, best = 0;
    for (size_t k = NEAR; k < n / 2; k++)
        if (k < FAR)
            early = fmax(early, correlation[k]);
        else
            best = fmax(best, correlation[k]);
    return correlation[NEAR] < near_max * best && early < early_max * best;
}

/* Sets result [n] to triangular means over seven neighbours. */
static void smooth(const double *y, size_t n, double *result)
{
    enum { REACH = 3 };
    for (size_t i = 0; i < n; i++) {
        double sum = 0, weight = 0;
        for (size_t k = i < REACH ? 0 : i - REACH; k <= i + REACH && k < n; k++) {
            const double w = (double)(REACH + 1) - fabs((double)k - (double)i);
            sum += w * y[k];
            weight += w;
        }
        result[i] = sum / weight;
    }
}

/* Prepares *lags, the autocorrelation of a series (NAN period if unknown): thins or selects rows,
 * and smooths series of narrow pulses first. Returns false if there are too few rows or if out of
 * memory. */
bool lags_init(const struct series *whole, double period, struct arena *arena, struct lags *lags)
{
    enum { ROWS = 4096, ROWS_A_PERIOD = 128, PERIODS = 32 };
    const struct series all = period > 0 ? series_longest_stretch(whole, period) : *whole;
    struct series part = all;
    const double span = all.n > 0 ? all.t[all.n - 1] - all.t[0] : 0;
    if (period > 0 && all.n > ROWS) {
        const double samples = period * (double)(all.n - 1) / span;
        const double each = floor(fmin(fmax(samples / ROWS_A_PERIOD, 1), (double)all.n / ROWS)),
                     rows = fmax(fmin(PERIODS * samples / each, (double)all.n), ROWS);
        if (!series_lively_part(&all, (size_t)each, (size_t)rows, arena, &part))
            return false;
    }
    *lags = (struct lags){.n = part.n};
    if (part.n < 4 * LAG_SHORTEST || !(span > 0))
        return false;
    lags->dt = (part.t[part.n - 1] - part.t[0]) / (double)(part.n - 1);
    for (int i = 0; i < SINC_PLACES; i++)
        sinc_weights((i + 1.0) / (SINC_PLACES + 1), lags->weight[i]);
    lags->correlation = series_correlations(&part, arena, &lags->y);
    if (lags->correlation && is_narrow(lags->correlation, part.n)) {
        double *y = arena_array(arena, part.n, sizeof *y);
        if (!y)
            return false;
        smooth(part.y, part.n, y);
        part.y = y;
        lags->correlation = series_correlations(&part, arena, &lags->y);
    }
    return lags->correlation;
}

/* Returns the difference between two correlations near r that chance and resolution explain. */
static double correlation_band(const struct lags *l, double r)
{
    return correlation_resolution +
           correlation_sigmas * (1 - fmin(r, 1)) * sqrt(3.0 / (double)l->n);
}

/* Returns the smallest correlation that is not chance. */
static double correlation_least(const struct lags *l)
{
    return 0.15 + 5 / sqrt((double)l->n);
}

/* Returns true if the correlation has a maximum at lag k. */
static bool is_peak(const struct lags *l, size_t k)
{
    const double *r = l->correlation + k;
    return r[0] > 0 && r[0] > r[-1] && r[0] >= r[1];
}

/* Returns the interpolated value between y[0] and y[1], by weights of sinc_weights(). */
static double sinc_value(const double *y, const double *weight)
{
    double sum = 0;
    for (int j = 0; j < 2 * SINC_REACH; j++)
        sum += weight[j] * y[j - (SINC_REACH - 1)];
    return sum;
}

/* Returns the highest interpolated correlation around a peak at lag k, or -1 near the ends. */
static double sinc_top(const struct lags *l, size_t k)
{
    double top = -1;
    if (k <= SINC_REACH || k + SINC_REACH + 1 >= l->n)
        return top;
    for (int i = 0; i < SINC_PLACES; i++) {
        top = fmax(top, sinc_value(l->correlation + k - 1, l->weight[i]));
        top = fmax(top, sinc_value(l->correlation + k, l->weight[i]));
    }
    return top;
}

/* A peak of the correlation. Its height by a parabola (for pulses of few samples, by band-limited
 * interpolation), and by two straight lines through its flanks, as suits a wave with edges. */
struct lag_peak {
    double shift; /* [s] */
    double parabola, flanks;
};

/* Returns the peak of the correlation at lag k with interpolated position and heights: by a
 * parabola, and by lines through its flanks, which narrow peaks need. */
static struct lag_peak read_peak(const struct lags *l, size_t k)
{
    const double *r = l->correlation + k, bend = r[-1] - 2 * r[0] + r[1],
                 slope = 0.5 * (r[1] - r[-1]);
    const double offset = bend < 0 ? -slope / bend : 0;
    struct lag_peak peak = {((double)k + offset) * l->dt, r[0] + 0.5 * slope * offset, r[0]};
    /* the top lies on the side of the higher neighbour */
    const int side = r[1] > r[-1] ? 1 : -1;
    if (k >= 2 && k + 2 < l->n) {
        const double rise = r[0] - r[-side], fall = r[side] - r[2 * side];
        if (rise > 0 && fall > 0)
            peak.flanks = r[0] + rise * (r[side] + fall - r[0]) / (rise + fall);
    }
    peak.parabola = fmin(fmax(peak.parabola, sinc_top(l, k)), 1);
    peak.flanks = fmin(fmax(peak.flanks, peak.parabola), 1);
    return peak;
}

/* Finds the highest peak within `reach` of a shift [s]. Returns false if there is none. */
static bool peak_near(const struct lags *l, double shift, double reach, struct lag_peak *peak)
{
    const size_t low = (size_t)fmax((shift - reach) / l->dt, 1),
                 high = (size_t)fmin((shift + reach) / l->dt + 1, (double)l->n - 2);
    *peak = (struct lag_peak){NAN, -1, -1};
    for (size_t k = low; k <= high; k++) {
        const struct lag_peak here = is_peak(l, k) ? read_peak(l, k) : (struct lag_peak){0, -1, -1};
        if (here.parabola > peak->parabola)
            *peak = here;
    }
    return isfinite(peak->shift);
}

/* Returns the lag [s] of the first peak of the correlation whose height (lag_peak.flanks) is at
 * most correlation_band() below the highest one, or NAN if none exceeds correlation_least(), that
 * is, if the series does not repeat. Looks beyond the first lag without positive correlation, up to
 * half of the series. */
double lags_period(const struct lags *l)
{
    const size_t half = l->n / 2;
    size_t first = 1;
    double highest = 0;
    while (first < half && l->correlation[first] > 0)
        first++;
    first = first < LAG_SHORTEST ? LAG_SHORTEST : first;
    for (size_t k = first; k < half; k++)
        highest = is_peak(l, k) ? fmax(highest, read_peak(l, k).parabola) : highest;
    for (size_t k = first; k < half && highest > correlation_least(l); k++) {
        if (!is_peak(l, k))
            continue;
        const struct lag_peak peak = read_peak(l, k);
        if (peak.flanks >= highest - correlation_band(l, highest))
            return peak.shift;
    }
    return NAN;
}

/* Returns the correlation of `count` values from index i on with those `shift` samples later or,
 * with weights, between that sample and the next. */
static double window_correlation(const double *y, size_t i, size_t count, size_t shift,
                                 const double *weight)
{
    double a = 0, b = 0, aa = 0, ab = 0, bb = 0;
    for (size_t k = i; k < i + count; k++) {
        const double u = y[k], v = weight ? sinc_value(y + k + shift, weight) : y[k + shift];
        a += u;
        b += v;
        aa += u * u;
        ab += u * v;
        bb += v * v;
    }
    const double n = (double)count, saa = aa - a * a / n, sbb = bb - b * b / n;
    return saa > 0 && sbb > 0 ? (ab - a * b / n) / sqrt(saa * sbb) : 0;
}

/* Returns the correlation of `count` values from index i on with those `shift` [s] later: the best
 * of that shift and the two whole numbers of samples around it. */
static double shifted_correlation(const struct lags *l, size_t i, size_t count, double shift)
{
    const size_t low = (size_t)(shift / l->dt);
    double weight[2 * SINC_REACH], best = fmax(window_correlation(l->y, i, count, low, NULL),
                                               window_correlation(l->y, i, count, low + 1, NULL));
    if (i + low >= SINC_REACH && i + count + low + SINC_REACH < l->n) {
        sinc_weights(shift / l->dt - (double)low, weight);
        best = fmax(best, window_correlation(l->y, i, count, low, weight));
    }
    return best;
}

/* Returns true if most parts of the series resemble themselves more after n periods than after one;
 * each part counts the same, however large its amplitude. */
static bool most_prefer(const struct lags *l, double period, int n)
{
    const size_t count = (size_t)(n * period / l->dt);
    size_t prefer = 0, all = 0;
    for (size_t i = 0; i + 2 * count + 2 < l->n; i += count) {
        const double once = shifted_correlation(l, i, count, period),
                     often = shifted_correlation(l, i, count, n * period);
        if (fmax(once, often) > 0.5) { /* the others show no wave at all */
            prefer += often > once + 0.5 * correlation_resolution;
            all++;
        }
    }
    return 3 * prefer > 2 * all;
}

/* Returns 1/n if the period holds n equal waves, else 1. `once` is the correlation after one
 * period. */
static double lags_part(const struct lags *l, double period, double reach, double once)
{
    struct lag_peak peak;
    for (int n = few_multiples; n >= 2; n--)
        if (period / n > LAG_SHORTEST * l->dt && peak_near(l, period / n, reach / n, &peak) &&
            peak.parabola >= once - 0.5 * correlation_resolution)
            return 1.0 / n;
    return 1;
}

/* Returns the distance of a shift from the nearest whole number of samples, from 0 to 0.5. */
static double between_samples(const struct lags *l, double shift)
{
    return fabs(remainder(shift / l->dt, 1));
}

/* Returns true if multiples of n periods have higher correlations than other multiples that lie no
 * farther between samples. As sampling lowers the peaks of narrow pulses, this comparison favours
 * the others. */
static bool fairly_better(const struct lags *l, double period, int n)
{
    const double span = (double)(l->n - 1) * l->dt, reach = 0.04 * period + 0.5 * l->dt;
    double other = -1, distance = 1;
    struct lag_peak peak;
    for (int k = 1; k <= MULTIPLES_MAX && k * period < 0.6 * span; k++)
        if (k % n != 0 && peak_near(l, k * period, reach, &peak) &&
            between_samples(l, peak.shift) < distance) {
            distance = between_samples(l, peak.shift);
            other = peak.parabola;
        }
    for (int k = n; k <= MULTIPLES_MAX && k * period < 0.6 * span && other > 0; k += n)
        if (peak_near(l, k * period, reach, &peak) && between_samples(l, peak.shift) >= distance &&
            peak.parabola > other + correlation_band(l, peak.parabola))
            return true;
    return false;
}

/* Returns the factor by which the period [s] must be multiplied so that the series repeats best: a
 * small whole number, 1, or a fraction. */
double lags_multiple(const struct lags *l, double period)
{
    const double span = (double)(l->n - 1) * l->dt, reach = 0.04 * period + 0.5 * l->dt;
    struct lag_peak once, peak;
    double best = 0;
    peak_near(l, period, reach, &once);
    for (int n = 2; n <= MULTIPLES_MAX && n * period < 0.55 * span; n++)
        if ((n <= few_multiples || once.flanks < alike_min) &&
            peak_near(l, n * period, n * reach, &peak))
            best = fmax(best, peak.parabola);
    if (best < correlation_least(l) || best <= once.parabola + correlation_band(l, best))
        return once.parabola > correlation_least(l) ? lags_part(l, period, reach, once.parabola)
                                                    : 1;
    for (int n = 2; n <= MULTIPLES_MAX && n * period < 0.55 * span; n++)
        if (peak_near(l, n * period, n * reach, &peak) &&
            peak.flanks >= best - correlation_band(l, best) &&
            (best > once.flanks + correlation_band(l, best) || fairly_better(l, period, n)))
            return most_prefer(l, period, n) ? n : 1;
    return 1;
}

/* Looks for a peak of the correlation within a tenth of the period that exceeds 0.5 and what chance
 * explains. */
bool lags_support(const struct lags *l, double period)
{
    struct lag_peak peak;
    return peak_near(l, period, 0.1 * period + 0.5 * l->dt, &peak) &&
           peak.parabola > fmax(0.5, correlation_least(l));
}
