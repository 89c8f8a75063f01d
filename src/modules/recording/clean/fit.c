/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Local robust fits without a law for the whole (clean_fit()): sway, drift and drag are slow
 * compared with two periods, so that noise and bad echoes remain. Iteratively reweighted least
 * squares: Huber's weights, then bisquare (Holland & Welsch 1977). */
#include "modules/recording/clean/clean.h"

#include <hooke/base/cancel.h>
#include <hooke/base/numeric.h>

#include <gsl/gsl_statistics_double.h>
#include <math.h>
#include <string.h>

/* Samples that a fit needs; last rounds with Huber's weights, and of all. */
enum { TERMS = LOCAL_TERMS, SAMPLES_MIN = 2 * TERMS, ROUNDS_HUBER = 6, ROUNDS = 12 };

/* [periods] Duration that must have samples; a fit across a gap is meaningless. */
#define COVERED_PERIODS 1.25
#define BEND_SHARE 0.002  /* bend of the amplitude within two periods, relative to the swing */
#define SETTLED_SHARE 0.3 /* change, in standard errors, at which the rounds end */

/* A fit starts from the previous one if the scale about that is at most this many times its own. */
static const double start_scale_max = 1.5;

/* Four samples at once. */
typedef double four __attribute__((vector_size(32), aligned(8), may_alias));

/* Samples of a local fit; all arrays have space for a multiple of 4. */
struct clean_samples {
    size_t n;
    double *column[TERMS + 1]; /* terms of the model, then the values */
    double *weight, *residual, *size;
    const struct cancel *cancel;
};

/* Returns n rounded up to a multiple of 4. */
static size_t padded(size_t n)
{
    return (n + 3) / 4 * 4;
}

/* Returns the four values from an offset on as one vector. */
static four *fours(double *values, size_t offset)
{
    return (four *)(void *)(values + offset);
}

/* Computes the weighted products of the terms with each other (lower triangle of a) and with the
 * values (b). Columns are filled with zeros up to a multiple of four. */
CLONES static void normal_equations(const struct clean_samples *s, double a[TERMS][TERMS],
                                    double b[TERMS])
{
    for (size_t i = s->n; i < padded(s->n); i++) {
        s->weight[i] = 0;
        for (int j = 0; j <= TERMS; j++)
            s->column[j][i] = 0;
    }
#pragma GCC unroll 8
    for (int j = 0; j < TERMS; j++) {
        four sum[TERMS + 1] = {{0}};
        for (size_t i = 0; i < s->n; i += 4) {
            const four weighted = *fours(s->weight, i) * *fours(s->column[j], i);
#pragma GCC unroll 8
            for (int k = j; k <= TERMS; k++)
                sum[k] += weighted * *fours(s->column[k], i);
        }
        for (int k = j; k <= TERMS; k++) {
            const double product = (sum[k][0] + sum[k][1]) + (sum[k][2] + sum[k][3]);
            *(k < TERMS ? &a[k][j] : &b[j]) = product;
        }
    }
}

/* Solves the weighted least squares. Returns false if the samples do not determine the terms. */
static bool weighted_fit(const struct clean_samples *s, double parameter[TERMS])
{
    double a[TERMS][TERMS];
    normal_equations(s, a, parameter);
    for (int i = 0; i < TERMS; i++)
        a[i][i] *= 1 + 1e-10; /* a ridge that no determined parameter feels */
    if (!matrix_cholesky(TERMS, TERMS, &a[0][0], 1e-14, &a[0][0]))
        return false;
    cholesky_forward(TERMS, TERMS, &a[0][0], parameter);
    cholesky_backward(TERMS, TERMS, &a[0][0], parameter);
    return true;
}

/* Returns the value of the fit for the terms of a row. */
static double clean_fit_value(const double parameter[TERMS], const double term[TERMS])
{
    double sum = 0;
    for (int j = 0; j < TERMS; j++)
        sum += parameter[j] * term[j];
    return sum;
}

/* Returns the median magnitude of the residuals. It is searched near the guess, that of the
 * previous fit, first, because the scale changes little from fit to fit. */
static double median_size(const struct clean_samples *s, double guess)
{
    const double low = 0.8 * guess, high = 1.25 * guess;
    const size_t middle = s->n / 2;
    size_t smaller_count = 0, near_count = 0;
    for (size_t i = 0; i < s->n; i++) {
        const double size = fabs(s->residual[i]);
        s->size[near_count] = size;
        smaller_count += size < low;
        near_count += size >= low && size <= high;
    }
    if (middle >= smaller_count && middle < smaller_count + near_count)
        return gsl_stats_select(s->size, 1, near_count, middle - smaller_count);
    for (size_t i = 0; i < s->n; i++)
        s->size[i] = fabs(s->residual[i]);
    return values_quantile(s->size, s->n, 0.5);
}

/* Computes the residuals. Returns their robust scale; `guess` is a value near it. */
CLONES static double residual_scale(const struct clean_samples *s, const double parameter[TERMS],
                                    double guess)
{
    for (size_t i = 0; i < s->n; i += 4) {
        four r = *fours(s->column[TERMS], i);
#pragma GCC unroll 8
        for (int j = 0; j < TERMS; j++)
            r -= parameter[j] * *fours(s->column[j], i);
        *fours(s->residual, i) = r;
    }
    return MAD_TO_SIGMA * median_size(s, guess / MAD_TO_SIGMA);
}

/* Returns the largest difference between two sets of parameters. */
static double largest_change(const double a[TERMS], const double b[TERMS])
{
    double change = 0;
    for (int j = 0; j < TERMS; j++)
        change = fmax(change, fabs(a[j] - b[j]));
    return change;
}

/* Sets the weights of the samples by Huber's function if `huber`, otherwise by Tukey's bisquare,
 * for residuals of the scale `width`. Returns the number of samples outside of the bisquare's
 * range. */
static size_t set_weights(const struct clean_samples *s, bool huber, double width)
{
    const double bisquare = 1 / (BISQUARE_TUNING * BISQUARE_TUNING * width * width);
    size_t outside = 0;
    for (size_t i = 0; i < s->n; i++) {
        const double r = s->residual[i], share = 1 - bisquare * r * r;
        if (huber)
            s->weight[i] = fabs(r) > width ? width / fabs(r) : 1;
        else
            s->weight[i] = share > 0 ? share * share : 0;
        outside += share <= 0;
    }
    return outside;
}

/* Improves parameter (in and out) and *scale by alternating weights and weighted fits: Huber's
 * weights up to round ROUNDS_HUBER, then bisquare. first_round tells which weights are set already.
 * `min` is the smallest scale. Returns false if not determined or cancelled. */
static bool robust_fit(const struct clean_samples *s, int first_round, double min,
                       double parameter[TERMS], double *scale)
{
    const double settled = SETTLED_SHARE / sqrt((double)s->n);
    double previous[TERMS];
    memcpy(previous, parameter, sizeof previous);
    for (int round = first_round; round <= ROUNDS; round++) {
        if (cancelled(s->cancel) || !weighted_fit(s, parameter))
            return false;
        *scale = residual_scale(s, parameter, *scale);
        const double width = fmax(*scale, min);
        if (round > 0 && largest_change(parameter, previous) <= settled * width) {
            if (round > ROUNDS_HUBER)
                return true;
            round = ROUNDS_HUBER;
        }
        memcpy(previous, parameter, sizeof previous);
        set_weights(s, round < ROUNDS_HUBER, width);
    }
    return true;
}

/* Fits the samples into *local, from the parameters of the previous fit extrapolated by that many
 * periods, if there is one and the samples are about as near to it. If some are far off, Huber's
 * weights come first, which lead to the same minimum from everywhere. `min` is the smallest scale.
 * Returns false if not fitted. */
static bool fit_onward(const struct clean_samples *s, const struct local *previous, double periods,
                       double min, struct local *local)
{
    static const int rate_of[TERMS] = {1, -1, 4, 5, -1, -1};
    double *parameter = local->parameter;
    int first_round = 0;
    if (previous) {
        for (int j = 0; j < TERMS; j++)
            parameter[j] = previous->parameter[j] +
                           (rate_of[j] < 0 ? 0 : periods * previous->parameter[rate_of[j]]);
        const double width = fmax(residual_scale(s, parameter, previous->scale), min);
        if (width <= start_scale_max * fmax(previous->scale, min)) {
            first_round = ROUNDS_HUBER + 1;
            if (set_weights(s, false, width) > 0) {
                first_round = 1;
                set_weights(s, true, width);
            }
        }
    }
    for (size_t i = 0; i < s->n && first_round == 0; i++)
        s->weight[i] = 1;
    return robust_fit(s, first_round, min, parameter, &local->scale);
}

/* Fills the terms of a row, with times from `middle`. */
static void terms_at(const struct cleaning *c, size_t row, double middle, double term[TERMS])
{
    const double s = (c->t[row] - middle) / c->period, x = c->turn[row][0], y = c->turn[row][1];
    const double all[TERMS] = {1, s, x, y, s * x, s * y};
    memcpy(term, all, sizeof all);
}

/* Fills c->turn with cosine and sine of the phase of each row; at equal steps by rotation of the
 * previous phase, recomputed every TURNED_MAX rows. Returns false if out of memory. */
static bool fill_turns(struct cleaning *c)
{
    enum { TURNED_MAX = 64 };
    static const double equal_steps = 1e-9;
    const double step = TWO_PI * c->step / c->period, x = cos(step), y = sin(step);
    c->turn = arena_array(c->scratch, c->n, sizeof *c->turn);
    for (size_t i = 0; c->turn && i < c->n && !cancelled_at(c->cancel, i); i++) {
        const double angle = TWO_PI * (c->t[i] - c->t[0]) / c->period;
        double *turn = c->turn[i];
        if (i % TURNED_MAX && fabs(c->t[i] - c->t[i - 1] - c->step) < equal_steps * c->step) {
            const double *previous = c->turn[i - 1];
            turn[0] = previous[0] * x - previous[1] * y;
            turn[1] = previous[0] * y + previous[1] * x;
        } else {
            turn[0] = cos(angle);
            turn[1] = sin(angle);
        }
    }
    return c->turn != NULL;
}

/* Returns the first row at or after t. */
static size_t row_at(const struct cleaning *c, double t)
{
    return first_from(c->t, c->n, t);
}

/* Sets the residuals of the rows that a local fit judges. */
static void put_residuals(struct cleaning *c, const struct local *local)
{
    for (size_t i = local->begin; i < local->end; i++)
        c->residual[i] = local->fitted && !isnan(c->y[i]) ? c->y[i] - c->model[i] : 0;
}

/* Fits the period around local->t by the samples of two periods that are not excluded, and sets
 * model and residuals of the rows that *local judges. `work` has the memory of the samples. If the
 * same samples were used in the previous pass (c->fitted_without), only the residuals are set. Sets
 * local->fitted to false if there are too few samples. */
static void fit_local(struct cleaning *c, struct local *local, const struct clean_samples *work)
{
    const double first = c->t[0], last = c->t[c->n - 1];
    const double begin = fmin(fmax(local->t - c->period, first), fmax(first, last - 2 * c->period));
    const size_t row_begin = row_at(c, begin), row_end = row_at(c, begin + 2 * c->period);
    if (c->fitted_without &&
        memcmp(c->excluded + row_begin, c->fitted_without + row_begin, row_end - row_begin) == 0) {
        put_residuals(c, local); /* the same samples have the same fit */
        return;
    }
    struct clean_samples s = *work;
    const double *parameter = local->parameter;
    double here[TERMS];
    s.n = 0;
    for (size_t i = row_begin; i < row_end; i++)
        if (!c->excluded[i]) {
            terms_at(c, i, local->t, here);
#pragma GCC unroll 8
            for (int j = 0; j < TERMS; j++)
                s.column[j][s.n] = here[j];
            s.column[TERMS][s.n++] = c->y[i];
        }
    const double min = fmax(c->quantum / sqrt(12.0), BEND_SHARE * c->swing);
    const bool enough = s.n >= SAMPLES_MIN && (double)s.n * c->step > COVERED_PERIODS * c->period &&
                        local->end > local->begin;
    const struct local *previous = local > c->local && local[-1].fitted ? local - 1 : NULL;
    local->fitted =
        enough &&
        fit_onward(&s, previous, previous ? (local->t - previous->t) / c->period : 0, min, local);
    /* A fit follows few samples too closely, which makes the scale too small. */
    local->scale *= local->fitted ? (double)s.n / (double)(s.n - TERMS) : 1;
    local->amplitude = local->fitted ? hypot(parameter[2], parameter[3]) : NAN;
    for (size_t i = local->begin; i < local->end; i++) {
        terms_at(c, i, local->t, here);
        c->model[i] = local->fitted ? clean_fit_value(parameter, here) : NAN;
    }
    put_residuals(c, local);
}

/* Fits a sine to each period of the recording (c->local) by fit_local(). The first call also
 * divides the recording into c->locals periods. Sets c->typical to the median residual of the fits,
 * NAN if none succeeded, and c->fitted_without to a copy of the mask of excluded samples. Returns
 * false if out of memory or cancelled. */
bool clean_fit(struct cleaning *c)
{
    const double first = c->t[0], span = c->t[c->n - 1] - first;
    c->locals = (size_t)fmax(1, floor(span / c->period));
    const double each = span / (double)c->locals;
    const bool again = c->local != NULL;
    size_t largest = 0;
    if (!again) {
        c->local = arena_array(c->scratch, c->locals, sizeof *c->local);
        c->per_local = arena_array(c->scratch, c->locals, sizeof *c->per_local);
    }
    if (!c->local || !c->per_local || (!again && !fill_turns(c)))
        return false;
    for (size_t k = 0; k < c->locals; k++) {
        const double begin = first + each * (double)k;
        const size_t rows = row_at(c, begin + 2.5 * c->period) - row_at(c, begin - 2.5 * c->period);
        if (!again)
            c->local[k] = (struct local){
                .t = begin + 0.5 * each,
                .begin = row_at(c, begin),
                .end = k + 1 < c->locals ? row_at(c, first + each * (double)(k + 1)) : c->n};
        largest = rows > largest ? rows : largest;
    }
    const size_t room = padded(largest);
    double *all = arena_array(c->scratch, (TERMS + 4) * room, sizeof *all);
    if (!all)
        return false;
    struct clean_samples work = {.cancel = c->cancel,
                                 .weight = all + (TERMS + 1) * room,
                                 .residual = all + (TERMS + 2) * room,
                                 .size = all + (TERMS + 3) * room};
    for (int j = 0; j <= TERMS; j++)
        work.column[j] = all + (size_t)j * room;
    size_t fitted = 0;
    for (size_t k = 0; k < c->locals; k++) {
        if (cancelled(c->cancel))
            return false;
        fit_local(c, &c->local[k], &work);
        if (c->local[k].fitted)
            c->per_local[fitted++] = c->local[k].scale;
    }
    if (!again)
        c->fitted_without = arena_alloc(c->scratch, c->n);
    if (!c->fitted_without)
        return false;
    memcpy(c->fitted_without, c->excluded, c->n);
    c->typical = fitted > 0
                     ? fmax(values_quantile(c->per_local, fitted, 0.5), c->quantum / sqrt(12.0))
                     : NAN;
    return true;
}
