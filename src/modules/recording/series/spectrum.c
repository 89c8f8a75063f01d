/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Spectra by fast Fourier transform (Hann window, zero padding) and their peaks, which are refined
 * by least squares on the true times (Lomb–Scargle). Times with gaps go through
 * spectrum_drawn.c. */
#include <hooke/base/cancel.h>
#include "modules/recording/series/internal.h"

#include <gsl/gsl_fft_real.h>
#include <math.h>

/* Number of values transformed at once without a check for Ctrl-C: about 5 ms. */
#define TRANSFORM_PIECE ((size_t)1 << 17)
/* Number of rotations of a phase factor before it is computed anew. */
#define PHASE_ROTATIONS_MAX 64
/* Peaks with fewer periods in the record are drift. */
#define LOWEST_PERIODS 1.3

/* Smallest number of samples of a part, and peaks taken from one mean spectrum. */
enum { PART_MIN = 16, CANDIDATES = 5 };

/* ---- the Fourier transform of real values in pieces, between which it can be ended ---- */

/* Combines the transforms of even and odd values, in GSL's half-complex order, to the transform of
 * all n values (Cooley and Tukey 1965) in result. Returns false if cancelled. */
static bool combine_halves(const double *even, const double *odd, size_t n, double *result,
                           const struct cancel *cancel)
{
    const size_t half = n / 2;
    const double angle = TWO_PI / (double)n, turn_c = cos(angle), turn_s = sin(angle);
    double c = 1, s = 0;
    result[0] = even[0] + odd[0];
    result[half] = even[0] - odd[0];
    result[half / 2] = even[half / 2];
    result[n - half / 2] = -odd[half / 2];
    for (size_t k = 1; k < half / 2; k++) {
        if (k % LOOK_EACH_ROWS == 0 && cancelled(cancel))
            return false;
        const double previous_c = c;
        c = k % PHASE_ROTATIONS_MAX ? c * turn_c - s * turn_s : cos(angle * (double)k);
        s = k % PHASE_ROTATIONS_MAX ? previous_c * turn_s + s * turn_c : sin(angle * (double)k);
        const double a = even[k], b = even[half - k];
        const double re = c * odd[k] + s * odd[half - k], im = c * odd[half - k] - s * odd[k];
        result[k] = a + re;
        result[n - k] = b + im;
        result[half - k] = a - re;
        result[half + k] = im - b;
    }
    return true;
}

/* Computes the transform of n real values (a power of 2) in place, in GSL's half-complex order.
 * Splits long data into even and odd values, so that cancellation is checked between pieces.
 * scratch [n] is work space. Returns false if cancelled. */
bool transform_real(double *data, size_t n, double *scratch, const struct cancel *cancel)
{
    const size_t half = n / 2;
    if (cancelled(cancel))
        return false;
    if (n <= TRANSFORM_PIECE)
        return gsl_fft_real_radix2_transform(data, 1, n) == 0;
    for (size_t i = 0; i < half; i++) {
        scratch[i] = data[2 * i];
        scratch[half + i] = data[2 * i + 1];
    }
    return transform_real(scratch, half, data, cancel) &&
           transform_real(scratch + half, half, data, cancel) &&
           combine_halves(scratch, scratch + half, n, data, cancel);
}

/* ---- spectra ---- */

/* Power spectrum of samples. */
struct transform {
    double *power; /* [bins] |X|^2 */
    size_t bins;   /* frequencies from 0 to Nyquist */
    double step;   /* [Hz] between bins */
    double gain;   /* sum of the window: amplitude = 2 |X|/gain */
    bool memory;   /* false if out of memory or cancelled */
};

/* Fills an even grid of x->n points with values: rejected samples are bridged by straight lines,
 * and the least-squares line is subtracted. */
static void fill_even(const struct samples *x, double *filled)
{
    size_t right = 0, left = 0;
    double dt = (x->t[x->n - 1] - x->t[0]) / (double)(x->n - 1);
    double sum = 0, moment = 0, square = 0, middle = 0.5 * (double)(x->n - 1);
    for (size_t i = 0; i < x->n; i++) {
        double t = x->uniform ? x->t[i] : x->t[0] + (double)i * dt;
        if (x->uniform && x->use[i]) {
            filled[i] = x->y[i];
            left = i;
        } else {
            while (right < x->n && (!x->use[right] || x->t[right] < t)) {
                left = x->use[right] ? right : left;
                right++;
            }
            size_t next = right < x->n ? right : left;
            double width = x->t[next] - x->t[left];
            filled[i] = width > 0 ? x->y[left] + (x->y[next] - x->y[left]) *
                                                     fmin((t - x->t[left]) / width, 1)
                                  : x->y[next];
        }
        double s = (double)i - middle;
        sum += filled[i];
        moment += s * filled[i];
        square += s * s;
    }
    double mean = sum / (double)x->n, slope = moment / square;
    for (size_t i = 0; i < x->n; i++) {
        filled[i] -= mean + slope * ((double)i - middle);
    }
}

/* Computes the power spectrum of samples without gaps, under a Hann window and with zeros appended.
 * Check `memory` of the result. */
static struct transform power_spectrum(const struct samples *x, struct arena *arena)
{
    struct transform result = {.memory = true};
    size_t length = 32;
    while (length < x->n || (length < 2 * x->n && length < 16384)) {
        length *= 2;
    }
    double *data = arena_array(arena, 2 * length, sizeof *data);
    if (!data || cancelled(x->cancel)) {
        result.memory = false;
        return result;
    }
    fill_even(x, data);
    double angle = TWO_PI / (double)x->n, c = cos(angle), s = sin(angle), re = cos(0.5 * angle),
           im = sin(0.5 * angle);
    for (size_t i = 0; i < x->n; i++) {
        double window = 0.5 * (1 - re); /* Hann window, where re = cos(2 pi (i + 1/2)/n) */
        data[i] *= window;
        result.gain += window;
        double next = re * c - im * s;
        im = re * s + im * c;
        re = next;
    }
    if (!transform_real(data, length, data + length, x->cancel)) {
        result.memory = false;
        return result;
    }
    result.bins = length / 2 + 1;
    result.step = (double)(x->n - 1) / (x->t[x->n - 1] - x->t[0]) / (double)length;
    /* The sum is computed in place: data[length - k] is read before data[k] is written. */
    for (size_t k = 1; k < length / 2; k++) {
        data[k] = data[k] * data[k] + data[length - k] * data[length - k];
    }
    data[0] *= data[0];
    data[length / 2] *= data[length / 2];
    result.power = data;
    return result;
}

/* Computes the power spectrum of samples with a gap. A straight line across the gap, as in
 * fill_even(), would distort the spectrum. */
static struct transform transform_with_gap(const struct samples *x, struct arena *arena)
{
    struct spectrum spectrum;
    struct transform result = {.memory = samples_spectrum(x, arena, &spectrum)};
    for (size_t k = 0; result.memory && k < spectrum.bins; k++) {
        spectrum.amplitude[k] *= spectrum.amplitude[k];
    }
    if (result.memory) {
        result.power = spectrum.amplitude;
        result.bins = spectrum.bins;
        result.step = spectrum.step;
    }
    return result;
}

/* Does the work of peak_frequency() with memory of an arena. */
static double peak_of_transform(const struct samples *x, struct arena *arena, bool *memory)
{
    *memory = true;
    if (x->n < 8) {
        return NAN;
    }
    const bool gap = samples_have_gap(x, arena, memory);
    struct transform spectrum = !*memory ? (struct transform){.memory = false}
                                : gap    ? transform_with_gap(x, arena)
                                         : power_spectrum(x, arena);
    *memory = spectrum.memory;
    if (!spectrum.memory || spectrum.bins < 3) {
        return NAN;
    }
    const double *p = spectrum.power;
    double span = x->t[x->n - 1] - x->t[0];
    size_t peak = 0, first = (size_t)ceil(LOWEST_PERIODS / span / spectrum.step);
    for (size_t k = first > 1 ? first : 1; k + 2 < spectrum.bins && k < spectrum.bins * 99 / 100;
         k++) { /* 2.02 samples a period */
        if (p[k] > p[k - 1] && p[k] >= p[k + 1] && (peak == 0 || p[k] > p[peak])) {
            peak = k;
        }
    }
    if (peak == 0 || !(p[peak - 1] > 0) || !(p[peak + 1] > 0)) {
        return peak == 0 ? NAN : TWO_PI * spectrum.step * (double)peak;
    }
    /* Parabola through the logarithms of three bins. */
    double l = log(p[peak - 1]), m = log(p[peak]), r = log(p[peak + 1]);
    return TWO_PI * spectrum.step * ((double)peak + 0.5 * (l - r) / (l - 2 * m + r));
}

/* Works in an arena of its own, released at once. */
double peak_frequency(const struct samples *x, bool *memory)
{
    struct arena arena = {0};
    const double omega = peak_of_transform(x, &arena, memory);
    arena_reset(&arena);
    return omega;
}

/* Sets omega [max] to the highest local maxima of a spectrum, highest first. span is the length [s]
 * of the record, which sets the lowest frequency. Returns their number. */
static int highest_peaks(const struct transform *spectrum, double span, double *omega, int max)
{
    const double *p = spectrum->power;
    const size_t first = (size_t)ceil(LOWEST_PERIODS / span / spectrum->step);
    double height[8] = {0};
    int count = 0;
    max = max < (int)COUNT_OF(height) ? max : (int)COUNT_OF(height);
    for (size_t k = first > 1 ? first : 1; k + 2 < spectrum->bins; k++) {
        if (!(p[k] > p[k - 1] && p[k] >= p[k + 1])) {
            continue;
        }
        int rank = count < max ? count++ : max;
        for (; rank > 0 && p[k] > height[rank - 1]; rank--) {
            if (rank < max) {
                height[rank] = height[rank - 1];
                omega[rank] = omega[rank - 1];
            }
        }
        if (rank < max) {
            height[rank] = p[k];
            omega[rank] = TWO_PI * spectrum->step * (double)k;
        }
    }
    return count;
}

/* Adds up the spectra of `parts` equal parts (Welch 1967, without overlap), a multiple of their
 * mean. */
static struct transform sum_transforms(const struct samples *x, size_t parts, struct arena *arena)
{
    const size_t n = x->n / parts;
    struct transform sum = {.memory = true};
    for (size_t k = 0; k < parts && sum.memory; k++) {
        const struct samples part = samples_part(x, k * n, (k + 1) * n);
        const struct transform one = power_spectrum(&part, arena);
        if (k == 0 || !one.memory) {
            sum = one;
            continue;
        }
        for (size_t i = 0; i < sum.bins; i++) {
            sum.power[i] += one.power[i];
        }
    }
    return sum;
}

/* Sets omega [max] to the highest peaks [rad/s] of the mean spectrum of `parts` equal parts.
 * Returns their number. Clears *memory if out of memory. */
int mean_spectrum_peaks(const struct samples *x, size_t parts, double *omega, int max, bool *memory)
{
    struct arena arena = {0};
    int count = 0;
    *memory = true;
    if (x->n / parts >= PART_MIN) {
        const struct transform spectrum = sum_transforms(x, parts, &arena);
        *memory = spectrum.memory;
        if (spectrum.memory)
            count =
                highest_peaks(&spectrum, (x->t[x->n - 1] - x->t[0]) / (double)parts, omega, max);
    }
    arena_reset(&arena);
    return count;
}

/* Peaks of the whole transform come first, then those of spectra averaged over 8 and 32 parts. */
int spectrum_candidates(const struct samples *x, double *omega, int max, bool *memory)
{
    static const size_t parts[] = {1, 8, 32};
    int count = 0;
    *memory = true;
    for (size_t k = 0; k < COUNT_OF(parts) && *memory; k++) {
        const int quota = max - count < CANDIDATES ? max - count : CANDIDATES;
        count += mean_spectrum_peaks(x, parts[k], omega + count, quota, memory);
    }
    return count;
}

/* Returns the share of the power that lies around the highest peaks of the spectrum, `peaks` of
 * them, within a factor exp(ratio_log) in frequency; 0 if it has no spectrum. */
double power_share_of_peaks(const struct samples *x, int peaks, double ratio_log,
                            struct arena *arena)
{
    static const double wider = 3; /* [bins] half width of a line under a Hann window */
    struct spectrum spectrum;
    double all = 0, left = 0;
    if (!samples_spectrum(x, arena, &spectrum) || spectrum.bins < 4)
        return 0;
    double *a = spectrum.amplitude;
    const double bins = wider / (spectrum.step * (x->t[x->n - 1] - x->t[0]));
    const size_t first = (size_t)bins;
    for (size_t k = first; k < spectrum.bins; k++)
        all += a[k] * a[k];
    for (int i = 0; i < peaks; i++) {
        size_t peak = first;
        for (size_t k = first; k < spectrum.bins; k++)
            peak = a[k] > a[peak] ? k : peak;
        const double middle = (double)peak, low = middle * exp(-ratio_log) - bins,
                     high = middle * exp(ratio_log) + bins;
        for (size_t k = first; k < spectrum.bins; k++)
            a[k] = (double)k > low && (double)k < high ? 0 : a[k];
    }
    for (size_t k = first; k < spectrum.bins; k++)
        left += a[k] * a[k];
    return all > 0 ? 1 - left / all : 0;
}

/* Returns the minimum near omega of the least-squares misfit of a sine with floating mean
 * (Zechmeister & Kürster 2009), by a parabola through three frequencies; omega itself if that
 * fails. */
static double refine_frequency(const struct samples *x, double omega)
{
    double span = x->t[x->n - 1] - x->t[0], step = PI / (4 * span), rss[3];
    for (int i = 0; i < 3; i++) {
        struct harmonic h = {.omega = omega + (i - 1) * step, .origin = x->t[0] + 0.5 * span};
        if (!harmonic_fit(x, FREE_LINEAR, &h, NULL)) {
            return omega;
        }
        rss[i] = h.rss;
    }
    double curvature = rss[0] - 2 * rss[1] + rss[2], shift = 0.5 * (rss[0] - rss[2]) / curvature;
    return curvature > 0 && fabs(shift) <= 1 ? omega + shift * step : omega;
}

/* Takes the peak of the spectrum and refines it by least squares. */
double series_peak_frequency(const struct series *series, struct arena *arena)
{
    struct samples samples;
    bool memory;
    double *scratch = arena_array(arena, series->n + 1, sizeof *scratch);
    if (!scratch || !samples_init(&samples, series, arena)) {
        return NAN;
    }
    samples_flag_spikes(&samples, scratch);
    double omega = peak_frequency(&samples, &memory);
    return isfinite(omega) ? refine_frequency(&samples, omega) : NAN;
}

/* Returns the power of the series at `multiple` times the frequency of a period [s]. The Hann
 * window keeps a bent baseline and the fundamental out of it. */
static double power_at(const struct series *series, double period, double multiple)
{
    const double t0 = series->t[0], span = series->t[series->n - 1] - t0;
    double mean = 0, re = 0, im = 0;
    for (size_t i = 0; i < series->n; i++)
        mean += series->y[i] / (double)series->n;
    for (size_t i = 0; i < series->n; i++) {
        const double t = series->t[i] - t0, angle = TWO_PI * multiple * t / period;
        const double weighted = (series->y[i] - mean) * (1 - cos(TWO_PI * t / span));
        re += weighted * cos(angle);
        im += weighted * sin(angle);
    }
    return re * re + im * im;
}

/* Compares the power at two and three times the frequency with that between. */
bool series_has_harmonics(const struct series *series, double period)
{
    /* fewer cycles leave the lines overlapping */
    static const double stands_out = 16, cycles_min = 6;
    if (series->t[series->n - 1] - series->t[0] < cycles_min * period)
        return true;
    const double background = (power_at(series, period, 1.5) + power_at(series, period, 2.5) +
                               power_at(series, period, 3.5)) /
                              3;
    return fmax(power_at(series, period, 2), power_at(series, period, 3)) > stands_out * background;
}
