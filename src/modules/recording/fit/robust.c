/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rejection of missed echoes around a least-squares fit, segment by segment. Every rejected sample
 * is counted. */
#include "modules/recording/series/internal.h"

#include <math.h>
#include <string.h>

/* Deviation, in robust standard deviations, from which on a sample is rejected. */
#define REJECT_AT 5.0
/* Smaller deviations, relative to the amplitude, are errors of the model and reject nothing. */
#define EXACT_AMPLITUDE_FRACTION 1e-7

/* Fits a, b, c of the harmonic to one segment, with the whole's frequency and damping, and sets
 * residuals, scale and rms of the segment. Slow changes (sway, another law of drag, drift) go into
 * a, b, c and reject nothing. */
static void fit_segment(struct motion *m, struct swing_segment *s)
{
    struct samples part = samples_part(&m->samples, s->begin, s->end);
    struct harmonic h = {
        .a = s->a, .b = s->b, .c = s->c, .omega = m->harmonic.omega, .gamma = m->harmonic.gamma};
    h.origin = 0.5 * (part.t[0] + part.t[part.n - 1]);
    s->settled = true;
    if (!harmonic_fit(&part, FREE_LINEAR, &h, m->residual + s->begin)) {
        /* Too few good samples are left to judge the others. */
        memset(m->residual + s->begin, 0, part.n * sizeof(double));
        return;
    }
    s->a = h.a;
    s->b = h.b;
    s->c = h.c;
    /* Errors of the model are proportional to the amplitude, so the scale refers to the middle. */
    double square = 0,
           growth = exp(0.5 * h.gamma * (part.t[part.n - 1] - part.t[0]) / (double)(part.n - 1));
    double weight = exp(0.5 * h.gamma * (part.t[0] - h.origin));
    for (size_t i = 0; i < part.n; i++, weight *= growth) {
        double r = m->residual[s->begin + i], model = part.y[i] - r - h.c;
        square += model * model;
        m->scratch[i] = fabs(r) * weight;
    }
    s->scale = MAD_TO_SIGMA * values_quantile(m->scratch, part.n, 0.5);
    s->rms = sqrt(square / (double)part.n);
}

/* Marks the samples to use: those whose residual is within REJECT_AT of the segment's scale or the
 * typical one. Counts m->rejected. Returns the number of samples whose mark changed. */
static size_t update_mask(struct motion *m, double typical)
{
    size_t changed = 0;
    double exact = EXACT_AMPLITUDE_FRACTION * hypot(m->harmonic.a, m->harmonic.b);
    m->rejected = 0;
    for (size_t k = 0; k < m->segments; k++) {
        struct swing_segment *s = &m->segment[k];
        double duration = m->samples.t[s->end - 1] - m->samples.t[s->begin];
        double fall = exp(-0.5 * m->harmonic.gamma * duration / (double)(s->end - s->begin));
        double local = s->scale * exp(0.25 * m->harmonic.gamma * duration);
        for (size_t i = s->begin; i < s->end; i++, local *= fall) {
            bool use = fabs(m->residual[i]) <= REJECT_AT * fmax(local, typical) + exact;
            if (use != (m->samples.use[i] != 0)) {
                m->samples.use[i] = use;
                s->settled = false;
                changed++;
            }
            m->rejected += !use;
        }
    }
    return changed;
}

/* Divides the motion into segments of two periods, and repeats local fits and rejection of outliers
 * until the marks settle; lowers the estimate of the noise to the residuals. Returns false if out
 * of memory. */
bool reject_outliers(struct motion *m, struct arena *arena)
{
    enum { ROUNDS = 30, LEAST = 24 };
    double span = m->samples.t[m->samples.n - 1] - m->samples.t[0],
           max = (double)(m->samples.n / LEAST);
    m->segments = (size_t)fmax(1, fmin(max, floor(0.25 * m->harmonic.omega * span / PI)));
    m->segment = arena_array(arena, m->segments, sizeof *m->segment);
    if (!m->segment) {
        return false;
    }
    for (size_t k = 0; k < m->segments; k++) {
        m->segment[k].begin = m->samples.n * k / m->segments;
        m->segment[k].end = m->samples.n * (k + 1) / m->segments;
    }
    double typical = 0, rounding = m->quantum / sqrt(12.0);
    for (int round = 0; round < ROUNDS; round++) {
        for (size_t k = 0; k < m->segments; k++) {
            if (!m->segment[k].settled) {
                fit_segment(m, &m->segment[k]);
            }
        }
        for (size_t k = 0; k < m->segments; k++) {
            m->scratch[k] = m->segment[k].scale;
        }
        typical = fmax(values_quantile(m->scratch, m->segments, 0.5), rounding);
        if (update_mask(m, typical) == 0) {
            break;
        }
    }
    m->overview.noise = fmax(fmin(m->overview.noise, typical), rounding);
    return true;
}
