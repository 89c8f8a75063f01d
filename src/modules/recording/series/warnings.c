/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Warnings about a fit that a user should know before using it. */
#include <hooke/base/number.h>
#include "modules/recording/series/internal.h"

#include <math.h>
#include <stdio.h>

/* Relative modulation of the amplitude above which a warning is given. */
#define SWAY_MIN 0.03
/* The model misses something if residuals over signal (rms) exceed POOR_MIN, and either residuals
 * over noise or their autocorrelation exceed the other two limits. */
#define POOR_MIN 0.10
#define POOR_NOISES 1.5
#define POOR_TOGETHER 0.3

void fit_warn(struct fit *fit, const char *format, ...)
{
    if (fit->warnings < (int)COUNT_OF(fit->warning)) {
        va_list args;
        va_start(args, format);
        vsnprintf(fit->warning[fit->warnings], sizeof fit->warning[0], format, args);
        va_end(args);
        fit->warnings++;
    }
}

/* Warns if gamma or the period differs between the halves of the window by more than chance and by
 * a size that matters. */
static void warn_halves(struct fit *fit)
{
    const struct measured *a = &fit->halves[0], *b = &fit->halves[1];
    double difference = a->value - b->value, sigma = hypot(a->uncertainty, b->uncertainty);
    const bool differ =
        fabs(difference) > HALVES_DIFFER * sigma && fabs(difference) > 0.1 * fabs(fit->gamma.value);
    if (differ && fit->drag.candidates == 0) { /* compared laws describe the decay better */
        struct buffer first = {0}, second = {0};
        buffer_uncertain(&first, a->value, a->uncertainty);
        buffer_uncertain(&second, b->value, b->uncertainty);
        if (!first.failed && !second.failed)
            fit_warn(fit,
                     "the decay is not one exponential: gamma is %s 1/s in the first half and %s "
                     "1/s in the second (%s; 'fit drag' compares the laws)",
                     first.data, second.data,
                     difference > 0 ? "as for drag that grows with speed" : "as for dry friction");
        buffer_free(&first);
        buffer_free(&second);
    }
    const struct measured *p = fit->half_periods;
    difference = p[0].value - p[1].value;
    if (fabs(difference) > HALVES_DIFFER * hypot(p[0].uncertainty, p[1].uncertainty) &&
        fabs(difference) > 2e-4 * p[0].value) {
        fit_warn(fit, "the period drifts: %.5g s in the first half, %.5g s in the second",
                 p[0].value, p[1].value);
    }
}

/* Warns of beats if there are two frequencies, or of another modulation of the amplitude by the
 * share `sway`, which is mostly sideways motion. `poor` is the ratio of residuals to signal. */
static void warn_sway(const struct motion *m, double sway, double poor, struct fit *fit)
{
    struct mode_pair pair;
    if (!(sway > SWAY_MIN) && !(poor > POOR_MIN)) {
        return;
    }
    if (two_lines(&m->samples, &pair)) {
        fit_warn(fit,
                 "there are two frequencies, T = %.5g and %.5g s, which beat every %.4g s; try "
                 "'fit modes 2'",
                 pair.period[0], pair.period[1], pair.beat);
    } else if (sway > SWAY_MIN) {
        fit_warn(fit,
                 "the amplitude is modulated by about %.0f %% (rms), perhaps by sideways motion",
                 100 * sway);
    }
}

/* Returns residuals over signal, both rms, of the law whose values the fit has, or 0 if the
 * residuals are noise and no fault of the model. */
static double poorness(const struct motion *m, const struct fit *fit)
{
    double signal = 0;
    if (fit->drag.candidates > 0)
        return fit->rms / fit->drag.signal;
    for (size_t i = 0; i < m->samples.n; i++) {
        double model = m->samples.use[i] ? m->samples.y[i] - m->residual[i] - m->harmonic.c : 0;
        signal += model * model;
    }
    const bool noise =
        fit->rms < POOR_NOISES * m->overview.noise && m->autocorrelation < POOR_TOGETHER;
    return noise ? 0 : fit->rms * sqrt((double)m->harmonic.used / signal);
}

/* Adds the warnings of a fit of a damped sine to *fit, in a fixed order, the most fundamental
 * first. `sway` is the relative slow change of the amplitude. */
void fit_diagnose(const struct motion *m, double sway, struct fit *fit)
{
    const struct harmonic *h = &m->harmonic;
    if (m->overview.periods < 3) {
        fit_warn(fit,
                 "the window has only %.2g periods, so frequency and offset are poorly separated",
                 m->overview.periods);
    }
    if (fit->gamma.value < -2 * fit->gamma.uncertainty) {
        fit_warn(fit, "gamma is negative: the amplitude grows; check that neither a hand nor a "
                      "drive acts within the window");
    }
    if (fit->drag.wander > 0) {
        fit_warn(fit,
                 "the offset wanders by %.2g %% of the amplitude (rms); a parabola every three "
                 "periods was subtracted",
                 100 * fit->drag.wander / fit->amplitude.value);
    }
    const double poor = poorness(m, fit);
    warn_sway(m, sway, poor, fit);
    if (h->gamma != 0) {
        warn_halves(fit);
    }
    if (m->clipped > 0) {
        fit_warn(fit,
                 "%zu samples are left out because the fit goes beyond flat tops (clipped) there",
                 m->clipped);
    }
    if (m->rejected > m->clipped) {
        fit_warn(fit,
                 "%zu of %zu samples rejected (missed echoes, spikes): off by more than 5 robust "
                 "standard deviations",
                 m->rejected - m->clipped, m->samples.n);
    }
    if (h->drifts) {
        double span = m->samples.t[m->samples.n - 1] - m->samples.t[0];
        fit_warn(fit,
                 "the offset drifts by %.2g %% of the amplitude over the window; a straight line "
                 "was fitted to it",
                 100 * fabs(h->d) * span / fit->amplitude.value);
    }
    if (poor > POOR_MIN) {
        fit_warn(fit, "the model fits poorly: the residuals of %s are %.0f %% of the signal (rms)",
                 fit->drag.candidates > 0 ? drag_law_name(fit->drag.best) : "a damped sine",
                 100 * poor);
    }
}
