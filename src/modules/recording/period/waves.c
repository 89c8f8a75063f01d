/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Waves one by one: the stretches above the middle level. Their number distinguishes a period from
 * several of them, and the variation of the times between them shows how well their mean is
 * known. */
#include "modules/recording/period/cycle.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    LEVEL_ROWS = 512, /* rows from which the levels are read */
    WAVES_MIN = 6,    /* fewer show no variation */
    /* Rows from which the noise is estimated. */
    NOISE_ROWS = 2048,
};

/* Quantiles of the rows that count as low and high level, without outliers. */
static const double low_share = 0.01, high_share = 0.99;
/* Relative to the distance between the levels: how far a wave must exceed the middle on either
 * side, and the largest noise. */
static const double beyond_middle = 0.15, noise_max = 0.05;

/* Times of waves, and statistics of the times between neighbours. */
struct waves {
    double *t; /* [n] middle of each wave */
    size_t n;
    double gap, spread;       /* [s] mean and standard deviation */
    double shortest, longest; /* [s] extremes */
    /* [s] robust standard deviation of the times, which a few missing waves do not change */
    double typical;
    double noise;       /* [s] shift of one of these times by noise */
    double correlation; /* lag 1; -1/2 if each wave is off its place independently */
};

/* Sets the middle level of a series, the hysteresis about it, and the noise, from samples of it.
 * Returns false if noise may exceed the hysteresis. */
static bool find_levels(const struct series *s, double *middle, double *hysteresis, double *noise)
{
    double value[LEVEL_ROWS], scratch[NOISE_ROWS];
    const size_t rows = s->n < LEVEL_ROWS ? s->n : LEVEL_ROWS;
    const size_t part = s->n < NOISE_ROWS ? s->n : NOISE_ROWS;
    for (size_t i = 0; i < rows; i++)
        value[i] = s->y[s->n * i / rows];
    const double low = values_quantile(value, rows, low_share),
                 high = values_quantile(value, rows, high_share);
    unsigned char use[NOISE_ROWS];
    memset(use, 1, part);
    *noise = samples_noise(&(struct samples){.t = s->t, .y = s->y, .n = part, .use = use}, scratch);
    *middle = low + 0.5 * (high - low);
    *hysteresis = beyond_middle * (high - low);
    return high > low && *noise < noise_max * (high - low);
}

/* Returns the time at which the line between rows next - 1 and next passes a level. */
static double passes_level(const struct series *s, size_t next, double level)
{
    const double a = s->y[next - 1] - level, b = s->y[next] - level;
    return s->t[next - 1] + (s->t[next] - s->t[next - 1]) * (a / (a - b));
}

/* Stores in w the middle time of each wave, a stretch above the middle level. Returns the mean
 * shift [s] of an edge by noise. */
static double find_waves(const struct series *s, double middle, double hysteresis, double noise,
                         struct waves *w)
{
    double begin = NAN, shift = 0;
    size_t crossed = 0;
    int side = 0;
    for (size_t i = 1; i < s->n; i++) {
        const double deviation = s->y[i] - middle;
        if ((deviation > 0) != (s->y[i - 1] - middle > 0))
            crossed = i;
        const int now = level_side(deviation, hysteresis);
        if (now == 0 || now == side)
            continue;
        if (side != 0 && crossed > 0) {
            const double t = passes_level(s, crossed, middle);
            if (now < 0 && isfinite(begin)) {
                w->t[w->n++] = 0.5 * (begin + t);
                shift += noise * (s->t[crossed] - s->t[crossed - 1]) /
                         fmax(fabs(s->y[crossed] - s->y[crossed - 1]), noise);
            }
            begin = now > 0 ? t : NAN;
        }
        side = now;
    }
    return w->n > 0 ? shift / (double)w->n : 0;
}

/* Returns a robust standard deviation of the times between waves, which ignores a few missing
 * waves. deviation [n] is work space. */
static double typical_spread(const struct waves *w, double *deviation)
{
    static const double normal = 1.4826; /* standard deviations of a median distance */
    const size_t gaps = w->n - 1;
    for (size_t i = 0; i < gaps; i++)
        deviation[i] = w->t[i + 1] - w->t[i];
    const double middle = values_quantile(deviation, gaps, 0.5);
    for (size_t i = 0; i < gaps; i++)
        deviation[i] = fabs(w->t[i + 1] - w->t[i] - middle);
    return normal * values_quantile(deviation, gaps, 0.5);
}

/* Computes the statistics of the times between the waves. */
static void describe_gaps(struct waves *w)
{
    double square = 0, product = 0, previous = 0;
    w->gap = (w->t[w->n - 1] - w->t[0]) / (double)(w->n - 1);
    w->shortest = HUGE_VAL;
    for (size_t i = 1; i < w->n; i++) {
        const double gap = w->t[i] - w->t[i - 1], deviation = gap - w->gap;
        square += deviation * deviation;
        product += deviation * previous;
        previous = deviation;
        w->shortest = fmin(w->shortest, gap);
        w->longest = fmax(w->longest, gap);
    }
    w->spread = sqrt(square / (double)(w->n - 2));
    w->correlation = square > 0 ? product / square : 0;
}

/* Finds and describes the waves. Returns false if there are too few, if some may be missing, or if
 * noise hides them. */
static bool waves_init(const struct series *s, struct arena *arena, struct waves *w)
{
    static const double shortest_min = 0.3, longest_max = 2.2; /* mean gaps */
    double middle, hysteresis, noise;
    *w = (struct waves){.n = 0};
    if (s->n < 4 * WAVES_MIN || !find_levels(s, &middle, &hysteresis, &noise))
        return false;
    w->t = arena_array(arena, s->n / 2 + 1, sizeof *w->t);
    if (!w->t)
        return false;
    w->noise = find_waves(s, middle, hysteresis, noise, w);
    if (w->n < WAVES_MIN)
        return false;
    describe_gaps(w);
    double *deviation = arena_array(arena, w->n, sizeof *deviation);
    if (!deviation)
        return false;
    w->typical = typical_spread(w, deviation);
    return w->shortest > shortest_min * w->gap && w->longest < longest_max * w->gap;
}

/* Returns the standard deviation of the times that `waves` waves take, about `period` [s]. */
static double spread_after(const struct waves *w, size_t waves, double period)
{
    double square = 0;
    for (size_t i = 0; i + waves < w->n; i++) {
        const double deviation = w->t[i + waves] - w->t[i] - period;
        square += deviation * deviation;
    }
    return sqrt(square / (double)(w->n - waves));
}

/* Returns true if the times between waves vary by more than noise and interpolation explain. */
static bool gaps_vary(const struct waves *w)
{
    static const double chance = 3, small = 0.01;
    return w->typical > chance * w->noise && w->typical > small * w->gap;
}

/* Takes the mean time between waves as the period, with a warning. */
static void take_mean_gap(const struct waves *w, struct period *period)
{
    const double gaps = (double)(w->n - 1);
    *period = (struct period){.period = {w->gap, w->spread * sqrt(1.2 / gaps)},
                              .first = w->t[0],
                              .last = w->t[w->n - 1],
                              .periods = gaps,
                              .level = period->level,
                              .how = "up-crossings"};
    snprintf(period->warning, sizeof period->warning,
             "single waves take %.4g to %.4g s (a varying frequency, or jitter); T is the mean",
             w->shortest, w->longest);
}

/* Accepts a rhythm of at least 8 waves whose spacing does not vary too much. */
bool waves_period(const struct series *series, struct arena *arena, struct period *period)
{
    /* relative to the mean gap; with more there is no rhythm */
    static const double spread_max = 0.4;
    enum { SURE = 8 };
    struct waves w;
    *period = (struct period){.level = NAN};
    if (!waves_init(series, arena, &w) || w.n < SURE || w.spread > spread_max * w.gap)
        return false;
    take_mean_gap(&w, period);
    return true;
}

/* Compares the period with the number of waves that it contains and with their spacing; replaces it
 * by the mean time between waves, widens it, or warns, if these vary. */
void period_check_waves(const struct series *series, struct arena *arena, struct period *period)
{
    /* The pattern of waves repeats if they come within this share of the spread, */
    static const double repeats = 0.08;
    static const double chance = 4; /* or within this number of standard deviations of the noise. */
    /* Relative distance of T from a whole number of waves. */
    static const double whole_number = 0.05;
    /* Correlation of the times between waves that are off their places independently, and the
     * chance deviation from it in units of 1/sqrt(n). */
    static const double alone = -0.5, alone_chance = 0.9;
    enum { SEVERAL = 4 };
    struct waves w;
    if (!waves_init(series, arena, &w) || !gaps_vary(&w))
        return;
    const double many = period->period.value / w.gap,
                 mean_sigma = w.spread * sqrt(1.2 / (double)(w.n - 1));
    const size_t count = (size_t)(many + 0.5);
    /* The period is no whole number of waves where some are missing or others among them. */
    if (count < 1 || count + 2 > w.n || fabs(many / (double)count - 1) > whole_number)
        return;
    if (count >= 2) {
        if (spread_after(&w, count, period->period.value) >
            fmax(repeats * w.spread, chance * w.noise))
            take_mean_gap(&w, period);
        else if (count >= SEVERAL && !period->warning[0])
            snprintf(period->warning, sizeof period->warning,
                     "T contains %zu waves of %.4g to %.4g s; if their frequency varies, their "
                     "mean is %.4g s",
                     count, w.shortest, w.longest, w.gap);
        return;
    }
    if (fabs(period->period.value - w.gap) > chance * hypot(mean_sigma, period->period.uncertainty))
        take_mean_gap(&w, period);
    else if (w.correlation > alone + alone_chance / sqrt((double)w.n))
        period->period.uncertainty = fmax(period->period.uncertainty, mean_sigma);
}
