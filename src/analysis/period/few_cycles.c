/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Whether few cycles differ in turn: the rows of each are laid over those one, two and three cycles
 * later. Where two later ones agree but for noise and the next does not, the period is two of them.
 */
#include "analysis/period/cycle.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    ROWS_MAX = 2048, /* more are averaged */
    TURNS_MAX = 3,   /* cycles after which they may repeat */
    REFINEMENTS = 4, /* passes of a search, each with a quarter of the reach */
};

struct overlay {
    const double *t, *y; /* [n] */
    size_t n;
};

/* A shift and what differs after it. */
struct shifted {
    double shift; /* [s] */
    double left;  /* variance of one row that the earlier rows do not explain */
};

/* Returns the value at t of the cubic through the four rows about it; row: the first one after t.
 */
static double cubic_value(const struct overlay *o, size_t row, double t)
{
    const size_t first = row < 2 ? 0 : row - 2 + 4 > o->n ? o->n - 4 : row - 2;
    double value = 0;
    for (size_t i = first; i < first + 4; i++) {
        double weight = o->y[i];
        for (size_t k = first; k < first + 4; k++)
            if (k != i)
                weight *= (t - o->t[k]) / (o->t[i] - o->t[k]);
        value += weight;
    }
    return value;
}

/* Returns the variance of a row that a straight line of those a shift before it does not explain:
 * an amplitude that decays and an offset are no difference. */
static double left_after(const struct overlay *o, double shift)
{
    double n = 0, u = 0, v = 0, uu = 0, uv = 0, vv = 0;
    size_t row = 0;
    for (size_t i = 0; i < o->n; i++) {
        const double t = o->t[i] + shift, a = o->y[i] - o->y[0];
        while (row < o->n && o->t[row] < t)
            row++;
        if (row == o->n)
            break;
        const double b = cubic_value(o, row, t) - o->y[0];
        n++;
        u += a;
        v += b;
        uu += a * a;
        uv += a * b;
        vv += b * b;
    }
    const double suu = uu - u * u / n, suv = uv - u * v / n, svv = vv - v * v / n;
    if (!(n > 8) || !(suu > 0) || !(suv > 0))
        return HUGE_VAL;
    const double slope = suv / suu;
    return fmax(svv - slope * suv, 0) / (n - 2) / (1 + slope * slope);
}

/* Finds the shift next to one that leaves least. */
static struct shifted best_shift(const struct overlay *o, double shift, double reach)
{
    struct shifted best = {shift, left_after(o, shift)};
    for (int k = 0; k < REFINEMENTS; k++, reach *= 0.25) {
        const double middle = best.shift;
        for (int side = -3; side <= 3; side++) {
            const double here = middle + side * reach / 3,
                         left = side == 0 ? HUGE_VAL : left_after(o, here);
            if (left < best.left)
                best = (struct shifted){here, left};
        }
    }
    return best;
}

/* Returns the variance of the rows. */
static double spread_of_rows(const struct overlay *o)
{
    double mean = 0, square = 0;
    for (size_t i = 0; i < o->n; i++)
        mean += o->y[i] / (double)o->n;
    for (size_t i = 0; i < o->n; i++)
        square += (o->y[i] - mean) * (o->y[i] - mean);
    return square / (double)o->n;
}

/* Returns the mean square by which a cubic between every second row misses the rows between. */
static double interpolation_left(const struct overlay *o)
{
    double square = 0;
    for (size_t i = 3; i + 3 < o->n; i++) {
        const double off =
            o->y[i] - (9 * (o->y[i - 1] + o->y[i + 1]) - o->y[i - 3] - o->y[i + 3]) / 16;
        square += off * off;
    }
    return square / (double)o->n;
}

/* Takes the rows of a series, or means of them. Returns false if too few, or if out of memory. */
static bool overlay_init(const struct series *s, struct arena *arena, struct overlay *o)
{
    struct series means;
    const struct samples all = {.t = s->t, .y = s->y, .n = s->n, .cancel = s->cancel};
    if (!samples_average(&all, s->n / ROWS_MAX + 1, arena, &means) || means.n < 32)
        return false;
    for (size_t i = 1; i < means.n; i++)
        if (!(means.t[i] > means.t[i - 1]))
            return false;
    *o = (struct overlay){means.t, means.y, means.n};
    return true;
}

/* Returns true if rows are clearly more like those one shift later than like those another. */
static bool clearly_more_alike(const struct shifted *here, const struct shifted *there,
                               double least, double rows)
{
    static const double clear = 4;  /* times what is left there */
    static const double chance = 8; /* standard deviations of a variance of white noise */
    static const double all_noise = 1.5;
    const bool only_noise = here->left < all_noise * least;
    const double times = only_noise ? fmin(clear, 1 + chance * sqrt(2 / rows)) : clear;
    return there->left > times * here->left && isfinite(there->left);
}

/* Returns after how many cycles they repeat: 1 if after each, or if that cannot be told. */
static int turns_of(const struct overlay *o, const struct period *p, double noise,
                    struct shifted after[TURNS_MAX + 1])
{
    static const double noise_part = 0.02; /* a remaining difference of this share counts as none */
    static const double reach = 0.02;      /* share of the period in which shifts are searched */
    static const double like_noise = 1.2;  /* times the variance of noise */
    const double period = p->period.value, span = o->t[o->n - 1] - o->t[0],
                 least = noise * noise + interpolation_left(o);
    if (left_after(o, period) <= like_noise * least)
        return 1;
    after[1] = best_shift(o, period, reach * period);
    for (int n = 2; n <= TURNS_MAX && (n + 1) * period <= span; n++) {
        if (after[1].left <= like_noise * least)
            return 1;
        after[n] = best_shift(o, n * period, reach * period);
        const double rows = (double)o->n * (1 - n * period / span);
        bool more_alike = after[n].left <= fmax(2 * least, noise_part * after[1].left);
        for (int k = 1; k < n; k++)
            more_alike = more_alike && clearly_more_alike(&after[n], &after[k], least, rows);
        if (more_alike)
            return n;
    }
    return 1;
}

void period_find_turns(const struct series *series, struct arena *arena, struct period *period)
{
    struct overlay o;
    struct shifted after[TURNS_MAX + 1];
    const double shortest = period->period.value;
    if (series->t[series->n - 1] - series->t[0] < TURNS_MAX * shortest ||
        series_is_uneven(series) || !overlay_init(series, arena, &o))
        return;
    double *scratch = arena_array(arena, o.n, sizeof *scratch);
    unsigned char *use = arena_alloc(arena, o.n);
    if (!scratch || !use)
        return;
    memset(use, 1, o.n);
    const double noise =
        samples_noise(&(struct samples){.t = o.t, .y = o.y, .n = o.n, .use = use}, scratch);
    const int n = turns_of(&o, period, noise, after);
    if (n == 1)
        return;
    const double off = fabs(after[n].shift - n * shortest), sigma = n * period->period.uncertainty;
    period->period =
        (struct measured){off > sigma ? after[n].shift : n * shortest, hypot(sigma, off)};
    period->periods = floor(period->periods / n);
    snprintf(period->warning, sizeof period->warning,
             "cycles of %.5g s are not alike (%.2g %% of their size differs in turn): they repeat "
             "after %d of them",
             shortest, 100 * sqrt(after[1].left / spread_of_rows(&o)), n);
}
