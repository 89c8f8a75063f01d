/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Least squares for any curve: the iteration. Bounds by a change of variables (James & Roos 1975,
 * MINUIT), robust loss by weights that are set anew between the fits (Holland & Welsch 1977).
 */
#include "analysis/fit/least_squares.h"
#include "analysis/fit/projection.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <math.h>
#include <string.h>

enum { ITERATIONS = 500, ROBUST_ROUNDS = 40, SOFT_ROUNDS = 5, MANY = CURVE_MANY };

#define NO_VALUE 1e140 /* residual where the curve has none: the step is refused */
#define SOFT_L1 1.345
#define WEIGHTS_STAY 1e-3 /* change of a weight from which on they stay */
/* of the step that is polished no further, relative to value or uncertainty */
#define LENGTH_EXACT 1e-14
#define LENGTH_COSTLY 1e-10

/* ---- the residuals as GSL wants them ---- */

static int residuals(const gsl_vector *u, void *context, gsl_vector *f)
{
    struct problem *p = context;
    double x[CURVE_PARAMETERS], slope;
    for (int j = 0; j < p->curve->parameters; j++)
        x[j] = inside(p, j, gsl_vector_get(u, (size_t)j), &slope);
    bool there = p->curve->evaluate(p->curve->context, x, p->t, p->n, p->value, NULL);
    for (size_t i = 0; i < p->n && there; i++) {
        gsl_vector_set(f, i, p->value[i] - p->y[i]);
        there = isfinite(p->value[i]);
    }
    if (!there)
        gsl_vector_set_all(f, NO_VALUE);
    return GSL_SUCCESS;
}

static int derivatives(const gsl_vector *u, void *context, gsl_matrix *jacobian)
{
    struct problem *p = context;
    size_t count = (size_t)p->curve->parameters;
    double x[CURVE_PARAMETERS], slope[CURVE_PARAMETERS];
    for (int j = 0; j < p->curve->parameters; j++)
        x[j] = inside(p, j, gsl_vector_get(u, (size_t)j), &slope[j]);
    if (!p->curve->evaluate(p->curve->context, x, p->t, p->n, p->value, p->derivative))
        return GSL_EDOM;
    for (size_t i = 0; i < p->n; i++) {
        for (size_t j = 0; j < count; j++) {
            double d = p->derivative[i * count + j] * slope[j];
            if (!isfinite(d))
                return GSL_EDOM;
            gsl_matrix_set(jacobian, i, j, d);
        }
    }
    return GSL_SUCCESS;
}

/* Has the iteration nowhere to go? polish() does the rest. */
static bool settled(const gsl_multifit_nlinear_workspace *work, const struct problem *p)
{
    const gsl_vector *f = gsl_multifit_nlinear_residual(work), *dx = work->dx, *x = work->x,
                     *g = work->g;
    const gsl_matrix *jacobian = gsl_multifit_nlinear_jac(work);
    double size = gsl_blas_dnrm2(f),
           rounding = fmin(1, 16 * 2.3e-16 * p->size / fmax(size, 1e-300));
    for (size_t j = 0; j < x->size; j++) {
        gsl_vector_const_view column = gsl_matrix_const_column(jacobian, j);
        double norm = gsl_blas_dnrm2(&column.vector), at = fabs(gsl_vector_get(x, j));
        double scale = fmax(at, norm > 0 ? size / sqrt((double)p->n) / norm : 0);
        if (fabs(gsl_vector_get(dx, j)) > 1e-8 * scale ||
            fabs(gsl_vector_get(g, j)) > fmax(1e-8, rounding) * norm * size)
            return false;
    }
    return true;
}

enum outcome { OUTCOME_DONE, OUTCOME_NO_VALUE, OUTCOME_MEMORY, OUTCOME_CANCELLED };

/* From u [parameters] to the nearest minimum; u is the answer. */
static enum outcome descend(struct problem *p, double *u, bool accelerate, int max, int *iterations)
{
    size_t count = (size_t)p->curve->parameters;
    gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
    parameters.trs = accelerate ? gsl_multifit_nlinear_trs_lmaccel : gsl_multifit_nlinear_trs_lm;
    parameters.scale = gsl_multifit_nlinear_scale_more;
    parameters.solver = gsl_multifit_nlinear_solver_qr;
    parameters.avmax = 0.75;
    gsl_multifit_nlinear_fdf fdf = {
        .f = residuals, .df = derivatives, .n = p->n, .p = count, .params = p};
    gsl_multifit_nlinear_workspace *work =
        gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, p->n, count);
    if (!work)
        return OUTCOME_MEMORY;
    gsl_vector_view start = gsl_vector_view_array(u, count),
                    weight = gsl_vector_view_array(p->weight, p->n);
    enum outcome outcome = OUTCOME_DONE;
    int status = gsl_multifit_nlinear_winit(&start.vector, &weight.vector, &fdf, work);
    if (status != GSL_SUCCESS || !(gsl_blas_dnrm2(gsl_multifit_nlinear_residual(work)) < NO_VALUE))
        outcome = OUTCOME_NO_VALUE;
    for (int i = 0; i < max && status == GSL_SUCCESS && outcome == OUTCOME_DONE; i++) {
        if (cancelled(p->cancel)) {
            outcome = OUTCOME_CANCELLED;
            break;
        }
        /* GSL_ENOPROG: the minimum to the last digit, or stuck */
        status = gsl_multifit_nlinear_iterate(work);
        ++*iterations;
        if (status == GSL_SUCCESS && settled(work, p))
            break;
    }
    if (outcome == OUTCOME_DONE)
        for (size_t j = 0; j < count; j++)
            u[j] = gsl_vector_get(gsl_multifit_nlinear_position(work), j);
    gsl_multifit_nlinear_free(work);
    return outcome;
}

/*
 * Close to the minimum the sum of squares does not change in its last digit any more and can lead
 * nowhere; full Gauss-Newton steps still can, as long as they shrink. False: no memory.
 */
static bool polish(struct problem *p, double *x, struct curve_fit *fit)
{
    enum { STEPS = 60 };
    int count = p->curve->parameters;
    if (!judge(p, x, false, fit))
        return false;
    double length = p->length, floor = fit->rss * (1 + 1e-12) + p->size * p->size * 1e-31;
    const double min = p->costly ? LENGTH_COSTLY : LENGTH_EXACT;
    for (int k = 0; k < STEPS && fit->small_gradient && length > min && !cancelled(p->cancel);
         k++) {
        double trial[CURVE_PARAMETERS];
        bool allowed = true;
        for (int j = 0; j < count; j++) {
            trial[j] = x[j] + p->step[j];
            allowed =
                allowed && !(p->low && trial[j] < p->low[j]) && !(p->high && trial[j] > p->high[j]);
        }
        if (allowed && !judge(p, trial, false, fit))
            return false;
        if (!allowed || !(p->length < 0.9 * length && fit->rss <= floor))
            break;
        length = p->length;
        memcpy(x, trial, (size_t)count * sizeof *x);
    }
    return judge(p, x, true, fit);
}

/*
 * Of very many samples, from a start that fits a part of them: Gauss-Newton steps, halved where
 * they lead upwards. No matrix with a row for each sample but the derivatives themselves.
 */
static enum outcome descend_long(struct problem *p, double *x, int max, int *iterations,
                                 struct curve_fit *fit)
{
    enum { HALVINGS = 12 };
    const int count = p->curve->parameters;
    if (!judge(p, x, false, fit))
        return OUTCOME_MEMORY;
    if (!isfinite(fit->rss))
        return OUTCOME_NO_VALUE;
    for (int k = 0; k < max && !fit->converged && p->length > 1e-12; k++) {
        double trial[CURVE_PARAMETERS], step[CURVE_PARAMETERS], part = 1;
        const double before = fit->rss * (1 + 1e-12);
        memcpy(step, p->step, sizeof step);
        for (int halving = 0;; halving++, part /= 2) {
            if (cancelled(p->cancel))
                return OUTCOME_CANCELLED;
            for (int j = 0; j < count; j++) {
                trial[j] = x[j] + part * step[j];
                trial[j] = p->low ? fmax(trial[j], p->low[j]) : trial[j];
                trial[j] = p->high ? fmin(trial[j], p->high[j]) : trial[j];
            }
            if (!judge(p, trial, false, fit))
                return OUTCOME_MEMORY;
            if (fit->rss <= before)
                break;
            if (halving == HALVINGS)
                return judge(p, x, false, fit) ? OUTCOME_DONE : OUTCOME_MEMORY;
        }
        memcpy(x, trial, (size_t)count * sizeof *x);
        ++*iterations;
    }
    return OUTCOME_DONE;
}

/* Plain, then accelerated where that did not arrive: the better of the two. */
static enum outcome minimise(struct problem *p, double *x, int max, int *iterations,
                             struct curve_fit *fit)
{
    struct curve_fit best = {.converged = false};
    double start[CURVE_PARAMETERS], slope;
    size_t bytes = (size_t)p->curve->parameters * sizeof *x;
    if (p->n > MANY) {
        const enum outcome outcome = descend_long(p, x, max, iterations, fit);
        return outcome == OUTCOME_DONE && !p->rough && !judge(p, x, true, fit) ? OUTCOME_MEMORY
                                                                               : outcome;
    }
    memcpy(start, x, bytes);
    for (int accelerate = 0; accelerate < (p->rough ? 1 : 2) && !best.converged; accelerate++) {
        double u[CURVE_PARAMETERS];
        for (int j = 0; j < p->curve->parameters; j++)
            u[j] = outside(p, j, start[j]);
        enum outcome outcome = descend(p, u, accelerate, max, iterations);
        if (outcome != OUTCOME_DONE)
            return outcome;
        for (int j = 0; j < p->curve->parameters; j++)
            u[j] = inside(p, j, u[j], &slope);
        if (!judge(p, u, !p->rough, fit))
            return OUTCOME_MEMORY;
        if (accelerate == 0 || fit->converged || !(fit->rss >= best.rss)) {
            best = *fit;
            memcpy(x, u, bytes);
        }
    }
    return p->rough || polish(p, x, fit) ? OUTCOME_DONE : OUTCOME_MEMORY;
}

/* Robust standard deviation of the residuals [from, to) about `middle`. */
static double robust_scale(struct problem *p, const double *residual, double middle, size_t from,
                           size_t to)
{
    for (size_t i = from; i < to; i++)
        p->scratch[i] = fabs(residual[i] - middle);
    return MAD_TO_SIGMA * quantile(p->scratch + from, to - from, 0.5);
}

/* Weights of the residuals in robust standard deviations. Returns the largest change; INFINITY:
 * stopped. */
static double set_weights(struct problem *p, const double *residual, bool soft)
{
    const size_t stretches = p->stretch > 0 && p->n >= 2 * p->stretch ? p->n / p->stretch : 1;
    for (size_t i = 0; i < p->n; i++)
        p->scratch[i] = residual[i];
    double middle = quantile(p->scratch, p->n, 0.5), change = 0;
    if (cancelled(p->cancel))
        return INFINITY;
    p->scale =
        fmax(robust_scale(p, residual, middle, 0, p->n), 4e-16 * p->size / sqrt((double)p->n));
    for (size_t k = 0; k < stretches && !cancelled(p->cancel); k++) {
        const size_t from = p->n * k / stretches, to = p->n * (k + 1) / stretches;
        const double local = stretches > 1 ? robust_scale(p, residual, middle, from, to) : 0;
        const double width = fmax(p->scale, local) * (soft ? SOFT_L1 : BISQUARE);
        for (size_t i = from; i < to; i++) {
            double z = residual[i] / width;
            double left = 1 - z * z, weight = soft       ? 1 / sqrt(1 + z * z)
                                              : left > 0 ? left * left
                                                         : 0;
            change = fmax(change, fabs(weight - p->weight[i]));
            p->weight[i] = weight;
        }
    }
    return cancelled(p->cancel) ? INFINITY : change;
}

/* A few steps towards the minimum, which is not asked for: the weights are about to change. */
static enum outcome come_nearer(struct problem *p, double *x, int max, int *iterations,
                                struct curve_fit *fit)
{
    enum { STEPS = 3 };
    double u[CURVE_PARAMETERS], slope;
    if (p->n > MANY)
        return descend_long(p, x, 1, iterations, fit);
    for (int j = 0; j < p->curve->parameters; j++)
        u[j] = outside(p, j, x[j]);
    enum outcome outcome = descend(p, u, false, max < STEPS ? max : STEPS, iterations);
    for (int j = 0; j < p->curve->parameters && outcome == OUTCOME_DONE; j++)
        x[j] = inside(p, j, u[j], &slope);
    return outcome == OUTCOME_DONE && !judge(p, x, false, fit) ? OUTCOME_MEMORY : outcome;
}

/*
 * Weights and steps by turns on the tangent of the curve at the last judged point, `left` [n] being
 * what its residuals become; round: counted on. False: no memory.
 */
static bool settle_on_tangent(struct problem *p, const struct curve_fit *fit, double *left,
                              double *step, int *round)
{
    const size_t count = (size_t)fit->parameters;
    memcpy(left, fit->residual, p->n * sizeof *left);
    memset(step, 0, count * sizeof *step);
    for (; *round < ROBUST_ROUNDS; ++*round) {
        const bool soft = *round < SOFT_ROUNDS;
        if (set_weights(p, left, soft) < WEIGHTS_STAY && !soft)
            break;
        if (cancelled(p->cancel) || !tangent_step(p, fit, fit->residual, step))
            return false;
        for (size_t i = 0; i < p->n && !cancelled_at(p->cancel, i); i++) {
            left[i] = fit->residual[i];
            for (size_t j = 0; j < count; j++)
                left[i] -= p->derivative[i * count + j] * step[j];
        }
    }
    return true;
}

/*
 * The robust rounds of a curve that is costly: it is evaluated only where the weights have settled
 * on its tangent. Stops where the curve leaves that tangent; x is then the best point, and judged.
 * soft: the soft rounds are done.
 */
static enum outcome approach_on_tangent(struct problem *p, double *x, bool *soft, int *iterations,
                                        struct curve_fit *fit)
{
    enum { TURNS = 8 };
    const size_t count = (size_t)p->curve->parameters;
    int round = *soft ? SOFT_ROUNDS : 0;
    for (int turn = 0; turn < TURNS && !cancelled(p->cancel); turn++) {
        double step[CURVE_PARAMETERS], trial[CURVE_PARAMETERS], *left = p->value, expected = 0;
        const int before = round;
        if (!settle_on_tangent(p, fit, left, step, &round))
            return OUTCOME_MEMORY;
        if (round == before) /* the weights stay at once */
            break;
        for (size_t i = 0; i < p->n; i++)
            expected += p->weight[i] * left[i] * left[i];
        for (size_t j = 0; j < count; j++) {
            trial[j] = x[j] + step[j];
            trial[j] = p->low ? fmax(trial[j], p->low[j]) : trial[j];
            trial[j] = p->high ? fmin(trial[j], p->high[j]) : trial[j];
        }
        if (!judge(p, trial, false, fit))
            return OUTCOME_MEMORY;
        if (!(fit->rss <= 1.1 * expected))
            return judge(p, x, false, fit) ? OUTCOME_DONE : OUTCOME_MEMORY;
        memcpy(x, trial, count * sizeof *x);
        ++*iterations;
        *soft = true;
    }
    return OUTCOME_DONE;
}

static enum outcome minimise_robust(struct problem *p, double *x, int max, struct curve_fit *fit)
{
    int iterations = 0;
    /* then it starts from a robust fit already: nothing soft is needed */
    const bool is_long = p->n > MANY;
    const bool wanted = p->rough;
    p->rough = true; /* until the weights stay */
    enum outcome outcome =
        is_long ? come_nearer(p, x, max, &iterations, fit) : minimise(p, x, max, &iterations, fit);
    bool settles = false, soft = is_long; /* the soft rounds are done */
    if (p->costly && outcome == OUTCOME_DONE)
        outcome = approach_on_tangent(p, x, &soft, &iterations, fit);
    for (int round = soft ? SOFT_ROUNDS : 0;
         round < ROBUST_ROUNDS && outcome == OUTCOME_DONE && !settles; round++) {
        settles = set_weights(p, fit->residual, round < SOFT_ROUNDS) < WEIGHTS_STAY &&
                  round >= SOFT_ROUNDS;
        if (!settles)
            outcome = come_nearer(p, x, max, &iterations, fit);
    }
    p->rough = wanted;
    if (outcome == OUTCOME_DONE)
        outcome = minimise(p, x, max, &iterations, fit);
    fit->iterations = iterations;
    fit->converged = fit->converged && settles;
    return outcome;
}

static bool fail(enum outcome outcome, const struct fit_curve *curve, const double *start,
                 struct error *error)
{
    if (outcome == OUTCOME_CANCELLED)
        return error_set(error, ERROR_CANCELLED, "the fit was stopped");
    if (outcome == OUTCOME_MEMORY)
        return error_memory(error);
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

/* work: what only the iteration needs; of 2e6 samples that is much, and a formula is fitted from
 * many starts. */
static bool prepare(struct problem *p, const struct series *series, const double *start,
                    struct arena *arena, struct arena *work)
{
    size_t n = series->n, count = (size_t)p->curve->parameters;
    p->t = series->t;
    p->y = series->y;
    p->n = n;
    p->value = arena_array(work, n, sizeof(double));
    p->scratch = arena_array(work, n, sizeof(double));
    p->weight = arena_array(arena, n, sizeof(double));
    p->derivative = arena_array(work, n * count, sizeof(double));
    if (!p->value || !p->scratch || !p->weight || !p->derivative)
        return false;
    for (size_t i = 0; i < n; i++) {
        if (i % LOOK_EACH_ROWS == 0 && cancelled(p->cancel))
            return false;
        p->weight[i] = 1;
        p->size = hypot(p->size, series->y[i]);
    }
    for (size_t j = 0; j < count; j++) {
        double bound = p->low && isfinite(p->low[j])     ? p->low[j]
                       : p->high && isfinite(p->high[j]) ? p->high[j]
                                                         : 0;
        p->unit[j] = fmax(fabs(start[j] - bound), 1e-3 * fabs(bound));
        p->unit[j] = p->unit[j] > 0 ? p->unit[j] : 1;
    }
    return true;
}

/*
 * Of very many samples the start comes from a fit of every so manieth. False: an error that ends
 * everything; a part that has no answer leaves the start as it was.
 */
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

static bool fit_within(const struct fit_curve *curve, const struct series *series,
                       const double *start, const struct curve_options *o, struct arena *arena,
                       struct arena *work, struct curve_fit *fit, struct error *error)
{
    struct problem p = {.curve = curve,
                        .low = o->low,
                        .high = o->high,
                        .robust = o->robust,
                        .rough = o->rough,
                        .costly = o->costly,
                        .stretch = o->stretch,
                        .cancel = o->cancel};
    double x[CURVE_PARAMETERS];
    int count = curve->parameters, max = o->iterations > 0 ? o->iterations : ITERATIONS,
        iterations = 0;
    *fit = (struct curve_fit){.parameters = count};
    if (!enough_samples(series, count, error))
        return false;
    memcpy(x, start, (size_t)count * sizeof *x);
    if (series->n > MANY && !improve_by_part(curve, series, x, o, error))
        return false;
    fit->residual = arena_array(arena, series->n, sizeof(double));
    if (!fit->residual || !prepare(&p, series, start, arena, work))
        return cancelled(o->cancel) ? error_set(error, ERROR_CANCELLED, "stopped")
                                    : error_memory(error);
    fit->weight = p.weight;
    enum outcome outcome =
        o->robust ? minimise_robust(&p, x, max, fit) : minimise(&p, x, max, &iterations, fit);
    if (outcome != OUTCOME_DONE)
        return fail(cancelled(o->cancel) ? OUTCOME_CANCELLED : outcome, curve, start, error);
    fit->iterations += iterations;
    conclude(&p, fit);
    return o->bootstrap <= 0 || !fit->converged || bootstrap(&p, series, o, arena, fit, error);
}

bool curve_fit(const struct fit_curve *curve, const struct series *series, const double *start,
               const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
               struct error *error)
{
    static const struct curve_options none;
    struct arena work = {0};
    const bool ok =
        fit_within(curve, series, start, options ? options : &none, arena, &work, fit, error);
    arena_reset(&work);
    return ok;
}
