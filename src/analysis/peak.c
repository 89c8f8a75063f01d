/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Lines of a spectrum: each is fitted as a sine by least squares, and taken away before the next is looked for.
 *
 * Uncertainties are those of the Cramer-Rao bound for one real tone (Rife and Boorstyn, IEEE Trans. Inf. Theory 20
 * (1974) 591, with twice the variance of their complex tone; Kay, Fundamentals of Statistical Signal Processing I
 * (1993), example 3.14), which the least-squares estimate reaches. The variance in them is that of the residuals, or
 * their power beside the line where that is more: what a decay, an unsteady period or a neighbour leaks into the line
 * is there, too.
 */
#include "internal.h"

#include <math.h>
#include <string.h>

#define BESIDE 4    /* bins on each side of a line where its surroundings are looked at */
#define APART 4     /* bins: nearer to a line that was found is its own foot */
#define LEAST 0.01  /* of the first line */
#define SIGMAS 8    /* a line stands so far above its surroundings: by chance none of 10^4 bins does */
#define WHITE 6     /* the first one so far above white noise, its own foot counted as such: it may be broad */

double variance_beside(const struct samples *x, const double *residual, double omega)
{
    const double bin = TWO_PI / (x->t[x->n - 1] - x->t[0]);
    double power = 0, used = 0, bins = 0;
    for (int k = -BESIDE; k <= BESIDE; k++) {
        const double w = omega + k * bin;
        double c = 0, s = 0, n = 0;
        for (size_t i = 0; i < x->n && k != 0 && w > 0.5 * bin; i++) {
            if (!x->use[i])
                continue;
            c += residual[i] * cos(w * (x->t[i] - x->t[0]));
            s += residual[i] * sin(w * (x->t[i] - x->t[0]));
            n++;
        }
        power += c * c + s * s;
        used += n;
        bins += n > 0;
    }
    return bins > 0 ? power / used : 0;
}

/* One line of what is left in `x`, whose residuals it leaves in `residual`. */
static bool find_line(const struct samples *x, struct arena *arena, struct spectrum_peak *peak, bool first,
                      double *residual)
{
    bool memory;
    const double span = x->t[x->n - 1] - x->t[0], bin = TWO_PI / span;
    const double omega = peak_frequency(x, arena, &memory);
    struct harmonic h = {.omega = omega, .origin = x->t[0] + 0.5 * span};
    if (!(omega > 0) || !harmonic_fit(x, FREE_OMEGA, &h, residual) || !(fabs(h.omega - omega) <= bin))
        return false;
    const double amplitude = hypot(h.a, h.b), n = (double)h.used, white = harmonic_sigma(&h, FREE_OMEGA);
    const double variance = fmax(white * white, variance_beside(x, residual, h.omega));
    const double length = span * sqrt((n + 1) / (n - 1));
    peak->amplitude = (struct measured){amplitude, sqrt(2 * variance / n)};
    peak->frequency = (struct measured){h.omega / TWO_PI, sqrt(24 * variance / n) / (TWO_PI * amplitude * length)};
    const double chance = first ? WHITE * white * sqrt(2 / n) : SIGMAS * peak->amplitude.uncertainty;
    return amplitude > chance;
}

int series_peaks(const struct series *series, struct arena *arena, struct spectrum_peak *peak, int most)
{
    struct samples x;
    double *left = arena_array(arena, series->n + 1, sizeof *left);
    double *next = arena_array(arena, series->n + 1, sizeof *next);
    int count = 0;
    if (series->n < 8 || !left || !next || !samples_init(&x, series, arena))
        return 0;
    samples_flag_spikes(&x, next);
    const double bin = 1 / (x.t[x.n - 1] - x.t[0]);
    while (count < most && find_line(&x, arena, &peak[count], count == 0, next)) {
        const struct spectrum_peak *found = &peak[count];
        bool own = true;
        for (int i = 0; i < count; i++)
            own &= fabs(found->frequency.value - peak[i].frequency.value) > APART * bin;
        if (!own || found->amplitude.value < LEAST * peak[0].amplitude.value)
            break;
        count++;
        memcpy(left, next, x.n * sizeof *left);
        x.y = left;
    }
    return count;
}
