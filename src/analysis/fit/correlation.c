/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period from the autocorrelation: the shifts at which a series looks most like itself, against
 * their number. */
#include "analysis/internal.h"

#include <math.h>

enum { PEAKS_MAX = 12, BLOCKS = 16, BLOCK_MIN = 4096, PERIODS_IN_BLOCK = 4 * PEAKS_MAX };

/* Parts of a recording on an even grid, its mean taken off: all of it, or of a long one some all
 * along it. */
struct blocks {
    double *y;
    size_t count, length;
};

/* `length` values from t0 on; straight lines across gaps. Returns their sum. */
static double fill_grid(const struct series *s, double t0, double dt, size_t length, double *out)
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
    *b = (struct blocks){.count = 1, .length = s->n};
    if (2 * BLOCKS * min < (double)s->n)
        *b = (struct blocks){.count = BLOCKS, .length = (size_t)min};
    const size_t all = b->count * b->length;
    b->y = arena_array(arena, all, sizeof *b->y);
    if (!b->y)
        return false;
    for (size_t k = 0; k < b->count; k++) {
        const size_t first = b->count > 1 ? (s->n - b->length) * k / (b->count - 1) : 0;
        sum += fill_grid(s, s->t[0] + (double)first * dt, dt, b->length, b->y + k * b->length);
    }
    for (size_t i = 0; i < all; i++)
        b->y[i] -= sum / (double)all;
    return true;
}

static double correlation(const struct blocks *b, size_t shift)
{
    double product = 0, first = 0, second = 0;
    for (const double *y = b->y; y < b->y + b->count * b->length; y += b->length)
        for (size_t i = 0; i + shift < b->length; i++) {
            product += y[i] * y[i + shift];
            first += y[i] * y[i];
            second += y[i + shift] * y[i + shift];
        }
    return product / sqrt(first * second);
}

/*
 * The shift of the highest correlation within a quarter of a period, uphill from where it is
 * expected, refined by a parabola; NAN: at the border.
 */
static double peak_about(const struct blocks *b, double shift, double period)
{
    const size_t low = (size_t)fmax(shift - 0.25 * period, 1);
    const size_t high = (size_t)fmin(shift + 0.25 * period, (double)b->length - 3);
    size_t at = (size_t)fmin(fmax(nearbyint(shift), (double)low + 1), (double)high - 1);
    if (low + 2 > high)
        return NAN;
    double before = correlation(b, at - 1), best = correlation(b, at),
           after = correlation(b, at + 1);
    while (!(best >= before && best >= after)) {
        const bool up = after > before;
        at = up ? at + 1 : at - 1;
        if (at <= low || at >= high)
            return NAN;
        if (up) {
            before = best;
            best = after;
            after = correlation(b, at + 1);
        } else {
            after = best;
            best = before;
            before = correlation(b, at - 1);
        }
    }
    return (double)at + 0.5 * (before - after) / (before - 2 * best + after);
}

bool series_correlation_period(const struct series *series, const struct period *known,
                               struct arena *arena, struct measured *period)
{
    *period = (struct measured){NAN, NAN};
    const size_t n = series->n;
    const double span = n > 1 ? series->t[n - 1] - series->t[0] : 0, dt = span / (double)(n - 1);
    const double expected = known->period.value / dt, periods = span / known->period.value;
    double at[PEAKS_MAX], kk = 0, kt = 0, square = 0;
    struct blocks blocks;
    if (!(dt > 0) || !(periods > 0) || !fill_blocks(series, dt, expected, arena, &blocks))
        return false;
    int peaks = 0;
    while (peaks < PEAKS_MAX && 2 * (peaks + 1) <= periods) {
        const double shift = peak_about(&blocks, (peaks + 1) * expected, expected);
        if (!isfinite(shift))
            break;
        at[peaks++] = shift * dt;
        kk += (double)peaks * peaks;
        kt += peaks * at[peaks - 1];
    }
    if (peaks < 2)
        return false;
    period->value = kt / kk;
    for (int k = 0; k < peaks; k++)
        square += (at[k] - (k + 1) * period->value) * (at[k] - (k + 1) * period->value);
    period->uncertainty = sqrt(square / (peaks - 1) / kk);
    return true;
}
