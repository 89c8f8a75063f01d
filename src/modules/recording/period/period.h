/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Analysis of a series: crossings, period, amplitude, decay, spectrum, rates, lines. */
#pragma once

#include <hooke/data.h>

void series_overview(const struct series *series, struct arena *arena, struct overview *overview);
/* Sets use [n] to 0 for the samples that the fit of a damped sine leaves out. Returns false where
 * no damped sine describes the series, if it is too long to be fitted for that, or if out of
 * memory.
 */
bool series_outliers(const struct series *series, struct arena *arena, unsigned char *use);
/* Returns true if it is two damped sines, of which one alone is far from it: their beats are no
 * start and no end. */
bool series_beats(const struct series *series, struct arena *arena);

/* ---- crossings and period ---- */

/*
 * Crossings of `level` with hysteresis (4 sigma of the noise or 5 % of the amplitude, whichever is
 * more), each placed by a line fit to the samples around it (+-5 samples of noisy data, as many as
 * the curvature allows; cubic interpolation for noise-free series). Writes up to `capacity`,
 * returns how many there are.
 */
size_t series_crossings(const struct series *series, const struct overview *overview, double level,
                        struct crossing *result, size_t capacity);

/* A time or a rate, with what all times have in common [relative] added to its uncertainty. */
struct measured measured_at_pace(struct measured time, double pace);
/*
 * Noisy samples: from the line through the phases of sines fitted window by window, each on its own
 * parabola. Others, and fewer than four windows: from the line through the up-crossing times
 * against their number. The period is tested against its multiples and parts by how much the series
 * is like itself after them; where another one is right, or no sine describes it, from the times of
 * whole cycles. A step or a knock beside the oscillation is left out, with a warning. Refused with
 * a reason where it does not oscillate.
 */
bool series_period(const struct series *series, struct arena *arena, struct period *period,
                   struct error *error);
/*
 * The same of a simulation, which has no noise, about a centre that is known: from the crossings
 * alone, at a small part of the cost. Returns false if they are irregular or too few, or if there
 * are less than 20 samples a period.
 */
bool series_clean_period(const struct series *series, double centre, struct arena *arena,
                         struct period *period);

struct period_reading {
    double t_begin, t_end, t;  /* [s] the window, and its middle */
    struct measured amplitude; /* half the swing; of a simulation with its overtones */
    struct measured period;    /* [s] */
    double periods;
};

/* Reads equal windows one after the other. */
bool series_period_readings(const struct series *series, int windows, struct arena *arena,
                            struct period_reading *reading, struct error *error);

/* ---- amplitude and decay ---- */

struct reading {
    double t; /* [s] centre of the window */
    /* half the swing about the local offset: local harmonic fit over one or more periods */
    struct measured amplitude;
};

/* Reads the amplitude at the given times, each from a window of `width` [s], or of two periods if
 * it is 0. Returns false with the error if a window has too few samples, or if out of memory. */
bool series_amplitudes(const struct series *series, struct arena *arena, const double *reading_time,
                       int count, double width, struct reading *reading, struct error *error);

struct decay {
    struct measured gamma; /* [1/s] from the weighted line through ln(amplitude) */
    /* tau and quality as measured_reciprocal() */
    struct measured tau;       /* [s] 1/e time of the amplitude: 2/gamma */
    struct measured decrement; /* ln of the ratio of successive amplitudes = gamma T / 2 */
    struct measured quality;   /* Q = omega/gamma */
    struct measured initial;   /* amplitude at the start of the window */
    double halves[2];          /* gamma of the first and second half */
    int readings;
    struct reading reading[64]; /* readings to which the line was fitted */
};

/*
 * Returns top/rate (tau = 2/gamma, Q = omega/gamma) where the rate is positive by more than two
 * standard deviations. Else its value is NAN, and *least is what top/rate exceeds with 97.5 %
 * confidence; NAN where the rate is negative beyond doubt.
 */
struct measured measured_reciprocal(double top, struct measured rate, double *least);

/* Mean and spread over time (trapezoids), so that uneven samples count by how long they stand. */
struct measured series_mean(const struct series *series);

/* Reads the decay of a motion or, unless energy is NULL, of an energy with this noise, which falls
 * as exp(-gamma t) without crossing zero; the line is then fitted to its local means, less what the
 * noise adds. */
bool series_decay(const struct series *series, struct arena *arena,
                  const struct energy_noise *energy, int readings, struct decay *decay,
                  struct error *error);

/* ---- spectrum ---- */

/* Returns the angular frequency of the peak [rad/s], or NAN if none stands out. Uses a Hann window,
 * zero padding and a log-parabolic peak, and Lomb-Scargle for uneven sampling. */
double series_peak_frequency(const struct series *series, struct arena *arena);
/* Amplitude spectrum on `bins` frequencies [Hz] from 0 to the Nyquist frequency; arrays from arena.
 */
bool series_spectrum(const struct series *series, struct arena *arena, const double **frequency,
                     const double **amplitude, size_t *bins);

/*
 * The strongest line, and others that stand out; returns how many, or 0 if there is none.
 * Least-squares sines (damped ones where these describe the series better) with their uncertainty
 * in the noise around the line. The amplitude is that of the best steady sine.
 */
int series_peaks(const struct series *series, struct arena *arena, struct spectrum_peak *peak,
                 int max);

/* ---- rates ---- */

struct derivative {
    double *value; /* [n] beside the series, from the arena; NAN next to gaps */
    size_t known;  /* number of values that are not NAN */
    double gain;   /* [1/s] standard deviation for samples with independent noise of 1 */
    double step;   /* [s] median */
    int points;
    enum quantity quantity; /* quantity of the values */
};

#define DERIVATIVE_POINTS 5

/* Computes the slope of the least-squares parabola through `points` neighbouring samples (odd, at
 * least 3), at any times. */
bool series_derivative(const struct series *series, int points, struct arena *arena,
                       struct derivative *derivative, struct error *error);
/* Returns by which part velocities of an oscillation are too small, because the parabola
 * smooths. */
double derivative_loss(const struct derivative *derivative, double omega);

/*
 * Reads the period, as a cross-check, from the shifts at which the series is most like itself, near
 * the multiples of the known period; a long recording is read in parts all along it. Returns false
 * if it does not oscillate long enough, or if out of memory.
 */
bool series_correlation_period(const struct series *series, const struct period *known,
                               struct arena *arena, struct measured *period);

/* ---- straight lines ---- */

struct line_fit {
    struct measured slope, intercept;
    double covariance; /* covariance of slope and intercept */
    double chi2;       /* sum of squares over the uncertainties */
    int freedom;       /* points less two */
};

/* Weighted by the uncertainties u of y (u 0: all alike), which are widened where the points scatter
 * more. Returns false for fewer than two different x. */
bool line_fit(const double *x, const struct measured *y, int n, struct line_fit *fit);
