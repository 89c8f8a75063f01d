/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the files of the analysis layer share. */
#pragma once

#include "modules/recording/series/analysis.h"
#include "modules/recording/table/load.h"
#include <hooke/base/numeric.h>

struct cancel;

#define HALVES_DIFFER 2.5 /* standard deviations from which two halves are said to differ */

/* ---- a series with a mask, and robust statistics (samples.c) ---- */

/* Returns the index of the first sample at or after t [s]. */
static inline size_t samples_index(const struct samples *samples, double t)
{
    return first_from(samples->t, samples->n, t);
}
/* [from, to), shares memory */
struct samples samples_part(const struct samples *samples, size_t begin, size_t end);
/* Makes means of `each` neighbours, of those in use (all, if use is NULL), at their mean times;
 * none where none is in use, nor of fewer at the end. Returns false if out of memory. */
bool samples_average(const struct samples *samples, size_t each, struct arena *arena,
                     struct series *means);
/* Returns the mean square of n values about their mean. */
double values_variance(const double *y, size_t n);
/* Returns the part with the most rows that is without a gap: a step of a good part of a period [s],
 * and of several usual ones. */
struct series series_longest_stretch(const struct series *series, double period);
/*
 * Makes means of two, four, ... neighbours of a long series, of as many as lose no more of its
 * variance than white noise and lost_share_max. The series itself is returned where it is short, or
 * little but noise; what has no noise loses no more than THIN_KEEPS_LINES. use [n]: the rows that
 * count, or NULL. Returns false if out of memory.
 */
#define THIN_KEEPS_LINES 1e-3 /* lost_share_max where a value may be read from the means */
#define THIN_FOR_HINTS 1e-2   /* and where they serve a hint or a warning only */
#define THIN_FOR_PERIOD 3e-2  /* and where its times are read, which means do not move */
bool series_thin(const struct series *series, const unsigned char *use, double lost_share_max,
                 struct arena *arena, struct series *thin);
/* Returns the first sample from which on no motion is visible, even after a strong decay, or n if
 * there is none. */
static inline size_t samples_quiet(const struct samples *x, double period)
{
    return motion_quiet(&(struct motion_rows){x->t, x->y, x->use, 1, x->n}, period);
}
/* Returns true if an interval without samples is 8 times as long as half of them are, in times that
 * are no even grid. */
bool samples_have_gap(const struct samples *samples, struct arena *arena, bool *memory);
/* Hann window over all of the times, no matter what of them was recorded: the peak of a line is its
 * amplitude. */
struct spectrum {
    double *amplitude; /* [bins] as y */
    /* frequencies up to half the rate of the samples; 0 if there are too few samples */
    size_t bins;
    double step; /* [Hz] distance of two frequencies */
};
/* Computes the spectrum. Returns false if out of memory or if cancelled. */
bool samples_spectrum(const struct samples *samples, struct arena *arena,
                      struct spectrum *spectrum);
/* Returns the step to which values are rounded, the smallest between neighbours or a part of it, if
 * nearly all are multiples of it; else 0. */
double samples_quantum(const struct samples *samples);
/* clears `use` of short far excursions */
void samples_flag_spikes(struct samples *samples, double *scratch);

/* ---- y = c + d s + exp(-gamma s/2) (a cos(omega s) + b sin(omega s)), s = t - origin (harmonic.c)
 * ---- */

enum { LINEAR_A, LINEAR_B, LINEAR_C, LINEAR_D, RATE_OMEGA, RATE_GAMMA, HARMONIC_PARAMETERS };

/* Number of parameters, in the order of the list above, that a fit may change; d only if
 * `drifts`. */
enum harmonic_free { FREE_LINEAR = 4, FREE_OMEGA = 5, FREE_GAMMA = 6 };

struct harmonic {
    double a, b, c; /* as y */
    double d;       /* [y/s] drift of the offset, 0 unless it drifts */
    bool drifts;
    double omega;  /* [rad/s] */
    double gamma;  /* [1/s] */
    double origin; /* [s] */
    /* results of the fit */
    /* (J^T J)^-1 of the free parameters, else 0 */
    double inverse[HARMONIC_PARAMETERS][HARMONIC_PARAMETERS];
    double rss; /* sum of squared residuals of the samples used */
    size_t used;
    int iterations;
    bool converged;
};

/*
 * Fits by least squares over samples->use from the given omega, gamma, origin (and a, b, c unless a
 * and b are 0). residual [n] is set to y - model of all samples unless NULL. Returns false if there
 * are too few samples, if they do not determine the parameters, or if cancelled; `harmonic` must
 * then not be used. If it returns true, `converged` must be checked.
 */
bool harmonic_fit(const struct samples *samples, enum harmonic_free unknowns,
                  struct harmonic *harmonic, double *residual);
/* Sets residual [n] to y - model. Returns false if no sample is used, or if cancelled. */
bool harmonic_residuals(const struct samples *samples, const struct harmonic *harmonic,
                        double *residual);
/* standard deviation of the residuals */
double harmonic_sigma(const struct harmonic *harmonic, int unknowns);
/* Returns the lag-1 autocorrelation of the residuals of the samples used. */
double residual_autocorrelation(const struct samples *samples, const double *residual);

/* ---- widening.c ---- */

/*
 * Factors by which variances are larger than independent residuals would make them: of amplitude
 * and decay, of phase and frequency, of the offset.
 */
struct widening {
    double amplitude, phase, offset;
};

struct oscillation {
    /* exp(-gamma s/2) (a cos(omega s) + b sin(omega s)), s = t - origin */
    double a, b, omega, gamma, origin;
};

/* Number `fitted` is that of the parameters of amplitude and decay together, as many as of phase
 * and frequency. */
struct widening residual_widening(const struct samples *samples, const double *residual,
                                  const struct oscillation *oscillation, int fitted);

/* n(1 - rho)/(1 + rho) instead of n independent residuals: the factor by which variances grow (>=
 * 1). */
double autocorrelation_factor(double rho);

/*
 * Returns the factor by which the variance of the slope of a line through n times of cycles grows
 * where its residuals have that lag-1 autocorrelation: as of an autoregressive process, or of a
 * random walk, where each cycle begins some random time after the one before.
 */
double line_correlation_factor(double rho, double n);

/* ---- the start of every analysis of an oscillation (motion.c) ---- */

struct swing_segment {
    size_t begin, end; /* samples [from, to) */
    /* local harmonic fit, see struct harmonic; its origin is the middle of the segment */
    double a, b, c;
    /* robust standard deviation of its residuals, where they fall like the amplitude: in the
     * middle */
    double scale;
    double rms; /* rms of the part of the model with a and b */
    bool settled;
};

struct motion {
    struct samples samples; /* `use` leaves out spikes, rejected and clipped samples */
    struct overview overview;
    struct harmonic harmonic;      /* damped sine, robust */
    double *residual;              /* [n] of it */
    double *scratch;               /* [n] */
    struct swing_segment *segment; /* [segments] two periods each, one after the other */
    size_t segments;
    double quantum; /* step to which values are rounded (noise of quantum/sqrt(12)), or 0 */
    double autocorrelation;
    bool tracked; /* followed window by window; the damped sine is only the nearest one */
    bool buried;  /* buried in noise, so that no part of it has to be examined */
    size_t rejected, clipped; /* clipped are counted in rejected */
};

/* Returns false if out of memory. harmonic and the members after it are filled only if
 * overview.oscillates is true. */
bool motion_init(struct motion *motion, const struct series *series, struct arena *arena,
                 const struct cancel *cancel);
/* Fits one damped sine to the whole series and looks no further where it does not fit. Returns
 * false if out of memory or cancelled. */
bool motion_one_sine(struct motion *motion, const struct series *series, struct arena *arena);
/* The same as motion_init(). Returns false with an error if out of memory or cancelled. */
bool motion_find(struct motion *motion, const struct series *series, struct arena *arena,
                 const struct cancel *cancel, struct error *error);
/* Returns true if all values are the same but for rounding. */
bool overview_is_constant(const struct overview *overview);
struct mode_pair;
struct swing;
/* Sets the error that says why it does not oscillate, or that it is two lines, or which part of it
 * does; NULL where there are none. Returns false. */
bool motion_refuse_known(const struct motion *motion, const struct mode_pair *pair,
                         const struct swing *swing, struct error *error);
/* The same as motion_find(), refusing what does not oscillate with the reason, and with the window
 * of the part that does. */
bool motion_require(struct motion *motion, const struct series *series, struct arena *arena,
                    const struct cancel *cancel, struct error *error);

/*
 * Returns the relative standard uncertainty of the period that the step of the sensor leaves open
 * where every period reads the same: its rounding errors do not average out, and no scatter shows
 * them. 0 where readings differ.
 */
double quantum_pace(const struct motion *motion);

/* ---- swing.c ---- */

/* The longest part of a series that one damped sine describes. */
struct swing {
    double window[2];  /* [s] times of its first and last sample */
    double period;     /* [s] */
    size_t begin, end; /* samples [from, to) */
};

/*
 * Looks for a part that oscillates in a series that does not as a whole: a step or a knock comes
 * before it, rest or a hand after it. Returns false if there is none, if it is the whole series, or
 * if out of memory.
 */
bool find_swing(const struct series *series, struct swing *swing);
/* The same for the first swings after rest, however few, where offset or damping change later. */
bool find_first_swing(const struct series *series, struct swing *swing);

/* ---- robust.c ---- */

/*
 * Clears `use` of missed echoes, two periods at a time, with the motion's omega and gamma; fills
 * segment, rejected, clipped and improves overview.noise. Returns false if out of memory.
 */
bool reject_outliers(struct motion *motion, struct arena *arena);

/* ---- clipping.c ---- */

/* Clears `use` of what is censored by a ceiling that the damped sine reveals; updates the harmonic,
 * its residuals and the counts. Returns false if out of memory. */
bool censor_clipped(struct motion *motion, struct arena *arena);

/* ---- samples.c ---- */

/* Returns false with the reason unless there are more samples than parameters. */
bool enough_samples(const struct series *series, int parameters, struct error *error);

/* ---- spectrum.c ---- */

/*
 * Transforms to the order of gsl_fft_real_radix2_transform: real parts from 0 up, imaginary parts
 * from n down. n is a power of two; scratch [n] may be NULL for n <= 2^17. Returns false if
 * cancelled.
 */
bool transform_real(double *data, size_t n, double *scratch, const struct cancel *cancel);

/* ---- correlation.c ---- */

/* Returns the normalised correlation of a series with itself at all shifts [n], its straight line
 * taken off; NULL if out of memory or cancelled. *grid [n]: what is left of it at equal times. */
double *series_correlations(const struct series *series, struct arena *arena, double **grid);
/* Makes a series of at most that many means of `each` neighbours: of the stretch next to
 * the middle in which the values move. Returns false if out of memory. */
bool series_lively_part(const struct series *series, size_t each, size_t rows, struct arena *arena,
                        struct series *part);

/* Returns the angular frequency of the highest peak [rad/s], or NAN if none is inside the band.
 * Sets *memory to false if out of memory. */
double peak_frequency(const struct samples *samples, bool *memory);
/* Sets omega [max] to the highest peaks [rad/s] of the mean spectrum of that many parts: of many, a
 * frequency that drifts has a line. Returns how many there are. *memory becomes false without
 * memory.
 */
int mean_spectrum_peaks(const struct samples *samples, size_t parts, double *omega, int max,
                        bool *memory);
/* The same of the whole, of 8 and of 32 parts. */
int spectrum_candidates(const struct samples *samples, double *omega, int max, bool *memory);
/* Returns true if the second or third harmonic of a period stands out of what lies between them. */
bool series_has_harmonics(const struct series *series, double period);
/* Returns the share of the power that lies about the highest peaks, within a ratio (its logarithm)
 * of each; 0 if out of memory. */
double power_share_of_peaks(const struct samples *samples, int peaks, double ratio_log,
                            struct arena *arena);

/* ---- crossing.c ---- */

/* Returns 1 or -1 if the value is above or below a level by more than the hysteresis, else 0. */
static inline int level_side(double deviation, double hysteresis)
{
    if (deviation > hysteresis)
        return 1;
    return deviation < -hysteresis ? -1 : 0;
}

/* Returns true if there is so little noise that interpolation is better than averaging. */
bool overview_is_exact(const struct overview *overview);

/* ---- peak.c ---- */

/* Returns the variance of one sample in white noise that has as much power as the residuals have
 * about omega, where a line is. */
double variance_beside(const struct samples *x, const double *residual, double omega);

/* ---- modes.c ---- */

struct mode_pair {
    double period[2], beat; /* [s] */
    double left;            /* share of the power that both leave */
};

/* Returns true if it is two damped sines, and one alone is far from it. */
bool two_lines(const struct samples *samples, struct mode_pair *pair);

/* ---- amplitude.c ---- */

/* Fits a harmonic locally to the samples [from, to) with the motion's omega and gamma. Returns
 * false if there are too few samples. */
bool local_amplitude(const struct motion *motion, size_t begin, size_t end,
                     struct reading *reading);

/* ---- envelope.c ---- */

/* Rates of an envelope. */
struct envelope_rates {
    double gamma, q; /* [1/s]: exp(-gamma s/2)/(1 + q phi(s)) */
};

/*
 * Fits linear, quadratic and linear+quadratic drag to the envelope. *sway is the scatter of the
 * amplitudes about the best of them, relative to their size, if it exceeds their noise, else 0; NAN
 * if there are too few readings. Sets the rates of those of the three that were found. Returns
 * false if out of memory.
 */
bool envelope_laws(const struct motion *motion, double *sway, struct envelope_rates rates[3]);

/* ---- laws.c ---- */

struct law_fit;

/* Chooses among the laws' fits. Returns the place of the law that the fit's values are to be those
 * of. */
struct law_evidence {
    const struct law_fit *fit; /* [DRAG_LAWS] */
    double variance;           /* [y^2] of one independent residual */
    double freedom;            /* degrees of freedom of this variance */
    double loss[DRAG_RATES];   /* energy that a rate of 1 takes */
};

int law_choose(const struct law_evidence *evidence, struct fit *fit);

/* ---- drag.c ---- */

/*
 * Fits the whole oscillation under every law, starting from the rates, and chooses. Also for a
 * velocity or an acceleration, b and f are those of the position. If `forces` is true, the
 * restoring force is searched for, too. The motion's samples and residuals are then those of the
 * law.
 */
bool drag_laws(struct motion *motion, enum quantity quantity, bool forces,
               const struct envelope_rates rates[3], struct arena *arena, struct fit *fit,
               struct error *error);

/* ---- warnings.c ---- */

void fit_warn(struct fit *fit, const char *format, ...) PRINTF_LIKE(2, 3);
/* Adds warnings to the fit; sway is that of envelope_laws(). */
void fit_diagnose(const struct motion *motion, double sway, struct fit *fit);
