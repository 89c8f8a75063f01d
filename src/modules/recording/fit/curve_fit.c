/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Least squares for any curve (curve_fit()). Robust fits set weights anew between the steps
 * (Holland & Welsch 1977). The descent itself is in least_squares.c, uncertainties are in
 * judgement.c. */
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include "modules/recording/fit/curve_problem.h"

#include <math.h>
#include <string.h>

/* Default number of iterations; rounds of new weights at most, the first of them with soft-L1
 * weights; and the number of samples from which on a thinned series provides the start. */
enum { ITERATIONS = 500, ROBUST_ROUNDS = 40, SOFT_ROUNDS = 5, MANY = CURVE_MANY };

/* Tuning constant of the soft-L1 weights, in robust standard deviations. */
#define SOFT_L1 1.345
/* Largest change of a weight with which the weights count as settled. */
#define WEIGHTS_STAY 1e-3
/* Steps are refined to this length, relative to the value or the uncertainty; costly curves
 * less. */
#define LENGTH_EXACT 1e-14
#define LENGTH_COSTLY 1e-10
/* Largest gain, in variances of a residual, that the last step of a rough fit may promise. */
#define TRUST_ROUGH 1e-8
/* Levenberg-Marquardt damping of the first step. */
#define DAMPING_FIRST 3e-3

/* ---- the problem ---- */

/* Computes residuals and derivatives at x, in the curve's order, unless they are those of x
 * already. Returns false if the curve has no finite value or derivative there. */
static bool evaluate_curve(struct curve_problem *p, const double *x)
{
    const size_t count = (size_t)p->curve->parameters, bytes = count * sizeof *x;
    if (p->known && memcmp(p->point, x, bytes) == 0)
        return true;
    p->known = false;
    if (!p->curve->evaluate(p->curve->context, x, p->t, p->n, p->value, p->derivative))
        return false;
    for (size_t i = 0; i < p->n; i++) {
        p->residual[i] = p->y[i] - p->value[i];
        for (size_t j = 0; j < count; j++)
            if (!isfinite(p->derivative[i * count + j]))
                return false;
    }
    memcpy(p->point, x, bytes);
    return p->known = true;
}

/* Converts parameters from the model's order to the curve's. */
static void to_curve(const struct curve_problem *p, const double *model, double *curve)
{
    for (int j = 0; j < p->curve->parameters; j++)
        curve[p->order[j]] = model[j];
}

/* Converts parameters from the curve's order to the model's. */
static void to_model(const struct curve_problem *p, const double *curve, double *model)
{
    for (int j = 0; j < p->curve->parameters; j++)
        model[j] = curve[p->order[j]];
}

/* Sets *t to the triangle of the weighted derivatives by the model's first `columns` parameters,
 * with `right` [n] as the last column. Returns false if cancelled. */
static bool triangle_fold(const struct curve_problem *p, int columns, const double *right,
                          struct triangle *t)
{
    const size_t count = (size_t)p->curve->parameters, width = (size_t)columns + 1;
    double block[(TRIANGLE_COLUMNS + TRIANGLE_ROWS) * TRIANGLE_COLUMNS];
    size_t rows = 0;
    *t = (struct triangle){.n = columns};
    for (size_t i = 0; i < p->n; i++) {
        const double root = sqrt(p->weight[i]);
        double *row = block + (width + rows) * width;
        if (cancelled_at(p->cancel, i))
            return false;
        for (int j = 0; j < columns; j++)
            row[j] = root * p->derivative[i * count + (size_t)p->order[j]];
        row[columns] = root * right[i];
        t->rows += root > 0;
        rows += root > 0;
        if (rows == TRIANGLE_ROWS || (i + 1 == p->n && rows > 0)) {
            triangle_add(t, block, rows);
            rows = 0;
        }
    }
    return true;
}

/* Fills the triangle of the first `columns` parameters at x (see struct least_squares). */
static bool linearise(void *context, const double *x, int columns, struct triangle *t)
{
    struct curve_problem *p = context;
    double place[CURVE_PARAMETERS];
    to_curve(p, x, place);
    return evaluate_curve(p, place) && triangle_fold(p, columns, p->residual, t);
}

/* Fills the triangle with the second derivative of the residuals along `step`, by a finite
 * difference (see struct least_squares). Returns false if the curve has no value there. */
static bool curvature(void *context, const double *x, const double *step, struct triangle *t)
{
    static const double part = 0.02; /* fraction of the step over which the difference is taken */
    struct curve_problem *p = context;
    const size_t count = (size_t)p->curve->parameters;
    double ahead[CURVE_PARAMETERS];
    for (size_t j = 0; j < count; j++)
        ahead[j] = x[j] + part * step[j];
    if (!evaluate_curve(p, x) ||
        !p->curve->evaluate(p->curve->context, ahead, p->t, p->n, p->value, NULL))
        return false;
    for (size_t i = 0; i < p->n; i++) {
        double slope = 0;
        for (size_t j = 0; j < count; j++)
            slope += p->derivative[i * count + j] * step[j];
        p->scratch[i] = 2 / part * (slope - (p->value[i] - p->y[i] + p->residual[i]) / part);
    }
    return triangle_fold(p, p->model.parameters, p->scratch, t);
}

/* Sets the model's order of parameters: those marked in `linear` first. NULL marks none. */
static void set_order(struct curve_problem *p, const bool *linear)
{
    int others = 0;
    p->model.linears = 0;
    for (int j = 0; j < p->curve->parameters; j++)
        p->model.linears += linear && linear[j];
    for (int j = 0, solved = 0; j < p->curve->parameters; j++)
        p->order[linear && linear[j] ? solved++ : p->model.linears + others++] = j;
}

/* Sets up the least-squares problem of a curve and a series in *p: allocates its arrays in the
 * arena, orders the parameters so that the linear ones (NULL for none) come first, and gives all
 * samples the weight 1. Returns false if out of memory or cancelled. */
bool curve_problem_init(struct curve_problem *p, const struct fit_curve *curve, const bool *linear,
                        const struct series *series, struct arena *arena)
{
    const size_t n = series->n;
    *p = (struct curve_problem){
        .curve = curve, .t = series->t, .y = series->y, .n = n, .cancel = series->cancel};
    p->model = (struct least_squares){.parameters = curve->parameters,
                                      .unit = p->unit,
                                      .context = p,
                                      .linearise = linearise,
                                      .curvature = curvature};
    set_order(p, linear);
    p->value = arena_array(arena, n, sizeof(double));
    p->scratch = arena_array(arena, n, sizeof(double));
    p->weight = arena_array(arena, n, sizeof(double));
    p->residual = arena_array(arena, n, sizeof(double));
    p->derivative = arena_array(arena, n * (size_t)curve->parameters, sizeof(double));
    if (!p->value || !p->scratch || !p->weight || !p->residual || !p->derivative)
        return false;
    for (size_t i = 0; i < n; i++) {
        if (cancelled_at(p->cancel, i))
            return false;
        p->weight[i] = 1;
        p->size = hypot(p->size, series->y[i]);
    }
    return true;
}

/* Solves in the order of the model, which has the linear parameters first, from values of 0. */
double curve_solve_linears(struct curve_problem *p, double *x)
{
    struct triangle t = {.n = p->model.linears};
    double place[CURVE_PARAMETERS];
    to_model(p, x, place);
    memset(place, 0, (size_t)t.n * sizeof *place);
    const double rss = solve_linears(&p->model, place, &t);
    to_curve(p, place, x);
    return rss;
}

/* ---- the minimum ---- */

/* Manners of descent: to 1e-8 variances; to the last digits; the same with geodesic acceleration;
 * and with damping scaled by the present columns. */
enum manner { ROUGHLY, EXACTLY, ACCELERATED, RESCALED, MANNERS };

/* Descends from x, in the curve's order, to the minimum in the given manner with at most `max`
 * steps, and adds their number to *iterations. Returns false if the curve has no value at x, or if
 * cancelled. */
static bool descend_in_manner(struct curve_problem *p, double *x, enum manner manner, int max,
                              int *iterations)
{
    static const double rounding = 32 * 2.2e-16;
    struct descent d = {.iterations = 0};
    const double exact = p->costly ? LENGTH_COSTLY : LENGTH_EXACT;
    const struct descent_options options = {.trust = TRUST_ROUGH,
                                            .rounding = rounding * p->size * rounding * p->size,
                                            .exact = manner == ROUGHLY ? 0 : exact,
                                            .accelerated = manner >= ACCELERATED,
                                            .rescaled = manner == RESCALED || p->model.linears > 0,
                                            .damping = DAMPING_FIRST,
                                            .iterations = max,
                                            .cancel = p->cancel};
    to_model(p, x, d.x);
    /* The derivatives by the nonlinear parameters depend on the linear ones, so these are solved
     * first. */
    if (p->model.linears > 0) {
        struct triangle t = {.n = p->model.linears};
        if (!isfinite(solve_linears(&p->model, d.x, &t)))
            return false;
    }
    const bool done = least_squares_descend(&p->model, &options, &d);
    if (done)
        to_curve(p, d.x, x);
    *iterations += d.iterations;
    return done;
}

/* Returns the robust standard deviation (from the median) of the residuals begin to end - 1 about
 * `middle`. */
static double robust_scale(struct curve_problem *p, double middle, size_t begin, size_t end)
{
    for (size_t i = begin; i < end; i++)
        p->scratch[i] = fabs(p->residual[i] - middle);
    return MAD_TO_SIGMA * values_quantile(p->scratch + begin, end - begin, 0.5);
}

/* Sets the weights from the residuals in robust standard deviations: soft-L1 or bisquare. Returns
 * the largest change of a weight, or INFINITY if cancelled. */
static double set_weights(struct curve_problem *p, bool soft)
{
    const size_t stretches = p->stretch > 0 && p->n >= 2 * p->stretch ? p->n / p->stretch : 1;
    memcpy(p->scratch, p->residual, p->n * sizeof *p->scratch);
    double middle = values_quantile(p->scratch, p->n, 0.5), change = 0;
    if (cancelled(p->cancel))
        return INFINITY;
    p->scale = fmax(robust_scale(p, middle, 0, p->n), 4e-16 * p->size / sqrt((double)p->n));
    for (size_t k = 0; k < stretches && !cancelled(p->cancel); k++) {
        const size_t begin = p->n * k / stretches, end = p->n * (k + 1) / stretches;
        const double local = stretches > 1 ? robust_scale(p, middle, begin, end) : 0;
        const double width = fmax(p->scale, local) * (soft ? SOFT_L1 : BISQUARE_TUNING);
        for (size_t i = begin; i < end; i++) {
            double z = p->residual[i] / width;
            const double left = fmax(1 - z * z, 0);
            const double weight = soft ? 1 / sqrt(1 + z * z) : left * left;
            change = fmax(change, fabs(weight - p->weight[i]));
            p->weight[i] = weight;
        }
    }
    return cancelled(p->cancel) ? INFINITY : change;
}

/* Alternates between new robust weights and single steps of x until the weights settle; *settles
 * tells whether they did. Adds the steps to *iterations. Returns false if the curve has no value or
 * the search was cancelled. */
static bool find_weights(struct curve_problem *p, double *x, int *iterations, bool *settles)
{
    for (int round = 0; round < ROBUST_ROUNDS; round++) {
        const bool soft = round < SOFT_ROUNDS;
        if (!evaluate_curve(p, x))
            return false;
        const double change = set_weights(p, soft);
        *settles = !soft && change < WEIGHTS_STAY;
        if (*settles)
            return true;
        if (!isfinite(change) || !descend_in_manner(p, x, ROUGHLY, 1, iterations))
            return false;
    }
    return true;
}

/* Finds the minimum of the sum of squares from x [parameters], which is in and out, and sets the
 * result, with errors and fit->converged, in *fit. Begins with variable projection if the curve is
 * linear in some parameters; then bounds and robust weights are applied, and the manners of descent
 * are tried in turn until one converges. Returns false if the curve has no value at x, or if
 * cancelled. */
static bool fit_minimise(struct curve_problem *p, double *x, const struct curve_options *o,
                         struct curve_fit *fit)
{
    const int max = o->iterations > 0 ? o->iterations : ITERATIONS;
    bool settles = true;
    int iterations = 0;
    const size_t bytes = (size_t)p->curve->parameters * sizeof *x;
    double start[CURVE_PARAMETERS] = {0}, least = INFINITY;
    if (p->model.linears > 0 && !descend_in_manner(p, x, ROUGHLY, max, &iterations))
        return false;
    set_order(p, NULL);
    p->model.low = o->low;
    p->model.high = o->high;
    for (int j = 0; j < p->curve->parameters; j++) {
        x[j] = o->low ? fmax(x[j], o->low[j]) : x[j];
        x[j] = o->high ? fmin(x[j], o->high[j]) : x[j];
    }
    if ((p->rough || p->robust) && !descend_in_manner(p, x, ROUGHLY, max, &iterations))
        return false;
    if (p->robust && !find_weights(p, x, &iterations, &settles))
        return false;
    memcpy(start, x, bytes);
    for (int manner = EXACTLY; manner < (p->costly ? ACCELERATED : MANNERS) && !p->rough;
         manner++) {
        double trial[CURVE_PARAMETERS];
        memcpy(trial, start, bytes);
        if (!descend_in_manner(p, trial, (enum manner)manner, max, &iterations))
            return false;
        fit_judge(p, trial, true, fit);
        if (manner == EXACTLY || fit->converged || fit->rss < least)
            memcpy(x, trial, bytes);
        least = fmin(least, fit->rss);
        if (fit->converged)
            break;
    }
    if (!fit->converged)
        fit_judge(p, x, !p->rough, fit);
    fit->iterations = iterations;
    fit->converged = fit->converged && settles;
    return !cancelled(p->cancel);
}

/* Sets the error of a curve without a finite value or derivative at the start. Returns false. */
static bool fit_error_set(const struct fit_curve *curve, const double *start, struct error *error)
{
    struct buffer where = {0};
    for (int j = 0; j < curve->parameters; j++) {
        buffer_format(&where, "%s%s = ", j ? ", " : "", curve->name[j]);
        buffer_short(&where, start[j], 6);
    }
    error_set(error, ERROR_COMMAND, "the formula has no finite value or slope at %s",
              where.failed ? "the start" : where.data);
    buffer_free(&where);
    return error_hint(error, "give other starts");
}

/* Sets the size of each parameter by which is judged if it lies on a bound: its distance from a
 * bound, or from 0 without bounds. */
static void set_units(struct curve_problem *p, const struct curve_options *o, const double *start)
{
    const double *low = o->low, *high = o->high;
    for (int j = 0; j < p->curve->parameters; j++) {
        const double upper = high && isfinite(high[j]) ? high[j] : 0;
        const double bound = low && isfinite(low[j]) ? low[j] : upper;
        p->unit[j] = fmax(fabs(start[j] - bound), 1e-3 * fabs(bound));
        p->unit[j] = p->unit[j] > 0 ? p->unit[j] : 1;
    }
}

/* Replaces the start x of a fit of very many samples by the answer of a fit to a thinned series.
 * Returns false if out of memory for the thinned series. If that fit fails, the start stays
 * unchanged; the error is set if it was cancelled. */
static bool improve_by_part(const struct fit_curve *curve, const struct series *series, double *x,
                            const struct curve_options *options, struct error *error)
{
    struct arena scratch = {0};
    struct series part;
    struct curve_options plain = *options;
    struct curve_fit fit;
    struct error local = {0};
    const bool memory = curve_part(series, &scratch, &part);
    plain.bootstrap = 0;
    plain.stretch = options->stretch / (series->n / MANY + 1);
    const bool ok = memory && curve_fit(curve, &part, x, &plain, &scratch, &fit, &local);
    for (int j = 0; j < curve->parameters && ok; j++)
        x[j] = fit.value[j].value;
    arena_reset(&scratch);
    if (!ok && local.code != ERROR_COMMAND) {
        *error = local;
        return memory || error_memory(error);
    }
    return true;
}

/* Fits the curve to the series. A long series is fitted in part first, to improve the start.
 * `options` may be NULL. On success *fit holds the values, their errors, residuals and weights (in
 * the arena), with a bootstrap if the options ask for one and the fit converged. Returns false with
 * *error otherwise. */
bool curve_fit(const struct fit_curve *curve, const struct series *series, const double *start,
               const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
               struct error *error)
{
    static const struct curve_options none;
    const struct curve_options *o = options ? options : &none;
    const size_t n = series->n, bytes = (size_t)curve->parameters * sizeof *start;
    struct arena work = {0};
    struct curve_problem p;
    double x[CURVE_PARAMETERS];
    *fit = (struct curve_fit){.parameters = curve->parameters};
    if (!enough_samples(series, curve->parameters, error))
        return false;
    memcpy(x, start, bytes);
    if (n > MANY && !improve_by_part(curve, series, x, o, error))
        return false;
    fit->residual = arena_array(arena, n, sizeof(double));
    fit->weight = arena_array(arena, n, sizeof(double));
    bool ok =
        fit->residual && fit->weight && curve_problem_init(&p, curve, o->linear, series, &work);
    if (!ok) {
        arena_reset(&work);
        return cancelled(o->cancel) ? error_set(error, ERROR_CANCELLED, "stopped")
                                    : error_memory(error);
    }
    p.robust = o->robust;
    p.rough = o->rough;
    p.costly = o->costly;
    p.stretch = o->stretch;
    p.cancel = o->cancel;
    set_units(&p, o, start);
    ok = fit_minimise(&p, x, o, fit);
    if (ok) {
        memcpy(fit->residual, p.residual, n * sizeof(double));
        memcpy(fit->weight, p.weight, n * sizeof(double));
        fit_conclude(&p, fit);
        ok =
            o->bootstrap <= 0 || !fit->converged || fit_bootstrap(&p, series, o, arena, fit, error);
    } else if (cancelled(o->cancel)) {
        error_set(error, ERROR_CANCELLED, "the fit was stopped");
    } else {
        fit_error_set(curve, start, error);
    }
    arena_reset(&work);
    return ok;
}
