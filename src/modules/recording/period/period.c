/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The period of a series (series_period()): from the phases of sines window by window, from one
 * damped sine, from crossings or from whole cycles, and the choice between them. */
#include "modules/recording/period/cycle.h"
#include "modules/recording/period/track.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    CYCLES_SURE = 6,     /* cycles from which on their period is sure */
    COARSE_PERIOD = 128, /* samples a period below which harmonics do not cancel in a window */
};

/* A warning of beats is given if the amplitude falls below this ratio between two maxima. */
#define BEAT_AMPLITUDE_RATIO 0.7
/* Standard deviations of an amplitude that bound it. */
#define AMPLITUDE_CLEAR_SIGMAS 3.0
/* A damped sine is poor if its residuals exceed the noise by this ratio and have at least this
 * autocorrelation. */
#define POOR_RESIDUAL_RATIO 2.0
#define RESIDUAL_CORRELATION_MIN 0.5
/* Relative uncertainty of a period below which nothing better is searched for. */
#define PERIOD_SHARP_RELATIVE 1e-6
/* Relative difference up to which two readings are of the same period. */
#define SAME_PERIOD 0.05
/* Difference of ln(period) between consecutive windows and a damped sine in a part of the series,
 * above which one of them is wrong: the sine is right if it leaves only noise. */
#define OTHER_PERIOD_LOG 0.2
/* Difference of ln(period) below which the sum of two oscillations beats. */
#define BEATS_RATIO_LOG 0.4
/* Standard deviations above which the phases of sines contradict whole cycles. */
#define CONTRADICTION_SIGMAS 3.0
/* Part of the range between two neighbouring samples from which on it is an edge. */
#define EDGE_RANGE_FRACTION 0.4
/* Smallest share of the power around the highest line for beats, and the largest share that two
 * lines may leave; with more, there are other lines. */
#define BEATS_SHARE 0.9
#define BEATS_LEAVE 0.01

/* Reads the period from one damped sine, if there are too few windows for a line through phases.
 * Returns false if it does not fit. */
static bool damped_sine_period(const struct motion *m, struct period *period)
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
    /* A recording has no periods where it is at rest. */
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

/* Returns a lower bound of the window's amplitude, or 0 if it shows no oscillation. */
static double sure_amplitude(const struct track_window *w)
{
    return w->clear ? w->amplitude * fmax(1 - AMPLITUDE_CLEAR_SIGMAS * w->sigma, 0) : 0;
}

/* Returns the smallest ratio, not by chance, of an amplitude to larger ones before and after it; 1
 * if there is none. */
static double deepest_wane(const struct track *track, struct arena *arena)
{
    double *later_max = arena_array(arena, track->windows + 1, sizeof *later_max), earlier_max = 0,
           deepest = 1;
    for (size_t k = track->windows; later_max && k-- > 0;) {
        later_max[k] = k + 1 < track->windows
                           ? fmax(later_max[k + 1], sure_amplitude(&track->window[k + 1]))
                           : 0;
    }
    for (size_t k = 0; later_max && k < track->windows; k++) {
        const struct track_window *w = &track->window[k];
        const double surrounding = fmin(earlier_max, later_max[k]),
                     here = w->amplitude * (1 + AMPLITUDE_CLEAR_SIGMAS * fmin(w->sigma, 1));
        deepest = surrounding > 0 && w->used > 0 ? fmin(deepest, here / surrounding) : deepest;
        earlier_max = fmax(earlier_max, sure_amplitude(w));
    }
    return deepest;
}

/* Warns if the amplitude falls and rises again: two frequencies, sway or a drive. */
static void warn_beats(const struct track *track, struct arena *arena, struct period *period)
{
    const double deepest = deepest_wane(track, arena);
    if (deepest < BEAT_AMPLITUDE_RATIO) {
        snprintf(period->warning, sizeof period->warning,
                 "the amplitude falls to %.0f %% and rises again: two frequencies ('measure "
                 "spectrum' lists them), sway or a drive",
                 100 * deepest);
    }
}

/* Returns true if one damped sine leaves more than noise; its interval is then wide and rests on a
 * wrong model. */
static bool is_poor(const struct motion *m)
{
    return harmonic_sigma(&m->harmonic, FREE_GAMMA) > POOR_RESIDUAL_RATIO * m->overview.noise &&
           m->autocorrelation > RESIDUAL_CORRELATION_MIN;
}

/* Returns true if the amplitude changes and one damped sine explains nearly all, so that phases are
 * lost only by an envelope that is not exponential. */
static bool is_decaying(const struct motion *m)
{
    static const double left_max = 0.02; /* power that the fit may leave, as a share */
    static const double decay_min = 0.1; /* least change of ln A */
    const struct harmonic *h = &m->harmonic;
    const double span = m->samples.t[m->samples.n - 1] - m->samples.t[0];
    double power = 0;
    if (!h->converged || !(0.5 * fabs(h->gamma) * span > decay_min))
        return false;
    for (size_t i = 0; i < m->samples.n; i++)
        power += m->samples.use[i] * (m->samples.y[i] - h->c) * (m->samples.y[i] - h->c);
    return h->rss < left_max * power;
}

/* Reads the period from phases, in the narrowest windows that show an oscillation. Returns false if
 * there are too few or if out of memory. */
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
                warn_beats(&track, arena, period);
            }
            return found;
        }
    }
    return false;
}

/* Reads the period of a series that a damped sine describes, or sines window by window. */
static bool sine_period(const struct series *series, struct motion *m, struct arena *arena,
                        struct period *period)
{
    struct error ignored;
    if (overview_is_exact(&m->overview))
        return crossing_period(series, &m->overview, arena, period, &ignored);
    return phase_period(m, arena, period) ||
           ((!is_poor(m) || is_decaying(m)) && damped_sine_period(m, period));
}

/* Reads the period of the part of a series that oscillates, with a warning. */
static bool part_period(const struct series *series, const struct swing *swing, struct arena *arena,
                        struct period *period)
{
    struct motion m;
    const struct series part = series_window(*series, swing->window[0], swing->window[1]);
    if (!motion_init(&m, &part, arena, NULL) || !m.overview.oscillates ||
        !(sine_period(&part, &m, arena, period) || damped_sine_period(&m, period)))
        return false;
    snprintf(period->warning, sizeof period->warning,
             "only part of it is an oscillation; T is measured from t = %.6g to %.6g s",
             swing->window[0], swing->window[1]);
    return true;
}

/* Finds the part of a series that oscillates and reads its period. Returns false if there is
 * none. */
static bool swing_period(const struct series *series, struct arena *arena, struct period *period)
{
    struct swing swing;
    return find_swing(series, &swing) && part_period(series, &swing, arena, period);
}

/* Returns true if the period and `value` [s] are two readings of the same one. */
static bool is_same_period(const struct period *period, double value)
{
    return fabs(period->period.value / value - 1) < SAME_PERIOD;
}

/* Tests the period of a sine against its multiples and fractions, by the correlation in `lags`, and
 * takes the one at which the series repeats, or warns. `exact` is set for series without noise. */
static void take_multiple(const struct series *series, bool exact, const struct lags *lags,
                          struct arena *arena, struct period *period)
{
    struct period other;
    const enum wave_kind kind = exact ? WAVE_EXACT : WAVE_NOISY;
    const double multiple = lags_multiple(lags, period->period.value),
                 guess = multiple * period->period.value;
    if (multiple == 1) {
        /* A wave that is no sine is placed better by its crossings than by phases of sines. */
        if (period->period.uncertainty > PERIOD_SHARP_RELATIVE * period->period.value &&
            wave_period(series, kind, arena, &other) && is_same_period(&other, guess) &&
            other.period.uncertainty < period->period.uncertainty / 10)
            *period = other;
        return;
    }
    if (cycle_period(series, guess, arena, &other) ||
        (swing_period(series, arena, &other) && is_same_period(&other, guess))) {
        const double T = period->period.value;
        *period = other;
        if (multiple > 1 && lags_support(lags, T) && !period->warning[0])
            snprintf(
                period->warning, sizeof period->warning,
                "cycles of %.5g s differ; T is %g of them, after which the motion repeats best", T,
                multiple);
        return;
    }
    snprintf(
        period->warning, sizeof period->warning,
        "the motion repeats better after %.4g s, %.3g of these periods, so this may be a harmonic",
        guess, multiple);
}

/* Reads the period of a series that no sine describes, trying crossings, a part that oscillates,
 * whole cycles and waves in turn. `rows` is the series, or means of its neighbours, m its attempted
 * sine. Returns false with the error. */
static bool period_without_sine(const struct series *series, const struct series *rows,
                                struct motion *m, const struct lags *lags, struct arena *arena,
                                struct period *period, struct error *error)
{
    struct mode_pair pair;
    struct swing swing;
    const bool exact = overview_is_exact(&m->overview);
    if (wave_period(series, exact ? WAVE_EXACT : WAVE_NOISY, arena, period))
        return true;
    const double guess = lags->correlation ? lags_period(lags) : NAN;
    const double multiple = isfinite(guess) ? lags_multiple(lags, guess) : 1;
    /* Two lines, and nothing else, that are so close that they beat, have neither a part that
     * oscillates alone nor equal cycles. */
    const bool lines = two_lines(&m->samples, &pair),
               beats = lines && pair.left < BEATS_LEAVE &&
                       fabs(log(pair.period[0] / pair.period[1])) < BEATS_RATIO_LOG &&
                       power_share_of_peaks(&m->samples, 1, BEATS_RATIO_LOG, arena) > BEATS_SHARE,
               swings = !beats && find_swing(rows, &swing);
    if ((swings && part_period(rows, &swing, arena, period)) ||
        (!beats && isfinite(guess) && cycle_period(rows, multiple * guess, arena, period)) ||
        (!exact && wave_period(series, WAVE_FEW, arena, period)))
        return true;
    const struct swing *swinging = swings ? &swing : NULL;
    if (!m->overview.oscillates)
        return (!lines && !swings && waves_period(series, arena, period)) ||
               motion_refuse_known(m, lines ? &pair : NULL, swinging, error);
    if ((exact || !damped_sine_period(m, period)) &&
        !crossing_period(exact ? series : rows, &m->overview, arena, period, error))
        return false;
    snprintf(period->warning, sizeof period->warning,
             "neither one damped sine nor equal cycles describe the motion (perhaps several "
             "frequencies); T is the closest period");
    return true;
}

/* Replaces the period from phases by that of whole cycles if the two contradict each other: the
 * harmonics of a wave that is no sine shift the phases of sines. */
static void prefer_cycles(const struct series *series, const struct series *rows,
                          struct arena *arena, struct period *period)
{
    struct period other;
    const double span = series->t[series->n - 1] - series->t[0];
    if ((double)series->n * period->period.value < COARSE_PERIOD * span &&
        series_has_harmonics(rows, period->period.value) &&
        cycle_period(rows, period->period.value, arena, &other) &&
        is_same_period(period, other.period.value) &&
        fabs(other.period.value - period->period.value) >
            CONTRADICTION_SIGMAS * hypot(other.period.uncertainty, period->period.uncertainty)) {
        /* If cycles are few, either of the two may be wrong. */
        if (other.periods < CYCLES_SURE)
            other.period.uncertainty =
                hypot(other.period.uncertainty, 0.5 * (other.period.value - period->period.value));
        memcpy(other.warning, period->warning, sizeof other.warning);
        *period = other;
    }
}

/* Widens the period of a wave with edges between two samples. These are known to one time step, and
 * all err equally if the period is nearly a whole number of steps. */
static void widen_by_edges(const struct series *series, struct period *period)
{
    double low = HUGE_VAL, high = -HUGE_VAL, edges = 0;
    for (size_t i = 0; i < series->n; i++) {
        low = fmin(low, series->y[i]);
        high = fmax(high, series->y[i]);
    }
    for (size_t i = 1; i < series->n; i++)
        edges += fabs(series->y[i] - series->y[i - 1]) > EDGE_RANGE_FRACTION * (high - low);
    if (period->periods >= 1 && edges >= period->periods) {
        const double dt = (series->t[series->n - 1] - series->t[0]) / (double)(series->n - 1);
        period->period.uncertainty =
            hypot(period->period.uncertainty, dt / sqrt(12) / period->periods);
    }
}

/* Measures the period by the method that suits the series; series_period() then tests it. Sets
 * *pace to the relative standard uncertainty that all times share. Returns false with the error. */
static bool period_by_method(const struct series *series, struct arena *arena,
                             struct period *period, double *pace, struct error *error)
{
    struct motion m;
    struct lags lags;
    struct series rows;
    struct period part;
    /* The rows of a stiff run are dense in its jumps: crossings use them at their times. */
    if (series_is_uneven(series) && wave_period(series, WAVE_EXACT, arena, period))
        return true;
    if (!series_thin(series, NULL, THIN_FOR_PERIOD, arena, &rows))
        return error_memory(error);
    if (!motion_find(&m, &rows, arena, NULL, error))
        return false;
    const bool exact = overview_is_exact(&m.overview),
               found = m.overview.oscillates && sine_period(series, &m, arena, period);
    *pace = fmax(*pace, m.samples.pace);
    if (!found && (overview_is_constant(&m.overview) || m.buried))
        return motion_refuse_known(&m, NULL, NULL, error);
    const bool has_lags = lags_init(&rows, found ? period->period.value : NAN, arena, &lags);
    if (!found) {
        if (!period_without_sine(series, &rows, &m, &lags, arena, period, error))
            return false;
        if (!exact)
            widen_by_edges(series, period);
        return true;
    }
    const bool supported = has_lags && lags_support(&lags, period->period.value);
    if (m.tracked && !exact && !supported && swing_period(&rows, arena, &part) &&
        fabs(log(part.period.value / period->period.value)) > OTHER_PERIOD_LOG)
        *period = part;
    else if (has_lags)
        take_multiple(exact ? series : &rows, exact, &lags, arena, period);
    if (!exact && (m.tracked || is_poor(&m))) {
        prefer_cycles(series, &rows, arena, period);
        widen_by_edges(series, period);
    }
    return true;
}

/* Measures the period of a series by a fast method if it is smooth, else by the general one, whose
 * result is then tested by waves and cycles. Returns false with the error. */
bool series_period(const struct series *series, struct arena *arena, struct period *period,
                   struct error *error)
{
    double pace = series->pace;
    /* A smooth series is not tested further: a subharmonic would shift every second crossing. */
    const bool smooth = smooth_period(series, arena, period);
    if (!smooth && !period_by_method(series, arena, period, &pace, error))
        return false;
    if (!smooth) {
        period_check_waves(series, arena, period);
        period_doubt(series, arena, period);
    }
    period->period = measured_at_pace(period->period, pace);
    return true;
}
