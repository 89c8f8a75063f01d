/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the files of the analysis layer share. */
#ifndef HOOKE_ANALYSIS_INTERNAL_H
#define HOOKE_ANALYSIS_INTERNAL_H

#include <hooke/analysis.h>

#define PI 3.14159265358979323846
#define TWO_PI 6.28318530717958647692
#define HALVES_DIFFER 2.5   /* standard deviations from which two halves are said to differ */
#define MAD_TO_SIGMA 1.4826 /* median |x| of normal noise -> its standard deviation */

/* ---- samples.c: a series with a mask, and robust statistics ---- */

struct samples {
    const double *t, *y;
    size_t n;
    double t0, dt; /* [s] where uniform: t = t0 + i dt to within the rounding of the times */
    bool uniform;
    unsigned char *use; /* [n] 1: takes part in fits, 0: rejected */
};

bool samples_init(struct samples *samples, const struct series *series, struct arena *arena); /* false: no memory */
struct samples samples_part(const struct samples *samples, size_t from, size_t to); /* [from, to), shares memory */
size_t samples_index(const struct samples *samples, double t);                      /* first sample at or after t [s] */
double samples_noise(const struct samples *samples, double *scratch);
void samples_flag_spikes(struct samples *samples, double *scratch); /* clears `use` of short far excursions */
double quantile(double *values, size_t n, double q);                /* reorders the values */

/* ---- harmonic.c: y = c + exp(-gamma s/2) (a cos(omega s) + b sin(omega s)), s = t - origin ---- */

enum { LINEAR_A, LINEAR_B, LINEAR_C, RATE_OMEGA, RATE_GAMMA, HARMONIC_PARAMETERS };

/* Which parameters a fit may change: the first so many of the list above. */
enum harmonic_free { FREE_LINEAR = 3, FREE_OMEGA = 4, FREE_GAMMA = 5 };

struct harmonic {
    double a, b, c; /* as y */
    double omega;   /* [rad/s] */
    double gamma;   /* [1/s] */
    double origin;  /* [s] */
    /* what the fit leaves behind */
    double inverse[HARMONIC_PARAMETERS][HARMONIC_PARAMETERS]; /* (J^T J)^-1 of the free parameters, else 0 */
    double rss;                                               /* sum of squared residuals of the samples used */
    size_t used;
    int iterations;
    bool converged;
};

/*
 * Least squares over samples->use from the given omega, gamma, origin (and a, b, c unless a and b are 0). residual [n]
 * or NULL: y - model, of all samples. False: too few samples or they do not determine the parameters; `harmonic` is
 * then not to be used. Where it returns true, look at `converged`.
 */
bool harmonic_fit(const struct samples *samples, enum harmonic_free unknowns, struct harmonic *harmonic,
                  double *residual);
double harmonic_sigma(const struct harmonic *harmonic, int unknowns); /* standard deviation of the residuals */
/* Lag-1 autocorrelation of the residuals of the samples used. */
double residual_autocorrelation(const struct samples *samples, const double *residual);
/* n(1 - rho)/(1 + rho) instead of n independent residuals: the factor by which variances grow (>= 1). */
double autocorrelation_factor(double rho);

/* ---- motion.c: what every analysis of an oscillation starts from ---- */

struct segment {
    size_t from, to; /* samples [from, to) */
    double a, b, c;  /* local harmonic fit, see struct harmonic; its origin is the middle of the segment */
    double scale;    /* robust standard deviation of its residuals, where they fall like the amplitude: in the middle */
    double rms;      /* of a, b part of the model */
    bool settled;
};

struct motion {
    struct samples samples; /* use: without spikes, rejected and clipped samples */
    struct overview overview;
    struct harmonic harmonic; /* damped sine, robust */
    double *residual;         /* [n] of it */
    double *scratch;          /* [n] */
    struct segment *segment;  /* [segments] two periods each, one after the other */
    size_t segments;
    double quantum; /* step to which values are rounded (noise of quantum/sqrt(12)), 0: none */
    double autocorrelation;
    size_t rejected, clipped; /* clipped are counted in rejected */
    struct ceiling {
        double high, low, band;
    } ceiling; /* where flat tops would be */
};

/* False: no memory. overview.oscillates tells the rest; harmonic and what follows it are filled only if it is true. */
bool motion_init(struct motion *motion, const struct series *series, struct arena *arena);
/* The same, refusing what does not oscillate with the reason. */
bool motion_require(struct motion *motion, const struct series *series, struct arena *arena, struct error *error);

/* ---- robust.c ---- */

/*
 * Clears `use` of missed echoes and clipped samples, two periods at a time, with the motion's omega and gamma; fills
 * segment, rejected, clipped and improves overview.noise. False: no memory.
 */
bool reject_outliers(struct motion *motion, struct arena *arena);

/* ---- spectrum.c ---- */

/* Angular frequency of the highest peak [rad/s], NAN: none inside the band. *memory becomes false without memory. */
double peak_frequency(const struct samples *samples, struct arena *arena, bool *memory);

/* ---- amplitude.c ---- */

/* Local harmonic fit to the samples [from, to) with the motion's omega and gamma. False: too few samples there. */
bool local_amplitude(const struct motion *motion, size_t from, size_t to, struct reading *reading);

/* ---- envelope.c ---- */

/*
 * Compares linear, quadratic and mixed drag on the envelope: fills preferred and evidence. *sway: scatter of the
 * amplitudes about the best law, relative to their size, where it is more than their noise, else 0; NAN: too few
 * readings to tell. False: no memory.
 */
bool envelope_laws(const struct motion *motion, struct fit *fit, double *sway);

/* ---- warnings.c ---- */

void fit_warn(struct fit *fit, const char *format, ...) PRINTF_LIKE(2, 3);
/* sway: what envelope_laws returned. */
void fit_diagnose(const struct motion *motion, double sway, struct fit *fit);

#endif
