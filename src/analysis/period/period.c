/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period of a series: from the phases of sines window by window, from one damped sine, or from
 * its crossings. */
#include "analysis/period/cycle.h"
#include "analysis/period/track.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    LONG_RECORD = 8192,
    LINES_ROWS_MAX = 32768, /* in which two lines are looked for to name both */
    NOISE_SAMPLES = 4096,
    CYCLES_SURE = 6,
    GAP_STEPS = 8,       /* mean steps: a longer one is a gap */
    COARSE_PERIOD = 128, /* samples of a period in whose windows harmonics do not cancel */
};

#define WANES 0.7      /* amplitude between two maxima from which on it is looked for beats */
#define CHANCE 3.0     /* standard deviations of an amplitude */
#define POOR 2.0       /* what a damped sine leaves, over the noise, */
#define CORRELATED 0.5 /* and hangs together */
#define SHARP 1e-6     /* of the period: nothing better is looked for */
/* relative difference of readings of one period */
#define SAME_PERIOD 0.05
/* what is followed window by window and a damped sine in a part of it differ by more only if one of
 * them is wrong: the sine is what leaves nothing but noise */
#define OTHER_PERIOD_LOG 0.2
/* of two periods that are so near, the sum waxes and wanes */
#define BEATS_RATIO_LOG 0.4
/* standard deviations from which on the phases of sines contradict whole cycles */
#define CONTRADICTS 3.0
/* an edge: of the range, between two samples */
#define EDGE 0.4
#define BEATS_LEAVE 0.01 /* of the power: where two lines leave more, there are others */

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
    if (deepest < WANES && (samples->n > LINES_ROWS_MAX || !warn_lines(samples, period))) {
        snprintf(period->warning, sizeof period->warning,
                 "the amplitude falls to %.0f %% and rises again: two frequencies (beats), sway or "
                 "a drive",
                 100 * deepest);
    }
}

/* Returns true if one damped sine leaves more than noise: then the interval is wide, and rests on a
 * model that is not true. */
static bool is_poor(const struct motion *m)
{
    return harmonic_sigma(&m->harmonic, FREE_GAMMA) > POOR * m->overview.noise &&
           m->autocorrelation > CORRELATED;
}

static void warn_poor(const struct motion *m, struct period *period)
{
    if (!warn_lines(&m->samples, period))
        snprintf(period->warning, sizeof period->warning,
                 "one damped sine does not describe it: what it leaves is %.2g times the noise",
                 harmonic_sigma(&m->harmonic, FREE_GAMMA) / m->overview.noise);
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

/* Reads the period where a damped sine describes the series, or sines do window by window. */
static bool sine_period(const struct series *series, struct motion *m, struct arena *arena,
                        struct period *period)
{
    struct error ignored;
    if (overview_is_exact(&m->overview))
        return crossing_period(series, &m->overview, arena, period, &ignored);
    return phase_period(m, arena, period) ||
           ((!is_poor(m) || motion_is_decaying(m)) && whole_period(m, period));
}

/* Of many samples, in a few passes. False: no memory, or the slower way has to judge. */
static bool long_period(const struct series *series, struct arena *arena, struct period *period,
                        double *pace, bool *is_exact)
{
    struct samples x;
    struct track track;
    double scratch[NOISE_SAMPLES];
    struct overview o = {.low = HUGE_VAL, .high = -HUGE_VAL, .oscillates = true};
    if (!samples_init(&x, series, arena) || !(x.dt > 0)) {
        return false;
    }
    *pace = x.pace;
    samples_flag_spikes(&x, scratch);
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
    *is_exact = overview_is_exact(&o);
    if (*is_exact && crossing_period(series, &o, arena, &exact, &ignored)) {
        *period = exact;
    } else {
        warn_beats(&x, &track, arena, period);
    }
    return true;
}

/* Reads the period of the part of a series that swings. */
static bool part_period(const struct series *series, const struct swing *swing, struct arena *arena,
                        struct period *period)
{
    struct motion m;
    const struct series part = series_window(*series, swing->window[0], swing->window[1]);
    if (!motion_init(&m, &part, arena, NULL) || !m.overview.oscillates ||
        !(sine_period(&part, &m, arena, period) || whole_period(&m, period)))
        return false;
    snprintf(period->warning, sizeof period->warning,
             "only a part of it is an oscillation: T is that from t = %.6g to %.6g s",
             swing->window[0], swing->window[1]);
    return true;
}

static bool swing_period(const struct series *series, struct arena *arena, struct period *period)
{
    struct swing swing;
    return find_swing(series, &swing) && part_period(series, &swing, arena, period);
}

static bool is_same(const struct period *period, double value)
{
    return fabs(period->period.value / value - 1) < SAME_PERIOD;
}

/* Tests the period of a sine against its multiples and parts, and takes that at which the series
 * repeats. */
static void take_multiple(const struct series *series, bool exact, const struct lags *lags,
                          struct arena *arena, struct period *period)
{
    struct period other;
    const enum wave_kind kind = exact ? WAVE_EXACT : WAVE_NOISY;
    const double multiple = lags_multiple(lags, period->period.value),
                 guess = multiple * period->period.value;
    if (multiple == 1) {
        /* A wave that is no sine is placed better by its crossings than by phases of sines. */
        if (period->period.uncertainty > SHARP * period->period.value &&
            wave_period(series, kind, arena, &other) && is_same(&other, guess) &&
            other.period.uncertainty < period->period.uncertainty / 10)
            *period = other;
        return;
    }
    if ((wave_period(series, kind, arena, &other) && is_same(&other, guess)) ||
        cycle_period(series, guess, arena, &other) ||
        (swing_period(series, arena, &other) && is_same(&other, guess))) {
        *period = other;
        return;
    }
    snprintf(period->warning, sizeof period->warning,
             "it is more like itself after %.4g s, %.3g of these periods: this may be a harmonic",
             guess, multiple);
}

/* Reads the period of what no sine describes. */
static bool other_period(const struct series *series, struct motion *m, const struct lags *lags,
                         struct arena *arena, struct period *period, struct error *error)
{
    struct mode_pair pair;
    struct swing swing;
    bool swings = false;
    if (overview_is_constant(&m->overview) || m->buried)
        return motion_refuse_known(m, NULL, NULL, error);
    const bool exact = overview_is_exact(&m->overview), lines = two_lines(&m->samples, &pair);
    const double guess = lags->correlation ? lags_period(lags) : NAN,
                 multiple = isfinite(guess) ? lags_multiple(lags, guess) : 1;
    const bool beats = lines && pair.left < BEATS_LEAVE &&
                       fabs(log(pair.period[0] / pair.period[1])) < BEATS_RATIO_LOG;
    if (wave_period(series, exact ? WAVE_EXACT : WAVE_NOISY, arena, period))
        return true;
    if (!beats)
        swings = find_swing(series, &swing);
    if ((swings && part_period(series, &swing, arena, period)) ||
        (!beats && isfinite(guess) && cycle_period(series, multiple * guess, arena, period)) ||
        (!exact && wave_period(series, WAVE_NOISY_FEW, arena, period)))
        return true;
    if (!m->overview.oscillates && !lines && !swings && waves_period(series, arena, period))
        return true;
    if (!m->overview.oscillates)
        return motion_refuse_known(m, lines ? &pair : NULL, swings ? &swing : NULL, error);
    if (!exact && whole_period(m, period)) {
        warn_poor(m, period);
        return true;
    }
    if (!crossing_period(series, &m->overview, arena, period, error))
        return false;
    snprintf(period->warning, sizeof period->warning,
             "neither a damped sine nor its cycles describe it: T is that of its crossings alone");
    return true;
}

/* Returns the power of the series at `multiple` times the frequency of a period, through a Hann
 * window, which keeps a bent baseline and the fundamental out of it. */
static double power_at(const struct series *series, double period, double multiple)
{
    const double t0 = series->t[0], span = series->t[series->n - 1] - t0;
    double mean = 0, re = 0, im = 0;
    for (size_t i = 0; i < series->n; i++)
        mean += series->y[i] / (double)series->n;
    for (size_t i = 0; i < series->n; i++) {
        const double t = series->t[i] - t0, angle = TWO_PI * multiple * t / period;
        const double weighted = (series->y[i] - mean) * (1 - cos(TWO_PI * t / span));
        re += weighted * cos(angle);
        im += weighted * sin(angle);
    }
    return re * re + im * im;
}

/* Returns true if the second or third harmonic of a period stands out of what lies between them. */
static bool has_harmonics(const struct series *series, double period)
{
    static const double stands_out = 16, cycles_min = 6; /* fewer cycles do not part the lines */
    if (series->t[series->n - 1] - series->t[0] < cycles_min * period)
        return true;
    const double between = (power_at(series, period, 1.5) + power_at(series, period, 2.5) +
                            power_at(series, period, 3.5)) /
                           3;
    return fmax(power_at(series, period, 2), power_at(series, period, 3)) > stands_out * between;
}

/*
 * A wave that is no sine shifts the phases of sines by what its harmonics bring into each window:
 * where whole cycles contradict them, these are right.
 */
static void prefer_cycles(const struct series *series, struct arena *arena, struct period *period)
{
    struct period other;
    const double span = series->t[series->n - 1] - series->t[0];
    if ((double)series->n * period->period.value < COARSE_PERIOD * span &&
        cycle_period(series, period->period.value, arena, &other) &&
        is_same(period, other.period.value) && has_harmonics(series, period->period.value) &&
        fabs(other.period.value - period->period.value) >
            CONTRADICTS * hypot(other.period.uncertainty, period->period.uncertainty)) {
        /* of few cycles it is not sure which of the two is wrong */
        if (other.periods < CYCLES_SURE)
            other.period.uncertainty =
                hypot(other.period.uncertainty, 0.5 * (other.period.value - period->period.value));
        memcpy(other.warning, period->warning, sizeof other.warning);
        *period = other;
    }
}

/* Edges between two samples are known to one step, and all by the same part of it where a period
 * is nearly a whole number of steps. */
static void widen_by_edges(const struct series *series, struct period *period)
{
    double low = HUGE_VAL, high = -HUGE_VAL, edges = 0;
    for (size_t i = 0; i < series->n; i++) {
        low = fmin(low, series->y[i]);
        high = fmax(high, series->y[i]);
    }
    for (size_t i = 1; i < series->n; i++)
        edges += fabs(series->y[i] - series->y[i - 1]) > EDGE * (high - low);
    if (period->periods >= 1 && edges >= period->periods) {
        const double dt = (series->t[series->n - 1] - series->t[0]) / (double)(series->n - 1);
        period->period.uncertainty =
            hypot(period->period.uncertainty, dt / sqrt(12) / period->periods);
    }
}

/* *pace: relative standard uncertainty that all times have in common. */
static bool find_period(const struct series *series, struct arena *arena, struct period *period,
                        double *pace, struct error *error)
{
    struct motion m;
    struct lags lags;
    bool exact = false, follows = false, shaped = false, has_motion = false;
    /* The rows of a stiff run crowd in its jumps: the crossings use them where they are. */
    if (series_is_uneven(series) && wave_period(series, WAVE_EXACT, arena, period))
        return true;
    bool found = series->n > LONG_RECORD && long_period(series, arena, period, pace, &exact);
    if (!found) {
        if (!motion_find(&m, series, arena, NULL, error))
            return false;
        exact = overview_is_exact(&m.overview);
        *pace = m.samples.pace;
        found = m.overview.oscillates && sine_period(series, &m, arena, period);
        has_motion = true;
        follows = m.tracked;
        shaped = !exact && (follows || is_poor(&m));
    }
    const bool has_lags = lags_init(series, found ? period->period.value : NAN, arena, &lags);
    if (!found) {
        if (!other_period(series, &m, &lags, arena, period, error))
            return false;
        if (!exact) {
            widen_by_edges(series, period);
            period_widen_by_envelope(&m, is_poor(&m), arena, period);
        }
        return true;
    }
    struct period part;
    const bool supported = has_lags && lags_support(&lags, period->period.value);
    if (follows && !exact && !supported && swing_period(series, arena, &part) &&
        fabs(log(part.period.value / period->period.value)) > OTHER_PERIOD_LOG)
        *period = part;
    else if (has_lags)
        take_multiple(series, exact, &lags, arena, period);
    if (shaped) {
        prefer_cycles(series, arena, period);
        widen_by_edges(series, period);
    }
    if (has_motion && !exact)
        period_widen_by_envelope(&m, is_poor(&m), arena, period);
    return true;
}

/* Reads the period of every stretch between gaps that is long enough, and their weighted mean.
 * *before [s] becomes the time before the longest gap. Returns false if there is no gap, or if no
 * stretch can be read. */
static bool stretches_period(const struct series *series, double whole, struct arena *arena,
                             struct period *mean, double *before)
{
    static const double gap_periods = 0.04, stretch_periods = 4;
    enum { STRETCHES_MAX = 16, ROWS_MIN = 32 };
    const double step = (series->t[series->n - 1] - series->t[0]) / (double)(series->n - 1),
                 gap = fmax(GAP_STEPS * step, gap_periods * whole);
    double weight = 0, sum = 0, longest = 0, pace;
    size_t begin = 0, stretches = 0;
    struct error ignored;
    *mean = (struct period){.first = HUGE_VAL, .how = "phases"};
    for (size_t i = 1; i <= series->n; i++) {
        const bool ends = i == series->n;
        const double here = ends ? 0 : series->t[i] - series->t[i - 1];
        if (!ends && here <= gap)
            continue;
        struct series part = *series;
        struct period p;
        part.t += begin;
        part.y += begin;
        part.n = i - begin;
        if (here > longest) {
            longest = here;
            *before = series->t[i - 1];
        }
        begin = i;
        if (part.n == series->n || ++stretches > STRETCHES_MAX)
            return false;
        if (part.n < ROWS_MIN || part.t[part.n - 1] - part.t[0] < stretch_periods * whole ||
            !find_period(&part, arena, &p, &pace, &ignored) || !is_same(&p, whole))
            continue;
        const double w = 1 / (p.period.uncertainty * p.period.uncertainty);
        weight += w;
        sum += w * p.period.value;
        mean->first = fmin(mean->first, p.first);
        mean->last = p.last;
        mean->periods += p.periods;
        mean->level = p.level;
        mean->how = p.how;
    }
    mean->period = (struct measured){sum / weight, 1 / sqrt(weight)};
    return isfinite(weight) && weight > 0;
}

/* Where the clock jumps, rather than the recording pauses, the stretches before and after it show
 * another period than all of it: theirs is right. */
static void heed_clock_jumps(const struct series *series, struct arena *arena,
                             struct period *period)
{
    static const double contradicts = 2.5; /* standard deviations */
    const double step = (series->t[series->n - 1] - series->t[0]) / (double)(series->n - 1);
    struct period mean;
    double before = NAN, longest = 0;
    for (size_t i = 1; i < series->n; i++) {
        const double here = series->t[i] - series->t[i - 1];
        longest = here > longest ? here : longest;
    }
    if (longest <= GAP_STEPS * step || series_is_uneven(series) ||
        !stretches_period(series, period->period.value, arena, &mean, &before) ||
        fabs(mean.period.value - period->period.value) <=
            contradicts * hypot(mean.period.uncertainty, period->period.uncertainty / 3))
        return;
    *period = mean;
    snprintf(period->warning, sizeof period->warning,
             "the phase jumps in the gap after t = %.6g s (a clock that was set?): T is that of "
             "the stretches between gaps",
             before);
}

bool series_period(const struct series *series, struct arena *arena, struct period *period,
                   struct error *error)
{
    double pace = series->pace;
    /* A subharmonic would move every second crossing of a smooth series. */
    const bool smooth = smooth_period(series, arena, period);
    if (!smooth && !find_period(series, arena, period, &pace, error))
        return false;
    if (!smooth) {
        heed_clock_jumps(series, arena, period);
        period_check_waves(series, arena, period);
        period_doubt(series, arena, period);
    }
    period->period = measured_at_pace(period->period, pace);
    return true;
}
