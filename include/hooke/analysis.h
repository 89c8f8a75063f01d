/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * analysis: what a series (t, y), measured or simulated, says: crossings, period, amplitude, decay, spectrum, fits.
 *
 * Convention everywhere: y = c + A exp(-gamma t/2) cos(omega t + phi), with t counted from the first sample of the
 * window. The amplitude falls as exp(-gamma t/2), the energy as exp(-gamma t); tau = 2/gamma is the 1/e time of the
 * amplitude. A series whose samples have no noise (a simulation) goes through the same code; its uncertainties are then
 * tiny, never 0/0.
 */
#ifndef HOOKE_ANALYSIS_H
#define HOOKE_ANALYSIS_H

#include <hooke/data.h>

/* What the series looks like before any model: NaN-free, robust. */
struct overview {
    double mean, low, high; /* offset (mid of the robust extremes, or mean over whole periods), extremes */
    double noise;           /* standard deviation of the noise, from differences */
    double period;          /* [s] first estimate from the spectrum, refined; NAN: does not oscillate */
    double periods;         /* how many of them the series holds */
    bool oscillates;
    char reason[160]; /* why not */
};

void series_overview(const struct series *series, struct arena *arena, struct overview *overview);
/* The part [from, to] of a series; shares memory. */
struct series series_window(struct series series, double from, double to);

/* ---- crossings and period ---- */

struct crossing {
    double t, uncertainty; /* [s] */
    bool up;
};

/*
 * Crossings of `level` with hysteresis (4 sigma of the noise or 5 % of the amplitude, whichever is more), each placed
 * by a line fit to the samples around it (+-5 samples of noisy data, as many as the curvature allows; cubic
 * interpolation for noise-free series). Writes up to `room`, returns how many there are.
 */
size_t series_crossings(const struct series *series, const struct overview *overview, double level,
                        struct crossing *out, size_t room);

struct period {
    struct measured period; /* [s] */
    double periods;         /* whole periods between first and last crossing used */
    double first, last;     /* [s] */
    double level;
};

/* From the line through the up-crossing times against their number. Refused with a reason where it does not oscillate.
 */
bool series_period(const struct series *series, struct arena *arena, struct period *period, struct error *error);

/* ---- amplitude and decay ---- */

struct reading {
    double t;                  /* [s] centre of the window */
    struct measured amplitude; /* half the swing about the local offset: local harmonic fit over one or more periods */
};

/* Amplitude at the given times (each from a window of `width` [s], 0: two periods). */
bool series_amplitudes(const struct series *series, struct arena *arena, const double *at, int count, double width,
                       struct reading *out, struct error *error);

struct decay {
    struct measured gamma;     /* [1/s] from the weighted line through ln(amplitude) */
    struct measured tau;       /* [s] 1/e time of the amplitude: 2/gamma */
    struct measured decrement; /* ln of the ratio of successive amplitudes = gamma T / 2 */
    struct measured quality;   /* Q = omega/gamma */
    struct measured initial;   /* amplitude at the start of the window */
    double halves[2];          /* gamma of the first and second half */
    int readings;
    struct reading reading[64]; /* what the line was fitted to */
};

/* `energy`: the series is an energy (falls as exp(-gamma t) without crossing zero; the line is fitted to its local
 * means over a period). */
bool series_decay(const struct series *series, struct arena *arena, bool energy, int readings, struct decay *decay,
                  struct error *error);

/* ---- spectrum ---- */

/* Hann window, zero padding, log-parabolic peak; uneven sampling by Lomb–Scargle. Peak angular frequency [rad/s], NAN
 * if none stands out. */
double series_peak_frequency(const struct series *series, struct arena *arena);
/* Amplitude spectrum on `bins` frequencies [Hz] from 0 to the Nyquist frequency; arrays from arena. */
bool series_spectrum(const struct series *series, struct arena *arena, const double **frequency,
                     const double **amplitude, size_t *bins);

/* ---- fits ---- */

enum drag_law { LAW_NONE, LAW_LINEAR, LAW_QUADRATIC, LAW_MIXED, LAW_UNDECIDED };

const char *
drag_law_name(enum drag_law law); /* "linear", "quadratic", "mixed", "not distinguishable", NULL for LAW_NONE */

struct fit {
    const char *model;
    struct measured period, omega, gamma, amplitude, phase, offset; /* SI; period = 2 pi/omega (the damped one) */
    double rms;                                                     /* of the residuals of the samples used */
    size_t used, rejected;
    double window[2];                /* [s] */
    struct measured halves[2];       /* gamma of the two halves of the window, NAN where a half determines nothing */
    struct measured half_periods[2]; /* [s] */
    enum drag_law preferred;         /* which law the envelope follows */
    double evidence[3];              /* BIC of linear, quadratic, mixed */
    bool converged;
    int iterations;
    double autocorrelation; /* lag 1 of the residuals; the uncertainties are widened for it */
    char warning[8][200];
    int warnings;
    double t0; /* [s] time of the first sample: t in the model counts from here */
};

struct fit_model {
    struct row row; /* damped, sine, … */
    bool (*fit)(const struct series *series, struct arena *arena, const struct cancel *cancel, struct fit *fit,
                struct error *error);
};

/*
 * Rows damped and sine need no guess. Uncertainties: least squares, widened for the lag-1 autocorrelation of the
 * residuals; of period, omega and gamma also half the difference of the window's halves where these differ by more
 * than 2.5 standard deviations. ERROR_COMMAND: does not oscillate; ERROR_NUMERICAL: did not converge. A fit switches
 * GSL's error handler off (process-wide: GSL has no other way).
 */
extern const struct catalog fit_catalog;

/* Model value at time t [s] (absolute). */
double fit_value(const struct fit *fit, double t);
/* k = m (omega^2 + gamma^2/4) with the mass's and the fit's uncertainties. */
struct measured fit_stiffness(const struct fit *fit, struct measured mass);

#endif
