/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Normal equations of an equation of motion (law_fit.h), summed sample by sample; what a baseline
 * explains is projected out block by block. */
#include <hooke/base/cancel.h>
#include "modules/recording/fit/least_squares.h"
#include "modules/recording/law/law_fit.h"

enum {
    /* Samples integrated at once, largest number of iterations, and columns: the derivatives, then
     * the residual. */
    CHUNK = 128,
    ITERATIONS = 60,
    COLUMNS = LAW_PARAMETERS + 1
};

/* Products of the columns. */
struct normal {
    double product[COLUMNS][COLUMNS]; /* upper part; the last column is the residual */
};

/* Sums over the samples of a block: products of the basis 1, s, s^2 (s in -1 .. 1) with itself and
 * with the columns. */
struct gram_block {
    double middle, half; /* [s] */
    double gram[BASELINE_TERMS][BASELINE_TERMS];
    double cross[BASELINE_TERMS][COLUMNS];
};

/* ---- one pass ---- */

/* Returns the empty sums of block k. */
static struct gram_block block_of(const struct law_samples *x, size_t k)
{
    const double *t = x->samples->t;
    const double t_begin = t[x->baseline.edge[k]], t_end = t[x->baseline.edge[k + 1] - 1];
    return (struct gram_block){.middle = 0.5 * (t_begin + t_end),
                               .half = fmax(0.5 * (t_end - t_begin), 1e-300)};
}

/* Returns the time of sample i, exact for an even grid. */
static double time_of(const struct samples *x, size_t i)
{
    return x->uniform ? x->t0 + (double)i * x->dt : x->t[i];
}

/* Computes the basis polynomials at time t. */
static void baseline_basis(const struct gram_block *block, int terms, double t,
                           double value[BASELINE_TERMS])
{
    const double s = (t - block->middle) / block->half;
    value[0] = 1;
    for (int m = 1; m < terms; m++)
        value[m] = value[m - 1] * s;
}

/* Adds one sample to the sums: products of its columns [count] to *normal, and of the baseline's
 * basis functions base [terms], with the columns and with each other, to *block. */
static void add_row(int count, int terms, const double *column, const double *base,
                    struct gram_block *block, struct normal *normal)
{
    for (int k = 0; k < count; k++)
        for (int j = k; j < count; j++)
            normal->product[k][j] += column[j] * column[k];
    for (int m = 0; m < terms; m++) {
        for (int j = 0; j < count; j++)
            block->cross[m][j] += base[m] * column[j];
        for (int k = 0; k <= m; k++)
            block->gram[m][k] += base[m] * base[k];
    }
}

/* Factorises the Gram matrix of the basis into l, with as many terms as the block's samples
 * determine. Returns their number. */
static int factor_block(const struct gram_block *block, int terms, double *l)
{
    while (terms > 0 && !matrix_cholesky(terms, BASELINE_TERMS, &block->gram[0][0], 1e-14, l))
        terms--;
    return terms;
}

/* Subtracts from the products what the block's baseline explains of every column. */
static void subtract_baseline(int count, int terms, const struct gram_block *block,
                              struct normal *normal)
{
    double l[BASELINE_TERMS * BASELINE_TERMS], part[COLUMNS][BASELINE_TERMS];
    terms = factor_block(block, terms, l);
    for (int j = 0; j < count; j++) {
        for (int m = 0; m < terms; m++)
            part[j][m] = block->cross[m][j];
        cholesky_forward(terms, BASELINE_TERMS, l, part[j]);
        for (int k = 0; k <= j; k++)
            for (int m = 0; m < terms; m++)
                normal->product[k][j] -= part[j][m] * part[k][m];
    }
}

/* Collects the times t and values y (minus x->middle) of the next samples in use, from index *point
 * up to `end`, at most CHUNK. *point moves behind the last one. Returns their number. */
static int gather_samples(const struct law_samples *x, size_t *point, size_t end, double *t,
                          double *y)
{
    int count = 0;
    for (; *point < end && count < CHUNK; ++*point) {
        if (x->use[*point]) {
            t[count] = time_of(x->samples, *point);
            y[count++] = x->samples->y[*point] - x->middle;
        }
    }
    return count;
}

/* Context of the least-squares problem. */
struct law_problem {
    const struct law_samples *samples;
    struct law_fit *fit;
};

/* Sets the fitted parameters of the motion to x. */
static void law_fit_move(struct law_fit *fit, const double *x)
{
    for (int j = 0; j < fit->parameters; j++)
        fit->motion.value[fit->index[j]] = x[j];
}

/* Adds to *sums the products of the residual and of the first `rows` derivatives of the law's
 * motion, over all samples in use, after projecting out the baseline; *used is raised by the number
 * of samples. With rows = 0 this is only the sum of squares. Returns false if the motion has no
 * value, if its frequency is far from the start, or if cancelled. */
static bool normal_equations_sum(const struct law_samples *x, const struct law_fit *fit, int rows,
                                 struct normal *sums, size_t *used)
{
    double t[CHUNK], y[CHUNK], value[CHUNK], derivative[CHUNK * EQUATION_PARAMETERS],
        column[COLUMNS], base[3];
    const int terms = x->baseline.terms;
    enum equation_slopes slopes = rows > 0 ? EQUATION_SLOPES_BUT_B : EQUATION_VALUES;
    struct equation motion = fit->motion;
    struct equation_walk walk;
    for (int j = 0; j < rows; j++)
        slopes = fit->index[j] == EQUATION_RATE + 1 ? EQUATION_SLOPES : slopes;
    motion.value[EQUATION_OFFSET] = 0;
    if (!(fabs(motion.value[EQUATION_OMEGA] - fit->omega) < 0.5 * fit->omega) ||
        !equation_begin(&motion, slopes, &walk))
        return false;
    size_t index = 0;
    for (size_t k = 0; k < x->baseline.blocks; k++) {
        struct gram_block block = block_of(x, k);
        while (index < x->baseline.edge[k + 1]) {
            if (cancelled(x->cancel))
                return false;
            const int count = gather_samples(x, &index, x->baseline.edge[k + 1], t, y);
            if (!equation_values(&walk, t, (size_t)count, value, rows > 0 ? derivative : NULL))
                return false;
            for (int i = 0; i < count; i++) {
                for (int j = 0; j < rows; j++)
                    column[j] = derivative[i * EQUATION_PARAMETERS + fit->index[j]];
                column[rows] = y[i] - value[i];
                baseline_basis(&block, terms, t[i], base);
                add_row(rows + 1, terms, column, base, &block, sums);
            }
            *used += (size_t)count;
        }
        subtract_baseline(rows + 1, terms, &block, sums);
    }
    return true;
}

/* Fills the triangle of the first `columns` parameters at x (see struct least_squares), or at the
 * present motion if x is NULL. `context` is the struct law_problem. Returns false if the motion has
 * no value or if there are too few samples. */
static bool linearise(void *context, const double *x, int columns, struct triangle *t)
{
    static const double independent = 1e-14;
    const struct law_problem *p = context;
    struct law_fit *fit = p->fit;
    struct normal sums = {{{0}}};
    t->rows = 0;
    if (x)
        law_fit_move(fit, x);
    if (!normal_equations_sum(p->samples, fit, columns, &sums, &t->rows) ||
        t->rows <= (size_t)fit->parameters)
        return false;
    triangle_of_products(t, columns, COLUMNS, &sums.product[0][0], independent);
    fit->used = t->rows;
    return true;
}

/* Linearises by no parameter, so that the triangle holds only what the baseline leaves. */
double law_squares(const struct law_samples *x, struct law_fit *fit)
{
    struct law_problem problem = {x, fit};
    struct triangle t;
    return linearise(&problem, NULL, 0, &t) ? triangle_squares(&t, 0) : NAN;
}

/* Fits the free parameters of the law's motion from their present values by
 * least_squares_descend(). `trust` is the promised gain, in variances, below which it ends,
 * `rounding` that which is only rounding. Returns true if it converged. */
bool law_descend(const struct law_samples *x, double trust, double rounding, struct law_fit *fit)
{
    static const double first_damping = 1e-3;
    struct law_problem problem = {x, fit};
    struct descent d = {.iterations = 0};
    /* A minimum with friction may be a kink, where one more half swing begins and steps do not
     * become small. */
    bool dry = false;
    for (int j = 0; j < fit->parameters; j++) {
        d.x[j] = fit->motion.value[fit->index[j]];
        dry = dry || fit->index[j] == EQUATION_RATE + 2;
    }
    const struct least_squares model = {
        .parameters = fit->parameters, .context = &problem, .linearise = linearise};
    const struct descent_options options = {.trust = trust,
                                            .rounding = rounding,
                                            .damping = first_damping,
                                            .rescaled = true,
                                            .kinks = dry,
                                            .iterations = ITERATIONS,
                                            .cancel = x->cancel};
    const bool done = least_squares_descend(&model, &options, &d);
    law_fit_move(fit, d.x);
    fit->rss = done ? d.rss : NAN;
    fit->converged =
        done && d.converged && triangle_inverse(&d.triangle, LAW_PARAMETERS, &fit->inverse[0][0]);
    return fit->converged;
}

double law_formal(const struct law_fit *fit, int parameter)
{
    return sqrt(fmax(fit->inverse[parameter][parameter], 0));
}

/* ---- what is left ---- */

/* Computes residual [n], data minus motion and baseline, and unless NULL level and slope of each
 * block's baseline. Returns false if the motion has no value or if cancelled. */
bool law_residuals(const struct law_samples *x, const struct law_fit *fit, double *residual,
                   double *level, double *slope)
{
    struct equation_walk walk;
    double t[CHUNK], base[BASELINE_TERMS], l[BASELINE_TERMS * BASELINE_TERMS];
    const struct samples *samples = x->samples;
    if (!equation_begin(&fit->motion, EQUATION_VALUES, &walk))
        return false;
    for (size_t k = 0; k < x->baseline.blocks; k++) {
        const size_t begin = x->baseline.edge[k], end = x->baseline.edge[k + 1];
        struct gram_block block = block_of(x, k);
        struct normal unused = {{{0}}};
        for (size_t start = begin; start < end; start += CHUNK) {
            if (cancelled(x->cancel))
                return false;
            const size_t count = end - start < CHUNK ? end - start : CHUNK;
            for (size_t i = 0; i < count; i++)
                t[i] = time_of(samples, start + i);
            if (!equation_values(&walk, t, count, residual + start, NULL))
                return false;
            for (size_t i = 0; i < count; i++) {
                residual[start + i] = samples->y[start + i] - x->middle - residual[start + i];
                baseline_basis(&block, x->baseline.terms, t[i], base);
                if (x->use[start + i])
                    add_row(1, x->baseline.terms, &residual[start + i], base, &block, &unused);
            }
        }
        const int terms = factor_block(&block, x->baseline.terms, l);
        double coefficient[BASELINE_TERMS] = {0};
        for (int m = 0; m < terms; m++)
            coefficient[m] = block.cross[m][0];
        cholesky_forward(terms, BASELINE_TERMS, l, coefficient);
        cholesky_backward(terms, BASELINE_TERMS, l, coefficient);
        for (size_t i = begin; i < end; i++) {
            baseline_basis(&block, terms, time_of(samples, i), base);
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
