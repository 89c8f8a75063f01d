/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Normal equations of an equation of motion, sample after sample, less what a baseline block by
 * block explains. */
#include "analysis/law/law_fit.h"

#include <string.h>

enum {
    /* derivatives, then the residual */
    CHUNK = 128,
    ITERATIONS = 60,
    COLUMNS = LAW_PARAMETERS + 1
};

/* With friction a minimum may lie where a half swing more begins, in a kink: no step promises
 * little there. */
#define KINK 1e8 /* damping at which none goes down */
enum { SMALL_MAX = 4 };

struct normal {
    double product[COLUMNS][COLUMNS]; /* lower part; the last row is that of the residual */
};

/* Sums over the samples of a block: of the basis 1, s, s^2 (s in -1 .. 1) and of it with the
 * columns. */
struct gram_block {
    double middle, half; /* [s] */
    double gram[BASELINE_TERMS][BASELINE_TERMS];
    double cross[BASELINE_TERMS][COLUMNS];
};

/* ---- small systems ---- */

/* (A + lambda diag A) step = right, the columns scaled to length one; false: not positive. */
static bool damped_step(int n, const struct normal *normal, double lambda, const double *right,
                        double *step)
{
    double a[LAW_PARAMETERS * LAW_PARAMETERS] = {0}, l[LAW_PARAMETERS * LAW_PARAMETERS],
                              scale[LAW_PARAMETERS];
    for (int i = 0; i < n; i++) {
        scale[i] = sqrt(normal->product[i][i]);
        if (!(scale[i] > 0) || !isfinite(scale[i]))
            return false;
        for (int j = 0; j <= i; j++)
            a[i * LAW_PARAMETERS + j] =
                normal->product[i][j] / (scale[i] * scale[j]) + (i == j ? lambda : 0);
        step[i] = right[i] / scale[i];
    }
    if (!cholesky(n, LAW_PARAMETERS, a, 1e-14, l))
        return false;
    cholesky_forward(n, LAW_PARAMETERS, l, step);
    cholesky_backward(n, LAW_PARAMETERS, l, step);
    for (int i = 0; i < n; i++)
        step[i] /= scale[i];
    return true;
}

/* ---- one pass ---- */

static struct gram_block block_of(const struct law_samples *x, size_t k)
{
    const double *t = x->samples->t;
    const double from = t[x->baseline.edge[k]], to = t[x->baseline.edge[k + 1] - 1];
    return (struct gram_block){.middle = 0.5 * (from + to),
                               .half = fmax(0.5 * (to - from), 1e-300)};
}

static double time_of(const struct samples *x, size_t i)
{
    return x->uniform ? x->t0 + (double)i * x->dt : x->t[i];
}

/* The basis at a time. */
static void basis(const struct gram_block *block, int terms, double t, double out[BASELINE_TERMS])
{
    const double s = (t - block->middle) / block->half;
    out[0] = 1;
    for (int m = 1; m < terms; m++)
        out[m] = out[m - 1] * s;
}

/* A row of columns into the sums. */
static void add_row(int count, int terms, const double *column, const double *base,
                    struct gram_block *block, struct normal *normal)
{
    for (int j = 0; j < count; j++)
        for (int k = 0; k <= j; k++)
            normal->product[j][k] += column[j] * column[k];
    for (int m = 0; m < terms; m++) {
        for (int j = 0; j < count; j++)
            block->cross[m][j] += base[m] * column[j];
        for (int k = 0; k <= m; k++)
            block->gram[m][k] += base[m] * base[k];
    }
}

/* As many terms of the baseline as the block's samples hold; their number. */
static int factor_block(const struct gram_block *block, int terms, double *l)
{
    while (terms > 0 && !cholesky(terms, BASELINE_TERMS, &block->gram[0][0], 1e-14, l))
        terms--;
    return terms;
}

/* Less what the block's baseline explains of every column. */
static void project(int count, int terms, const struct gram_block *block, struct normal *normal)
{
    double l[BASELINE_TERMS * BASELINE_TERMS], part[COLUMNS][BASELINE_TERMS];
    terms = factor_block(block, terms, l);
    for (int j = 0; j < count; j++) {
        for (int m = 0; m < terms; m++)
            part[j][m] = block->cross[m][j];
        cholesky_forward(terms, BASELINE_TERMS, l, part[j]);
        for (int k = 0; k <= j; k++)
            for (int m = 0; m < terms; m++)
                normal->product[j][k] -= part[j][m] * part[k][m];
    }
}

/* The next samples that take part, from *at up to `end`. */
static int gather(const struct law_samples *x, size_t *at, size_t end, double *t, double *y)
{
    int count = 0;
    for (; *at < end && count < CHUNK; ++*at) {
        if (x->use[*at]) {
            t[count] = time_of(x->samples, *at);
            y[count++] = x->samples->y[*at] - x->middle;
        }
    }
    return count;
}

/* Normal equations at the motion of the fit, unless NULL. Returns the sum of squares, NAN: no value
 * there. */
static double pass(const struct law_samples *x, struct law_fit *fit, struct normal *normal)
{
    double t[CHUNK], y[CHUNK], value[CHUNK], derivative[CHUNK * EQUATION_PARAMETERS],
        column[COLUMNS], base[3];
    const int rows = normal ? fit->parameters : 0, terms = x->baseline.terms;
    enum equation_slopes slopes = normal ? EQUATION_SLOPES_BUT_B : EQUATION_VALUES;
    struct normal sums;
    struct equation_walk walk;
    memset(&sums, 0, sizeof sums);
    for (int j = 0; j < rows; j++)
        slopes = fit->index[j] == EQUATION_RATE + 1 ? EQUATION_SLOPES : slopes;
    fit->motion.value[EQUATION_OFFSET] = 0;
    fit->used = 0;
    if (!(fabs(fit->motion.value[EQUATION_OMEGA] - fit->omega) < 0.5 * fit->omega) ||
        !equation_begin(&fit->motion, slopes, &walk))
        return NAN;
    size_t at = 0;
    for (size_t k = 0; k < x->baseline.blocks && !cancelled(x->cancel); k++) {
        struct gram_block block = block_of(x, k);
        while (at < x->baseline.edge[k + 1]) {
            if (cancelled(x->cancel))
                return NAN;
            const int count = gather(x, &at, x->baseline.edge[k + 1], t, y);
            if (!equation_values(&walk, t, (size_t)count, value, normal ? derivative : NULL))
                return NAN;
            for (int i = 0; i < count; i++) {
                for (int j = 0; j < rows; j++)
                    column[j] = derivative[i * EQUATION_PARAMETERS + fit->index[j]];
                column[rows] = y[i] - value[i];
                basis(&block, terms, t[i], base);
                add_row(rows + 1, terms, column, base, &block, &sums);
            }
            fit->used += (size_t)count;
        }
        project(rows + 1, terms, &block, &sums);
    }
    const double sum = fmax(sums.product[rows][rows], 0);
    if (normal)
        *normal = sums;
    return isfinite(sum) && fit->used > (size_t)fit->parameters ? sum : NAN;
}

double law_squares(const struct law_samples *x, struct law_fit *fit)
{
    return pass(x, fit, NULL);
}

/* ---- the minimum ---- */

static void move(const struct law_fit *from, const double *step, struct law_fit *to)
{
    *to = *from;
    for (int j = 0; j < from->parameters; j++)
        to->motion.value[from->index[j]] += step[j];
}

static bool invert(const struct normal *normal, struct law_fit *fit)
{
    for (int j = 0; j < fit->parameters; j++) {
        double unit[LAW_PARAMETERS] = {0}, column[LAW_PARAMETERS];
        unit[j] = 1;
        if (!damped_step(fit->parameters, normal, 0, unit, column))
            return false;
        for (int i = 0; i < fit->parameters; i++)
            fit->inverse[i][j] = column[i];
    }
    return true;
}

/* The step and by how much it promises to lower the sum of squares (to first order, twice that);
 * NAN: none. */
static double find_step(const struct law_fit *fit, const struct normal *normal, double lambda,
                        double *step)
{
    const double *right = normal->product[fit->parameters];
    double decrement = 0;
    if (!damped_step(fit->parameters, normal, lambda, right, step))
        return NAN;
    for (int j = 0; j < fit->parameters; j++)
        decrement += step[j] * right[j];
    return decrement;
}

bool law_descend(const struct law_samples *x, double trust, double rounding, struct law_fit *fit)
{
    struct normal normal, next;
    struct law_fit trial;
    double step[LAW_PARAMETERS] = {0}, full[LAW_PARAMETERS] = {0}, lambda = 1e-3;
    int small = 0; /* steps in a row that went down by less than a hundredth of a variance */
    fit->converged = false;
    fit->rss = pass(x, fit, &normal);
    for (int i = 0; i < ITERATIONS && isfinite(fit->rss) && !cancelled(x->cancel); i++) {
        const double unit = fit->rss / (double)fit->used;
        const double promised = find_step(fit, &normal, 0, full);
        if (promised < fmax(trust * unit, rounding)) {
            move(fit, full, fit);
            fit->rss = fmax(fit->rss - promised, 0);
            fit->converged = true;
            break;
        }
        if (!isfinite(find_step(fit, &normal, lambda, step)))
            return false;
        move(fit, step, &trial);
        trial.rss = pass(x, &trial, &next);
        if (trial.rss <= fit->rss) {
            small = fit->rss - trial.rss < 0.01 * unit ? small + 1 : 0;
            *fit = trial;
            normal = next;
            lambda *= 0.01;
        } else {
            lambda = fmax(lambda * 10, 1e-6);
        }
        if (fit->motion.value[EQUATION_RATE + 2] > 0 && (lambda > KINK || small >= SMALL_MAX)) {
            fit->converged = true;
            break;
        }
    }
    fit->converged = fit->converged && invert(&normal, fit);
    return fit->converged;
}

double law_formal(const struct law_fit *fit, int at)
{
    return sqrt(fmax(fit->inverse[at][at], 0));
}

/* ---- what is left ---- */

bool law_residuals(const struct law_samples *x, const struct law_fit *fit, double *residual,
                   double *level, double *slope)
{
    struct equation_walk walk;
    double t[CHUNK], base[BASELINE_TERMS], l[BASELINE_TERMS * BASELINE_TERMS];
    const struct samples *samples = x->samples;
    if (!equation_begin(&fit->motion, EQUATION_VALUES, &walk))
        return false;
    for (size_t k = 0; k < x->baseline.blocks; k++) {
        const size_t from = x->baseline.edge[k], to = x->baseline.edge[k + 1];
        struct gram_block block = block_of(x, k);
        struct normal unused = {{{0}}};
        for (size_t at = from; at < to; at += CHUNK) {
            if (cancelled(x->cancel))
                return false;
            const size_t count = to - at < CHUNK ? to - at : CHUNK;
            for (size_t i = 0; i < count; i++)
                t[i] = time_of(samples, at + i);
            if (!equation_values(&walk, t, count, residual + at, NULL))
                return false;
            for (size_t i = 0; i < count; i++) {
                residual[at + i] = samples->y[at + i] - x->middle - residual[at + i];
                basis(&block, x->baseline.terms, t[i], base);
                if (x->use[at + i])
                    add_row(1, x->baseline.terms, &residual[at + i], base, &block, &unused);
            }
        }
        const int terms = factor_block(&block, x->baseline.terms, l);
        double coefficient[BASELINE_TERMS] = {0};
        for (int m = 0; m < terms; m++)
            coefficient[m] = block.cross[m][0];
        cholesky_forward(terms, BASELINE_TERMS, l, coefficient);
        cholesky_backward(terms, BASELINE_TERMS, l, coefficient);
        for (size_t i = from; i < to; i++) {
            basis(&block, terms, time_of(samples, i), base);
            for (int m = 0; m < terms; m++)
                residual[i] -= coefficient[m] * base[m];
        }
        if (level)
            level[k] = x->middle + coefficient[0];
        if (slope)
            slope[k] = coefficient[1] / block.half;
    }
    return true;
}
