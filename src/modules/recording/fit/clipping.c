/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds samples with clipped tops (a nearer object echoes, or the sensor's range ends) and leaves
 * them out: y = min(level, model) + noise. Samples at which the model lies beyond the level are
 * censored, whatever they read. If they were judged by their reading, those that noise carries one
 * way would be used and the others dropped, and amplitude and decay would be wrong by many standard
 * deviations. */
#include "modules/recording/series/internal.h"

#include <math.h>
#include <string.h>

enum {
    /* Smallest number of censored samples from which a level can be computed. */
    CENSORED_MIN = 6,
    /* Largest number of iterations between level and sine. */
    ROUNDS = 25,
    /* The level has settled if at most one in this number of samples changes sides. */
    ROWS_A_CHANGE = 1 << 14,
};

/* Standard deviations by which a second or third harmonic must stand out of the noise. */
#define HARMONIC_CLEAR_SIGMAS 2.5
/* Chi-square by which a ceiling must explain the samples better than none (3 standard
 * deviations). */
#define GAIN_MIN 9.0
/* Values that vary by fewer resolution steps of the recording are rounded, not clipped. */
#define FLAT_RESOLVED_STEPS 1.5
/* Readings of a flat top scatter by at most this number of standard deviations of the noise, plus
 * this share of what the model does there. */
#define FLAT_NOISE_RATIO_MAX 3.0
#define FLAT_SHARE 0.02
/* Largest slope of the readings against the model beyond the level: it is 0 for a flat top, 1
 * without clipping. */
#define SLOPE_MAX 0.35

/* Returns true if the residuals contain a second or third harmonic of the oscillation, as a flat
 * top makes and noise does not. */
static bool has_harmonics(const struct motion *m)
{
    const struct harmonic *h = &m->harmonic;
    double sum[2] = {0, 0}, norm[2] = {0, 0}, phase = atan2(-h->b, h->a);
    for (size_t i = 0; i < m->samples.n; i++) {
        if (!m->samples.use[i])
            continue;
        double s = m->samples.t[i] - h->origin, e = exp(-1.5 * h->gamma * s),
               c = cos(h->omega * s + phase);
        double u[2] = {e * (2 * c * c - 1), e * c * (4 * c * c - 3)}; /* cos 2x, cos 3x */
        for (int k = 0; k < 2; k++) {
            sum[k] += u[k] * m->residual[i];
            norm[k] += u[k] * u[k];
        }
    }
    double sigma = harmonic_sigma(h, FREE_GAMMA),
           min = HARMONIC_CLEAR_SIGMAS * HARMONIC_CLEAR_SIGMAS * sigma * sigma;
    return sum[0] * sum[0] > min * norm[0] || sum[1] * sum[1] > min * norm[1];
}

/* Returns true if all residuals are so small that is_flat() could not tell a flat top from
 * rounding: at a flat top, residuals are about as large as the model's excess over the level. */
static bool is_rounding(const struct motion *m)
{
    static const double amplitude_share = 1e-5;
    const double max = fmax(0.5 * FLAT_RESOLVED_STEPS * m->quantum,
                            amplitude_share * hypot(m->harmonic.a, m->harmonic.b));
    for (size_t i = 0; i < m->samples.n; i++)
        if (m->samples.use[i] && fabs(m->residual[i]) > max)
            return false;
    return true;
}

/* Returns true if the residuals of the sine, beside noise, have more power than those of a square
 * wave would have: a quarter of the sine's own power. Flat tops (clipping) then do not explain the
 * misfit. */
static bool is_no_sine(const struct motion *m)
{
    /* a quarter, with a margin */
    static const double left_max = 0.3;
    double power = 0, left = 0;
    for (size_t i = 0; i < m->samples.n; i++)
        if (m->samples.use[i]) {
            const double r = m->residual[i], sine = m->samples.y[i] - r - m->harmonic.c;
            power += sine * sine;
            left += r * r - m->overview.noise * m->overview.noise;
        }
    return left > left_max * power;
}

/* A trial level on one side, the sine fitted to the samples that are not beyond it, and its
 * quality. */
struct censoring {
    struct harmonic harmonic;
    unsigned char *use; /* [n] 1 for samples that are used, without the censored ones */
    double *residual;   /* [n] data minus sine */
    /* Reading of the flat top, sum of squares, and slope of the readings against the model beyond
     * it. */
    double level, rss, slope;
    double excess;   /* largest distance of the model beyond the level */
    double scatter;  /* standard deviation of the censored readings about the level */
    size_t censored; /* number of samples beyond the level */
};

/* Finds the level at which tops (side 1) or bottoms (-1) are clipped, from a first level c->level
 * and a first sine: censors samples beyond the level, fits the others, and takes the mean of the
 * censored readings as the new level. Fills c. Returns false if too few samples are censored or the
 * fit fails. */
static bool settle_level(const struct motion *m, int side, const struct harmonic *start,
                         struct censoring *c)
{
    /* change of the level, relative to the amplitude and to its uncertainty */
    static const double small = 1e-6, unseen = 1e-2;
    struct samples x = m->samples;
    x.use = c->use;
    c->harmonic = *start;
    memcpy(c->use, m->samples.use, x.n);
    if (!harmonic_residuals(&x, start, c->residual))
        return false;
    for (int round = 0; round < ROUNDS; round++) {
        double sum = 0, counted = 0, previous = c->level;
        size_t changed = 0;
        c->censored = 0;
        for (size_t i = 0; i < x.n; i++) {
            bool is_clipped = side * (x.y[i] - c->residual[i] - c->level) > 0,
                 use = m->samples.use[i] && !is_clipped;
            changed += use != (c->use[i] != 0);
            c->use[i] = use;
            c->censored += is_clipped;
            sum += is_clipped && m->samples.use[i] ? x.y[i] : 0;
            counted += is_clipped && m->samples.use[i];
        }
        if (counted < CENSORED_MIN || !harmonic_fit(&x, FREE_GAMMA, &c->harmonic, c->residual) ||
            !c->harmonic.converged)
            return false;
        c->level = sum / counted;
        if (changed <= x.n / ROWS_A_CHANGE &&
            fabs(c->level - previous) <= fmax(small * hypot(c->harmonic.a, c->harmonic.b),
                                              unseen * m->overview.noise / sqrt(counted)))
            break;
    }
    /* Statistics of the censored readings: scatter about the level, and slope against the model. */
    c->excess = 0;
    double square = 0, xx = 0, xy = 0, mean_x = 0, mean_y = 0, counted = 0;
    for (size_t i = 0; i < x.n; i++) {
        double excess = x.y[i] - c->residual[i] - c->level, deviation = x.y[i] - c->level;
        if (m->samples.use[i] && !c->use[i]) {
            square += deviation * deviation;
            c->excess = fmax(c->excess, fabs(excess));
            xx += excess * excess;
            xy += excess * deviation;
            mean_x += excess;
            mean_y += deviation;
            counted++;
        }
    }
    c->scatter = sqrt(square / fmax(counted, 1));
    double spread = xx - mean_x * mean_x / fmax(counted, 1);
    c->rss = c->harmonic.rss + square;
    c->slope = spread > 0 ? (xy - mean_x * mean_y / counted) / spread : 1;
    return true;
}

/* Returns true if the censored readings are level. The wide trough of another wave form is not: its
 * readings vary with the model, by more than noise and rounding do. */
static bool is_flat(const struct motion *m, const struct censoring *c)
{
    return fabs(c->slope) < SLOPE_MAX && c->excess > FLAT_RESOLVED_STEPS * m->quantum &&
           c->scatter <= FLAT_NOISE_RATIO_MAX * m->overview.noise +
                             FLAT_RESOLVED_STEPS * m->quantum + FLAT_SHARE * c->excess;
}

/* Sets *some to the motion with only every k-th sample of a long recording, for a first search of
 * clipping levels: at least ROWS_MIN samples and ROWS_A_PERIOD in a period remain. A shorter one
 * shares the arrays of m. Returns false if out of memory. */
static bool motion_thin(const struct motion *m, struct arena *arena, struct motion *some)
{
    enum { ROWS_MIN = 4096, ROWS_A_PERIOD = 6 };
    const struct samples *x = &m->samples;
    const double period = TWO_PI / (m->harmonic.omega * x->dt);
    const size_t each =
        (size_t)fmax(fmin((double)(x->n / ROWS_MIN), floor(period / ROWS_A_PERIOD)), 1);
    const size_t n = x->n / each;
    *some = *m;
    if (each == 1)
        return true;
    double *t = arena_array(arena, n, sizeof *t), *y = arena_array(arena, n, sizeof *y);
    some->residual = arena_array(arena, n, sizeof *y);
    some->samples = (struct samples){.t = t,
                                     .y = y,
                                     .n = n,
                                     .t0 = x->t0,
                                     .dt = x->dt * (double)each,
                                     .uniform = x->uniform,
                                     .use = arena_alloc(arena, n),
                                     .cancel = x->cancel};
    if (!t || !y || !some->residual || !some->samples.use)
        return false;
    for (size_t i = 0; i < n; i++) {
        t[i] = x->t[i * each];
        y[i] = x->y[i * each];
        some->residual[i] = m->residual[i * each];
        some->samples.use[i] = x->use[i * each];
    }
    return true;
}

/* Searches the best clipping level on one side (1 above, -1 below): from several heights in the
 * thinned motion `some`, then once in all samples. Returns true with the best in *best if it
 * explains the samples better than no level; *trial is work space. */
static bool find_ceiling(const struct motion *m, const struct motion *some, int side,
                         struct censoring *best, struct censoring *trial)
{
    static const double heights[] = {0.95, 0.8, 0.6};
    const struct harmonic *h = &m->harmonic;
    const bool all = some->samples.n == m->samples.n;
    struct harmonic start = *h;
    double swing = 0, level = NAN, least = HUGE_VAL, settled = HUGE_VAL;
    bool found = false;
    for (size_t i = 0; i < m->samples.n; i++)
        if (m->samples.use[i])
            swing = fmax(swing, side * (m->samples.y[i] - m->residual[i] - h->c));
    for (size_t k = 0; k < COUNT_OF(heights) + !all; k++) {
        const bool last = k == COUNT_OF(heights);
        trial->level = last ? level : h->c + side * heights[k] * swing;
        /* A start between an earlier one and its result would lead to the same result. */
        if (!last && side * trial->level >= settled)
            continue;
        const struct motion *motion = last ? m : some;
        if (!isfinite(trial->level) || !settle_level(motion, side, last ? &start : h, trial))
            continue;
        settled = side * trial->level;
        if (!all && !last) {
            if (trial->rss < least && is_flat(m, trial)) {
                level = trial->level;
                least = trial->rss;
                start = trial->harmonic;
            }
            continue;
        }
        const double variance = trial->rss / (double)h->used;
        if (h->rss - trial->rss > GAIN_MIN * variance && is_flat(m, trial) &&
            !(found && trial->rss >= best->rss)) {
            struct censoring swap = *best;
            *best = *trial;
            *trial = swap;
            found = true;
        }
    }
    return found;
}

/* Searches for clipped tops, then for clipped bottoms, if the residuals suggest them, and leaves
 * their samples out of the motion's fit. Returns false if out of memory. */
bool censor_clipped(struct motion *m, struct arena *arena)
{
    size_t n = m->samples.n;
    if (is_rounding(m) || is_no_sine(m) || !has_harmonics(m))
        return true;
    struct censoring two[2] = {0};
    struct motion some;
    if (!motion_thin(m, arena, &some))
        return false;
    for (int k = 0; k < 2; k++) {
        two[k].use = arena_alloc(arena, n);
        two[k].residual = arena_array(arena, n, sizeof(double));
        if (!two[k].use || !two[k].residual)
            return false;
    }
    for (int side = 1; side >= -1; side -= 2) {
        struct censoring best = two[0], trial = two[1];
        if (find_ceiling(m, &some, side, &best, &trial)) {
            memcpy(m->samples.use, best.use, n);
            memcpy(m->residual, best.residual, n * sizeof(double));
            m->harmonic = best.harmonic;
            m->clipped += best.censored;
        }
    }
    m->rejected = 0;
    for (size_t i = 0; i < n; i++)
        m->rejected += !m->samples.use[i];
    m->clipped = m->clipped < m->rejected ? m->clipped : m->rejected;
    return true;
}
