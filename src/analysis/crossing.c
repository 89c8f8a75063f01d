/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Crossings of a level, and the period from the line through their times. */
#include "track.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { LONG_RECORD = 32768, NOISE_SAMPLES = 4096 };

#define WANES 0.7        /* amplitude between two maxima from which on it is looked for beats */
#define NEIGHBOURS 0.25  /* relative distance of two frequencies that beat */
#define SECOND_LEAST 0.1 /* amplitude of the second line */

#define HALF_WIDTH 0.1  /* [periods] samples on each side of a crossing that place it */
#define SHAPE 0.01      /* of the swing in the window: what decay and drift do to its shape */
#define NOISE_FREE 1e-6 /* of the amplitude: below, interpolation is better than averaging */

struct context {
    const struct series *series;
    double level, mean, noise;
    double omega; /* [rad/s] 0: unknown */
    double half;  /* [s] samples used on each side */
    bool exact;
};

static bool is_exact(const struct overview *o)
{
    return o->noise <= NOISE_FREE * 0.5 * (o->high - o->low);
}

/* Value at t of the polynomial through the `count` samples from `from` on (Neville). */
static double interpolate(const struct series *s, size_t from, size_t count, double t)
{
    double p[6];
    for (size_t i = 0; i < count; i++) {
        p[i] = s->y[from + i];
    }
    for (size_t k = 1; k < count; k++) {
        for (size_t i = 0; i + k < count; i++) {
            double a = s->t[from + i], b = s->t[from + i + k];
            p[i] = ((t - b) * p[i] + (a - t) * p[i + 1]) / (a - b);
        }
    }
    return p[0];
}

/* Noise-free: the root of the quintic through the six samples around the bracket [i - 1, i], by false position
 * (Illinois). */
static bool place_exact(const struct context *c, size_t i, struct crossing *out)
{
    const struct series *s = c->series;
    size_t count = s->n < 6 ? s->n : 6, from = i < 3 ? 0 : i - 3;
    from = from + count > s->n ? s->n - count : from;
    double a = s->t[i - 1], b = s->t[i], fa = s->y[i - 1] - c->level, fb = s->y[i] - c->level, t = a;
    double slope = (fb - fa) / (b - a), close = 1e-15 * (fabs(fa) + fabs(fb));
    int side = 0;
    for (int k = 0; k < 60; k++) {
        t = (a * fb - b * fa) / (fb - fa);
        double f = interpolate(s, from, count, t) - c->level;
        if (fabs(f) <= close) {
            break;
        }
        bool right = (f > 0) == (fb > 0);
        if (right) {
            b = t;
            fb = f;
            fa *= side > 0 ? 0.5 : 1;
        } else {
            a = t;
            fa = f;
            fb *= side < 0 ? 0.5 : 1;
        }
        side = right ? 1 : -1;
    }
    out->t = t;
    out->uncertainty = fabs(c->noise / slope);
    return isfinite(t);
}

/*
 * Two-parameter fit y - mean = p cos(omega s) + q sin(omega s)/omega, s = t - centre, to the samples within `half` of
 * the centre: a line that knows how a sine bends (a plain line where omega is unknown), so the window may be wide.
 * Samples five sigma off (missed echoes) are left out in the end.
 */
static bool place_fit(const struct context *c, double centre, struct crossing *out)
{
    const struct series *s = c->series;
    double p = 0, q = 0, target = c->level - c->mean;
    bool fitted = false;
    for (int pass = 0; pass < 4; pass++) {
        struct samples all = {.t = s->t, .n = s->n};
        size_t from = samples_index(&all, centre - c->half), used = 0;
        double cc = 0, cs = 0, ss = 0, cy = 0, sy = 0;
        for (size_t i = from; i < s->n && s->t[i] <= centre + c->half; i++) {
            double x = s->t[i] - centre, u = cos(c->omega * x), v = c->omega > 0 ? sin(c->omega * x) / c->omega : x;
            double y = s->y[i] - c->mean;
            if (fitted && pass > 1 && fabs(y - p * u - q * v) > 5 * c->noise + SHAPE * fabs(q) * c->half) {
                continue;
            }
            cc += u * u;
            cs += u * v;
            ss += v * v;
            cy += u * y;
            sy += v * y;
            used++;
        }
        double det = cc * ss - cs * cs;
        if (used < 3 || !(det > 1e-12 * cc * ss)) {
            return false;
        }
        p = (ss * cy - cs * sy) / det;
        q = (cc * sy - cs * cy) / det;
        double x = 0;
        for (int k = 0; k < 5; k++) {
            double u = cos(c->omega * x), v = c->omega > 0 ? sin(c->omega * x) / c->omega : x;
            x -= (p * u + q * v - target) / (q * u - p * c->omega * c->omega * v);
        }
        if (!(fabs(x) <= c->half)) {
            return false;
        }
        centre += x;
        out->uncertainty = c->noise * sqrt(ss / det) / fabs(q);
        /* p, q move with the centre: as seen from the new one the value is the target and the slope q' */
        double slope = q * cos(c->omega * x) - p * c->omega * sin(c->omega * x);
        p = target;
        q = slope;
        fitted = true;
    }
    out->t = centre;
    return true;
}

size_t series_crossings(const struct series *s, const struct overview *o, double level, struct crossing *out,
                        size_t room)
{
    double amplitude = 0.5 * (o->high - o->low), hysteresis = fmax(4 * o->noise, 0.05 * amplitude);
    struct context c = {.series = s, .level = level, .mean = level, .noise = o->noise};
    if (s->n < 4 || !(amplitude > 0)) {
        return 0;
    }
    double dt = (s->t[s->n - 1] - s->t[0]) / (double)(s->n - 1);
    c.exact = o->noise <= NOISE_FREE * amplitude;
    c.half = 5 * dt;
    if (o->oscillates) {
        c.omega = TWO_PI / o->period;
        c.mean = o->mean;
        c.half = fmax(HALF_WIDTH * o->period, 2 * dt);
    }
    size_t count = 0, since = 0; /* since: last sample clearly on the old side */
    int side = 0;
    for (size_t i = 0; i < s->n; i++) {
        double above = s->y[i] - level;
        int now = above > hysteresis ? 1 : above < -hysteresis ? -1 : 0;
        if (now == 0) {
            continue;
        }
        if (side == -now) {
            /* Noise may cross the level several times in between: start from the middle of first and last. */
            size_t first = 0, last = 0;
            for (size_t k = since + 1; k <= i; k++) {
                if ((s->y[k] >= level) != (s->y[k - 1] >= level)) {
                    first = first ? first : k;
                    last = k;
                }
            }
            struct crossing crossing = {.up = now > 0};
            double centre = 0.25 * (s->t[first - 1] + s->t[first] + s->t[last - 1] + s->t[last]);
            if (c.exact ? place_exact(&c, last, &crossing) : place_fit(&c, centre, &crossing)) {
                if (count < room) {
                    out[count] = crossing;
                }
                count++;
            }
        }
        side = now;
        since = i;
    }
    return count;
}

/*
 * Where the counting of periods starts: the phase that the first crossings agree on, so that a spike that comes first
 * does not shift the rest. Only a few are asked: over many periods a small error of the guess would turn them against
 * each other.
 */
static double counting_origin(const struct crossing *up, size_t count, double guess)
{
    double c = 0, s = 0;
    for (size_t i = 0; i < count && i < 15; i++) {
        const double angle = 2 * M_PI * (up[i].t - up[0].t) / guess;
        c += cos(angle);
        s += sin(angle);
    }
    return up[0].t + guess * atan2(s, c) / (2 * M_PI);
}

#define FAR_OFF 0.1 /* of a period */

/* Weighted line t = start + n T through the up-crossings; those far off it (five robust sigma) are dropped once. */
static bool fit_period(const struct crossing *up, size_t count, double guess, double *scratch, bool exact,
                       struct period *out)
{
    const double origin = counting_origin(up, count, guess);
    for (size_t i = 0; i < count; i++) {
        scratch[i] = up[i].t - guess * nearbyint((up[i].t - origin) / guess);
    }
    /* Before any line: a spike's crossing can look very certain, so what is far from the crossings' median phase stays
     * out at once. */
    double limit = FAR_OFF * guess, slope = guess, start = quantile(scratch, count, 0.5);
    for (int pass = 0; pass < 2; pass++) {
        double w = 0, wn = 0, wt = 0, wnn = 0, wnt = 0, chi2 = 0;
        size_t used = 0;
        out->first = HUGE_VAL;
        out->last = -HUGE_VAL;
        for (size_t i = 0; i < count; i++) {
            double n = nearbyint((up[i].t - origin) / guess), t = up[i].t - up[0].t;
            double sigma = fmax(up[i].uncertainty, 1e-15 * (fabs(up[i].t) + guess)), weight = 1 / (sigma * sigma);
            if (fabs(up[i].t - start - n * slope) > limit) {
                continue;
            }
            w += weight;
            wn += weight * n;
            wt += weight * t;
            wnn += weight * n * n;
            wnt += weight * n * t;
            out->first = fmin(out->first, up[i].t);
            out->last = fmax(out->last, up[i].t);
            used++;
        }
        double det = w * wnn - wn * wn;
        if (used < 2 || !(det > 0)) {
            return false;
        }
        slope = (w * wnt - wn * wt) / det;
        start = up[0].t + (wt - slope * wn) / w;
        for (size_t i = 0; i < count; i++) {
            double n = nearbyint((up[i].t - origin) / guess), r = up[i].t - start - n * slope;
            double sigma = fmax(up[i].uncertainty, 1e-15 * (fabs(up[i].t) + guess));
            chi2 += fabs(r) <= limit ? r * r / (sigma * sigma) : 0;
            scratch[i] = fabs(r);
        }
        /* Scatter about the line says more than the single uncertainties where it is larger, or where these are only
         * rounding. */
        double spread = used > 2 ? chi2 / (double)(used - 2) : 1, widen = exact && used > 3 ? spread : fmax(spread, 1);
        out->period = (struct measured){slope, sqrt(widen * w / det)};
        limit = fmax(5 * MAD_TO_SIGMA * quantile(scratch, count, 0.5), 1e-12 * guess);
    }
    out->periods = nearbyint((out->last - out->first) / slope);
    return true;
}

/* From the line through the up-crossings of the mean. False: no memory, or there are too few, which `error` says. */
static bool crossing_period(const struct series *series, const struct overview *o, struct arena *arena,
                            struct period *period, struct error *error)
{
    size_t room = 2 * (size_t)o->periods + 16, up = 0;
    struct crossing *crossing = arena_array(arena, room, sizeof *crossing);
    double *scratch = arena_array(arena, room, sizeof *scratch);
    if (!crossing || !scratch) {
        return error_memory(error);
    }
    size_t count = series_crossings(series, o, o->mean, crossing, room);
    for (size_t i = 0; i < count && i < room; i++) {
        if (crossing[i].up) {
            crossing[up++] = crossing[i];
        }
    }
    *period = (struct period){.level = o->mean, .how = "up-crossings"};
    if (up < 2 || !fit_period(crossing, up, o->period, scratch, is_exact(o), period)) {
        error_set(error, ERROR_COMMAND, "no period: fewer than two up-crossings of %g stand out of the noise", o->mean);
        return error_hint(error, "fit finds the period of such a signal");
    }
    return true;
}

/* Of one damped sine, where there are too few windows for a line through their phases. */
static void whole_period(const struct motion *m, struct period *period)
{
    const struct harmonic *h = &m->harmonic;
    const struct oscillation o = {h->a, h->b, h->omega, h->gamma, h->origin};
    const double widen = residual_widening(&m->samples, m->residual, &o, 2).phase;
    const double sigma = harmonic_sigma(h, FREE_GAMMA) * sqrt(widen * h->inverse[RATE_OMEGA][RATE_OMEGA]);
    if (m->tracked || !h->converged || !isfinite(sigma)) {
        return;
    }
    period->period = (struct measured){TWO_PI / h->omega, TWO_PI / (h->omega * h->omega) * sigma};
    period->how = "one damped sine";
}

/* Two lines of the spectrum whose sum waxes and wanes. */
static void warn_beats(const struct series *series, const struct track *track, struct arena *arena,
                       struct period *period)
{
    struct spectrum_peak peak[3];
    double before = 0, deepest = 1;
    for (size_t k = 0; k < track->windows; k++) {
        double after = 0;
        for (size_t j = k + 1; j < track->windows; j++) {
            after = fmax(after, track->window[j].amplitude);
        }
        const double around = fmin(before, after);
        deepest = around > 0 ? fmin(deepest, track->window[k].amplitude / around) : deepest;
        before = fmax(before, track->window[k].amplitude);
    }
    if (!(deepest < WANES) || series_peaks(series, arena, peak, 2) < 2) {
        return;
    }
    const double f = peak[0].frequency.value, g = peak[1].frequency.value;
    if (fabs(g / f - 1) < NEIGHBOURS && peak[1].amplitude.value > SECOND_LEAST * peak[0].amplitude.value) {
        snprintf(period->warning, sizeof period->warning, "two frequencies: %.5g and %.5g Hz (beats)", fmin(f, g),
                 fmax(f, g));
    }
}

/* Noisy samples, window by window. False: too few windows, or no memory. */
static bool phase_period(const struct series *series, struct motion *m, struct arena *arena, struct period *period)
{
    struct track track;
    if (m->tracked) {
        memset(m->samples.use, 1, m->samples.n);
        samples_flag_spikes(&m->samples, m->scratch);
    }
    for (int periods = 2; periods <= 32; periods *= 2) {
        if (!track_follow(&m->samples, TWO_PI / m->overview.period, periods, arena, &track)) {
            return false;
        }
        if (track_is_oscillation(&track)) {
            const bool found = track_period(&track, arena, period);
            if (found) {
                warn_beats(series, &track, arena, period);
            }
            return found;
        }
    }
    return false;
}

/* Where a damped sine describes the series, or sines do window by window. */
static bool sine_period(const struct series *series, struct arena *arena, struct period *period, struct error *error)
{
    struct motion m;
    if (!motion_require(&m, series, arena, NULL, error)) {
        return false;
    }
    if (!is_exact(&m.overview) && phase_period(series, &m, arena, period)) {
        return true;
    }
    if (!crossing_period(series, &m.overview, arena, period, error)) {
        return false;
    }
    if (!is_exact(&m.overview)) {
        whole_period(&m, period);
    }
    return true;
}

/* Of many samples, in a few passes. False: no memory, or the slower way has to judge. */
static bool long_period(const struct series *series, struct arena *arena, struct period *period)
{
    struct samples x;
    struct track track;
    double scratch[NOISE_SAMPLES];
    struct overview o = {.low = HUGE_VAL, .high = -HUGE_VAL, .oscillates = true};
    if (!samples_init(&x, series, arena) || !(x.dt > 0)) {
        return false;
    }
    const struct samples part = samples_part(&x, x.n / 2, x.n / 2 + NOISE_SAMPLES);
    if (!track_long(&x, arena, &track) || !track_is_oscillation(&track) || !track_period(&track, arena, period)) {
        return false;
    }
    for (size_t i = 0; i < x.n; i++) {
        o.low = fmin(o.low, x.y[i]);
        o.high = fmax(o.high, x.y[i]);
    }
    o.noise = samples_noise(&part, scratch);
    o.mean = period->level;
    o.period = period->period.value;
    o.periods = (x.t[x.n - 1] - x.t[0]) / o.period;
    struct period exact;
    struct error ignored;
    if (is_exact(&o) && crossing_period(series, &o, arena, &exact, &ignored)) {
        *period = exact;
    }
    return true;
}

#define WAVES 512   /* crossings that are asked for */
#define REGULAR 0.01 /* how far the times between crossings are off their median */

/* It crosses the level (NAN: the middle between its extremes) upwards at regular times, three times at least. */
static bool regular_period(const struct series *series, double level, size_t room, struct arena *arena,
                           struct period *period)
{
    struct crossing *crossing = arena_array(arena, room, sizeof *crossing);
    double *scratch = arena_array(arena, room, sizeof *scratch);
    struct overview o = {.low = HUGE_VAL, .high = -HUGE_VAL};
    size_t up = 0;
    for (size_t i = 0; i < series->n; i++) {
        o.low = series->y[i] < o.low ? series->y[i] : o.low;
        o.high = series->y[i] > o.high ? series->y[i] : o.high;
    }
    o.mean = isnan(level) ? o.low + (o.high - o.low) / 2 : level;
    const size_t count = crossing && scratch ? series_crossings(series, &o, o.mean, crossing, room) : 0;
    for (size_t i = 0; i < count && i < room; i++) {
        if (crossing[i].up) {
            crossing[up++] = crossing[i];
        }
    }
    if (up < 3) {
        return false;
    }
    for (size_t i = 1; i < up; i++) {
        scratch[i - 1] = crossing[i].t - crossing[i - 1].t;
    }
    const double beat = quantile(scratch, up - 1, 0.5);
    for (size_t i = 1; i < up; i++) {
        if (!(fabs(crossing[i].t - crossing[i - 1].t - beat) <= REGULAR * beat)) {
            return false;
        }
    }
    *period = (struct period){.level = o.mean, .how = "up-crossings"};
    return fit_period(crossing, up, beat, scratch, true, period);
}

/* A wave of any shape, as pulses and relaxation oscillations have it. Noise is not regular. */
static bool wave_period(const struct series *series, struct arena *arena, struct period *period)
{
    return regular_period(series, NAN, WAVES, arena, period);
}

#define SHARP 1e-6  /* of the period: nothing better is looked for */
#define SMOOTH 20 /* samples a period from which on a quintic places crossings to rounding */

bool series_clean_period(const struct series *series, double centre, struct arena *arena, struct period *period)
{
    return regular_period(series, centre, series->n / 2 + 1, arena, period) &&
           period->period.value * (double)(series->n - 1) >= SMOOTH * (series->t[series->n - 1] - series->t[0]);
}

bool series_period(const struct series *series, struct arena *arena, struct period *period, struct error *error)
{
    if (series->n > LONG_RECORD && long_period(series, arena, period)) {
        return true;
    }
    struct period wave;
    if (!sine_period(series, arena, period, error))
        return wave_period(series, arena, period);
    /* What repeats itself without noise, but is no sine, is placed better by its crossings than by phases of sines. */
    if (period->period.uncertainty > SHARP * period->period.value && wave_period(series, arena, &wave) &&
        wave.period.uncertainty < period->period.uncertainty / 10)
        *period = wave;
    return true;
}
