/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Periods by similarity. The first stage takes the shortest shift at which the normalised
 * correlation is as high as anywhere (McLeod & Wyvill, A smarter way to find pitch, ICMC 2005). The
 * second places every cycle against the mean of all (Woody, Med. Biol. Eng. 5 (1967) 539).
 */
#include "analysis/period/cycle.h"

#include <math.h>
#include <string.h>

enum {
    LAG_SHORTEST = 4, /* samples */
    CYCLES_MIN = 3,   /* fewer cycles prove nothing */
    BINS_MIN = 16,    /* of the mean cycle */
    BINS_MAX = 256,
    ALIGN_PASSES = 4,
    MULTIPLES_MAX = 12, /* periods after which a wave may be more like itself */
};

/* Correlations that differ by less are equal: what interpolation between shifts leaves of pulses of
 * two samples. */
static const double correlation_resolution = 0.02;
/* Chance differences [standard deviations]. */
static const double correlation_sigmas = 4;
/* Many periods that are more alike than one are beats or sway, unless one is not alike at all. */
static const double alike_min = 0.8;
static const int few_multiples = 3;

/* ---- shifts ---- */

/* Weights [2 SINC_REACH] of the samples from SINC_REACH - 1 before on, for a value `part` after one
 * (Lanczos's window on the sine integral's kernel). */
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

bool lags_init(const struct series *whole, double period, struct arena *arena, struct lags *lags)
{
    enum { ROWS = 4096, ROWS_A_PERIOD = 128, PERIODS = 32 };
    struct series part = *whole;
    const double span = whole->n > 0 ? whole->t[whole->n - 1] - whole->t[0] : 0;
    if (period > 0 && whole->n > ROWS) {
        const double samples = period * (double)(whole->n - 1) / span;
        const double each = floor(fmin(fmax(samples / ROWS_A_PERIOD, 1), (double)whole->n / ROWS)),
                     rows = fmax(fmin(PERIODS * samples / each, (double)whole->n), ROWS);
        if (!series_lively_part(whole, (size_t)each, (size_t)rows, arena, &part))
            return false;
    }
    *lags = (struct lags){.n = part.n};
    if (part.n < 4 * LAG_SHORTEST || !(span > 0))
        return false;
    lags->dt = (part.t[part.n - 1] - part.t[0]) / (double)(part.n - 1);
    for (int i = 0; i < SINC_PLACES; i++)
        sinc_weights((i + 1.0) / (SINC_PLACES + 1), lags->weight[i]);
    lags->correlation = series_correlations(&part, arena, &lags->y);
    return lags->correlation;
}

/* Returns how much two correlations about r differ by chance and resolution. */
static double correlation_band(const struct lags *l, double r)
{
    return correlation_resolution +
           correlation_sigmas * (1 - fmin(r, 1)) * sqrt(3.0 / (double)l->n);
}

/* Returns the least correlation that chance does not bring. */
static double correlation_least(const struct lags *l)
{
    return 0.15 + 5 / sqrt((double)l->n);
}

static bool is_peak(const struct lags *l, size_t k)
{
    const double *r = l->correlation + k;
    return r[0] > 0 && r[0] > r[-1] && r[0] >= r[1];
}

static double sinc_value(const double *y, const double *weight)
{
    double sum = 0;
    for (int j = 0; j < 2 * SINC_REACH; j++)
        sum += weight[j] * y[j - (SINC_REACH - 1)];
    return sum;
}

/* Returns the highest correlation between the samples beside a peak, or -1 near the ends. */
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

/* A peak of the correlation between two shifts: its top is that of the parabola or, of pulses of
 * few samples, of a band-limited curve; but of a wave with edges that of the two lines through its
 * flanks. */
struct lag_peak {
    double shift; /* [s] */
    double parabola, flanks;
};

static struct lag_peak read_peak(const struct lags *l, size_t k)
{
    const double *r = l->correlation + k, bend = r[-1] - 2 * r[0] + r[1],
                 slope = 0.5 * (r[1] - r[-1]);
    const double off = bend < 0 ? -slope / bend : 0;
    struct lag_peak peak = {((double)k + off) * l->dt, r[0] + 0.5 * slope * off, r[0]};
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

/* Finds the highest peak within a reach of a shift [s]. Returns false if there is none. */
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

/* Returns the correlation of `count` values from index i on with those some samples later, or, by
 * weights, between that sample and the next. */
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

/* The same for a shift between two samples: the best of that and those at the two. */
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

/* Returns true if most parts of the series are more like themselves after n periods than after one:
 * what is loud for a time does not decide. */
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

/* Returns one over the whole number of waves that a period holds. */
static double lags_part(const struct lags *l, double period, double reach, double once)
{
    struct lag_peak peak;
    for (int n = few_multiples; n >= 2; n--)
        if (period / n > LAG_SHORTEST * l->dt && peak_near(l, period / n, reach / n, &peak) &&
            peak.parabola >= once - 0.5 * correlation_resolution)
            return 1.0 / n;
    return 1;
}

/* Returns how far a shift lies from the nearest whole number of samples, from 0 to 0.5. */
static double between_samples(const struct lags *l, double shift)
{
    return fabs(remainder(shift / l->dt, 1));
}

/* Compares multiples of n periods with others that lie no farther between samples, so that what
 * sampling takes from narrow pulses favours the others. Returns true if they are still less alike.
 */
static bool fairly_better(const struct lags *l, double period, int n)
{
    const double span = (double)(l->n - 1) * l->dt, reach = 0.04 * period + 0.5 * l->dt;
    double other = -1, off = 1;
    struct lag_peak peak;
    for (int k = 1; k <= MULTIPLES_MAX && k * period < 0.6 * span; k++)
        if (k % n != 0 && between_samples(l, k * period) < off &&
            peak_near(l, k * period, reach, &peak)) {
            off = between_samples(l, k * period);
            other = peak.parabola;
        }
    for (int k = n; k <= MULTIPLES_MAX && k * period < 0.6 * span && other > 0; k += n)
        if (between_samples(l, k * period) >= off && peak_near(l, k * period, reach, &peak) &&
            peak.parabola > other + correlation_band(l, peak.parabola))
            return true;
    return false;
}

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

bool lags_support(const struct lags *l, double period)
{
    struct lag_peak peak;
    return peak_near(l, period, 0.1 * period + 0.5 * l->dt, &peak) &&
           peak.parabola > fmax(0.5, correlation_least(l));
}

/* ---- cycles ---- */

struct cycle {
    double t, sigma;     /* [s] its begin */
    double mean, height; /* y = mean + height f(phase) */
    double square, left; /* variances, about its mean and about the mean cycle */
};

struct cycles {
    const struct samples *samples;
    double period;       /* [s] */
    struct cycle *cycle; /* [count] */
    size_t count;
    double *shape, *weight; /* [bins] the mean cycle */
    size_t bins;
};

/* Returns the mean cycle at a phase, in periods. */
static double shape_at(const struct cycles *c, double phase)
{
    const double x = (phase - floor(phase)) * (double)c->bins;
    const size_t k = (size_t)x % c->bins, next = (k + 1) % c->bins;
    const double part = x - floor(x);
    return c->shape[k] + part * (c->shape[next] - c->shape[k]);
}

/* Least squares of one cycle against the mean cycle, begun at t. Returns the correlation. */
static double fit_cycle(const struct cycles *c, double t, struct cycle *out)
{
    const struct samples *x = c->samples;
    const double bin = 1.0 / (double)c->bins;
    double n = 0, f = 0, y = 0, ff = 0, fy = 0, yy = 0, slope = 0;
    const size_t from = samples_index(x, t), to = samples_index(x, t + c->period);
    const double y0 = x->y[from < x->n ? from : 0];
    for (size_t i = from; i < to; i++) {
        if (!x->use[i])
            continue;
        const double phase = (x->t[i] - t) / c->period, value = shape_at(c, phase),
                     d = shape_at(c, phase + bin) - shape_at(c, phase - bin), v = x->y[i] - y0;
        n++;
        f += value;
        y += v;
        ff += value * value;
        fy += value * v;
        yy += v * v;
        slope += d * d;
    }
    const double sff = ff - f * f / n, sfy = fy - f * y / n, syy = yy - y * y / n;
    if (n < BINS_MIN / 2 || !(sff > 0) || !(syy > 0))
        return -1;
    slope /= 4 * bin * bin * c->period * c->period;
    *out = (struct cycle){.t = t, .height = sfy / sff, .square = syy};
    out->mean = y0 + (y - out->height * f) / n;
    out->left = fmax(syy - sfy * sfy / sff, 0);
    out->left /= n - 3;
    out->square /= n - 1;
    out->sigma = sqrt(out->left / slope) / fabs(out->height);
    return sfy / sqrt(sff * syy);
}

/* Places one cycle within `reach` periods of the time where it is expected. Returns false if none
 * is like the mean cycle. */
static bool place_cycle(const struct cycles *c, double expected, double reach, struct cycle *out)
{
    const double step = c->period / (double)c->bins;
    const int most = (int)ceil(reach * (double)c->bins);
    double best = 0, value[3] = {NAN, NAN, NAN}, t = expected;
    struct cycle trial;
    for (int k = -most; k <= most; k++) {
        const double r = fit_cycle(c, expected + k * step, &trial);
        if (r > best) {
            best = r;
            t = expected + k * step;
        }
    }
    if (!(best > 0))
        return false;
    for (int k = 0; k < 3; k++)
        value[k] = fit_cycle(c, t + (k - 1) * step, &trial);
    const double bend = value[0] - 2 * value[1] + value[2];
    if (bend < 0)
        t += step * fmin(fmax(0.5 * (value[0] - value[2]) / bend, -0.5), 0.5);
    return fit_cycle(c, t, out) > 0 && out->height > 0;
}

/* Sets the shape to the mean over cycles [from, to), each less its mean and over its height. */
static bool mean_shape(struct cycles *c, size_t from, size_t to)
{
    const struct samples *x = c->samples;
    double sum = 0, used = 0;
    memset(c->shape, 0, c->bins * sizeof *c->shape);
    memset(c->weight, 0, c->bins * sizeof *c->weight);
    for (size_t k = from; k < to; k++) {
        const struct cycle *cycle = &c->cycle[k];
        for (size_t i = samples_index(x, cycle->t); i < x->n && cycle->height > 0; i++) {
            const double phase = (x->t[i] - cycle->t) / c->period;
            if (phase >= 1)
                break;
            const double at = phase * (double)c->bins, part = at - floor(at),
                         value = x->use[i] ? (x->y[i] - cycle->mean) / cycle->height : 0;
            const size_t bin = (size_t)at % c->bins, next = (bin + 1) % c->bins;
            const double w = x->use[i] * cycle->height * cycle->height;
            c->shape[bin] += w * (1 - part) * value;
            c->shape[next] += w * part * value;
            c->weight[bin] += w * (1 - part);
            c->weight[next] += w * part;
        }
    }
    for (size_t k = 0; k < c->bins; k++) {
        if (!(c->weight[k] > 0))
            return false;
        c->shape[k] /= c->weight[k];
        sum += c->shape[k];
    }
    for (size_t k = 0; k < c->bins; k++) {
        c->shape[k] -= sum / (double)c->bins;
        used += c->shape[k] * c->shape[k];
    }
    return used > 0;
}

/* Places all cycles, from the middle one outwards, each where those before it lead. */
static bool place_cycles(struct cycles *c, double reach)
{
    const size_t middle = c->count / 2;
    for (size_t k = middle; k < c->count; k++) {
        const double expected = k > middle ? c->cycle[k - 1].t + c->period : c->cycle[k].t;
        if (cancelled(c->samples->cancel))
            return false;
        if (!place_cycle(c, expected, reach, &c->cycle[k]))
            c->cycle[k] = (struct cycle){.t = expected};
    }
    for (size_t k = middle; k-- > 0;) {
        const double expected = c->cycle[k + 1].t - c->period;
        if (cancelled(c->samples->cancel))
            return false;
        if (!place_cycle(c, expected, reach, &c->cycle[k]))
            c->cycle[k] = (struct cycle){.t = expected};
    }
    return true;
}

static bool cycles_init(struct cycles *c, const struct samples *x, double guess,
                        struct arena *arena)
{
    const double span = x->t[x->n - 1] - x->t[0], samples = guess / (span / (double)(x->n - 1));
    *c = (struct cycles){.samples = x, .period = guess, .count = (size_t)(span / guess + 0.02)};
    c->bins = (size_t)fmin(fmax(samples, BINS_MIN), BINS_MAX);
    if (c->count < CYCLES_MIN || samples < BINS_MIN / 2)
        return false;
    c->cycle = arena_array(arena, c->count, sizeof *c->cycle);
    c->shape = arena_array(arena, c->bins, sizeof *c->shape);
    c->weight = arena_array(arena, c->bins, sizeof *c->weight);
    if (!c->cycle || !c->shape || !c->weight)
        return false;
    const double first = x->t[0] + 0.5 * fmax(span - (double)c->count * guess, 0);
    for (size_t k = 0; k < c->count; k++)
        c->cycle[k] = (struct cycle){.t = first + (double)k * guess, .height = 1};
    return true;
}

/* Returns the share of the power that the mean of the other cycles explains of each. */
static double explained_share(const struct cycles *c)
{
    const double others = (double)c->count / (double)(c->count - 1);
    double square = 0, left = 0;
    for (size_t k = 0; k < c->count; k++) {
        const struct cycle *cycle = &c->cycle[k];
        square += cycle->square;
        left +=
            cycle->height > 0 ? fmin(cycle->left * others * others, cycle->square) : cycle->square;
    }
    return square > 0 ? 1 - left / square : 0;
}

/* Returns the share from which on that number of cycles is alike: drift, steps and random walks
 * stay below it (tests/unit/analysis/detect.c). */
static double share_needed(size_t cycles)
{
    static const struct {
        size_t cycles;
        double share;
    } needed[] = {{20, 0.3}, {10, 0.4}, {6, 0.6}, {4, 0.8}};
    for (size_t k = 0; k < COUNT_OF(needed); k++)
        if (cycles >= needed[k].cycles)
            return needed[k].share;
    return 0.9;
}

bool cycle_period(const struct series *series, double guess, struct arena *arena,
                  struct period *period)
{
    struct samples x;
    struct cycles c;
    size_t used = 0, placed = 0;
    double level = 0;
    if (!samples_init(&x, series, arena) || !cycles_init(&c, &x, guess, arena))
        return false;
    const size_t middle = c.count / 2, few = c.count < 8 ? c.count : 8;
    struct crossing *begin = arena_array(arena, c.count, sizeof *begin);
    double *scratch = arena_array(arena, c.count, sizeof *scratch);
    if (!begin || !scratch || !mean_shape(&c, middle - few / 2, middle - few / 2 + few))
        return false;
    for (int pass = 0; pass < ALIGN_PASSES; pass++)
        if (!place_cycles(&c, pass == 0 ? 0.1 : 0.04) || !mean_shape(&c, 0, c.count))
            return false;
    for (size_t k = 0; k < c.count; k++)
        if (c.cycle[k].height > 0) {
            begin[placed++] = (struct crossing){c.cycle[k].t, c.cycle[k].sigma, true};
            level += c.cycle[k].mean;
        }
    *period = (struct period){.how = "cycles"};
    if (placed < CYCLES_MIN || explained_share(&c) < share_needed(c.count) ||
        !fit_beat(begin, placed, guess, scratch, false, period, &used) || 5 * used < 4 * c.count)
        return false;
    period->level = level / (double)placed;
    return true;
}
