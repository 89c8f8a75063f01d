/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period from the autocorrelation: the shifts at which a series looks most like itself, against their number. */
#include "internal.h"

#include <math.h>

enum { PEAKS_MOST = 12 };

/* On an even grid, the mean taken off; straight lines across gaps. */
static void fill_grid(const struct series *s, double dt, size_t n, double *out)
{
    double mean = 0;
    for (size_t i = 0, row = 0; i < n; i++) {
        const double t = s->t[0] + (double)i * dt;
        while (row + 2 < s->n && s->t[row + 1] < t)
            row++;
        const double part = (t - s->t[row]) / (s->t[row + 1] - s->t[row]);
        out[i] = s->y[row] + fmin(fmax(part, 0), 1) * (s->y[row + 1] - s->y[row]);
        mean += out[i] / (double)n;
    }
    for (size_t i = 0; i < n; i++)
        out[i] -= mean;
}

static double correlation(const double *y, size_t n, size_t shift)
{
    double product = 0, first = 0, second = 0;
    for (size_t i = 0; i + shift < n; i++) {
        product += y[i] * y[i + shift];
        first += y[i] * y[i];
        second += y[i + shift] * y[i + shift];
    }
    return product / sqrt(first * second);
}

/* The shift of the highest correlation within a quarter of a period, refined by a parabola; NAN: at the border. */
static double peak_about(const double *y, size_t n, double shift, double period)
{
    const size_t low = (size_t)fmax(shift - 0.25 * period, 1);
    const size_t high = (size_t)fmin(shift + 0.25 * period, (double)n - 3);
    size_t at = 0;
    double best = -2;
    for (size_t k = low; k <= high; k++) {
        const double value = correlation(y, n, k);
        if (value > best) {
            best = value;
            at = k;
        }
    }
    if (at <= low || at >= high)
        return NAN;
    const double before = correlation(y, n, at - 1), after = correlation(y, n, at + 1);
    return (double)at + 0.5 * (before - after) / (before - 2 * best + after);
}

bool series_correlation_period(const struct series *series, struct arena *arena, struct measured *period)
{
    struct overview o;
    series_overview(series, arena, &o);
    *period = (struct measured){NAN, NAN};
    if (!o.oscillates)
        return false;
    const size_t n = series->n;
    const double dt = (series->t[n - 1] - series->t[0]) / (double)(n - 1), expected = o.period / dt;
    double *y = arena_array(arena, n, sizeof *y), at[PEAKS_MOST], kk = 0, kt = 0, square = 0;
    if (!y)
        return false;
    fill_grid(series, dt, n, y);
    int peaks = 0;
    while (peaks < PEAKS_MOST && 2 * (peaks + 1) <= o.periods) {
        const double shift = peak_about(y, n, (peaks + 1) * expected, expected);
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
