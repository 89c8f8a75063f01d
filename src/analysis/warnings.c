/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a user should know about a fit before believing it. */
#include "internal.h"

#include <math.h>
#include <stdio.h>

#define SWAY_LEAST 0.03 /* relative modulation of the amplitude that is worth a word */
#define POOR_LEAST 0.10 /* residuals over signal (rms): the model misses something, */
#define POOR_NOISES 1.5   /* where they are more than noise */
#define POOR_TOGETHER 0.3 /* or hang together (autocorrelation) */

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

/* The k-th segment from one end of the window, 0 outermost. */
static const struct segment *segment_from(const struct motion *m, int end, size_t k)
{
    return &m->segment[end ? m->segments - 1 - k : k];
}

/*
 * A hand, a release or a rest at either end: the amplitude there is much less than further inside (where it is at least
 * as large as the decay allows), or no sine fits.
 */
static void warn_ends(const struct motion *m, struct fit *fit)
{
    size_t bad[2] = {0, 0}, reach = m->segments / 3;
    double fall =
        exp(-fmax(m->harmonic.gamma, 0) * m->overview.period); /* of the amplitude in a segment of two periods */
    for (size_t k = 0; k < m->segments; k++) {
        m->scratch[k] = m->segment[k].scale;
    }
    double typical = quantile(m->scratch, m->segments, 0.5);
    for (int end = 0; end < 2; end++) {
        for (; bad[end] < reach; bad[end]++) {
            const struct segment *s = segment_from(m, end, bad[end]);
            double here = sqrt(2.0) * s->rms, inside = 0, faded = 1;
            for (size_t k = bad[end] + 1; k <= bad[end] + reach; k++) {
                faded *= end ? fall : 1;
                inside = fmax(inside, faded * sqrt(2.0) * segment_from(m, end, k)->rms);
            }
            bool still = here < 0.6 * inside && inside > 6 * typical, rough = s->scale > fmax(0.3 * here, 5 * typical);
            if (!still && !rough) {
                break;
            }
        }
    }
    const struct samples *x = &m->samples;
    const size_t rest = samples_rest(x, TWO_PI / m->harmonic.omega);
    if (rest < x->n) { /* the laws with dry friction know what sticks */
        if (fit->drag.candidates == 0)
            fit_warn(fit, "it rests from %.4g s on, which no damped sine does: try window=%.4g..%.4g s", x->t[rest],
                     x->t[m->segment[bad[0]].from], x->t[rest - 1]);
    } else if (bad[0] + bad[1] > 0) {
        fit_warn(fit, "the %s of the window is no free oscillation (rest, hand or release): try window=%.4g..%.4g s",
                 bad[0] && bad[1] ? "start and the end"
                 : bad[0]         ? "start"
                                  : "end",
                 x->t[m->segment[bad[0]].from], x->t[m->segment[m->segments - 1 - bad[1]].to - 1]);
    }
}

static void warn_halves(struct fit *fit)
{
    const struct measured *a = &fit->halves[0], *b = &fit->halves[1];
    double difference = a->value - b->value, sigma = hypot(a->uncertainty, b->uncertainty);
    if (fabs(difference) > HALVES_DIFFER * sigma && fabs(difference) > 0.1 * fabs(fit->gamma.value)) {
        struct buffer first = {0}, second = {0};
        buffer_uncertain(&first, a->value, a->uncertainty);
        buffer_uncertain(&second, b->value, b->uncertainty);
        if (!first.failed && !second.failed)
            fit_warn(fit,
                     "the envelope is not one exponential: gamma is %s 1/s in the first half, %s 1/s in the second "
                     "(%s)",
                     first.data, second.data,
                     difference > 0 ? "drag that grows with speed does that" : "dry friction does that");
        buffer_free(&first);
        buffer_free(&second);
    }
    const struct measured *p = fit->half_periods;
    difference = p[0].value - p[1].value;
    if (fabs(difference) > HALVES_DIFFER * hypot(p[0].uncertainty, p[1].uncertainty) &&
        fabs(difference) > 2e-4 * p[0].value) {
        fit_warn(fit, "the period drifts: %.5g s in the first half, %.5g s in the second", p[0].value, p[1].value);
    }
}

/* Two lines clear of the noise beat: true; what else modulates the amplitude is mostly a swing sideways. poor: residuals
 * over signal. */
static bool warn_sway(const struct motion *m, double sway, double poor, struct fit *fit)
{
    struct mode_pair pair;
    if (!(sway > SWAY_LEAST) && !(poor > POOR_LEAST)) {
        return false;
    }
    if (two_lines(&m->samples, &pair)) {
        fit_warn(fit, "two frequencies: T = %.5g and %.5g s, which beat every %.4g s: try 'fit modes 2'",
                 pair.period[0], pair.period[1], pair.beat);
        return true;
    }
    if (sway > SWAY_LEAST) {
        fit_warn(fit, "the amplitude is modulated by about %.0f %% (rms): does it sway sideways?", 100 * sway);
    }
    return false;
}

/* Residuals over signal, both rms, of the law that the fit's values are those of; 0: they are noise, no fault of the
 * model. */
static double poorness(const struct motion *m, const struct fit *fit)
{
    double signal = 0;
    if (fit->drag.candidates > 0)
        return fit->rms / fit->drag.signal;
    for (size_t i = 0; i < m->samples.n; i++) {
        double model = m->samples.use[i] ? m->samples.y[i] - m->residual[i] - m->harmonic.c : 0;
        signal += model * model;
    }
    const bool noise = fit->rms < POOR_NOISES * m->overview.noise && m->autocorrelation < POOR_TOGETHER;
    return noise ? 0 : fit->rms * sqrt((double)m->harmonic.used / signal);
}

void fit_diagnose(const struct motion *m, double sway, struct fit *fit)
{
    const struct harmonic *h = &m->harmonic;
    if (m->overview.periods < 3) {
        fit_warn(fit, "only %.2g periods: frequency and offset are poorly separated", m->overview.periods);
    }
    if (fit->gamma.value < -2 * fit->gamma.uncertainty) {
        fit_warn(fit, "gamma is negative: the amplitude grows; is the window free of hands and of a drive?");
    }
    if (fit->drag.wander > 0) {
        fit_warn(fit, "the offset wanders, by %.2g %% of the amplitude (rms): a parabola every three periods is taken off",
                 100 * fit->drag.wander / fit->amplitude.value);
    }
    const double poor = poorness(m, fit);
    if (!warn_sway(m, sway, poor, fit)) { /* which an envelope that beats looks like at its ends */
        warn_ends(m, fit);
    }
    if (h->gamma != 0) {
        warn_halves(fit);
    }
    if (m->clipped > 0) {
        fit_warn(fit,
                 "%zu samples lie where the fit is beyond flat tops (clipped): they are left out, whatever they read",
                 m->clipped);
    }
    if (m->rejected > m->clipped) {
        fit_warn(fit, "%zu of %zu samples rejected (missed echoes, spikes): more than 5 robust standard deviations off",
                 m->rejected - m->clipped, m->samples.n);
    }
    if (h->drifts) {
        double span = m->samples.t[m->samples.n - 1] - m->samples.t[0];
        fit_warn(fit,
                 "the offset drifts, by %.2g %% of the amplitude over the window: a line of its own was fitted to it",
                 100 * fabs(h->d) * span / fit->amplitude.value);
    }
    if (poor > POOR_LEAST) {
        fit_warn(fit, "the model is poor: the residuals of %s are %.0f %% of the signal (rms)",
                 fit->drag.candidates > 0 ? drag_law_name(fit->drag.best) : "a damped sine", 100 * poor);
    }
}
