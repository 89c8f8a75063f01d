/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Analysis of a series: overview, crossings, period, amplitude, decay, spectrum, rates, straight
 * lines. Arrays in results come from the arena; series->cancel ends long computations. */
#pragma once

#include <hooke/data.h>

/* Sets *overview: extremes, mean, noise, and whether and with which period it oscillates. If out of
 * memory or cancelled, the reason tells so. */
void series_overview(const struct series *series, struct arena *arena, struct overview *overview);
/* Sets use [n] to 0 for the samples that the fit of a damped sine leaves out. Returns false if no
 * damped sine describes the series, if it is too long for such a fit, or if out of memory. */
bool series_outliers(const struct series *series, struct arena *arena, unsigned char *use);
/* Returns true if the series is two damped sines, and one alone is far from describing it. Its
 * beats are then neither a start nor an end of the motion. */
bool series_beats(const struct series *series, struct arena *arena);

/* ---- crossings and period ---- */

/* Finds crossings of `level` with a hysteresis of 4 standard deviations of the noise or 5 % of the
 * amplitude, whichever is larger. Each is placed by a fit to the samples around it (for noisy
 * series, as many as the curvature allows) or by interpolation (for series without noise). Writes
 * up to `capacity` crossings and returns how many there are. */
size_t series_crossings(const struct series *series, const struct overview *overview, double level,
                        struct crossing *result, size_t capacity);

/* Returns a time or a rate with the relative uncertainty `pace`, which all times of the series
 * share, added to its uncertainty. */
struct measured measured_at_pace(struct measured time, double pace);
/* Measures the period of a series. For noisy samples it comes from the line through the phases of
 * sines that are fitted window by window, each on its own parabola; for others, and for fewer than
 * four windows, from the line through the up-crossing times. It is tested against its multiples and
 * fractions; if another one is right, or if no sine describes the series, the times of whole cycles
 * are used. A step or a knock beside the oscillation is left out, with a warning. Returns false
 * with the reason if the series does not oscillate. */
bool series_period(const struct series *series, struct arena *arena, struct period *period,
                   struct error *error);
/* Measures the period of a simulation, which has no noise, about a known centre, from the crossings
 * alone and much faster. Returns false if they are irregular or too few, or if there are fewer than
 * 20 samples a period. */
bool series_clean_period(const struct series *series, double centre, struct arena *arena,
                         struct period *period);

/* Period and amplitude in one of several windows. */
struct period_reading {
    double t_begin, t_end, t;  /* [s] the window and its middle */
    struct measured amplitude; /* half the swing; for a simulation including overtones */
    struct measured period;    /* [s] */
    double periods;            /* number of periods in the window */
};

/* Reads equal, consecutive windows into reading [windows]. Returns false with the error if one
 * fails. */
bool series_period_readings(const struct series *series, int windows, struct arena *arena,
                            struct period_reading *reading, struct error *error);

/* ---- amplitude and decay ---- */

/* An amplitude at a time. */
struct reading {
    double t; /* [s] centre of the window */
    /* Half the swing about the local offset, from a local harmonic fit over one or more periods. */
    struct measured amplitude;
};

/* Reads the amplitude at `count` times [s], each from a window of `width` [s], or of two periods if
 * it is 0. Returns false with the error if a time is outside, if a window has too few samples, or
 * if out of memory. */
bool series_amplitudes(const struct series *series, struct arena *arena, const double *reading_time,
                       int count, double width, struct reading *reading, struct error *error);

/* Decay of an amplitude or an energy. */
struct decay {
    struct measured gamma; /* [1/s] from the weighted line through ln(amplitude) */
    /* tau and quality are measured_reciprocal() of gamma. */
    struct measured tau;       /* [s] 1/e time of the amplitude: 2/gamma */
    struct measured decrement; /* ln of the ratio of successive amplitudes = gamma T / 2 */
    struct measured quality;   /* Q = omega/gamma */
    struct measured initial;   /* amplitude at the start of the window */
    double halves[2];          /* [1/s] gamma of the first and of the second half */
    int readings;
    struct reading reading[64]; /* readings to which the line was fitted */
};

/* Returns top/rate (as for tau = 2/gamma, Q = omega/gamma) if the rate is positive by more than two
 * standard deviations. Otherwise the value is NAN, and *least is a lower bound of top/rate with
 * 97.5 % confidence, or NAN if the rate is clearly negative. */
struct measured measured_reciprocal(double top, struct measured rate, double *least);

/* Returns mean and standard deviation over time (by trapezoids), so that unevenly spaced samples
 * are weighted by their durations. */
struct measured series_mean(const struct series *series);

/* Reads the decay of a motion or, unless `energy` is NULL, of an energy with this noise, which
 * falls as exp(-gamma t) without crossing zero; the line is then fitted to the logarithms of local
 * means, less the contribution of the noise. readings is the number of windows, 0 for a default.
 * Returns false with the error. */
bool series_decay(const struct series *series, struct arena *arena,
                  const struct energy_noise *energy, int readings, struct decay *decay,
                  struct error *error);

/* ---- spectrum ---- */

/* Returns the angular frequency of the highest peak [rad/s], or NAN if none stands out. The
 * spectrum (Hann window, zero padding) is refined by least squares at the true times. */
double series_peak_frequency(const struct series *series, struct arena *arena);
/* Computes the amplitude spectrum at `bins` frequencies [Hz] from 0 to the Nyquist frequency; the
 * arrays come from the arena. Returns false if out of memory or if there are too few samples. */
bool series_spectrum(const struct series *series, struct arena *arena, const double **frequency,
                     const double **amplitude, size_t *bins);

/* Finds the strongest line and others that stand out, up to `max`; returns their number. They are
 * least-squares sines (damped ones if these describe the series better) with the uncertainty from
 * the noise around the line. The amplitude is that of the best steady sine. */
int series_peaks(const struct series *series, struct arena *arena, struct spectrum_peak *peak,
                 int max);

/* ---- rates ---- */

/* Rate of change of a series. */
struct derivative {
    double *value; /* [n] from the arena; NAN next to gaps */
    size_t known;  /* number of values that are not NAN */
    double gain;   /* [1/s] standard deviation of a value for samples with independent noise of 1 */
    double step;   /* [s] median time step */
    int points;    /* number of samples of each parabola */
    enum quantity quantity; /* quantity of the values */
};

/* Default number of points. */
#define DERIVATIVE_POINTS 5

/* Computes the slope of the least-squares parabola through `points` neighbouring samples (an odd
 * number, at least 3), at any times. Returns false with the error. */
bool series_derivative(const struct series *series, int points, struct arena *arena,
                       struct derivative *derivative, struct error *error);
/* Returns the fraction by which velocities of an oscillation at omega [rad/s] are too small,
 * because the parabola smooths. */
double derivative_loss(const struct derivative *derivative, double omega);

/* Measures the period, as a cross-check, from the lags at which the series resembles itself most,
 * near multiples of the known period; a long recording is read in several parts. Returns false if
 * it does not oscillate for long enough, or if out of memory. */
bool series_correlation_period(const struct series *series, const struct period *known,
                               struct arena *arena, struct measured *period);

/* ---- straight lines ---- */

/* A straight line y = intercept + slope x. */
struct line_fit {
    struct measured slope, intercept;
    double covariance; /* covariance of slope and intercept */
    double chi2;       /* sum of squares in units of the uncertainties */
    int freedom;       /* degrees of freedom: points minus two */
};

/* Fits n points, weighted by the uncertainties of y (all equally, if one is 0), which are widened
 * if the points scatter more. Returns false for fewer than two different x. */
bool line_fit(const double *x, const struct measured *y, int n, struct line_fit *fit);
