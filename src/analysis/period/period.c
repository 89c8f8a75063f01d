/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period of a series: from the phases of sines window by window, from one damped sine, or from
 * its crossings. */
#include "analysis/period/track.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { LONG_RECORD = 32768, NOISE_SAMPLES = 4096 };

#define WANES 0.7      /* amplitude between two maxima from which on it is looked for beats */
#define CHANCE 3.0     /* standard deviations of an amplitude */
#define POOR 2.0       /* what a damped sine leaves, over the noise, */
#define CORRELATED 0.5 /* and hangs together */

/*
 * Where the counting of periods starts: the phase that the first crossings agree on, so that a
 * spike that comes first does not shift the rest. Only a few are asked: over many periods a small
 * error of the guess would turn them against each other.
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

/* Weighted line t = start + n T through the up-crossings; those far off it (five robust sigma) are
 * dropped once. */
static bool fit_period(const struct crossing *up, size_t count, double guess, double *scratch,
                       bool exact, struct period *out)
{
    const double origin = counting_origin(up, count, guess);
    for (size_t i = 0; i < count; i++) {
        scratch[i] = up[i].t - guess * nearbyint((up[i].t - origin) / guess);
    }
    /* Before any line: a spike's crossing can look very certain, so what is far from the crossings'
     * median phase stays out at once. */
    double limit = FAR_OFF * guess, slope = guess, start = quantile(scratch, count, 0.5);
    for (int pass = 0; pass < 2; pass++) {
        double w = 0, wn = 0, wt = 0, wnn = 0, wnt = 0, chi2 = 0;
        size_t used = 0;
        out->first = HUGE_VAL;
        out->last = -HUGE_VAL;
        for (size_t i = 0; i < count; i++) {
            double n = nearbyint((up[i].t - origin) / guess), t = up[i].t - up[0].t;
            double sigma = fmax(up[i].uncertainty, 1e-15 * (fabs(up[i].t) + guess)),
                   weight = 1 / (sigma * sigma);
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
        /* Scatter about the line says more than the single uncertainties where it is larger, or
         * where these are only rounding. */
        double spread = used > 2 ? chi2 / (double)(used - 2) : 1,
               widen = exact && used > 3 ? spread : fmax(spread, 1);
        out->period = (struct measured){slope, sqrt(widen * w / det)};
        limit = fmax(5 * MAD_TO_SIGMA * quantile(scratch, count, 0.5), 1e-12 * guess);
    }
    out->periods = nearbyint((out->last - out->first) / slope);
    return true;
}

/* From the line through the up-crossings of the mean. False: no memory, or there are too few, which
 * `error` says. */
static bool crossing_period(const struct series *series, const struct overview *o,
                            struct arena *arena, struct period *period, struct error *error)
{
    size_t capacity = 2 * (size_t)o->periods + 16, up = 0;
    struct crossing *crossing = arena_array(arena, capacity, sizeof *crossing);
    double *scratch = arena_array(arena, capacity, sizeof *scratch);
    if (!crossing || !scratch) {
        return error_memory(error);
    }
    size_t count = series_crossings(series, o, o->mean, crossing, capacity);
    for (size_t i = 0; i < count && i < capacity; i++) {
        if (crossing[i].up) {
            crossing[up++] = crossing[i];
        }
    }
    *period = (struct period){.level = o->mean, .how = "up-crossings"};
    if (up < 2 || !fit_period(crossing, up, o->period, scratch, overview_is_exact(o), period)) {
        error_set(error, ERROR_COMMAND,
                  "no period: fewer than two up-crossings of %g stand out of the noise", o->mean);
        return error_hint(error, "fit finds the period of such a signal");
    }
    return true;
}

/* Of one damped sine, where there are too few windows for a line through their phases. */
static bool whole_period(const struct motion *m, struct period *period)
{
    const struct harmonic *h = &m->harmonic;
    const struct oscillation o = {h->a, h->b, h->omega, h->gamma, h->origin};
    const double widen = residual_widening(&m->samples, m->residual, &o, 2).phase;
    const double sigma =
        harmonic_sigma(h, FREE_GAMMA) * sqrt(widen * h->inverse[RATE_OMEGA][RATE_OMEGA]);
    const struct samples *x = &m->samples;
    if (m->tracked || !h->converged || !isfinite(sigma)) {
        return false;
    }
    /* what rests has no periods */
    const double last = x->t[samples_quiet(x, TWO_PI / h->omega) - 1];
    *period = (struct period){
        .period = {TWO_PI / h->omega, TWO_PI / (h->omega * h->omega) * sigma},
        .first = x->t[0],
        .last = last,
        .periods = floor(fmin(m->overview.periods, (last - x->t[0]) * h->omega / TWO_PI + 0.01)),
        .level = m->overview.mean,
        .how = "one damped sine"};
    return true;
}

/* At least that, where the window shows an oscillation at all. */
static double sure_amplitude(const struct track_window *w)
{
    return w->clear ? w->amplitude * fmax(1 - CHANCE * w->sigma, 0) : 0;
}

/* The amplitude of the windows between two that are larger: the smallest share that is not chance.
 */
static double deepest_wane(const struct track *track, struct arena *arena)
{
    double *after = arena_array(arena, track->windows + 1, sizeof *after), before = 0, deepest = 1;
    for (size_t k = track->windows; after && k-- > 0;) {
        after[k] =
            k + 1 < track->windows ? fmax(after[k + 1], sure_amplitude(&track->window[k + 1])) : 0;
    }
    for (size_t k = 0; after && k < track->windows; k++) {
        const struct track_window *w = &track->window[k];
        const double around = fmin(before, after[k]),
                     here = w->amplitude * (1 + CHANCE * fmin(w->sigma, 1));
        deepest = around > 0 && w->used > 0 ? fmin(deepest, here / around) : deepest;
        before = fmax(before, sure_amplitude(w));
    }
    return deepest;
}

static bool warn_lines(const struct samples *samples, struct period *period)
{
    struct mode_pair pair;
    if (!two_lines(samples, &pair)) {
        return false;
    }
    snprintf(period->warning, sizeof period->warning,
             "two frequencies: T = %.5g and %.5g s, which beat every %.4g s", pair.period[0],
             pair.period[1], pair.beat);
    return true;
}

/* Two frequencies whose sum waxes and wanes; or whatever else does. */
static void warn_beats(const struct samples *samples, const struct track *track,
                       struct arena *arena, struct period *period)
{
    const double deepest = deepest_wane(track, arena);
    if (deepest < WANES && (samples->n > LONG_RECORD || !warn_lines(samples, period))) {
        snprintf(period->warning, sizeof period->warning,
                 "the amplitude falls to %.0f %% and rises again: two frequencies (beats), sway or "
                 "a drive",
                 100 * deepest);
    }
}

/* What one damped sine leaves is more than noise: the interval is wide, and rests on a model that
 * is not true. */
static void warn_poor(const struct motion *m, struct period *period)
{
    const double left = harmonic_sigma(&m->harmonic, FREE_GAMMA);
    if (left > POOR * m->overview.noise && m->autocorrelation > CORRELATED &&
        !warn_lines(&m->samples, period)) {
        snprintf(period->warning, sizeof period->warning,
                 "one damped sine does not describe it: what it leaves is %.2g times the noise",
                 left / m->overview.noise);
    }
}

/* Noisy samples, window by window. False: too few windows, or no memory. */
static bool phase_period(struct motion *m, struct arena *arena, struct period *period)
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
                warn_beats(&m->samples, &track, arena, period);
            }
            return found;
        }
    }
    return false;
}

/* Where a damped sine describes the series, or sines do window by window. */
static bool sine_period(const struct series *series, struct motion *m, struct arena *arena,
                        struct period *period, struct error *error)
{
    const bool exact = overview_is_exact(&m->overview);
    if (!exact && phase_period(m, arena, period)) {
        return true;
    }
    if (!exact && whole_period(m, period)) {
        warn_poor(m, period);
        return true;
    }
    return crossing_period(series, &m->overview, arena, period, error);
}

/* Of many samples, in a few passes. False: no memory, or the slower way has to judge. */
static bool long_period(const struct series *series, struct arena *arena, struct period *period,
                        double *pace)
{
    struct samples x;
    struct track track;
    double scratch[NOISE_SAMPLES];
    struct overview o = {.low = HUGE_VAL, .high = -HUGE_VAL, .oscillates = true};
    if (!samples_init(&x, series, arena) || !(x.dt > 0)) {
        return false;
    }
    *pace = x.pace;
    const struct samples part = samples_part(&x, x.n / 2, x.n / 2 + NOISE_SAMPLES);
    if (!track_long(&x, arena, &track) || !track_is_oscillation(&track) ||
        !track_period(&track, arena, period)) {
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
    if (overview_is_exact(&o) && crossing_period(series, &o, arena, &exact, &ignored)) {
        *period = exact;
    } else {
        warn_beats(&x, &track, arena, period);
    }
    return true;
}

#define WAVES 512    /* crossings that are asked for */
#define REGULAR 0.01 /* how far the times between crossings are off their median */
/* the same of samples that may be noisy: crossings of noise are never so regular */
#define CLOCKWORK 1e-4

/* It crosses the level (NAN: the middle between its extremes) upwards at regular times, three times
 * at least. */
static bool regular_period(const struct series *series, double level, double regular,
                           size_t capacity, struct arena *arena, struct period *period)
{
    struct crossing *crossing = arena_array(arena, capacity, sizeof *crossing);
    double *scratch = arena_array(arena, capacity, sizeof *scratch);
    struct overview o = {.low = HUGE_VAL, .high = -HUGE_VAL};
    size_t up = 0;
    for (size_t i = 0; i < series->n; i++) {
        o.low = series->y[i] < o.low ? series->y[i] : o.low;
        o.high = series->y[i] > o.high ? series->y[i] : o.high;
    }
    o.mean = isnan(level) ? o.low + (o.high - o.low) / 2 : level;
    const size_t count =
        crossing && scratch ? series_crossings(series, &o, o.mean, crossing, capacity) : 0;
    for (size_t i = 0; i < count && i < capacity; i++) {
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
        if (!(fabs(crossing[i].t - crossing[i - 1].t - beat) <= regular * beat)) {
            return false;
        }
    }
    *period = (struct period){.level = o.mean, .how = "up-crossings"};
    return fit_period(crossing, up, beat, scratch, true, period);
}

/* A wave of any shape, as pulses and relaxation oscillations have it. */
static bool wave_period(const struct series *series, bool exact, struct arena *arena,
                        struct period *period)
{
    return regular_period(series, NAN, exact ? REGULAR : CLOCKWORK, WAVES, arena, period);
}

#define SHARP 1e-6 /* of the period: nothing better is looked for */
#define SMOOTH 20  /* samples a period from which on a quintic places crossings to rounding */

bool series_clean_period(const struct series *series, double centre, struct arena *arena,
                         struct period *period)
{
    return regular_period(series, centre, REGULAR, series->n / 2 + 1, arena, period) &&
           period->period.value * (double)(series->n - 1) >=
               SMOOTH * (series->t[series->n - 1] - series->t[0]);
}

struct measured measured_at_pace(struct measured time, double pace)
{
    if (pace > 0)
        time.uncertainty = hypot(time.uncertainty, pace * time.value);
    return time;
}

/* *pace: relative standard uncertainty that all times have in common. */
static bool find_period(const struct series *series, struct arena *arena, struct period *period,
                        double *pace, struct error *error)
{
    if (series->n > LONG_RECORD && long_period(series, arena, period, pace)) {
        return true;
    }
    struct motion m;
    struct period wave;
    const bool found = motion_require(&m, series, arena, NULL, error),
               exact = overview_is_exact(&m.overview);
    *pace = m.samples.pace;
    if (!found || !sine_period(series, &m, arena, period, error))
        return wave_period(series, exact, arena, period);
    /* What repeats itself without noise, but is no sine, is placed better by its crossings than by
     * phases of sines. */
    if (period->period.uncertainty > SHARP * period->period.value &&
        wave_period(series, exact, arena, &wave) &&
        wave.period.uncertainty < period->period.uncertainty / 10)
        *period = wave;
    return true;
}

bool series_period(const struct series *series, struct arena *arena, struct period *period,
                   struct error *error)
{
    double pace = 0;
    if (!find_period(series, arena, period, &pace, error))
        return false;
    period->period = measured_at_pace(period->period, pace);
    return true;
}
