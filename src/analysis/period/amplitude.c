/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Amplitudes read at single times: local harmonic fits. */
#include "analysis/internal.h"

#include <math.h>

bool local_amplitude(const struct motion *m, size_t from, size_t to, struct reading *reading)
{
    struct samples part = samples_part(&m->samples, from, to);
    if (part.n < 5) {
        return false;
    }
    struct harmonic h = {.omega = m->harmonic.omega, .gamma = m->harmonic.gamma};
    h.origin = reading->t = 0.5 * (part.t[0] + part.t[part.n - 1]);
    double *residual = m->scratch + from;
    if (!harmonic_fit(&part, FREE_LINEAR, &h, residual)) {
        return false;
    }
    double amplitude = hypot(h.a, h.b),
           sigma = fmax(harmonic_sigma(&h, FREE_LINEAR), m->overview.noise);
    double variance = h.a * h.a * h.inverse[LINEAR_A][LINEAR_A] +
                      h.b * h.b * h.inverse[LINEAR_B][LINEAR_B] +
                      2 * h.a * h.b * h.inverse[LINEAR_A][LINEAR_B];
    double widen = autocorrelation_factor(residual_autocorrelation(&part, residual));
    reading->amplitude.value = amplitude;
    reading->amplitude.uncertainty =
        amplitude > 0 ? sigma * sqrt(widen * variance) / amplitude : sigma;
    return true;
}

bool series_amplitudes(const struct series *series, struct arena *arena, const double *at,
                       int count, double width, struct reading *out, struct error *error)
{
    struct motion m;
    if (!motion_require(&m, series, arena, NULL, error)) {
        return false;
    }
    const struct samples *x = &m.samples;
    double first = x->t[0], last = x->t[x->n - 1], w = width > 0 ? width : 2 * m.overview.period;
    w = fmin(w, last - first);
    for (int i = 0; i < count; i++) {
        if (!(at[i] >= first && at[i] <= last)) {
            return error_set(error, ERROR_COMMAND, "no amplitude at %g s: the window is %g..%g s",
                             at[i], first, last);
        }
        /* At the ends the window is moved inside; its own damping carries the amplitude back to the
         * time asked for. */
        double from = fmin(fmax(at[i] - 0.5 * w, first), last - w);
        size_t low = samples_index(x, from - 1e-9 * w),
               high = samples_index(x, from + w * (1 + 1e-9));
        if (!local_amplitude(&m, low, high, &out[i])) {
            return error_set(error, ERROR_COMMAND,
                             "too few samples for an amplitude within %g s around %g s", w, at[i]);
        }
        double carry = exp(-0.5 * m.harmonic.gamma * (at[i] - out[i].t));
        out[i].amplitude.value *= carry;
        out[i].amplitude.uncertainty *= carry;
        out[i].t = at[i];
    }
    return true;
}
