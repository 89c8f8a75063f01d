/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the part of a series that oscillates: tries windows on a grid, the longest first, each with
 * its own damped sine; then both ends are moved outwards as long as the sine describes the
 * samples. */
#include <hooke/base/cancel.h>
#include "modules/recording/series/internal.h"

#include <math.h>

enum {
    /* Equal parts of the series from which windows are composed. */
    GRID_PARTS = 9,
    GRID_TRIM_MAX = 6,      /* parts that both ends together may lose */
    SWING_SAMPLES_MIN = 24, /* fewer samples show no shape */
};

/* Fewer periods prove no oscillation: a step that settles has one cycle and some rest. */
static const double swing_periods_min = 2.5;
/* A damped sine describes a window if its residuals do not exceed the noise by more than this
 * factor and are hardly correlated. */
static const double residual_noises_max = 1.6;
static const double residual_autocorrelation_max = 0.5;
/* If the wave has another shape, residuals may have this share of the power over many periods. */
static const double residual_power_max = 0.06;
static const double shape_periods_min = 5;
static const double rejected_share_max = 0.1;

/* Returns true if the damped sine of m describes its samples. */
static bool sine_describes(const struct motion *m)
{
    const struct samples *x = &m->samples;
    double power = 0, square = 0;
    if (!m->overview.oscillates || !m->harmonic.converged ||
        m->overview.periods < swing_periods_min ||
        (double)m->rejected > rejected_share_max * (double)x->n)
        return false;
    for (size_t i = 0; i < x->n; i++) {
        const double drift = m->harmonic.d * (x->t[i] - m->harmonic.origin),
                     deviation = x->y[i] - m->harmonic.c - drift;
        power += x->use[i] ? deviation * deviation : 0;
        square += x->use[i] ? m->residual[i] * m->residual[i] : 0;
    }
    const double left = harmonic_sigma(&m->harmonic, FREE_GAMMA);
    const bool is_noise = left <= residual_noises_max * m->overview.noise &&
                          m->autocorrelation < residual_autocorrelation_max;
    return (is_noise && square < 0.5 * power) ||
           (m->overview.periods >= shape_periods_min && square < residual_power_max * power);
}

/* Returns the value of the damped sine at time t, and sets *envelope to its amplitude there. */
static double sine_value(const struct harmonic *h, double t, double *envelope)
{
    const double s = t - h->origin, fall = exp(-0.5 * h->gamma * s);
    *envelope = fall * hypot(h->a, h->b);
    return h->c + h->d * s + fall * (h->a * cos(h->omega * s) + h->b * sin(h->omega * s));
}

/* Moves one end of the window outwards, in `direction` (1 or -1), sample by sample up to number
 * `limit` or until NEIGHBOURS samples in a row are off the sine of m. Returns the number of the
 * last sample that lies on the sine. */
static size_t extend_end(const struct series *s, const struct motion *m, size_t end, size_t limit,
                         int direction)
{
    enum { NEIGHBOURS = 3 };
    const double left = harmonic_sigma(&m->harmonic, FREE_GAMMA),
                 noise = fmax(left, m->overview.noise);
    size_t good = end;
    int outliers = 0;
    while (outliers < NEIGHBOURS && end != limit) {
        double envelope;
        end += (size_t)direction;
        const double value = sine_value(&m->harmonic, s->t[end], &envelope);
        /* gamma is not exact, so a part of the envelope is no contradiction */
        const bool is_off = !(fabs(s->y[end] - value) <= 4 * noise + 0.1 * envelope);
        outliers = is_off ? outliers + 1 : 0;
        good = is_off ? good : end;
    }
    return good;
}

/* Returns samples begin to end - 1 of a series; memory is shared. */
static struct series series_part(const struct series *s, size_t begin, size_t end)
{
    struct series part = *s;
    part.t += begin;
    part.y += begin;
    part.n = end - begin;
    return part;
}

/* Fits a damped sine to samples begin to end - 1. Returns true if it describes them. */
static bool try_window(const struct series *s, size_t begin, size_t end, struct arena *arena,
                       struct motion *m)
{
    const struct series part = series_part(s, begin, end);
    return part.n >= SWING_SAMPLES_MIN && motion_one_sine(m, &part, arena) && sine_describes(m);
}

/* Moves both ends of a window outwards by at most half a period at a time, with a new sine each
 * time, as long as it describes the samples. */
static void widen_window(const struct series *s, size_t window[2], struct motion *m,
                         struct arena *arena)
{
    enum { WIDENINGS_MAX = 24 };
    for (int i = 0; i < WIDENINGS_MAX && !cancelled(s->cancel); i++) {
        const double half = 0.5 * TWO_PI / m->harmonic.omega;
        const struct samples all = {.t = s->t, .n = s->n};
        const size_t least = samples_index(&all, s->t[window[0]] - half),
                     most = samples_index(&all, s->t[window[1] - 1] + half);
        const size_t low = extend_end(s, m, window[0], least, -1),
                     high = extend_end(s, m, window[1] - 1, most < s->n ? most : s->n - 1, 1) + 1;
        struct motion wider;
        if ((low == window[0] && high == window[1]) || !try_window(s, low, high, arena, &wider))
            return;
        *m = wider;
        window[0] = low;
        window[1] = high;
    }
}

static void set_swing(const struct series *s, const size_t window[2], const struct motion *m,
                      struct swing *swing)
{
    *swing = (struct swing){.window = {s->t[window[0]], s->t[window[1] - 1]},
                            .period = TWO_PI / m->harmonic.omega,
                            .begin = window[0],
                            .end = window[1]};
}

/* Tries all windows of `parts` parts and stores the one that a sine describes best, widened.
 * Returns false if none is described. */
static bool best_of_length(const struct series *s, size_t parts, struct swing *swing)
{
    double best = HUGE_VAL;
    for (size_t first = 0; first + parts <= GRID_PARTS && !cancelled(s->cancel); first++) {
        size_t window[2] = {s->n * first / GRID_PARTS, s->n * (first + parts) / GRID_PARTS};
        struct arena arena = {0};
        struct motion m;
        if (try_window(s, window[0], window[1], &arena, &m)) {
            const double left =
                harmonic_sigma(&m.harmonic, FREE_GAMMA) / hypot(m.harmonic.a, m.harmonic.b);
            if (left < best) {
                best = left;
                widen_window(s, window, &m, &arena);
                set_swing(s, window, &m, swing);
            }
        }
        arena_reset(&arena);
    }
    return isfinite(best);
}

/* Returns the index of the first of three samples in a row that leave the level at which the series
 * begins, or n if none do. */
static size_t leaves_rest(const struct series *s, struct arena *arena)
{
    enum { REST_MIN = 8, NEIGHBOURS = 3 };
    const size_t rest = s->n / 40 > REST_MIN ? s->n / 40 : REST_MIN;
    double sum = 0, square = 0;
    for (size_t i = 0; i < rest; i++)
        sum += s->y[i];
    const double level = sum / (double)rest;
    for (size_t i = 0; i < rest; i++)
        square += (s->y[i] - level) * (s->y[i] - level);
    const double limit = 6 * fmax(sqrt(square / (double)(rest - 1)), series_noise(s, arena));
    size_t outliers = 0, i = rest;
    for (; i < s->n && outliers < NEIGHBOURS; i++)
        outliers = fabs(s->y[i] - level) > limit ? outliers + 1 : 0;
    return outliers < NEIGHBOURS ? s->n : i - NEIGHBOURS;
}

/* Tries the part after an initial rest: all of it, then its first half, quarter and so on, up to
 * `halvings` times. Returns false if no sine describes one. */
static bool after_rest(const struct series *s, size_t halvings, struct swing *swing)
{
    struct arena arena = {0};
    const size_t first = leaves_rest(s, &arena);
    bool found = false;
    for (size_t i = 0; i <= halvings && !found && !cancelled(s->cancel); i++) {
        const size_t window[2] = {first, first + ((s->n - first) >> i)};
        struct motion m;
        if (window[1] - first < SWING_SAMPLES_MIN)
            break;
        const struct series part = series_part(s, first, window[1]);
        found = motion_init(&m, &part, &arena, NULL) && !m.tracked && sine_describes(&m);
        if (found)
            set_swing(s, window, &m, swing);
        arena_reset(&arena);
    }
    arena_reset(&arena);
    return found;
}

/* Finds a part of the series that one damped sine describes, in *swing: the part after a rest, then
 * windows of decreasing length. Returns false if there is none, or if it is all of the series. */
bool find_swing(const struct series *series, struct swing *swing)
{
    struct arena arena = {0};
    struct series few;
    bool found = false;
    if (series->n >= 2 * SWING_SAMPLES_MIN && !series_is_uneven(series) &&
        series_thin(series, NULL, THIN_FOR_HINTS, &arena, &few)) {
        found = after_rest(&few, 0, swing);
        for (size_t trim = 1; trim <= GRID_TRIM_MAX && !found && !cancelled(series->cancel); trim++)
            found = best_of_length(&few, GRID_PARTS - trim, swing);
        found = found && swing->end - swing->begin < few.n;
    }
    arena_reset(&arena);
    return found;
}

/* Thins the series, then looks for the swing that follows a rest at the start. */
bool find_first_swing(const struct series *series, struct swing *swing)
{
    enum { HALVINGS = 4 };
    struct arena arena = {0};
    struct series few;
    const bool found = series->n >= 2 * SWING_SAMPLES_MIN &&
                       series_thin(series, NULL, THIN_FOR_HINTS, &arena, &few) &&
                       after_rest(&few, HALVINGS, swing);
    arena_reset(&arena);
    return found;
}
