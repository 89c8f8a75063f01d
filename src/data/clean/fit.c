/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Local robust fits, without a law for the whole: sway, drift and any drag are slow against two
 * periods, what is left is noise and bad echoes. Iteratively reweighted least squares: Huber, then
 * bisquare (Holland & Welsch 1977).
 */
#include "data/clean/clean.h"

#include <hooke/base/numeric.h>

#include <math.h>
#include <string.h>

enum { TERMS = 6, SAMPLES_MIN = 2 * TERMS, ROUNDS_HUBER = 6, ROUNDS = 12 };

#define COVERED_PERIODS 1.25 /* at least so many with samples: a fit across a gap is none */
#define BEND_SHARE 0.002     /* bend of the amplitude within two periods, over the swing */
#define SETTLED_SHARE 0.3    /* change, in standard errors, that ends the rounds */

/* Number of samples that a fit is sought with, before all of them improve it. */
enum { SOUGHT_WITH = 128 };

struct clean_samples {
    size_t n;
    double (*term)[TERMS]; /* [n] */
    double *y, *weight, *residual, *size;
    const struct cancel *cancel;
};

static bool weighted_fit(const struct clean_samples *s, double parameter[TERMS])
{
    double a[TERMS][TERMS] = {{0}}, b[TERMS] = {0};
    for (size_t i = 0; i < s->n; i++) {
        const double *x = s->term[i];
#pragma GCC unroll 8
        for (int j = 0; j < TERMS; j++) {
            const double wx = s->weight[i] * x[j];
            b[j] += wx * s->y[i];
#pragma GCC unroll 8
            for (int k = 0; k <= j; k++)
                a[j][k] += wx * x[k];
        }
    }
    /* a ridge that no determined parameter feels */
    for (int i = 0; i < TERMS; i++)
        a[i][i] *= 1 + 1e-10;
    if (!cholesky(TERMS, TERMS, &a[0][0], 1e-14, &a[0][0]))
        return false;
    cholesky_forward(TERMS, TERMS, &a[0][0], b);
    cholesky_backward(TERMS, TERMS, &a[0][0], b);
    memcpy(parameter, b, sizeof b);
    return true;
}

static double value_of(const double parameter[TERMS], const double term[TERMS])
{
    double sum = 0;
    for (int j = 0; j < TERMS; j++)
        sum += parameter[j] * term[j];
    return sum;
}

/* Residuals and their robust scale. */
static double residual_scale(const struct clean_samples *s, const double parameter[TERMS])
{
    for (size_t i = 0; i < s->n; i++) {
        s->residual[i] = s->y[i] - value_of(parameter, s->term[i]);
        s->size[i] = fabs(s->residual[i]);
    }
    return MAD_TO_SIGMA * quantile(s->size, s->n, 0.5);
}

static double largest_change(const double a[TERMS], const double b[TERMS])
{
    double change = 0;
    for (int j = 0; j < TERMS; j++)
        change = fmax(change, fabs(a[j] - b[j]));
    return change;
}

static void set_weights(const struct clean_samples *s, bool huber, double width)
{
    for (size_t i = 0; i < s->n; i++) {
        const double r = fabs(s->residual[i]) / width, x = r / BISQUARE;
        s->weight[i] = huber ? 1 / fmax(r, 1) : x < 1 ? (1 - x * x) * (1 - x * x) : 0;
    }
}

/* Fits from the given weights on; first_round: ROUNDS_HUBER where these are bisquare weights. */
static bool robust_fit(const struct clean_samples *s, int first_round, double min,
                       double parameter[TERMS], double *scale)
{
    const double settled = SETTLED_SHARE / sqrt((double)s->n);
    double before[TERMS];
    memcpy(before, parameter, sizeof before);
    for (int round = first_round; round <= ROUNDS; round++) {
        if (cancelled(s->cancel) || !weighted_fit(s, parameter))
            return false;
        *scale = residual_scale(s, parameter);
        const double width = fmax(*scale, min);
        if (round > 0 && largest_change(parameter, before) <= settled * width) {
            if (round > ROUNDS_HUBER)
                return true;
            round = ROUNDS_HUBER;
        }
        memcpy(before, parameter, sizeof before);
        set_weights(s, round < ROUNDS_HUBER, width);
    }
    return true;
}

/* Copies SOUGHT_WITH of the samples: one of each of as many stretches, its place in them by the
 * golden ratio, so that no fault that recurs every few samples is in all of them. */
static void pick_samples(const struct clean_samples *s, struct clean_samples *few)
{
    static const double golden_ratio = 0.6180339887498949;
    const double each = (double)s->n / SOUGHT_WITH;
    few->n = SOUGHT_WITH;
    for (size_t k = 0; k < few->n; k++) {
        const double place = fmod((double)k * golden_ratio, 1);
        const size_t i = (size_t)(((double)k + place) * each);
        memcpy(few->term[k], s->term[i], sizeof few->term[k]);
        few->y[k] = s->y[i];
    }
}

/* Fits few of the samples first where there are many, then all from that answer on. */
static bool robust_fit_quickly(const struct clean_samples *s, double min, double parameter[TERMS],
                               double *scale)
{
    double term[SOUGHT_WITH][TERMS], y[SOUGHT_WITH], weight[SOUGHT_WITH], residual[SOUGHT_WITH],
        size[SOUGHT_WITH];
    struct clean_samples few = {.term = term,
                                .y = y,
                                .weight = weight,
                                .residual = residual,
                                .size = size,
                                .cancel = s->cancel};
    const bool many = s->n > SOUGHT_WITH;
    const struct clean_samples *first = many ? &few : s;
    if (many)
        pick_samples(s, &few);
    for (size_t i = 0; i < first->n; i++)
        first->weight[i] = 1;
    if (!robust_fit(first, 0, min, parameter, scale))
        return false;
    if (!many)
        return true;
    set_weights(s, false, fmax(residual_scale(s, parameter), min));
    return robust_fit(s, ROUNDS_HUBER + 1, min, parameter, scale);
}

/* Fills the terms of a row from the cosine and sine at its time. */
static void terms_at(const struct cleaning *c, size_t row, double middle, double term[TERMS])
{
    const double s = (c->t[row] - middle) / c->period, x = c->turn[row][0], y = c->turn[row][1];
    const double all[TERMS] = {1, s, x, y, s * x, s * y};
    memcpy(term, all, sizeof all);
}

/* Fills c->turn. Returns false if out of memory. */
static bool fill_turns(struct cleaning *c)
{
    c->turn = arena_array(c->scratch, c->n, sizeof *c->turn);
    for (size_t i = 0; c->turn && i < c->n && !cancelled_at(c->cancel, i); i++) {
        const double angle = TWO_PI * (c->t[i] - c->t[0]) / c->period;
        c->turn[i][0] = cos(angle);
        c->turn[i][1] = sin(angle);
    }
    return c->turn != NULL;
}

static size_t row_at(const struct cleaning *c, double t)
{
    return first_from(c->t, c->n, t);
}

static void put_residuals(struct cleaning *c, const struct local *local)
{
    for (size_t i = local->from; i < local->to; i++)
        c->residual[i] = local->fitted && !isnan(c->y[i]) ? c->y[i] - c->model[i] : 0;
}

static void fit_local(struct cleaning *c, struct local *local, const struct clean_samples *work)
{
    const double first = c->t[0], last = c->t[c->n - 1];
    const double begin = fmin(fmax(local->t - c->period, first), fmax(first, last - 2 * c->period));
    const size_t from = row_at(c, begin), to = row_at(c, begin + 2 * c->period);
    if (c->fitted_without && memcmp(c->excluded + from, c->fitted_without + from, to - from) == 0) {
        put_residuals(c, local); /* the same samples have the same fit */
        return;
    }
    struct clean_samples s = *work;
    double parameter[TERMS] = {0}, here[TERMS];
    s.n = 0;
    for (size_t i = from; i < to; i++)
        if (!c->excluded[i]) {
            terms_at(c, i, local->t, s.term[s.n]);
            s.y[s.n++] = c->y[i];
        }
    const double min = fmax(c->quantum / sqrt(12.0), BEND_SHARE * c->swing);
    const bool enough = s.n >= SAMPLES_MIN && (double)s.n * c->step > COVERED_PERIODS * c->period &&
                        local->to > local->from;
    local->fitted = enough && robust_fit_quickly(&s, min, parameter, &local->scale);
    /* So few samples are followed too closely. */
    local->scale *= local->fitted ? (double)s.n / (double)(s.n - TERMS) : 1;
    local->amplitude = local->fitted ? hypot(parameter[2], parameter[3]) : NAN;
    for (size_t i = local->from; i < local->to; i++) {
        terms_at(c, i, local->t, here);
        c->model[i] = local->fitted ? value_of(parameter, here) : NAN;
    }
    put_residuals(c, local);
}

bool clean_fit(struct cleaning *c)
{
    const double first = c->t[0], span = c->t[c->n - 1] - first;
    c->locals = (size_t)fmax(1, floor(span / c->period));
    const double each = span / (double)c->locals;
    const bool again = c->local != NULL;
    size_t largest = 0;
    if (!again)
        c->local = arena_array(c->scratch, c->locals, sizeof *c->local);
    if (!c->local || (!again && !fill_turns(c)))
        return false;
    for (size_t k = 0; k < c->locals; k++) {
        const double begin = first + each * (double)k;
        const size_t rows = row_at(c, begin + 2.5 * c->period) - row_at(c, begin - 2.5 * c->period);
        if (!again)
            c->local[k] = (struct local){
                .t = begin + 0.5 * each,
                .from = row_at(c, begin),
                .to = k + 1 < c->locals ? row_at(c, first + each * (double)(k + 1)) : c->n};
        largest = rows > largest ? rows : largest;
    }
    struct clean_samples work = {.cancel = c->cancel,
                                 .term = arena_array(c->scratch, largest, sizeof *work.term),
                                 .y = arena_array(c->scratch, largest, sizeof *work.y),
                                 .weight = arena_array(c->scratch, largest, sizeof *work.weight),
                                 .residual =
                                     arena_array(c->scratch, largest, sizeof *work.residual),
                                 .size = arena_array(c->scratch, largest, sizeof *work.size)};
    if (!work.term || !work.y || !work.weight || !work.residual || !work.size)
        return false;
    size_t fitted = 0;
    for (size_t k = 0; k < c->locals; k++) {
        if (cancelled(c->cancel))
            return false;
        fit_local(c, &c->local[k], &work);
        if (c->local[k].fitted)
            c->sorted[fitted++] = c->local[k].scale;
    }
    if (!again)
        c->fitted_without = arena_alloc(c->scratch, c->n);
    if (!c->fitted_without)
        return false;
    memcpy(c->fitted_without, c->excluded, c->n);
    c->typical = fitted > 0 ? fmax(quantile(c->sorted, fitted, 0.5), c->quantum / sqrt(12.0)) : NAN;
    return true;
}
