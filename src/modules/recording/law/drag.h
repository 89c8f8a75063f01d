/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the files of the fit of laws share. drag.c fits all laws with law_fit.c,
 * drag_report.c turns fits into results, restoring.c chooses the restoring force. */
#pragma once

#include "modules/recording/law/law_fit.h"

/* Indices of a fit's parameters; smallest number of windows from which slow changes are
 * computed. */
enum { START, SPEED, OMEGA, FIRST_RATE, DRAG_WINDOWS_MIN = 8 };

/* Relative mean square to which integration is accurate; no law is fitted better. */
#define INTEGRATION_ROUNDING_SQUARED 1e-16

#define DELTA_MIN 6.0           /* smallest difference of BIC for a claim */
#define CHANCE_MAX 0.001        /* largest F-test p value for claiming a further term */
#define HIDDEN_TERM_CHANCE 0.01 /* F-test p value below which a further term is possible */
/* Largest share of the loss, or of the force, that a term may have (at two standard deviations) to
 * be negligible. */
#define SHARE_MAX 0.2
/* Factor of the variance above which slow changes matter, so that windows are the independent
 * data. */
#define DRAG_WIDENED 1.05

/* State of the fits of all laws to one motion. */
struct drag_fitting {
    struct motion *motion;
    struct law_samples samples;
    unsigned char *use;      /* [n] 1 for samples that take part */
    size_t *edge;            /* [2] limits of the only block */
    double rounding;         /* [y^2] rounding of a sum of squares */
    double size;             /* amplitude, in the unit of y */
    double t0;               /* [s] time of the first sample */
    struct equation start;   /* values of the linear law from which fits start */
    double rate[DRAG_RATES]; /* rates from which single laws start */
    struct law_fit fit[DRAG_LAWS];
};

/* Effects of slow changes on variances, from drag_factors(). */
struct drag_factors {
    double amplitude, phase; /* factors of the variances of rates and of the frequency */
    double windows;          /* number of windows used */
    double lag;              /* lag-1 autocorrelation of the residuals */
    double sigma;            /* standard deviation of the residuals */
    double signal;           /* rms of the motion alone */
};

/* Sets index to the indices in the equation of the parameters of a fit with this law and force.
 * Returns their number. */
int drag_indices(enum drag_law law, enum restoring_force force, int index[LAW_PARAMETERS]);

/* ---- drag_report.c ---- */

/* Computes the effects of slow changes from the residuals of the fit, which are in the motion.
 * Returns false if the motion cannot be integrated or if cancelled. */
bool drag_factors(const struct drag_fitting *f, const struct law_fit *fit,
                  struct drag_factors *factors);
/* Sets loss to the energy per mass (up to a common factor) that a rate of 1 of each term would take
 * along the motion. */
void drag_losses(const struct drag_fitting *f, const struct law_fit *fit, double loss[DRAG_RATES]);
/* Fills the candidate of law i; deviation is the standard deviation of an independent residual. */
void drag_describe(const struct law_fit *fit, int i, double deviation,
                   struct drag_candidate *candidate);
/* Sets offset and drift of the result from the baseline of the fit. Returns false if out of memory
 * or cancelled. */
bool drag_report_offset(struct drag_fitting *f, const struct law_fit *fit,
                        const struct drag_factors *factors, struct arena *arena,
                        struct fit *result);
/* Sets the values of the result, under the names of the damped sine, from the fit of law i. */
void drag_report(const struct drag_fitting *f, int i, const struct drag_factors *factors,
                 struct fit *result);

/* ---- restoring.c ---- */

/* Fits each restoring force with linear and quadratic damping, in growing windows, and chooses by
 * BIC and F-test: fills drag->restoring, force, forces_remaining, and *best. If `angle`, a pendulum
 * is tried, too. Returns false if the residuals of the nearest force cannot be computed, or if
 * cancelled. */
bool restoring_choose(struct drag_fitting *f, bool angle, struct drag_fit *drag,
                      struct law_fit *best);
