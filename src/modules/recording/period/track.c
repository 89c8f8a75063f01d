/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Follows an oscillation window by window (track.h), and reads its period from the phases. */
#include <hooke/base/cancel.h>
#include "modules/recording/period/track.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Columns of a local fit; samples of a window; widest window in periods; numbers of clear windows
 * that are few or many; samples a period in means of a long recording. */
enum { COLUMNS = 5, WINDOW_SAMPLES = 10, PERIODS_MAX = 32, FEW = 2, MANY = 8, ROWS_A_PERIOD = 24 };

#define PART_ROWS 14.0 /* rows of a part, divided by the square root of those of the recording */
#define BEAT_MIN 0.6   /* [beats with the sampling] below which cosine and sine are too similar */
#define CLEAR_AT 5.0   /* explained over residual variance, per degree of freedom */
#define PIVOT_MIN 1e-8 /* squared sine of the angle between a column and those before it */
/* Part of a window's correction to the frequency that is applied at once. */
#define FREQUENCY_GAIN 0.5
/* Part of a window that must be filled; with less, beside a gap, it is too short for a phase. */
#define WINDOW_FILLED_MIN 0.6
/* Largest relative distance of the frequency from its start. */
#define FREQUENCY_STRAY_RELATIVE 0.35

/* Gram matrix of the columns 1, s, s^2, cos, sin and y. */
struct track_gram {
    double gram[COLUMNS + 1][COLUMNS + 1]; /* lower triangle; the last row belongs to y */
    size_t used;
};

/* Adds the products of one sample's columns to the lower triangle. */
static inline void add_sample(double gram[COLUMNS + 1][COLUMNS + 1], double x, double c, double d,
                              double y)
{
    const double column[COLUMNS + 1] = {1, x, x * x, c, d, y};
#pragma GCC unroll 8
    for (int i = 0; i <= COLUMNS; i++) {
#pragma GCC unroll 8
        for (int j = 0; j <= i; j++)
            gram[i][j] += column[i] * column[j];
    }
}

/* Returns the products of the columns over a window's samples; `half` scales s to -1 … 1. */
static struct track_gram window_products(const struct samples *x, const struct track_window *w,
                                         double half)
{
    struct track_gram m = {.used = 0};
    double gram[COLUMNS + 1][COLUMNS + 1] = {
        {0}}; /* a local array, so that it can stay in registers */
    const double scale = 1 / half;
    const double first = w->omega * (x->t[w->begin] - w->t), y0 = x->y[w->begin];
    double c = cos(first), d = sin(first), re = cos(w->omega * x->dt), im = sin(w->omega * x->dt);
    for (size_t i = w->begin; i < w->end; i++) {
        const double s = x->t[i] - w->t;
        if (!x->uniform) {
            c = cos(w->omega * s);
            d = sin(w->omega * s);
        }
        if (x->use[i]) {
            add_sample(gram, s * scale, c, d, x->y[i] - y0);
            m.used++;
        }
        const double next = c * re - d * im;
        d = c * im + d * re;
        c = next;
    }
    memcpy(m.gram, gram, sizeof gram);
    return m;
}

/* Replaces the matrix by its Cholesky factor, and the row of y by its components. Returns false if
 * a column is hardly independent of those before it. */
static bool factorise(struct track_gram *m)
{
    double *r = m->gram[COLUMNS], square = r[COLUMNS];
    if (!matrix_cholesky(COLUMNS, COLUMNS + 1, &m->gram[0][0], PIVOT_MIN, &m->gram[0][0]))
        return false;
    cholesky_forward(COLUMNS, COLUMNS + 1, &m->gram[0][0], r);
    for (int k = 0; k < COLUMNS; k++)
        square -= r[k] * r[k];
    r[COLUMNS] = sqrt(fmax(square, 0));
    return true;
}

/* Fits the sine with w->omega to the window: amplitude, and phase in (-pi, pi] at its middle. */
static void fit_window(const struct samples *x, struct track_window *w)
{
    if (cancelled(x->cancel))
        return;
    const double half = 0.5 * (x->t[w->end - 1] - x->t[w->begin]);
    struct track_gram m = {.used = 0};
    w->clear = false;
    w->amplitude = w->explained = w->rss = 0;
    w->sigma = w->phase_error = NAN;
    if (half > 0)
        m = window_products(x, w, half);
    w->used = m.used;
    if (m.used < COLUMNS + 2 || !factorise(&m))
        return;
    w->mean = x->y[w->begin] + m.gram[COLUMNS][0] / m.gram[0][0];
    const double *r = m.gram[COLUMNS], pc = r[3], pd = r[4];
    const double q = pd / m.gram[4][4], p = (pc - m.gram[4][3] * q) / m.gram[3][3];
    const double freedom = (double)(m.used - COLUMNS),
                 tiny = 1e-13 * (m.gram[COLUMNS][0] * m.gram[COLUMNS][0]);
    w->explained = pc * pc + pd * pd;
    w->rss = m.gram[COLUMNS][COLUMNS] * m.gram[COLUMNS][COLUMNS];
    w->amplitude = hypot(p, q);
    w->phase = atan2(-q, p);
    const double variance = w->rss / freedom, spread = 0.5 * (1 / (m.gram[3][3] * m.gram[3][3]) +
                                                              1 / (m.gram[4][4] * m.gram[4][4]));
    w->sigma = w->amplitude > 0 ? sqrt(variance * spread) / w->amplitude : NAN;
    w->clear = w->explained > 2 * CLEAR_AT * variance && w->explained > tiny && w->amplitude > 0;
}

/* Returns the first sample after a gap among begin to end - 1, or `end` if there is none. A gap is
 * a step of several usual ones and of a part of the width. */
static size_t after_gap(const struct samples *x, size_t begin, size_t end, double width)
{
    static const double gap_steps = 8, gap_widths = 0.02;
    const double gap = fmax(gap_steps * x->dt, gap_widths * width);
    size_t i = begin;
    while (i < end && (i == 0 || x->t[i] - x->t[i - 1] <= gap))
        i++;
    return i;
}

/* Divides the series into windows of equal width [s] with enough samples each; none spans a gap.
 * Returns false if out of memory. */
static bool divide_into_windows(const struct samples *x, double width, struct arena *arena,
                                struct track *track)
{
    const double span = x->t[x->n - 1] - x->t[0];
    const size_t count = (size_t)fmax(1, floor(span / width + 0.1));
    track->window = arena_array(arena, count, sizeof *track->window);
    if (!track->window)
        return false;
    size_t begin = 0;
    bool gap = false;
    for (size_t k = 0; k < count; k++) {
        const double end = x->t[0] + span * (double)(k + 1) / (double)count;
        const size_t next = k + 1 < count ? samples_index(x, end) : x->n,
                     split = after_gap(x, begin, next, width);
        struct track_window w = {.begin = begin, .end = next, .after_gap = gap};
        if (split < next) { /* keep the larger side of the gap */
            w.after_gap = gap || split - begin <= next - split;
            *(split - begin > next - split ? &w.end : &w.begin) = split;
        }
        gap = gap || split < next;
        begin = next;
        if (w.end < w.begin + COLUMNS + 2 ||
            x->t[w.end - 1] - x->t[w.begin] < WINDOW_FILLED_MIN * span / (double)count)
            continue; /* too few samples or too short */
        gap = split < next && w.end == split;
        w.t = 0.5 * (x->t[w.begin] + x->t[w.end - 1]);
        track->window[track->windows++] = w;
    }
    return true;
}

/* Fits all windows with omega. Returns the number of the one that the sine describes best, or
 * `windows` if none is clear. */
static size_t best_window(const struct samples *x, double omega, struct track *track)
{
    size_t best = track->windows;
    double max = 0;
    for (size_t k = 0; k < track->windows; k++) {
        struct track_window *w = &track->window[k];
        w->omega = omega;
        fit_window(x, w);
        const double merit = w->clear ? w->explained * w->explained / (w->explained + w->rss) : 0;
        if (merit > max) {
            max = merit;
            best = k;
        }
    }
    return best;
}

/* Fits windows in one direction (1 or -1) from `start` on, each at the frequency found by those
 * before it, first omega. */
static void follow_frequency(const struct samples *x, struct track *track, size_t start,
                             int direction, double omega)
{
    const double min = (1 - FREQUENCY_STRAY_RELATIVE) * omega,
                 max = (1 + FREQUENCY_STRAY_RELATIVE) * omega;
    struct track_window *previous = &track->window[start];
    for (size_t k = start + (size_t)direction; k < track->windows; k += (size_t)direction) {
        struct track_window *w = &track->window[k];
        w->omega = omega;
        fit_window(x, w);
        const double step = w->t - previous->t, expected = previous->phase + omega * step;
        const double phase_error = remainder(w->phase - expected, TWO_PI);
        w->phase = expected + phase_error;
        if (!w->clear)
            continue;
        w->phase_error = phase_error;
        omega = fmin(fmax(omega + FREQUENCY_GAIN * phase_error / step, min), max);
        previous = w;
    }
}

/* Computes the mean frequency from the phases, the coherence, and the explained share. */
static void conclude_track(struct track *track)
{
    double weight = 0, cosine = 0, explained = 0, rss = 0;
    const struct track_window *first = NULL, *last = NULL;
    for (size_t k = 0; k < track->windows; k++) {
        const struct track_window *w = &track->window[k];
        if (!w->clear)
            continue;
        first = first ? first : w;
        last = w;
        track->clear++;
        if (isfinite(w->phase_error)) {
            weight += w->amplitude;
            cosine += w->amplitude * cos(w->phase_error);
        }
    }
    for (const struct track_window *w = first; w && w <= last; w++) {
        explained += w->explained;
        rss += w->rss;
    }
    track->coherence = weight > 0 ? cosine / weight : 0;
    track->explained = explained;
    track->fraction = explained > 0 ? explained / (explained + rss) : 0;
    track->omega = first ? first->omega : NAN;
    if (last > first)
        track->omega = (last->phase - first->phase) / (last->t - first->t);
}

/* Returns the width of the windows [s]. */
static double window_width(const struct samples *x, double omega, double periods)
{
    const double beat = 0.5 - omega * x->dt / TWO_PI; /* [1/sample] from the Nyquist frequency */
    return fmax(periods * TWO_PI / omega,
                fmax(WINDOW_SAMPLES, BEAT_MIN / fmax(beat, 1e-3)) * x->dt);
}

/* Tracks the oscillation in windows of `periods` periods, in one pass from time t_start [s], where
 * its frequency is omega. Returns false if out of memory. */
static bool track_from(const struct samples *x, double omega, double periods, double t_start,
                       struct arena *arena, struct track *track)
{
    *track = (struct track){.omega = NAN, .periods = periods};
    if (!divide_into_windows(x, window_width(x, omega, periods), arena, track))
        return false;
    size_t start = 0;
    while (start + 1 < track->windows && track->window[start + 1].t <= t_start)
        start++;
    if (track->windows > 0) {
        track->window[start].omega = omega;
        fit_window(x, &track->window[start]);
        follow_frequency(x, track, start, 1, omega);
        follow_frequency(x, track, start, -1, omega);
    }
    conclude_track(track);
    return true;
}

/* Returns the frequency between the best window and its neighbours, or omega if these are not
 * clear. */
static double refined_frequency(const struct track *track, size_t start, double omega)
{
    double sum = 0, count = 0;
    for (size_t k = start > 0 ? start - 1 : 0; k + 1 < track->windows && k <= start; k++) {
        const struct track_window *a = &track->window[k], *b = a + 1;
        if (a->clear && b->clear) {
            sum += (b->phase - a->phase) / (b->t - a->t);
            count++;
        }
    }
    return count > 0 && fabs(sum / count / omega - 1) < FREQUENCY_STRAY_RELATIVE ? sum / count
                                                                                 : omega;
}

/* Tracks an oscillation of about omega from the window that this frequency describes best. */
bool track_follow(const struct samples *x, double omega, double periods, struct arena *arena,
                  struct track *track)
{
    *track = (struct track){.omega = NAN, .periods = periods};
    if (!divide_into_windows(x, window_width(x, omega, periods), arena, track))
        return false;
    const size_t start = best_window(x, omega, track);
    for (int pass = 0; pass < 2 && start < track->windows; pass++) {
        follow_frequency(x, track, start, 1, omega);
        follow_frequency(x, track, start, -1, omega);
        const double better = refined_frequency(track, start, omega);
        if (better == omega)
            break;
        omega = better;
        track->window[start].omega = omega;
        fit_window(x, &track->window[start]);
    }
    if (start < track->windows) {
        follow_frequency(x, track, start, 1, omega);
        follow_frequency(x, track, start, -1, omega);
    }
    conclude_track(track);
    return true;
}

/* Thousands of bumps, steps, exponentials and random walks stay well below these limits
 * (tests/modules/recording/analysis/detect.c); a few windows must explain nearly everything. */
bool track_is_oscillation(const struct track *track)
{
    const bool all = track->clear >= FEW && track->coherence > 0.9 && track->fraction > 0.9;
    return all || (track->clear >= MANY && track->coherence > 0.85 && track->fraction > 0.2);
}

/* Returns true if `track` is the fundamental of an oscillation whose strong harmonic was followed,
 * too. */
static bool is_fundamental(const struct track *track, const struct track *harmonic)
{
    const double ratio = harmonic->omega / track->omega;
    return track->clear >= FEW && track->coherence > 0.9 &&
           track->explained > 0.3 * harmonic->explained &&
           (fabs(ratio - 2) < 0.05 || fabs(ratio - 3) < 0.05);
}

/* Returns true if the track explains nearly everything, so that no other frequency need be
 * tried. */
static bool explains_all(const struct track *track)
{
    static const double coherence_min = 0.95, fraction_min = 0.9;
    return track->coherence > coherence_min && track->fraction > fraction_min;
}

/* Returns true if omega may be the fundamental of which the track is the second or third
 * harmonic. */
static bool may_be_fundamental(double omega, const struct track *harmonic)
{
    static const double ratio_min = 1.4, ratio_max = 4;
    const double ratio = harmonic->omega / omega;
    return ratio > ratio_min && ratio < ratio_max;
}

/* Follows a frequency in the narrowest windows that show an oscillation or, unless NULL, the
 * fundamental of `harmonic`. Returns false if none do; *memory becomes false if out of memory. */
static bool follow_narrowly(const struct samples *x, double omega, const struct track *harmonic,
                            struct arena *arena, struct track *trial, bool *memory)
{
    bool found = false;
    for (int periods = 2; periods <= PERIODS_MAX && *memory && !found; periods *= 2) {
        *memory = track_follow(x, omega, periods, arena, trial);
        found =
            *memory && (harmonic ? is_fundamental(trial, harmonic) : track_is_oscillation(trial));
    }
    return found;
}

/* Finds the best track: from peaks of spectra of 1, 8 and 32 parts, then from its fundamentals. */
bool track_find(const struct samples *x, struct arena *arena, struct track *track)
{
    enum { PEAKS = 5 };
    static const size_t parts[] = {1, 8, 32};
    double omega[PEAKS * COUNT_OF(parts)];
    bool memory = true;
    int count = 0;
    struct track best = {.omega = NAN}, trial;
    for (size_t k = 0; k < COUNT_OF(parts) && memory && !explains_all(&best); k++) {
        const int first = count;
        count += mean_spectrum_peaks(x, parts[k], omega + count, PEAKS, &memory);
        for (int i = first; i < count && memory && !explains_all(&best); i++)
            if (follow_narrowly(x, omega[i], NULL, arena, &trial, &memory) &&
                !(trial.explained * trial.coherence <= best.explained * best.coherence))
                best = trial;
    }
    for (int i = 0; i < count && memory && !explains_all(&best); i++)
        if (may_be_fundamental(omega[i], &best) &&
            follow_narrowly(x, omega[i], &best, arena, &trial, &memory))
            best = trial;
    *track = best;
    return memory;
}

/* ---- long recordings ---- */

/* Averages groups of `each` neighbouring samples. Returns false if out of memory. */
static bool average_samples(const struct samples *x, size_t each, struct arena *arena,
                            struct samples *result)
{
    const struct samples all = {.t = x->t, .y = x->y, .n = x->n, .cancel = x->cancel};
    struct series means;
    return samples_average(&all, each, arena, &means) && !cancelled(x->cancel) &&
           samples_init(result, &means, arena);
}

/* Returns the explained power per sample. */
static double window_power(const struct track *track, const struct samples *x)
{
    return track->omega > 0 ? track->explained / (double)x->n : 0;
}

/* Searches the oscillation of a long recording in a part and in means of neighbours, the livelier
 * one first, and follows the better track through all. Returns false if out of memory. */
bool track_long(const struct samples *x, struct arena *arena, struct track *track)
{
    /* A part of this size has some periods of any oscillation that is lost in means over the whole.
     */
    const size_t rows = (size_t)(PART_ROWS * sqrt((double)x->n));
    struct samples coarse, part = samples_part(x, (x->n - rows) / 2, (x->n + rows) / 2);
    struct track fast, slow;
    *track = (struct track){.omega = NAN};
    /* Slow oscillations remain in means of neighbours; fast ones are also present in a part. */
    if (!average_samples(x, x->n / rows, arena, &coarse))
        return false;
    const double half = 0.5 * values_variance(x->y, x->n);
    const struct samples *rows_of[2] = {&part, &coarse};
    struct track *found[2] = {&fast, &slow};
    const bool is_slow = values_variance(coarse.y, coarse.n) > half;
    fast = slow = (struct track){.omega = NAN};
    if (!track_find(rows_of[is_slow], arena, found[is_slow]))
        return false;
    const bool enough = window_power(found[is_slow], rows_of[is_slow]) > half;
    if (!enough && !track_find(rows_of[!is_slow], arena, found[!is_slow]))
        return false;
    const struct track *best =
        window_power(&fast, &part) > window_power(&slow, &coarse) ? &fast : &slow;
    const struct track_window *strongest = NULL;
    for (size_t k = 0; k < best->windows && best->omega > 0; k++) {
        const struct track_window *w = &best->window[k];
        strongest = w->clear && (!strongest ||
                                 w->explained * strongest->rss > strongest->explained * w->rss)
                        ? w
                        : strongest;
    }
    if (!strongest)
        return true;
    /* These means have enough samples a period to contain all of the oscillation. */
    const size_t each = (size_t)fmax(TWO_PI / (strongest->omega * x->dt * ROWS_A_PERIOD), 1);
    struct series means;
    if (each == 1)
        return track_from(x, strongest->omega, best->periods, strongest->t, arena, track);
    return samples_average(x, each, arena, &means) && samples_init(&coarse, &means, arena) &&
           track_from(&coarse, strongest->omega, best->periods, strongest->t, arena, track);
}

/* ---- the period from phases ---- */

/* Adds the delay of the phases by friction, which a decay that speeds up shows, to the uncertainty,
 * and warns: the period may seem too long. */
static void warn_friction(struct cycle_times *log_amplitude, double omega, struct period *period)
{
    static const double rises_at = 3; /* standard deviations of the curvature of ln A */
    static const double late = 1.8;   /* 1.4 to 1.8 in recordings whose motion is known */
    static const double normal_95 = 1.96;
    const double rise = -times_curvature(log_amplitude, rises_at), /* [1/s^2] of the decay rate */
        delay = late * fmax(rise, 0) / (omega * omega) * period->period.value;
    if (delay > normal_95 * period->period.uncertainty && !period->warning[0])
        snprintf(period->warning, sizeof period->warning,
                 "the decay speeds up, as with dry friction, which delays the phases; T may be up "
                 "to %.2g s too long ('fit drag' includes this)",
                 delay);
    period->period.uncertainty = hypot(period->period.uncertainty, delay / normal_95);
}

/* Returns the time of the upward crossing of the baseline next to the window's middle. */
static double crossing_near(const struct track_window *w)
{
    return w->t - remainder(w->phase + 0.5 * PI, TWO_PI) / w->omega;
}

/* Reads the period from a line through the phases of clear windows, and tests their decay. */
bool track_period(const struct track *track, struct arena *arena, struct period *period)
{
    enum { PHASES_MIN = 4 };
    static const double rounding = 1e-9; /* [rad] */
    const struct track_window *first = NULL, *last = NULL;
    struct cycle_times time, log_amplitude;
    double weight = 0, level = 0;
    bool gap = false;
    if (!cycle_times_init(&time, track->windows, arena) ||
        !cycle_times_init(&log_amplitude, track->windows, arena))
        return false;
    for (size_t k = 0; k < track->windows; k++) {
        const struct track_window *w = &track->window[k];
        gap = gap || w->after_gap;
        if (!w->clear)
            continue;
        level += w->mean * (double)w->used;
        weight += (double)w->used;
        if (!(w->sigma < 1))
            continue;
        last = w;
        first = first ? first : w;
        cycle_times_add(&time, w->t, fmax(w->sigma, rounding) / w->omega, w->phase / TWO_PI, gap);
        gap = false;
        cycle_times_add(&log_amplitude, log(w->amplitude), fmax(w->sigma, rounding), w->t, false);
    }
    *period = (struct period){.level = level / weight, .how = "phases"};
    if (!first || time.n < PHASES_MIN || !times_period(&time, false, arena, period))
        return false;
    period->first = crossing_near(first);
    period->last = crossing_near(last);
    period->periods = nearbyint((period->last - period->first) / period->period.value);
    if (log_amplitude.n > PHASES_MIN)
        warn_friction(&log_amplitude, TWO_PI / period->period.value, period);
    return true;
}
