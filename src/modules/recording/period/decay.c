/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Decay from a few readings: the weighted straight line through their logarithms. */
#include "modules/recording/series/internal.h"

#include <math.h>

/* Default and smallest number of readings. */
enum { READINGS_DEFAULT = 6, READINGS_MIN = 3 };

/* Relative error of the noise floor of energies, for recordings that are rounded. */
#define FLOOR_WRONG 0.15
/* Scatter of the energy of the noise, in units of that energy. */
#define NOISE_ENERGY_SCATTER 3.0

/* Fits a line to the logarithms of `count` readings against the time since t0 [s]. Readings that
 * are not positive, or mostly noise, are left out. Returns false for fewer than two. */
static bool fit_logarithms(const struct reading *reading, int count, double t0,
                           struct line_fit *line)
{
    static const double relative_max = 0.3, rounding = 1e-12;
    double t[COUNT_OF(((struct decay *)0)->reading)];
    struct measured log_a[COUNT_OF(t)];
    int used = 0;
    for (int i = 0; i < count; i++) {
        const struct measured *a = &reading[i].amplitude;
        const double relative = a->uncertainty / a->value;
        if (!(a->value > 0 && relative < relative_max))
            continue;
        t[used] = reading[i].t - t0;
        log_a[used++] = (struct measured){log(a->value), fmax(relative, rounding)};
    }
    return line_fit(t, log_a, used, line);
}

/* Sets *reading to the mean of an energy under a Hann window over samples first to end - 1: the
 * ripple at twice the frequency cancels, an exponential keeps its rate. The energy of the noise is
 * subtracted. The scatter counts for several samples, because velocities share them. */
static void local_mean(const struct samples *x, size_t first, size_t end,
                       const struct energy_noise *noise, struct reading *reading)
{
    double sum = 0, weight = 0, square = 0, moment = 0, begin = x->t[first],
           width = x->t[end - 1] - begin;
    for (size_t i = first; i < end; i++) {
        double s = sin(PI * (x->t[i] - begin) / width);
        sum += s * s * x->y[i];
        moment += s * s * x->t[i];
        weight += s * s;
        square += s * s * s * s;
    }
    const double value = sum / weight - noise->floor, alone = NOISE_ENERGY_SCATTER * noise->floor;
    const double scatter = noise->spread * noise->spread * fmax(value, 0) + alone * alone;
    reading->t = moment / weight;
    reading->amplitude = (struct measured){value, sqrt(scatter * square) / weight};
}

/* Returns the ratio of the mean of an exponential, weighted by sin^2, to its value at the middle. x
 * is the rate times half the width. */
static double mean_gain(double x)
{
    return fabs(x) < 1e-4 ? 1 : sinh(x) / x * (PI * PI) / (PI * PI + x * x);
}

/* Reads the mean energy of `count` equal windows. Returns their number. */
static int read_energy(const struct samples *x, int count, const struct energy_noise *noise,
                       struct reading *reading)
{
    for (int k = 0; k < count; k++) {
        size_t begin = x->n * (size_t)k / (size_t)count,
               end = x->n * (size_t)(k + 1) / (size_t)count;
        local_mean(x, begin, end, noise, &reading[k]);
    }
    return count;
}

/* Returns the relative change of the slope of ln(E - floor) if the floor is wrong by FLOOR_WRONG,
 * averaged over the readings. */
static double floor_fraction(const struct decay *decay, const struct energy_noise *noise)
{
    double sum = 0;
    for (int k = 0; k < decay->readings; k++)
        sum += FLOOR_WRONG * noise->floor / fmax(decay->reading[k].amplitude.value, noise->floor);
    return sum / decay->readings;
}

/* Reads the amplitude in `count` windows of at most two periods, spread over the series, into
 * reading[]. Returns the number of readings. */
static int read_amplitudes(const struct motion *m, int count, struct reading *reading)
{
    const struct samples *x = &m->samples;
    double width = fmin(2 * m->overview.period, (x->t[x->n - 1] - x->t[0]) / count);
    double first = x->t[0], last = x->t[x->n - 1] - width;
    int read = 0;
    for (int k = 0; k < count; k++) {
        double t_begin = first + (last - first) * k / (count - 1);
        size_t low = samples_index(x, t_begin - 1e-9 * width),
               high = samples_index(x, t_begin + width * (1 + 1e-9));
        read += local_amplitude(m, low, high, &reading[read]);
    }
    return read;
}

/* Returns top/rate, or NAN with a lower bound if the rate may be 0. */
struct measured measured_reciprocal(double top, struct measured rate, double *least)
{
    static const double doubt = 2; /* standard deviations */
    const double margin = doubt * rate.uncertainty;
    *least = NAN;
    if (rate.value > margin)
        return (struct measured){top / rate.value,
                                 top / (rate.value * rate.value) * rate.uncertainty};
    if (rate.value + margin > 0)
        *least = top / (fmax(rate.value, 0) + margin);
    return (struct measured){NAN, NAN};
}

/* Reads amplitudes (or with `energy`, its noise, local energies) in `readings` windows (0 chooses),
 * and fits a line to their logarithms, from whose slope gamma, tau, Q and decrement follow. Returns
 * false with the error. */
bool series_decay(const struct series *series, struct arena *arena,
                  const struct energy_noise *energy, int readings, struct decay *decay,
                  struct error *error)
{
    struct motion m;
    *decay = (struct decay){.halves = {NAN, NAN}};
    int count = readings > 0 ? readings : READINGS_DEFAULT;
    if (count < READINGS_MIN || count > (int)COUNT_OF(decay->reading)) {
        return error_set(error, ERROR_COMMAND, "a decay needs %d to %d readings, not %d",
                         READINGS_MIN, (int)COUNT_OF(decay->reading), count);
    }
    double omega = NAN, rate = energy ? -1 : -2; /* gamma = rate * slope */
    if (energy) {
        if (!samples_init(&m.samples, series, arena)) {
            return error_memory(error);
        }
        if (series->n < 4 * (size_t)count || !(m.samples.dt > 0)) {
            return error_set(error, ERROR_COMMAND, "too few samples for %d readings of the energy",
                             count);
        }
        decay->readings = read_energy(&m.samples, count, energy, decay->reading);
    } else {
        if (!motion_require(&m, series, arena, NULL, error)) {
            return false;
        }
        if (readings <= 0) { /* no more windows than the record holds */
            count = (int)fmin(count, fmax(READINGS_MIN, floor(m.overview.periods)));
        }
        omega = m.harmonic.omega;
        decay->readings = read_amplitudes(&m, count, decay->reading);
    }
    struct line_fit line, half;
    double t0 = series->t[0];
    if (!fit_logarithms(decay->reading, decay->readings, t0, &line)) {
        return error_set(error, ERROR_COMMAND,
                         "no decay: fewer than two readings are above the noise");
    }
    decay->gamma = (struct measured){rate * line.slope.value, fabs(rate) * line.slope.uncertainty};
    if (energy)
        decay->gamma.uncertainty =
            hypot(decay->gamma.uncertainty, floor_fraction(decay, energy) * decay->gamma.value);
    const double span = series->t[series->n - 1] - t0;
    const double initial = exp(line.intercept.value) /
                           (energy ? mean_gain(0.5 * decay->gamma.value * span / count) : 1);
    decay->initial = (struct measured){initial, initial * line.intercept.uncertainty};
    double least;
    decay->tau = measured_reciprocal(2, decay->gamma, &least);
    decay->quality = measured_reciprocal(omega, decay->gamma, &least);
    decay->decrement =
        (struct measured){PI / omega * decay->gamma.value, PI / omega * decay->gamma.uncertainty};
    int middle = decay->readings / 2;
    for (int i = 0; i < 2; i++) {
        const struct reading *reading = decay->reading + (i ? middle : 0);
        if (fit_logarithms(reading, i ? decay->readings - middle : middle, t0, &half)) {
            decay->halves[i] = rate * half.slope.value;
        }
    }
    return true;
}
