/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Amplitudes at single times, from local harmonic fits. */
#include "modules/recording/series/internal.h"

#include <math.h>

/* Reads the amplitude in samples begin to end - 1 by a least-squares fit of a and b of the motion's
 * sine; their covariance gives its uncertainty. Returns false if there are too few samples. */
bool local_amplitude(const struct motion *m, size_t begin, size_t end, struct reading *reading)
{
    struct samples part = samples_part(&m->samples, begin, end);
    if (part.n < 5) {
        return false;
    }
    struct harmonic h = {.omega = m->harmonic.omega, .gamma = m->harmonic.gamma};
    h.origin = reading->t = 0.5 * (part.t[0] + part.t[part.n - 1]);
    double *residual = m->scratch + begin;
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

/* Sets *t and *log_a to the middle of the window of `width` [s] from t_begin on and to the
 * logarithm of its amplitude. Returns false if the window has too few samples, is outside of the
 * series, or if the amplitude is lost in noise. */
static bool log_amplitude(const struct motion *m, double t_begin, double width, double *t,
                          struct measured *log_a)
{
    const struct samples *x = &m->samples;
    struct reading reading;
    if (t_begin < x->t[0] - 1e-9 * width || t_begin + width > x->t[x->n - 1] + 1e-9 * width ||
        !local_amplitude(m, samples_index(x, t_begin - 1e-9 * width),
                         samples_index(x, t_begin + width * (1 + 1e-9)), &reading) ||
        !(reading.amplitude.value > 2 * reading.amplitude.uncertainty))
        return false;
    *t = reading.t;
    *log_a = (struct measured){log(reading.amplitude.value),
                               reading.amplitude.uncertainty / reading.amplitude.value};
    return true;
}

/* Extrapolates *amplitude, that of the window of `width` [s] that begins at t_begin, to the time
 * t_reading, which lies beyond its middle. The damping of the whole is used if the next windows
 * inside agree with it; else the straight line or parabola through the logarithms of two or three
 * windows. */
static void carry_amplitude(const struct motion *m, double t_begin, double width, double t_reading,
                            struct measured *amplitude)
{
    double t[3], relative = amplitude->uncertainty / amplitude->value;
    struct measured log_a[3];
    int windows = 0;
    const double rate = -0.5 * m->harmonic.gamma, middle = t_begin + 0.5 * width,
                 inside = t_reading < middle ? width : -width;
    while (windows < 3 &&
           log_amplitude(m, t_begin + windows * inside, width, &t[windows], &log_a[windows]))
        windows++;
    double change = rate * (t_reading - middle);
    if (windows >= 2) {
        const double ahead = (t_reading - t[0]) / (t[1] - t[0]),
                     local = ahead * (log_a[1].value - log_a[0].value),
                     doubt = fabs(ahead) * hypot(log_a[0].uncertainty, log_a[1].uncertainty);
        double bend = 0, bend_doubt = 0;
        if (windows == 3) {
            const double factor = 0.5 * ahead * (ahead - 1);
            bend = factor * (log_a[0].value - 2 * log_a[1].value + log_a[2].value);
            bend_doubt = fabs(factor) * hypot(hypot(log_a[0].uncertainty, log_a[2].uncertainty),
                                              2 * log_a[1].uncertainty);
        }
        const bool bends = fabs(bend) > 2 * bend_doubt;
        if (bends || fabs(local - change) > doubt) {
            change = local + (bends ? bend : 0);
            relative = hypot((1 - ahead) * log_a[0].uncertainty, ahead * log_a[1].uncertainty);
            relative = hypot(relative, bend); /* bound of the next order */
        } else {
            relative = hypot(relative, local - change);
        }
    }
    amplitude->value *= exp(change);
    amplitude->uncertainty = amplitude->value * relative;
}

/* Adds to the uncertainty of *amplitude the difference between the readings of the window and of
 * its middle half: if the envelope is curved within the window, the mean is read, which is off by
 * 4/3 of that. */
static void widen_by_bend(const struct motion *m, double t_begin, double width,
                          const struct reading *window_reading, struct measured *amplitude)
{
    static const double chance = 2; /* standard deviations */
    const struct samples *x = &m->samples;
    struct reading half;
    if (!local_amplitude(m, samples_index(x, t_begin + (0.25 - 1e-9) * width),
                         samples_index(x, t_begin + (0.75 + 1e-9) * width), &half))
        return;
    const double bend = fabs(half.amplitude.value / window_reading->amplitude.value - 1),
                 noise = half.amplitude.uncertainty / half.amplitude.value;
    if (bend > chance * noise)
        amplitude->uncertainty = hypot(amplitude->uncertainty, 4.0 / 3 * bend * amplitude->value);
}

/* Reads the amplitude at `count` times [s] in windows of `width` [s] (two periods if 0), which are
 * moved inside at the ends of the series, from where the amplitude is extrapolated. Returns false
 * with the error. */
bool series_amplitudes(const struct series *series, struct arena *arena, const double *reading_time,
                       int count, double width, struct reading *reading, struct error *error)
{
    struct motion m;
    if (!motion_require(&m, series, arena, NULL, error)) {
        return false;
    }
    const struct samples *x = &m.samples;
    double first = x->t[0], last = x->t[x->n - 1], w = width > 0 ? width : 2 * m.overview.period;
    w = fmin(w, last - first);
    for (int i = 0; i < count; i++) {
        if (!(reading_time[i] >= first - 0.5 * x->dt && reading_time[i] <= last + 0.5 * x->dt)) {
            return error_set(error, ERROR_COMMAND, "no amplitude at %g s: the window is %g..%g s",
                             reading_time[i], first, last);
        }
        /* The window is moved inside at the ends of the series. */
        double t_begin = fmin(fmax(reading_time[i] - 0.5 * w, first), last - w);
        size_t low = samples_index(x, t_begin - 1e-9 * w),
               high = samples_index(x, t_begin + w * (1 + 1e-9));
        if (!local_amplitude(&m, low, high, &reading[i])) {
            return error_set(error, ERROR_COMMAND,
                             "too few samples for an amplitude within %g s around %g s", w,
                             reading_time[i]);
        }
        const struct reading window_reading = reading[i];
        carry_amplitude(&m, t_begin, w, reading_time[i], &reading[i].amplitude);
        widen_by_bend(&m, t_begin, w, &window_reading, &reading[i].amplitude);
        reading[i].t = reading_time[i];
    }
    return true;
}
