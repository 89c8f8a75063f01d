/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the files of the analysis (series, period, fit, law, modes) share and others do
 * not call. An analysis of an oscillation starts with motion_find() or motion_require(): prepare
 * samples, estimate noise, fit a robust damped sine. */
#pragma once

#include "modules/recording/series/analysis.h"
#include "modules/recording/table/load.h"
#include <hooke/base/numeric.h>

struct cancel;

/* Standard deviations above which two halves of a window are said to differ. */
#define HALVES_DIFFER 2.5

/* ---- a series with a mask, and robust statistics (samples.c) ---- */

/* Returns the index of the first sample at or after t [s]. */
static inline size_t samples_index(const struct samples *samples, double t)
{
    return first_from(samples->t, samples->n, t);
}
/* Returns the samples begin to end - 1; memory is shared. */
struct samples samples_part(const struct samples *samples, size_t begin, size_t end);
/* Sets *means to means of `each` neighbours, of those in use (all, if use is NULL), at their mean
 * times. A group without samples in use gives no mean, nor does an incomplete group at the end.
 * Memory is the arena's. Returns false if out of memory. */
bool samples_average(const struct samples *samples, size_t each, struct arena *arena,
                     struct series *means);
/* Returns the mean square of n values about their mean. */
double values_variance(const double *y, size_t n);
/* Returns the part with the most rows that contains no gap. A gap is a time step longer than an
 * eighth of the period [s] and than six mean steps. Memory is shared. */
struct series series_longest_stretch(const struct series *series, double period);
/* Values of lost_share_max in series_thin(): if amplitudes are read from the means; if they serve
 * a hint or a warning only; if times are read, which averaging does not move. */
#define THIN_KEEPS_LINES 1e-3
#define THIN_FOR_HINTS 1e-2
#define THIN_FOR_PERIOD 3e-2
/* Sets *thin to means of 2, 4, 8, ... neighbours of a long series: the largest number that loses no
 * more of the variance than white noise explains and the share lost_share_max. Without noise the
 * share is THIN_KEEPS_LINES. A short series, or one that is mostly noise, is returned unchanged.
 * use [n], or NULL, marks the rows that count. Returns false if out of memory. */
bool series_thin(const struct series *series, const unsigned char *use, double lost_share_max,
                 struct arena *arena, struct series *thin);
/* Returns the first sample from which on no motion is visible, even after a strong decay, or n if
 * the motion lasts. period is in seconds. */
static inline size_t samples_quiet(const struct samples *x, double period)
{
    return motion_quiet(&(struct motion_rows){x->t, x->y, x->use, 1, x->n}, period);
}
/* Returns true if a time step is at least 8 times the median step; evenly timed samples have no
 * gap. Sets *memory to false if out of memory. */
bool samples_have_gap(const struct samples *samples, struct arena *arena, bool *memory);
/* Amplitude spectrum under a Hann window over the whole span of times, including gaps: the height
 * of a line is its amplitude. */
struct spectrum {
    double *amplitude; /* [bins], in the unit of y */
    /* Number of frequencies, from 0 up to half the rate of the samples; 0 if there are too few
     * samples. */
    size_t bins;
    double step; /* [Hz] distance between bins */
};
/* Computes the spectrum. Returns false if out of memory or if cancelled. */
bool samples_spectrum(const struct samples *samples, struct arena *arena,
                      struct spectrum *spectrum);
/* Returns the step to which values are rounded (the sensor's resolution): the smallest difference
 * of neighbours or a simple fraction of it, if nearly all differences are multiples of it; else
 * 0. */
double samples_quantum(const struct samples *samples);
/* Clears `use` of short, far excursions (missed echoes) before a spectrum is computed. scratch [n]
 * is work space. */
void samples_flag_spikes(struct samples *samples, double *scratch);

/* ---- the harmonic: y = c + d s + exp(-gamma s/2) (a cos(omega s) + b sin(omega s)) (harmonic.c)
 * ---- */

enum { LINEAR_A, LINEAR_B, LINEAR_C, LINEAR_D, RATE_OMEGA, RATE_GAMMA, HARMONIC_PARAMETERS };

/* Number of leading parameters, in the order above, that a fit may change. d is changed only if
 * `drifts` is true. */
enum harmonic_free { FREE_LINEAR = 4, FREE_OMEGA = 5, FREE_GAMMA = 6 };

/* A damped sine with a straight baseline, and the result of fitting it. */
struct harmonic {
    double a, b, c; /* as y */
    double d;       /* [y/s] drift of the offset, 0 unless it drifts */
    bool drifts;    /* true if d is a parameter */
    double omega;   /* [rad/s] */
    double gamma;   /* [1/s] */
    double origin;  /* [s] time from which s counts */
    /* results of the fit */
    /* Results of the fit, from here on. (J^T J)^-1 for the free parameters, 0 for the others. */
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
/* Returns the standard deviation of the residuals with that number of fitted parameters, or NAN if
 * there are too few samples. */
double harmonic_sigma(const struct harmonic *harmonic, int unknowns);
/* Returns the lag-1 autocorrelation of the residuals of the samples used. */
double residual_autocorrelation(const struct samples *samples, const double *residual);

/* ---- widening.c ---- */

/* Factors by which variances of parameters are larger than independent residuals would make them:
 * of amplitude and decay, of phase and frequency, of the offset. */
struct widening {
    double amplitude, phase, offset;
};

/* Parameters of a damped sine without baseline. */
struct oscillation {
    /* y = exp(-gamma s/2) (a cos(omega s) + b sin(omega s)), s = t - origin */
    double a, b, omega, gamma, origin;
};

/* Computes the factors for the residuals of an oscillation. `fitted` is the number of parameters
 * that determine amplitude and decay together, and also the number for phase and frequency. */
struct widening residual_widening(const struct samples *samples, const double *residual,
                                  const struct oscillation *oscillation, int fitted);

/* Returns the factor (>= 1) by which variances grow for residuals of lag-1 autocorrelation rho: n
 * of them count as n(1 - rho)/(1 + rho) independent ones. */
double autocorrelation_factor(double rho);

/* Returns the factor by which the variance of the slope of a straight line through n cycle times
 * grows if its residuals have lag-1 autocorrelation rho. High correlation is treated as a random
 * walk, in which each cycle begins a random time after the one before; lower as an autoregressive
 * process. */
double line_correlation_factor(double rho, double n);

/* ---- the start of every analysis of an oscillation (overview.c) ---- */

/* A segment of about two periods of a motion, judged separately for outliers. */
struct swing_segment {
    size_t begin, end; /* samples begin to end - 1 */
    /* Local harmonic fit, see struct harmonic; its origin is the middle of the segment. */
    double a, b, c;
    /* Robust standard deviation of the residuals in the middle of the segment. Residuals are
     * assumed to fall like the amplitude. */
    double scale;
    double rms;   /* rms of the oscillation (a and b) in the segment */
    bool settled; /* true if its mask has not changed since the last local fit */
};

/* Result of examining a series: which samples are usable, whether it oscillates, and the robust
 * damped sine. */
struct motion {
    struct samples samples; /* `use` leaves out spikes, rejected and clipped samples */
    struct overview overview;
    struct harmonic harmonic;      /* damped sine, robust */
    double *residual;              /* [n] data minus harmonic */
    double *scratch;               /* [n] work space */
    struct swing_segment *segment; /* [segments] consecutive */
    size_t segments;               /* 0 until reject_outliers() */
    double quantum;         /* step to which values are rounded (noise of quantum/sqrt(12)), or 0 */
    double autocorrelation; /* lag 1 of the residuals */
    /* The oscillation was followed window by window, because no single damped sine describes it;
     * the harmonic is only the nearest one. */
    bool tracked;
    /* Every sample is mostly noise, and means of neighbours show no oscillation: parts need not be
     * examined. */
    bool buried;
    /* Numbers of samples left out; clipped ones are included in rejected. */
    size_t rejected, clipped;
};

/* Examines the series with memory of the arena. `harmonic` and the members after it are valid only
 * if overview.oscillates is true. cancel may be NULL. Returns false if out of memory. */
bool motion_init(struct motion *motion, const struct series *series, struct arena *arena,
                 const struct cancel *cancel);
/* Fits one damped sine to the whole series, and gives up if it does not fit. Returns false if out
 * of memory or cancelled. */
bool motion_one_sine(struct motion *motion, const struct series *series, struct arena *arena);
/* Does the same as motion_init(), and sets the error. Returns false if out of memory or
 * cancelled. */
bool motion_find(struct motion *motion, const struct series *series, struct arena *arena,
                 const struct cancel *cancel, struct error *error);
/* Returns true if all values are equal, except for rounding. */
bool overview_is_constant(const struct overview *overview);
struct mode_pair;
struct swing;
/* Sets the error for a series that does not oscillate as a whole: it has two frequencies (pair),
 * only a part oscillates (swing), or the reason in the overview if both are NULL. Returns false. */
bool motion_refuse_known(const struct motion *motion, const struct mode_pair *pair,
                         const struct swing *swing, struct error *error);
/* Does the same as motion_find(), and refuses a series that does not oscillate: with the reason,
 * and with the window of the part that does. Returns true only for an oscillation. */
bool motion_require(struct motion *motion, const struct series *series, struct arena *arena,
                    const struct cancel *cancel, struct error *error);

/* Returns the relative standard uncertainty of the period that is due to the sensor's resolution
 * when every period reads the same: rounding errors then do not average out, and no scatter shows
 * them. Returns 0 if readings differ from period to period. */
double quantum_pace(const struct motion *motion);

/* ---- swing.c ---- */

/* The longest part of a series that one damped sine describes. */
struct swing {
    double window[2];  /* [s] times of its first and last sample */
    double period;     /* [s] */
    size_t begin, end; /* samples begin to end - 1 */
};

/* Searches a part that oscillates in a series that does not as a whole, because a step or knock
 * comes before it, or rest or a hand after it. Returns false if there is none, if it is the whole
 * series, or if out of memory. */
bool find_swing(const struct series *series, struct swing *swing);
/* Does the same for the first swings after rest, however few, if offset or damping change later. */
bool find_first_swing(const struct series *series, struct swing *swing);

/* ---- robust.c ---- */

/* Clears `use` of missed echoes, two periods at a time, with the motion's omega and gamma. Fills
 * the segments, counts the rejected and improves overview.noise. Returns false if out of memory. */
bool reject_outliers(struct motion *motion, struct arena *arena);

/* ---- clipping.c ---- */

/* Finds samples that are clipped by a ceiling which the damped sine reveals, and clears their
 * `use`; updates the harmonic, its residuals and the counts. Returns false if out of memory. */
bool censor_clipped(struct motion *motion, struct arena *arena);

/* ---- samples.c ---- */

/* Returns false with the error unless there are more samples than parameters. */
bool enough_samples(const struct series *series, int parameters, struct error *error);

/* ---- spectrum.c ---- */

/* Transforms real data [n] in place to the order of gsl_fft_real_radix2_transform: real parts from
 * 0 up, imaginary parts from n down. n is a power of two; scratch [n] may be NULL for n <= 2^17.
 * Returns false if cancelled. */
bool transform_real(double *data, size_t n, double *scratch, const struct cancel *cancel);

/* ---- correlation.c ---- */

/* Returns the normalised autocorrelation at all lags [n] of the series on an even time grid, with
 * its regression line subtracted; NULL if out of memory or cancelled. Sets *grid [n] to the values
 * on the grid. */
double *series_correlations(const struct series *series, struct arena *arena, double **grid);
/* Sets *part to at most `rows` means of `each` neighbours, taken from the stretch nearest to the
 * middle in which the values move. Returns false if out of memory. */
bool series_lively_part(const struct series *series, size_t each, size_t rows, struct arena *arena,
                        struct series *part);

/* Returns the angular frequency [rad/s] of the highest peak of the spectrum, or NAN if there is
 * none between drift and half the sampling rate. Sets *memory to false if out of memory. */
double peak_frequency(const struct samples *samples, bool *memory);
/* Sets omega [max] to the highest peaks [rad/s] of the mean spectrum of that number of parts. In
 * many parts, a frequency that drifts still has a line. Returns the number of peaks. Sets *memory
 * to false if out of memory. */
int mean_spectrum_peaks(const struct samples *samples, size_t parts, double *omega, int max,
                        bool *memory);
/* Collects the peaks of the mean spectra of 1, 8 and 32 parts, as mean_spectrum_peaks() does. */
int spectrum_candidates(const struct samples *samples, double *omega, int max, bool *memory);
/* Returns true if the second or third harmonic of the period [s] stands out of the spectrum between
 * the harmonics, or if there are too few cycles to tell. */
bool series_has_harmonics(const struct series *series, double period);
/* Returns the share of the power that lies around the highest peaks, within a frequency ratio of
 * exp(ratio_log); 0 if out of memory. */
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

/* Returns the variance of white noise that has the same power density as the residuals have next to
 * the frequency omega [rad/s] of a line. */
double variance_beside(const struct samples *x, const double *residual, double omega);

/* ---- modes.c ---- */

/* Two damped sines with different frequencies. */
struct mode_pair {
    double period[2], beat; /* [s] */
    double left;            /* share of the power that both leave unexplained */
};

/* Returns true if the samples are a sum of two damped sines, and a single one is far from
 * describing them. */
bool two_lines(const struct samples *samples, struct mode_pair *pair);

/* ---- amplitude.c ---- */

/* Fits a harmonic with the motion's omega and gamma to the samples begin to end - 1. Returns false
 * if there are too few samples. */
bool local_amplitude(const struct motion *motion, size_t begin, size_t end,
                     struct reading *reading);

/* ---- envelope.c ---- */

/* Linear and quadratic damping of an amplitude. */
struct envelope_rates {
    /* [1/s] rates of the envelope exp(-gamma s/2)/(1 + q phi(s)), where phi is the integral of
     * exp(-gamma s/2) */
    double gamma, q;
};

/* Fits linear, quadratic and linear + quadratic drag to the envelope, and sets the rates of those
 * that were found. Sets *sway to the scatter of the amplitudes about the best of them, relative to
 * their size, if it exceeds their noise, else to 0; NAN if there are too few readings. Returns
 * false if out of memory. */
bool envelope_laws(const struct motion *motion, double *sway, struct envelope_rates rates[3]);

/* ---- laws.c ---- */

struct law_fit;

/* Fits of all laws of damping to the same samples, with what is needed to compare them. */
struct law_evidence {
    const struct law_fit *fit; /* [DRAG_LAWS] */
    double variance;           /* [y^2] of one independent residual */
    double freedom;            /* degrees of freedom of this variance */
    double loss[DRAG_RATES];   /* energy that each term would dissipate at a rate of 1 */
};

/* Chooses among the laws' fits and describes the choice in fit->drag. Returns the index of the law
 * whose values the fit takes. */
int law_choose(const struct law_evidence *evidence, struct fit *fit);

/* ---- drag.c ---- */

/* Fits the whole oscillation under every law of damping, starting from the rates, and chooses one.
 * For a velocity or an acceleration, b and f are still those of the position. If `forces` is true,
 * restoring forces are compared, too. The motion's samples and residuals are then those of the
 * chosen law. Returns false with the error if out of memory or cancelled. */
bool drag_laws(struct motion *motion, enum quantity quantity, bool forces,
               const struct envelope_rates rates[3], struct arena *arena, struct fit *fit,
               struct error *error);

/* ---- warnings.c ---- */

/* Adds a warning to the fit, formatted as by printf(); ignored if there is no space left. */
void fit_warn(struct fit *fit, const char *format, ...) PRINTF_LIKE(2, 3);
/* Adds the warnings that a user should read before using the fit; sway is that of
 * envelope_laws(). */
void fit_diagnose(const struct motion *motion, double sway, struct fit *fit);
