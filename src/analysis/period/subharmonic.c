/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Periods after which a series only nearly repeats: pulses of two heights in turn, or an orbit
 * whose period has doubled. Lines between the harmonics of 1/T show it, before the series is
 * clearly more like itself after 2 T or 3 T.
 */
#include "analysis/period/cycle.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>

enum {
    LINES_MAX = 3,        /* between the harmonics, lowest first */
    SAMPLES_MAX = 8192,   /* of a series, in its middle */
    SAMPLES_A_CYCLE = 40, /* more are averaged where there are too many */
    HARMONICS_MAX = 16,
    SIDES = 3, /* places beside a line, on either side */
    DOUBLINGS_MAX = 3,
};

/* A part of a series, less its harmonics. */
struct lines {
    double *t, *y, *weight; /* weight: of each sample, through a Hann window */
    size_t n;
    double cycles;    /* of the period in question */
    double period;    /* [s] */
    double strongest; /* power of the strongest harmonic */
    double quantum;   /* step of the sensor, 0 if none shows */
    double noise;     /* mean power of a line if all that is left is white noise */
    double last;      /* power of the last harmonics below half the sampling rate */
};

struct line_sum {
    double re, im; /* amplitudes of cosine and sine about the first sample */
};

/* Returns the weight of sample i among [from, to): the time around it, through a Hann window. */
static double hann_weight(const struct lines *l, size_t i, size_t from, size_t to)
{
    const double span = l->t[to - 1] - l->t[from];
    return i == from || i == to - 1 ? 0
                                    : (l->t[i + 1] - l->t[i - 1]) / span *
                                          (1 - cos(TWO_PI * (l->t[i] - l->t[from]) / span));
}

/* Returns the amplitudes at a frequency [1/s] of samples [from, to). */
static struct line_sum line_sum(const struct lines *l, double frequency, size_t from, size_t to)
{
    const bool whole = to - from == l->n;
    struct line_sum sum = {0, 0};
    for (size_t i = from; i < to; i++) {
        const double angle = TWO_PI * frequency * (l->t[i] - l->t[from]),
                     weighted = l->y[i] * (whole ? l->weight[i] : hann_weight(l, i, from, to));
        sum.re += weighted * cos(angle);
        sum.im += weighted * sin(angle);
    }
    return sum;
}

static double line_power(const struct lines *l, double frequency, size_t from, size_t to)
{
    const struct line_sum sum = line_sum(l, frequency, from, to);
    return sum.re * sum.re + sum.im * sum.im;
}

static double harmonic_power(const struct lines *l, double multiple)
{
    return line_power(l, multiple / l->period, 0, l->n);
}

/* The mean and the harmonics up to the last one, as line_sum() has them, in one go: cosines of
 * multiples follow from one another. */
static void sum_harmonics(const struct lines *l, int last, struct line_sum *sum)
{
    for (int k = 0; k <= last; k++)
        sum[k] = (struct line_sum){0, 0};
    for (size_t i = 0; i < l->n; i++) {
        const double angle = TWO_PI * (l->t[i] - l->t[0]) / l->period, c = cos(angle),
                     s = sin(angle), weighted = l->weight[i] * l->y[i];
        double re = weighted, im = 0;
        for (int k = 0; k <= last; k++) {
            sum[k].re += re;
            sum[k].im += im;
            const double next = re * c - im * s;
            im = im * c + re * s;
            re = next;
        }
    }
}

/* Takes the mean and the harmonics away: what the window leaves of them would hide weak lines of
 * few cycles. */
static void remove_harmonics(struct lines *l, int last)
{
    struct line_sum sum[HARMONICS_MAX + 1];
    sum_harmonics(l, last, sum);
    for (size_t i = 0; i < l->n; i++) {
        const double angle = TWO_PI * (l->t[i] - l->t[0]) / l->period, c = cos(angle),
                     s = sin(angle);
        double re = 1, im = 0, all = 0.5 * sum[0].re;
        for (int k = 1; k <= last; k++) {
            const double next = re * c - im * s;
            im = im * c + re * s;
            re = next;
            all += sum[k].re * re + sum[k].im * im;
        }
        l->y[i] -= all;
    }
}

/* Returns the power of a line in units of the mean of what lies beside it. */
static double line_contrast(const struct lines *l, double multiple, double power)
{
    static const double places[SIDES] = {2, 2.5, 3}; /* over the span: beside the window's lobe */
    double beside = 0;
    for (int k = 0; k < SIDES; k++)
        beside += harmonic_power(l, multiple - places[k] / l->cycles) +
                  harmonic_power(l, multiple + places[k] / l->cycles);
    return power * 2 * SIDES / beside;
}

/* Returns true if harmonics above half the sampling rate fall on the lines between the harmonics.
 */
static bool lines_are_folded(const struct lines *l, int n)
{
    const double samples = (double)(l->n - 1) / l->cycles, off = remainder(samples, 1);
    return fabs(remainder(n * off, 1)) < 2 * n / l->cycles && fabs(off) > 2 / l->cycles;
}

/* Returns true if a line lasts: one that dies out belongs to what the motion has been on its way to
 * the period. */
static bool line_lasts(const struct lines *l, double multiple)
{
    static const double lasting = 0.25; /* of the power */
    const size_t half = l->n / 2;
    return l->cycles < 20 || line_power(l, multiple / l->period, half, l->n) >
                                 lasting * line_power(l, multiple / l->period, 0, half);
}

/* Returns the amplitude of the lines at the multiples of 1/(n T) that are not those of 1/T, over
 * that of the strongest harmonic; 0 if they do not stand out. */
static double lines_between(const struct lines *l, int n)
{
    static const double one_stands_out = 40, two_stand_out = 15, power_min = 1e-6;
    /* rounding may repeat after several cycles */
    const double rounding = 0.1 * l->quantum,
                 chance = fmax(two_stand_out * l->noise, rounding * rounding),
                 least = fmax(fmax(power_min * l->strongest, chance),
                              lines_are_folded(l, n) ? 4 * l->last : 0);
    double highest = 0, line = 0;
    int clear = 0, sure = 0;
    for (int k = 1, lines = 0; lines < LINES_MAX; k++) {
        if (k % n == 0)
            continue;
        lines++;
        const double multiple = (double)k / n, power = harmonic_power(l, multiple);
        if (power < least)
            continue;
        const double contrast = line_contrast(l, multiple, power);
        clear += contrast > two_stand_out;
        sure += contrast > one_stands_out;
        if (contrast > two_stand_out && power > highest) {
            highest = power;
            line = multiple;
        }
    }
    if ((sure < 1 && clear < 2) || !line_lasts(l, line))
        return 0;
    return sqrt(highest / l->strongest);
}

/* Takes samples of the middle of a part, averaged where a cycle has more than enough. False: out of
 * memory. */
static bool take_samples(struct lines *l, const struct series *part, struct arena *arena)
{
    const double cycles = (part->t[part->n - 1] - part->t[0]) / l->period,
                 each = (double)part->n / cycles;
    const size_t spare = part->n / SAMPLES_MAX + 1,
                 enough = each > SAMPLES_A_CYCLE ? (size_t)(each / SAMPLES_A_CYCLE) : 1,
                 by = spare < enough ? spare : enough;
    assert(by > 0);
    const size_t n = part->n / by < SAMPLES_MAX ? part->n / by : SAMPLES_MAX,
                 from = (part->n - n * by) / 2;
    double *all = arena_array(arena, 3 * n, sizeof *all);
    if (!all)
        return false;
    *l = (struct lines){.t = all, .y = all + n, .weight = all + 2 * n, .n = n, .period = l->period};
    for (size_t i = 0; i < n; i++) {
        l->t[i] = l->y[i] = 0;
        for (size_t k = from + i * by; k < from + (i + 1) * by; k++) {
            l->t[i] += part->t[k] / (double)by;
            l->y[i] += part->y[k] / (double)by;
        }
    }
    return true;
}

/* Takes the samples in the middle of the part of a series that a period was read from, and the
 * harmonics of that from them. Returns false if these are too few, or if out of memory. */
static bool lines_init(struct lines *l, const struct series *s, const struct period *p,
                       struct arena *arena)
{
    enum { PASSES = 2, CYCLES_MIN = 10, SAMPLES_MIN = 4 };
    static const double whole = 0.8, hann_line = 6; /* variance of a line, of n samples over n */
    const double span = s->t[s->n - 1] - s->t[0];
    struct line_sum sum[HARMONICS_MAX + 1];
    struct series part = *s;
    if (p->last > p->first && p->last - p->first < whole * span)
        part = series_window(*s, p->first, p->last);
    *l = (struct lines){.period = p->period.value};
    if (part.n < 2 || (part.t[part.n - 1] - part.t[0]) / l->period < CYCLES_MIN ||
        !take_samples(l, &part, arena))
        return false;
    const size_t n = l->n;
    l->cycles = (l->t[n - 1] - l->t[0]) / l->period;
    if (l->cycles < CYCLES_MIN || (double)n < SAMPLES_MIN * l->cycles)
        return false;
    l->quantum = samples_quantum(&(struct samples){.y = part.y, .n = part.n < n ? part.n : n});
    const int below = (int)fmin((double)n / l->cycles / 2, 1e6);
    const int harmonics = below < HARMONICS_MAX ? below : HARMONICS_MAX;
    for (size_t i = 0; i < n; i++)
        l->weight[i] = hann_weight(l, i, 0, n);
    sum_harmonics(l, 0, sum);
    for (size_t i = 0; i < n; i++)
        l->y[i] -= 0.5 * sum[0].re;
    l->last = fmax(harmonic_power(l, below), harmonic_power(l, fmax(below - 1, 1)));
    sum_harmonics(l, harmonics, sum);
    for (int k = 1; k <= harmonics; k++)
        l->strongest = fmax(l->strongest, sum[k].re * sum[k].re + sum[k].im * sum[k].im);
    for (int pass = 0; pass < PASSES && !cancelled(s->cancel); pass++)
        remove_harmonics(l, harmonics);
    for (size_t i = 0; i < n; i++)
        l->noise += l->y[i] * l->y[i];
    l->noise *= hann_line / ((double)n * (double)n);
    return l->strongest > 0 && !cancelled(s->cancel);
}

void period_find_subharmonic(const struct series *series, struct arena *arena,
                             struct period *period)
{
    static const double cycles_each = 5; /* of the longer period */
    const double shortest = period->period.value;
    double share = 0, found = 1;
    struct lines l;
    for (int pass = 0; pass < DOUBLINGS_MAX && found > 0; pass++) {
        found = 0;
        if (!lines_init(&l, series, period, arena))
            break;
        for (int n = 2; n <= 3 && found == 0 && l.cycles >= cycles_each * n; n++) {
            found = lines_between(&l, n);
            if (found == 0)
                continue;
            period->period.value *= n;
            period->period.uncertainty *= n;
            period->periods = floor(period->periods / n);
        }
        share = fmax(share, found);
    }
    if (share > 0)
        snprintf(period->warning, sizeof period->warning,
                 "cycles of %.5g s are not alike (a line between their harmonics has %.2g %% of "
                 "the strongest): they repeat after %.0f of them",
                 shortest, 100 * share, period->period.value / shortest);
}
