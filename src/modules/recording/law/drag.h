/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Functions that the files of the fit of laws share. */
#pragma once

#include "modules/recording/law/law_fit.h"

/* Places among a fit's parameters; windows from which slow changes are read. */
enum { START, SPEED, OMEGA, FIRST_RATE, DRAG_WINDOWS_MIN = 8 };

/* mean square, relative, to which integration is good: no law is better than that */
#define INTEGRATION_ROUNDING_SQUARED 1e-16

#define DELTA_MIN 6.0           /* least difference of BIC for a claim */
#define CHANCE_MAX 0.001        /* F-test chance below which a further term is claimed */
#define HIDDEN_TERM_CHANCE 0.01 /* F-test chance below which a further term counts as possible */
/* Largest part of the loss, or of the force, that a further term may have (two standard
 * deviations). */
#define SHARE_MAX 0.2
/* Widening of the variance above which slow changes count, so that windows are the independent
 * data. */
#define DRAG_WIDENED 1.05

struct drag_fitting {
    struct motion *motion;
    struct law_samples samples;
    unsigned char *use; /* [n] */
    size_t *edge;       /* [2 + n/..] of blocks */
    double rounding;    /* [y^2] rounding of a sum of squares */
    double size;        /* amplitude, as y */
    double t0;
    struct equation start; /* values of the linear law */
    double rate[DRAG_RATES];
    struct law_fit fit[DRAG_LAWS];
};

struct drag_factors {
    double amplitude, phase; /* factors of variances */
    double windows;
    double lag; /* autocorrelation of neighbours */
    double sigma;
    double signal; /* rms of the motion alone */
};

/* Places of the fit's parameters among the equation's; their number. */
int drag_indices(enum drag_law law, enum restoring_force force, int index[LAW_PARAMETERS]);

/* ---- drag_report.c ---- */

bool drag_factors(const struct drag_fitting *f, const struct law_fit *fit,
                  struct drag_factors *factors);
void drag_losses(const struct drag_fitting *f, const struct law_fit *fit, double loss[DRAG_RATES]);
void drag_describe(const struct law_fit *fit, int i, double deviation,
                   struct drag_candidate *candidate);
bool drag_report_offset(struct drag_fitting *f, const struct law_fit *fit,
                        const struct drag_factors *factors, struct arena *arena,
                        struct fit *result);
void drag_report(const struct drag_fitting *f, int i, const struct drag_factors *factors,
                 struct fit *result);

/* ---- restoring.c ---- */

/*
 * Fits each restoring force with linear and quadratic damping, in windows that grow, and chooses by
 * BIC and F-test: fills drag->restoring, force, forces_remaining, and best. If `angle`, it may be a
 * pendulum. Returns false if the residuals of the nearest force cannot be computed, or if
 * cancelled.
 */
bool restoring_choose(struct drag_fitting *f, bool angle, struct drag_fit *drag,
                      struct law_fit *best);
