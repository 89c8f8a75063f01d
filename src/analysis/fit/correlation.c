/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period from the autocorrelation: the shifts at which a series looks most like itself, against
 * their number. */
#include "analysis/internal.h"

#include <hooke/data/even_times.h>

#include <math.h>
#include <string.h>

enum { PEAKS_MAX = 12, BLOCKS = 16, BLOCK_MIN = 4096, PERIODS_IN_BLOCK = 4 * PEAKS_MAX };

/* Parts of a recording on an even grid, its mean taken off: all of it, or of a long one some all
 * along it. */
struct blocks {
    double *y;
    size_t count, length;
    size_t begin;  /* the sample of each from which on the correlation sums */
    double period; /* [samples] */
    double whole; /* [samples] of whole periods that the correlation sums over; 0: as many as fit */
    double *product, *squares; /* [length], [length + 1], by shift, of all of them; NULL: not yet */
    const struct cancel *cancel;
};

double series_fill_grid(const struct series *s, double t0, double dt, size_t length, double *out)
{
    double sum = 0;
    const struct samples all = {.t = s->t, .n = s->n};
    size_t row = samples_index(&all, t0);
    row = row > 0 ? row - 1 : 0;
    for (size_t i = 0; i < length; i++) {
        const double t = t0 + (double)i * dt;
        while (row + 2 < s->n && s->t[row + 1] < t)
            row++;
        const double part = (t - s->t[row]) / (s->t[row + 1] - s->t[row]);
        out[i] = s->y[row] + fmin(fmax(part, 0), 1) * (s->y[row + 1] - s->y[row]);
        sum += out[i];
    }
    return sum;
}

/* period [samples]. False: no memory. */
static bool fill_blocks(const struct series *s, double dt, double period, struct arena *arena,
                        struct blocks *b)
{
    const double min = fmax(BLOCK_MIN, PERIODS_IN_BLOCK * period);
    double sum = 0;
    *b = (struct blocks){.count = 1, .length = s->n, .period = period, .cancel = s->cancel};
    if (2 * BLOCKS * min < (double)s->n) {
        b->count = BLOCKS;
        b->length = (size_t)min;
    }
    const size_t all = b->count * b->length;
    b->y = arena_array(arena, all, sizeof *b->y);
    if (!b->y)
        return false;
    for (size_t k = 0; k < b->count; k++) {
        const size_t first = b->count > 1 ? (s->n - b->length) * k / (b->count - 1) : 0;
        sum +=
            series_fill_grid(s, s->t[0] + (double)first * dt, dt, b->length, b->y + k * b->length);
    }
    for (size_t i = 0; i < all; i++)
        b->y[i] -= sum / (double)all;
    return true;
}

typedef double four __attribute__((vector_size(32), aligned(8), may_alias));

/* Adds the weighted sums of x y, x x and y y. */
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

/*
 * Over whole periods: what is left of one would shift the peaks. The last sample counts by the part
 * of it that belongs to them.
 */
static double correlation(const struct blocks *b, size_t shift)
{
    const double most = (double)(b->length - 1 - shift),
                 whole = floor(most / b->period) * b->period,
                 used = b->whole > 0 && b->whole <= most ? b->whole
                        : whole > 0                      ? whole
                                                         : most;
    const size_t n = (size_t)used;
    double sum[3] = {0};
    for (const double *y = b->y + b->begin; y < b->y + b->count * b->length; y += b->length) {
        add_products(y, y + shift, n, 1, sum);
        add_products(y + n, y + n + shift, 1, used - (double)n, sum);
    }
    return sum[0] / sqrt(sum[1] * sum[2]);
}

/*
 * Products and squares at all shifts at once: the autocorrelation is the transform of the power
 * (Wiener 1930, Khinchin 1934), of blocks followed by as many zeros. False: no memory, cancelled.
 */
static bool tabulate(struct blocks *b, struct arena *arena)
{
    size_t n = 4;
    while (n < 2 * b->length)
        n *= 2;
    double *data = arena_array(arena, n, sizeof *data), *work = arena_array(arena, n, sizeof *work),
           *power = arena_array(arena, n, sizeof *power),
           *squares = arena_array(arena, b->length + 1, sizeof *squares);
    if (!data || !work || !power || !squares)
        return false;
    for (const double *y = b->y; y < b->y + b->count * b->length; y += b->length) {
        double sum = 0;
        memset(data, 0, n * sizeof *data);
        memcpy(data, y, b->length * sizeof *data);
        for (size_t i = 0; i < b->length; i++)
            squares[i + 1] += sum += y[i] * y[i];
        if (!transform_real(data, n, work, b->cancel))
            return false;
        power[0] += data[0] * data[0];
        power[n / 2] += data[n / 2] * data[n / 2];
        for (size_t k = 1; k < n / 2; k++)
            power[k] = power[n - k] += data[k] * data[k] + data[n - k] * data[n - k];
    }
    if (!transform_real(power, n, work, b->cancel))
        return false;
    for (size_t i = 0; i < b->length; i++)
        power[i] /= (double)n;
    b->product = power;
    b->squares = squares;
    return true;
}

/* As correlation(), but for rounding. */
static double tabulated(const struct blocks *b, size_t shift)
{
    const double first = b->squares[b->length - shift],
                 second = b->squares[b->length] - b->squares[shift];
    return b->product[shift] / sqrt(first * second);
}

/* Uphill from shift `at`, which lies between low and high: value [3] is what lies there and beside.
 */
struct climb {
    double (*of)(const struct blocks *b, size_t shift);
    size_t at, low, high;
    double value[3];
};

/* At most so many steps. True: the top; at is the border or beyond: there is none. */
static bool climb(struct climb *c, const struct blocks *b, size_t most)
{
    double *v = c->value;
    for (size_t k = 0; k < 3; k++)
        v[k] = c->of(b, c->at + k - 1);
    for (size_t steps = 0; !(v[1] >= v[0] && v[1] >= v[2]); steps++) {
        const bool up = v[2] > v[0];
        if (steps == most || cancelled(b->cancel))
            return false;
        c->at = up ? c->at + 1 : c->at - 1;
        if (c->at <= c->low || c->at >= c->high)
            return false;
        memmove(up ? v : v + 1, up ? v + 1 : v, 2 * sizeof *v);
        v[up ? 2 : 0] = c->of(b, up ? c->at + 1 : c->at - 1);
    }
    return true;
}

/* Returns how far the top lies from the middle one of three correlations [samples]: that of a
 * cosine. Sets *doubt to how far off the top of a parabola is. */
static double top_between(const double value[3], double period, double *doubt)
{
    const double angle = TWO_PI / period,
                 parabola = 0.5 * (value[0] - value[2]) / (value[0] - 2 * value[1] + value[2]),
                 cosine = atan((value[2] - value[0]) / (2 * value[1] * sin(angle))) / angle;
    *doubt = fabs(cosine - parabola);
    return cosine;
}

/*
 * The shift of the highest correlation within a quarter of a period, uphill from where it is
 * expected; NAN: at the border. A long way goes by the table. Between the samples the peak of a
 * cosine is taken; *doubt is how far off the peak of a parabola is.
 */
static double peak_about(struct blocks *b, double shift, struct arena *arena, double *doubt)
{
    enum { FEW_STEPS = 24 };
    struct climb c = {.of = correlation,
                      .low = (size_t)fmax(shift - 0.25 * b->period, 1),
                      .high = (size_t)fmin(shift + 0.25 * b->period, (double)b->length - 3)};
    if (c.low + 2 > c.high)
        return NAN;
    c.at = (size_t)fmin(fmax(nearbyint(shift), (double)c.low + 1), (double)c.high - 1);
    /* the same samples at neighbouring shifts */
    b->whole = floor(((double)b->length - 1 - shift - 0.5 * b->period) / b->period) * b->period;
    b->begin = 0;
    bool top = climb(&c, b, FEW_STEPS);
    const bool inside = c.at > c.low && c.at < c.high;
    if (!top && inside && !cancelled(b->cancel) && (b->product || tabulate(b, arena))) {
        c.of = tabulated;
        top = climb(&c, b, SIZE_MAX);
        c.of = correlation;
        top = top && climb(&c, b, SIZE_MAX);
    }
    if (!top)
        return NAN;
    const double cosine = top_between(c.value, b->period, doubt);
    if (!(b->whole > 0))
        return (double)c.at + cosine;
    /* A changing amplitude shifts the top; a quarter period later it does so the other way. */
    double later_doubt;
    b->begin = (size_t)(0.25 * b->period);
    for (size_t k = 0; k < 3; k++)
        c.value[k] = correlation(b, c.at + k - 1);
    b->begin = 0;
    const double later = top_between(c.value, b->period, &later_doubt);
    *doubt += 0.25 * fabs(later - cosine);
    return (double)c.at + 0.5 * (cosine + later);
}

/*
 * Variance of the period from the peaks over that of the line through all phases. In noise n about
 * y the shift of peak k is off by the sum of n y' over the first k periods less that over the last
 * ones: what lies between cancels. Peaks share these samples, blocks do not. samples: of the whole
 * recording.
 */
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

bool series_correlation_period(const struct series *series, const struct period *known,
                               struct arena *arena, struct measured *period)
{
    *period = (struct measured){NAN, NAN};
    struct even_times even;
    even_times_find(series->t, series->y, series->n, series->cancel, &even);
    const double dt = even.step, span = dt * (double)(series->n - 1);
    const double expected = known->period.value / dt, periods = span / known->period.value;
    double at[PEAKS_MAX], kk = 0, kt = 0, square = 0, doubts = 0, doubt = NAN;
    struct blocks blocks;
    if (!(dt > 0) || !(periods > 0) || !fill_blocks(series, dt, expected, arena, &blocks))
        return false;
    int peaks = 0;
    while (peaks < PEAKS_MAX && 2 * (peaks + 1) <= periods) {
        const double shift = peak_about(&blocks, (peaks + 1) * expected, arena, &doubt);
        if (!isfinite(shift))
            break;
        at[peaks++] = shift * dt;
        kk += (double)peaks * peaks;
        kt += peaks * at[peaks - 1];
        doubts += peaks * doubt * dt;
    }
    if (peaks < 2)
        return false;
    period->value = kt / kk;
    for (int k = 0; k < peaks; k++)
        square += (at[k] - (k + 1) * period->value) * (at[k] - (k + 1) * period->value);
    const double scatter = sqrt(square / (peaks - 1) / kk),
                 noise = known->period.uncertainty *
                         sqrt(variance_of_peaks(&blocks, (double)series->n, peaks));
    period->uncertainty = hypot(hypot(scatter, noise), doubts / kk);
    *period = measured_at_pace(*period, hypot(series->pace, even.pace));
    return true;
}

/* Returns the sum of squares of some values about their mean. */
static double spread_of(const double *y, size_t n)
{
    double sum = 0, square = 0;
    for (size_t i = 0; i < n; i++) {
        const double off = y[i] - y[0];
        sum += off;
        square += off * off;
    }
    return square - sum * sum / (double)n;
}

bool series_lively_part(const struct series *series, size_t each, size_t rows, struct arena *arena,
                        struct series *part)
{
    enum { PLACES = 9, MIDDLE = PLACES / 2 };
    /* Of a motion that dies out or begins late, the stretches that show it; else what lasts counts,
     * not how it began. */
    static const double lively_share = 0.2;
    const size_t wanted = each * rows, all = wanted < series->n ? wanted : series->n,
                 used = all / each * each;
    double spread[PLACES], most = 0;
    size_t first = 0;
    for (size_t k = 0; k < PLACES && all < series->n; k++) {
        spread[k] = spread_of(series->y + (series->n - all) * k / (PLACES - 1), all);
        most = fmax(most, spread[k]);
    }
    for (size_t k = 0; k < PLACES && all < series->n; k++) {
        const size_t place = k % 2 ? MIDDLE + (k + 1) / 2 : MIDDLE - k / 2; /* from the middle on */
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

double *series_correlations(const struct series *series, struct arena *arena, double **grid)
{
    const size_t n = series->n;
    struct blocks b = {.count = 1, .length = n, .cancel = series->cancel};
    double *out = arena_array(arena, n, sizeof *out), moment = 0, square = 0;
    b.y = arena_array(arena, n, sizeof *b.y);
    if (!out || !b.y)
        return NULL;
    const double dt = (series->t[n - 1] - series->t[0]) / (double)(n - 1),
                 mean = series_fill_grid(series, series->t[0], dt, n, b.y) / (double)n,
                 middle = 0.5 * (double)(n - 1);
    for (size_t i = 0; i < n; i++) {
        moment += ((double)i - middle) * (b.y[i] - mean);
        square += ((double)i - middle) * ((double)i - middle);
    }
    for (size_t i = 0; i < n; i++)
        b.y[i] -= mean + moment / square * ((double)i - middle);
    if (!tabulate(&b, arena))
        return NULL;
    *grid = b.y;
    for (size_t i = 0; i < n; i++)
        out[i] = tabulated(&b, i);
    return out;
}
