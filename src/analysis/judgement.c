/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What the answer of a least-squares fit is worth: judged from the derivatives at the answer, not
 * from how the iteration ended. The residuals' part in the space of the derivatives is what a
 * further step could still gain (the relative offset of Bates & Watts 1981); the singular values
 * say which parameters the data determine.
 */
#include "analysis/fit/least_squares.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_linalg.h>
#include <stdio.h>
#include <string.h>

#define EPSILON 2.220446049250313e-16
#define STEP_MAX 1e-8
/* of the uncertainty: derivatives of integrated curves have errors, too */
#define STEP_COSTLY 1e-6
#define GRADIENT_MAX 1e-6
/* lag-1 autocorrelation from which the uncertainties are widened (NUMERICS: n_eff) */
#define CORRELATED 0.1

/* ---- the linear problem at the answer ---- */

struct linear {
    size_t count; /* free parameters */
    int at[CURVE_PARAMETERS];
    double norm[CURVE_PARAMETERS];      /* of the columns, which are scaled to length 1 */
    double projected[CURVE_PARAMETERS]; /* Q^T r */
    double r[CURVE_PARAMETERS * CURVE_PARAMETERS]; /* then U of its singular value decomposition */
    double v[CURVE_PARAMETERS * CURVE_PARAMETERS], s[CURVE_PARAMETERS];
};

/* Weighted row i of the derivatives, scaled, and its residual, into row `to`. */
static void fill_row(const struct problem *p, const double *residual, const struct linear *l,
                     size_t i, gsl_matrix *a, gsl_vector *b, size_t to)
{
    double root = sqrt(p->weight[i]);
    gsl_vector_set(b, to, root * residual[i]);
    for (size_t k = 0; k < l->count; k++) {
        size_t at = i * (size_t)p->curve->parameters + (size_t)l->at[k];
        gsl_matrix_set(a, to, k, root * p->derivative[at] / l->norm[k]);
    }
}

/*
 * R and Q^T r of the derivatives, some rows at a time under the R of those before (Golub & Van
 * Loan, 5.3.2): no matrix of n rows, and what is worked on stays in the cache. Then R = U S V^T.
 */
static bool decompose(const struct problem *p, const double *residual, struct linear *l)
{
    enum { ROWS = 128 };
    size_t m = l->count;
    gsl_matrix *a = gsl_matrix_calloc(m + ROWS, m);
    gsl_vector *b = gsl_vector_calloc(m + ROWS), *tau = gsl_vector_alloc(m);
    bool memory = a && b && tau;
    for (size_t k = 0; k < m; k++) {
        l->norm[k] = 0;
        memory = memory && !cancelled(p->cancel);
        for (size_t i = 0; i < p->n; i++) {
            double d = p->derivative[i * (size_t)p->curve->parameters + (size_t)l->at[k]] /
                       fmax(p->largest[l->at[k]], 1e-300);
            l->norm[k] += p->weight[i] * d * d;
        }
        l->norm[k] = l->norm[k] > 0 ? sqrt(l->norm[k]) * p->largest[l->at[k]] : 1;
    }
    for (size_t i = 0; i < p->n && memory; i += ROWS) {
        if (i % (LOOK_EACH_ROWS / 8) == 0 && cancelled(p->cancel))
            memory = false;
        size_t rows = p->n - i < ROWS ? p->n - i : ROWS;
        for (size_t k = 0; k < rows; k++)
            fill_row(p, residual, l, i + k, a, b, m + k);
        gsl_matrix_view part = gsl_matrix_submatrix(a, 0, 0, m + rows, m);
        gsl_vector_view right = gsl_vector_subvector(b, 0, m + rows);
        gsl_linalg_QR_decomp(&part.matrix, tau);
        gsl_linalg_QR_QTvec(&part.matrix, tau, &right.vector);
        for (size_t k = 1; k < m; k++)
            for (size_t j = 0; j < k; j++)
                gsl_matrix_set(a, k, j, 0);
    }
    if (memory) {
        gsl_matrix_view r = gsl_matrix_view_array(l->r, m, m),
                        v = gsl_matrix_view_array(l->v, m, m);
        gsl_vector_view s = gsl_vector_view_array(l->s, m);
        gsl_matrix_const_view top = gsl_matrix_const_submatrix(a, 0, 0, m, m);
        gsl_matrix_memcpy(&r.matrix, &top.matrix);
        for (size_t i = 0; i < m; i++)
            l->projected[i] = gsl_vector_get(b, i);
        /* by one-sided rotations: the other way allocates inside, and does not look whether it
         * could */
        gsl_linalg_SV_decomp_jacobi(&r.matrix, &v.matrix, &s.vector);
    }
    gsl_matrix_free(a);
    gsl_vector_free(b);
    gsl_vector_free(tau);
    return memory;
}

/* Full Gauss–Newton step, covariance for residuals of variance 1, what is determined. Returns the
 * length of what the step takes out of the residuals. */
static double solve(const struct problem *p, const struct linear *l, double *step,
                    struct curve_fit *fit)
{
    size_t m = l->count;
    double gain = 0, min = fmin(8 * EPSILON * (double)(p->n + m), 1e-10) * l->s[0];
    for (size_t k = 0; k < m; k++) {
        double turned = 0;
        for (size_t i = 0; i < m; i++)
            turned += l->r[i * m + k] * l->projected[i];
        for (size_t i = 0; i < m; i++) {
            double vi = l->v[i * m + k];
            if (!(l->s[k] > min)) {
                turned = 0; /* a direction that no column has */
                fit->determined[l->at[i]] = fit->determined[l->at[i]] && fabs(vi) < 0.1;
                continue;
            }
            step[l->at[i]] += vi * turned / l->s[k] / l->norm[i];
            for (size_t j = 0; j < m; j++)
                fit->covariance[l->at[i]][l->at[j]] +=
                    vi * l->v[j * m + k] / (l->s[k] * l->s[k]) / l->norm[i] / l->norm[j];
        }
        gain = hypot(gain, turned);
    }
    return gain;
}

/* ---- the variance of the residuals ---- */

/*
 * Sum of squares over degrees of freedom. Robust: E psi^2/(E psi')^2 (Huber 1981, 7.6), by which a
 * covariance with the weights inside is multiplied together with the mean weight.
 */
static double variance(const struct problem *p, const struct curve_fit *fit, size_t free)
{
    double n = (double)p->n;
    if (!p->robust)
        return fit->rss / (n - (double)free);
    double square = 0, slope = 0, weight = 0;
    for (size_t i = 0; i < p->n; i++) {
        double w = p->weight[i], r = fit->residual[i];
        square += w * w * r * r;
        slope += w > 0 ? 5 * w - 4 * sqrt(w) : 0; /* psi' = (1 - z^2)(1 - 5 z^2), w = (1 - z^2)^2 */
        weight += w;
    }
    return slope > 0 ? weight / n * square / (n - (double)free) / (slope / n) / (slope / n) : NAN;
}

/* One standard deviation to either side the sum of squares must change, or the data do not hold the
 * parameter there. */
static bool is_determined(struct problem *p, const double *x, int j, double deviation,
                          double variance, double rss)
{
    double trial[CURVE_PARAMETERS];
    memcpy(trial, x, (size_t)p->curve->parameters * sizeof *x);
    for (int side = -1; side <= 1; side += 2) {
        trial[j] = x[j] + side * deviation;
        if (cancelled(p->cancel) || (p->low && trial[j] < p->low[j]) ||
            (p->high && trial[j] > p->high[j]) ||
            !p->curve->evaluate(p->curve->context, trial, p->t, p->n, p->value, NULL))
            continue;
        double sum = 0;
        for (size_t i = 0; i < p->n; i++)
            sum += p->weight[i] * (p->y[i] - p->value[i]) * (p->y[i] - p->value[i]);
        if (fabs(sum - rss) < 0.01 * variance)
            return false;
    }
    return true;
}

/* ---- judge ---- */

bool judge(struct problem *p, const double *x, bool probe, struct curve_fit *fit)
{
    struct linear l = {.count = 0};
    int count = p->curve->parameters;
    double inward[CURVE_PARAMETERS], *residual = fit->residual, *weight = fit->weight;
    *fit = (struct curve_fit){.parameters = count, .residual = residual, .weight = weight};
    memset(p->step, 0, sizeof p->step);
    p->length = INFINITY;
    bool there = p->curve->evaluate(p->curve->context, x, p->t, p->n, p->value, p->derivative);
    for (size_t i = 0; i < p->n; i++) {
        residual[i] = there ? p->y[i] - p->value[i] : NAN;
        fit->rss += p->weight[i] * residual[i] * residual[i];
    }
    for (int j = 0; j < count; j++) {
        fit->value[j] = (struct measured){x[j], NAN};
        fit->formal[j] = NAN;
        fit->bound[j] = on_bound(p, j, x[j], &inward[j]);
        fit->determined[j] = !fit->bound[j];
        if (!fit->bound[j])
            l.at[l.count++] = j;
    }
    if (cancelled(p->cancel))
        return false;
    memset(p->largest, 0, sizeof p->largest);
    for (size_t i = 0; i < p->n * (size_t)count && there; i++) {
        double d = p->derivative[i], *largest = &p->largest[i % (size_t)count];
        there = isfinite(d);
        *largest = fmax(*largest, fabs(d));
    }
    if (!isfinite(fit->rss) || !there)
        return true;
    double offset = 0;
    if (l.count > 0) {
        if (!decompose(p, residual, &l))
            return false;
        offset = solve(p, &l, p->step, fit);
    }
    double left = variance(p, fit, l.count), sigma = sqrt(left), length = sqrt(fit->rss);
    double rounding = 32 * EPSILON * p->size;
    fit->sigma = sigma;
    fit->small_step = isfinite(left);
    p->length = 0;
    for (size_t k = 0; k < l.count; k++) {
        int j = l.at[k];
        double deviation = sqrt(fit->covariance[j][j]);
        for (int i = 0; i < count; i++)
            fit->covariance[j][i] *= left;
        fit->formal[j] = sigma * deviation;
        double part = p->costly ? STEP_COSTLY : STEP_MAX;
        double own = fmax(STEP_MAX * fabs(x[j]), part * fit->formal[j]);
        double max = fmax(own, rounding * deviation);
        fit->small_step = fit->small_step && fabs(p->step[j]) <= max;
        p->length = fmax(p->length, fabs(p->step[j]) / fmax(fabs(x[j]), fit->formal[j]));
        bool exact = length <= 1e-12 * p->size; /* nothing but rounding is left */
        fit->determined[j] =
            fit->determined[j] && (exact || !probe ||
                                   is_determined(p, x, j, fit->formal[j],
                                                 p->robust ? p->scale * p->scale : left, fit->rss));
    }
    fit->small_gradient = offset <= fmax(GRADIENT_MAX * length, rounding);
    fit->converged = fit->small_step && fit->small_gradient;
    for (int j = 0; j < count; j++) {
        double slope = 0; /* of the sum of squares, inwards: on a bound it must not fall */
        for (size_t i = 0; i < p->n && fit->bound[j]; i++)
            slope -= inward[j] * p->weight[i] * residual[i] *
                     p->derivative[i * (size_t)count + (size_t)j];
        fit->small_gradient = fit->small_gradient && !(slope < 0);
        fit->converged =
            fit->converged && fit->small_gradient && (fit->bound[j] || fit->determined[j]);
    }
    return true;
}

bool tangent_step(const struct problem *p, const struct curve_fit *fit, const double *residual,
                  double *step)
{
    struct linear l = {.count = 0};
    struct curve_fit unused = {.parameters = fit->parameters};
    memset(step, 0, (size_t)fit->parameters * sizeof *step);
    for (int j = 0; j < fit->parameters; j++)
        if (!fit->bound[j])
            l.at[l.count++] = j;
    if (l.count == 0)
        return true;
    if (!decompose(p, residual, &l))
        return false;
    solve(p, &l, step, &unused);
    return true;
}

/* ---- conclude ---- */

/* Runs of equal sign, in standard deviations from chance (Wald & Wolfowitz 1940), and lag-1
 * autocorrelation. */
static void diagnose(const struct problem *p, struct curve_fit *fit)
{
    double product = 0, square = 0, plus = 0, minus = 0, runs = 0, before = 0;
    for (size_t i = 0; i < p->n; i++) {
        if (!(p->weight[i] > 0)) {
            fit->rejected++;
            continue;
        }
        double r = fit->residual[i];
        product += before * r;
        square += r * r;
        plus += r > 0;
        minus += r <= 0;
        runs += before == 0 || (r > 0) != (before > 0);
        before = r;
        fit->used++;
    }
    double n = plus + minus, expected = 1 + 2 * plus * minus / n;
    double spread = sqrt((expected - 1) * (expected - 2) / (n - 1));
    fit->autocorrelation = square > 0 ? product / square : 0;
    fit->runs = spread > 0 ? (runs - expected) / spread : 0;
}

/*
 * Adds what the rounding errors of a coarse sensor do to the parameters, as they are no chance
 * where the curve is flat: the standard deviation over where the steps may lie. Noise spreads them.
 */
static void rounding_doubts(const struct problem *p, const struct curve_fit *fit,
                            double doubt[CURVE_PARAMETERS])
{
    enum { SHIFTS = 8 };
    static const double spread_out =
        0.05; /* a smaller part of them that noise leaves is neglected */
    const double variance = fit->sigma * fit->sigma,
                 step = samples_quantum(&(struct samples){.y = p->y, .n = p->n}),
                 noise = fmax(variance - step * step / 12, 0),
                 left = step > 0 ? exp(-2 * M_PI * M_PI * noise / (step * step)) : 0;
    const size_t count = (size_t)fit->parameters;
    double square[CURVE_PARAMETERS] = {0};
    if (!(left > spread_out) || !(variance > 0))
        return;
    for (int k = 0; k < SHIFTS; k++) {
        const double shift = ((k + 0.5) / SHIFTS - 0.5) * step;
        double product[CURVE_PARAMETERS] = {0};
        for (size_t i = 0; i < p->n && !cancelled_at(p->cancel, i); i++) {
            const double error = remainder(p->y[i] - fit->residual[i] + shift, step);
            for (size_t j = 0; j < count; j++)
                product[j] += p->weight[i] * error * p->derivative[i * count + j];
        }
        for (size_t j = 0; j < count; j++) {
            double change = 0;
            for (size_t i = 0; i < count; i++)
                change += fit->covariance[j][i] / variance * product[i];
            square[j] += change * change / SHIFTS;
        }
    }
    for (size_t j = 0; j < count; j++)
        doubt[j] = left * sqrt(square[j]);
}

static void say(const struct problem *p, struct curve_fit *fit)
{
    const char *undetermined = NULL;
    for (int j = 0; j < fit->parameters && !undetermined; j++)
        undetermined = fit->determined[j] || fit->bound[j] ? NULL : p->curve->name[j];
    if (fit_discards_much(fit->rejected, p->n))
        snprintf(fit->said, sizeof fit->said, "did not converge: it leaves out %zu of %zu samples",
                 fit->rejected, p->n);
    else if (fit->converged)
        snprintf(fit->said, sizeof fit->said,
                 "converged in %d iterations: step and gradient vanish", fit->iterations);
    else if (undetermined)
        snprintf(fit->said, sizeof fit->said,
                 "did not converge: parameter %s is not determined by the data", undetermined);
    else
        snprintf(fit->said, sizeof fit->said, "did not converge in %d iterations: %s",
                 fit->iterations,
                 fit->small_gradient ? "the steps do not become small"
                 : fit->small_step   ? "the gradient does not vanish"
                                     : "neither step nor gradient vanish");
}

void conclude(const struct problem *p, struct curve_fit *fit)
{
    double rounding[CURVE_PARAMETERS] = {0};
    diagnose(p, fit);
    rounding_doubts(p, fit, rounding);
    fit->converged = fit->converged && !fit_discards_much(fit->rejected, p->n);
    double factor =
        fit->autocorrelation > CORRELATED ? autocorrelation_factor(fit->autocorrelation) : 1;
    double freedom = fmax(1, (double)fit->used / factor - fit->parameters),
           student = gsl_cdf_tdist_Pinv(0.975, freedom);
    for (int j = 0; j < fit->parameters; j++) {
        double x = fit->value[j].value;
        double u = fit->bound[j] ? 0 : NAN;
        if (fit->determined[j])
            u = hypot(sqrt(factor) * fit->formal[j], rounding[j]);
        fit->value[j].uncertainty = u;
        fit->interval[j][0] = x - student * u;
        fit->interval[j][1] = x + student * u;
        for (int i = 0; i < fit->parameters; i++) {
            fit->covariance[j][i] *= factor;
            double both = fit->formal[i] * fit->formal[j];
            fit->correlation[j][i] = i == j     ? 1
                                     : both > 0 ? fit->covariance[j][i] / factor / both
                                                : 0;
        }
    }
    say(p, fit);
}
