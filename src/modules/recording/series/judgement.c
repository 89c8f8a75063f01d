/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Judges the answer of a least-squares fit from the derivatives at the answer, not from how the
 * iteration ended. The component of the residuals in the space of the derivatives is what a further
 * step could still gain (the relative offset of Bates & Watts 1981); the singular values show which
 * parameters the data determine. The two last functions judge a series for other modules. */
#include <hooke/base/cancel.h>
#include "modules/recording/fit/curve_problem.h"

#include <gsl/gsl_cdf.h>
#include <stdio.h>
#include <string.h>

#define DOUBLE_EPSILON 2.220446049250313e-16
/* Largest step, relative to the value or its uncertainty, at which a fit has converged. */
#define STEP_MAX 1e-8
/* The same relative to the uncertainty for costly curves, whose derivatives have errors of
 * integration. */
#define STEP_COSTLY 1e-6
/* Largest component of the residuals in the space of the derivatives, relative to their length. */
#define GRADIENT_MAX 1e-6
/* Autocorrelation of neighbouring residuals above which the uncertainties are widened. */
#define AUTOCORRELATION_MIN 0.1

/* Computes the full Gauss-Newton step from the triangle of normal equations, adds the covariance
 * for residuals of variance 1 to fit->covariance, and clears fit->determined of parameters without
 * influence. Returns the length of the change of the residuals that the step predicts. */
static double gauss_newton_solve(const struct triangle *t, double *step, struct curve_fit *fit)
{
    struct linear_problem l;
    linear_problem_of(t, 0, fit->bound, NULL, &l);
    const int m = l.free;
    for (int k = 0; k < m; k++)
        for (int i = 0; i < m; i++) {
            const double vi = l.v[i * m + k];
            bool *determined = &fit->determined[l.index[i]];
            if (!(l.s[k] > l.min)) /* a direction that no column has */
                *determined = *determined && fabs(vi) < 0.1;
            for (int j = 0; j < m && l.s[k] > l.min; j++)
                fit->covariance[l.index[i]][l.index[j]] +=
                    vi * l.v[j * m + k] / (l.s[k] * l.s[k]) / l.scale[i] / l.scale[j];
        }
    return sqrt(linear_problem_step(&l, 0, step));
}

/* ---- the variance of the residuals ---- */

/* Returns the variance of a residual, with `free` fitted parameters: sum of squares over degrees of
 * freedom. For robust fits it is the mean weight times E psi^2/(E psi')^2 (Huber 1981, 7.6), to be
 * multiplied by a covariance that contains the weights. */
static double residual_variance(const struct curve_problem *p, const struct curve_fit *fit,
                                size_t free)
{
    double n = (double)p->n;
    if (!p->robust)
        return fit->rss / (n - (double)free);
    double square = 0, slope = 0, weight = 0;
    for (size_t i = 0; i < p->n; i++) {
        double w = p->weight[i], r = p->residual[i];
        square += w * w * r * r;
        slope += w > 0 ? 5 * w - 4 * sqrt(w) : 0; /* psi' = (1 - z^2)(1 - 5 z^2), w = (1 - z^2)^2 */
        weight += w;
    }
    return slope > 0 ? weight / n * square / (n - (double)free) / (slope / n) / (slope / n) : NAN;
}

/* Returns true if the data determine parameter j of x: the weighted sum of squares, rss, changes by
 * more than a hundredth of `variance` if the parameter is moved by `deviation` to either side. */
static bool is_determined(struct curve_problem *p, const double *x, int j, double deviation,
                          double variance, double rss)
{
    double trial[CURVE_PARAMETERS];
    memcpy(trial, x, (size_t)p->curve->parameters * sizeof *x);
    for (int side = -1; side <= 1; side += 2) {
        trial[j] = x[j] + side * deviation;
        if (cancelled(p->cancel) || (p->model.low && trial[j] < p->model.low[j]) ||
            (p->model.high && trial[j] > p->model.high[j]) ||
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

/* Fills *fit for the parameters x: residual variance, covariances, and whether the fit has
 * converged, by the step and gradient that remain. `probe` also tests by evaluations that each
 * parameter is determined. */
void fit_judge(struct curve_problem *p, const double *x, bool probe, struct curve_fit *fit)
{
    const int count = p->curve->parameters;
    struct triangle t;
    double inward[CURVE_PARAMETERS], step[CURVE_PARAMETERS] = {0}, *residual = fit->residual,
                                     *weight = fit->weight;
    size_t free = 0;
    *fit = (struct curve_fit){
        .parameters = count, .rss = NAN, .sigma = NAN, .residual = residual, .weight = weight};
    for (int j = 0; j < count; j++) {
        fit->value[j] = (struct measured){x[j], NAN};
        fit->formal[j] = NAN;
        fit->bound[j] = on_bound(&p->model, j, x[j], &inward[j]);
        fit->determined[j] = !fit->bound[j];
        free += !fit->bound[j];
    }
    if (!p->model.linearise(p, x, count, &t))
        return;
    fit->rss = triangle_squares(&t, 0);
    if (!isfinite(fit->rss))
        return;
    const double offset = gauss_newton_solve(&t, step, fit), left = residual_variance(p, fit, free),
                 sigma = sqrt(left), length = sqrt(fit->rss),
                 rounding = 32 * DOUBLE_EPSILON * p->size;
    fit->sigma = sigma;
    fit->small_step = isfinite(left);
    fit->small_gradient = offset <= fmax(GRADIENT_MAX * length, rounding);
    bool determined = true;
    for (int j = 0; j < count; j++) {
        double deviation = sqrt(fit->covariance[j][j]), pull = 0;
        for (int i = 0; i < count; i++)
            fit->covariance[j][i] *= left;
        for (int i = 0; i <= j; i++)
            pull += t.r[i][j] * t.r[i][count];
        if (fit->bound[j]) { /* the sum of squares must not fall towards the inside */
            fit->small_gradient = fit->small_gradient && !(inward[j] * pull > 0);
            continue;
        }
        fit->formal[j] = sigma * deviation;
        double part = p->costly ? STEP_COSTLY : STEP_MAX;
        double step_max = fmax(STEP_MAX * fabs(x[j]), part * fit->formal[j]);
        fit->small_step = fit->small_step && fabs(step[j]) <= fmax(step_max, rounding * deviation);
        bool exact = length <= 1e-12 * p->size; /* nothing but rounding is left */
        fit->determined[j] =
            fit->determined[j] && (exact || !probe ||
                                   is_determined(p, x, j, fit->formal[j],
                                                 p->robust ? p->scale * p->scale : left, fit->rss));
        determined = determined && fit->determined[j];
    }
    fit->converged = fit->small_step && fit->small_gradient && determined;
}

/* ---- conclude ---- */

/* Counts used and rejected samples, and computes the residuals' lag-1 autocorrelation and number of
 * runs of equal sign, in standard deviations from chance (Wald & Wolfowitz 1940). */
static void residuals_diagnose(const struct curve_problem *p, struct curve_fit *fit)
{
    double product = 0, square = 0, plus = 0, minus = 0, runs = 0, previous = 0;
    for (size_t i = 0; i < p->n; i++) {
        if (!(p->weight[i] > 0)) {
            fit->rejected++;
            continue;
        }
        double r = fit->residual[i];
        product += previous * r;
        square += r * r;
        plus += r > 0;
        minus += r <= 0;
        runs += previous == 0 || (r > 0) != (previous > 0);
        previous = r;
        fit->used++;
    }
    double n = plus + minus, expected = 1 + 2 * plus * minus / n;
    double spread = sqrt((expected - 1) * (expected - 2) / (n - 1));
    fit->autocorrelation = square > 0 ? product / square : 0;
    fit->runs = spread > 0 ? (runs - expected) / spread : 0;
}

/* Computes the uncertainty of each parameter that is due to a sensor's coarse resolution: rounding
 * errors are systematic where the curve is flat. It is the standard deviation over the possible
 * positions of the rounding steps. Noise makes rounding errors random, and the doubt small. */
static void rounding_doubts(const struct curve_problem *p, const struct curve_fit *fit,
                            double doubt[CURVE_PARAMETERS])
{
    enum { SHIFTS = 8 };
    /* A smaller share of systematic rounding errors beside the noise is neglected. */
    static const double spread_out = 0.05;
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

/* Writes the verdict of a fit into fit->said. */
static void curve_fit_judge(const struct curve_problem *p, struct curve_fit *fit)
{
    const char *undetermined = NULL;
    const char *reason =
        fit->small_step ? "the gradient does not vanish" : "neither step nor gradient vanish";
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
                 fit->iterations, fit->small_gradient ? "the steps do not become small" : reason);
}

/* Completes *fit: widens formal uncertainties by the correlation of residuals, adds the effect of
 * the sensor's rounding, and computes 95 % intervals, correlations and the verdict. */
void fit_conclude(const struct curve_problem *p, struct curve_fit *fit)
{
    double rounding[CURVE_PARAMETERS] = {0};
    residuals_diagnose(p, fit);
    rounding_doubts(p, fit, rounding);
    fit->converged = fit->converged && !fit_discards_much(fit->rejected, p->n);
    /* Correlated residuals count as fewer: uncertainties grow by sqrt(factor), degrees of freedom
     * shrink. */
    double factor = fit->autocorrelation > AUTOCORRELATION_MIN
                        ? autocorrelation_factor(fit->autocorrelation)
                        : 1;
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
            const double correlation = both > 0 ? fit->covariance[j][i] / factor / both : 0;
            fit->correlation[j][i] = i == j ? 1 : correlation;
        }
    }
    curve_fit_judge(p, fit);
}

/* Sets use [n] to 0 for the samples that the fit of a damped sine leaves out as outliers. Returns
 * false if no damped sine describes the series, if it is too long for such a fit or its samples are
 * uneven, or if out of memory. */
bool series_outliers(const struct series *series, struct arena *arena, unsigned char *use)
{
    enum { ROWS_MAX = 16384 }; /* more are not fitted only in order to judge them */
    struct motion m;
    if (series->n > ROWS_MAX ||
        series_is_uneven(series)) /* fits use other samples than these rows */
        return false;
    if (!motion_init(&m, series, arena, NULL) || !m.overview.oscillates || !m.harmonic.converged ||
        fit_discards_much(m.rejected, m.samples.n))
        return false;
    memcpy(use, m.samples.use, series->n);
    return true;
}

/* Returns true if two damped sines describe the series and one alone does not, so that it beats.
 * Returns false without a search if the series has more than ROWS_MAX samples. */
bool series_beats(const struct series *series, struct arena *arena)
{
    enum { ROWS_MAX = 100000 };
    struct samples samples;
    struct mode_pair pair;
    return series->n <= ROWS_MAX && samples_init(&samples, series, arena) &&
           two_lines(&samples, &pair);
}
