/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Which drag makes the oscillation die out: the equation of motion under each law, integrated (equation.c) and fitted to
 * all samples; the averaged envelope is only where the search begins.
 */
#include "internal.h"

#include <stdio.h>
#include <string.h>

enum { START, SPEED, OMEGA, OFFSET, FIRST_RATE, WINDOWS_LEAST = 8, WINDOWS_MOST = 256 };

enum { ITERATIONS = 60 };

#define SETTLED 1e-6 /* of the variance: what a further step would gain */
#define SMALL 1e-4   /* damping of a step that counts as a full one */
#define INTEGRATED 1e-16 /* mean square, relative, to which integration is good: no law is better than that */

struct drag_curve {
    enum drag_law law;
    struct equation motion;
    double *slope; /* [n][EQUATION_PARAMETERS] */
    double omega;  /* of the start: what is far from it is no answer */
};

/* Places of the fit's parameters among the equation's; their number. */
static int places(enum drag_law law, int place[EQUATION_PARAMETERS])
{
    int count = FIRST_RATE;
    place[START] = EQUATION_START;
    place[SPEED] = EQUATION_SPEED;
    place[OMEGA] = EQUATION_OMEGA;
    place[OFFSET] = EQUATION_OFFSET;
    for (int k = 0; k < DRAG_RATES; k++)
        if (law >> k & 1)
            place[count++] = EQUATION_RATE + k;
    return count;
}

static bool evaluate(void *context, const double *x, const double *t, size_t n, double *value, double *derivative)
{
    struct drag_curve *o = context;
    int place[EQUATION_PARAMETERS];
    const int count = places(o->law, place);
    if (!(fabs(x[OMEGA] - o->omega) < 0.5 * o->omega))
        return false;
    for (int j = 0; j < count; j++)
        o->motion.value[place[j]] = x[j];
    if (!equation_solve(&o->motion, t, n, value, derivative ? o->slope : NULL))
        return false;
    for (size_t i = 0; i < n && derivative; i++)
        for (int j = 0; j < count; j++)
            derivative[i * (size_t)count + (size_t)j] = o->slope[i * EQUATION_PARAMETERS + (size_t)place[j]];
    return true;
}

/* ---- uncertainties ---- */

/* The frequency of the damped oscillation. */
static double damped(double omega, double gamma)
{
    return sqrt(fmax(omega * omega - 0.25 * gamma * gamma, 0));
}

/*
 * By how much slow changes of the amplitude (sway) make the variance of rates larger than independent residuals would:
 * the residuals' part in phase with the oscillation, window by window of two periods, against their own size, with its
 * correlation from window to window.
 */
static double amplitude_factor(const struct series *x, double t0, const struct curve_fit *f)
{
    double omega = f->value[OMEGA].value, p = f->value[START].value, q = f->value[SPEED].value / omega, a = hypot(p, q);
    double span = x->t[x->n - 1] - x->t[0], product = 0, square = 0, expected = 0, before = 0;
    double windows = 0;
    size_t count = (size_t)fmin(WINDOWS_MOST, 0.25 * omega * span / PI), i = 0;
    for (size_t k = 0; k < count; k++) {
        double end = x->t[0] + span * (double)(k + 1) / (double)count, in_phase = 0, norm = 0;
        for (; i < x->n && (x->t[i] <= end || k + 1 == count); i++) {
            double s = x->t[i] - t0, u = (p * cos(omega * s) + q * sin(omega * s)) / a;
            in_phase += u * f->residual[i];
            norm += u * u;
        }
        if (!(norm > 0))
            continue;
        in_phase /= sqrt(norm);
        square += in_phase * in_phase;
        product += in_phase * before;
        expected += f->sigma * f->sigma;
        before = in_phase;
        windows++;
    }
    if (windows < WINDOWS_LEAST || !(expected > 0))
        return autocorrelation_factor(f->autocorrelation);
    double left = windows / fmax(windows - 3, 1); /* up to three parameters of the envelope are fitted */
    return fmax(1, square / expected * left * autocorrelation_factor(product / square));
}

/* The samples that take part, without the drift of the offset. */
static bool used_samples(const struct samples *x, double drift, struct arena *arena, struct series *used)
{
    double *t = arena_array(arena, x->n, sizeof *t), *y = arena_array(arena, x->n, sizeof *y);
    *used = (struct series){.t = t, .y = y};
    for (size_t i = 0; i < x->n && t && y; i++) {
        if (x->use[i]) {
            t[used->n] = x->uniform ? x->t0 + (double)i * x->dt : x->t[i];
            y[used->n] = x->y[i] - drift * (t[used->n] - x->t0);
            used->n++;
        }
    }
    return t && y;
}

/* ---- the fits ---- */

struct fitting {
    struct series used;
    double *slope, *derivative; /* [used.n][EQUATION_PARAMETERS] */
    double *fitted;             /* [used.n] */
    double rounding;            /* [y^2] of a sum of squares */
    int order;
    double t0, start[EQUATION_PARAMETERS]; /* of the linear law */
    struct curve_fit fit[DRAG_LAWS];
    struct arena *arena;
    const struct cancel *cancel;
};

/* Sum of squares at x; normal equations unless NULL. NAN: no value there. */
static double squares(const struct fitting *f, const struct fit_curve *curve, const double *x, double *derivative,
                      double normal[EQUATION_PARAMETERS][EQUATION_PARAMETERS + 1])
{
    const int count = curve->parameters;
    double sum = 0;
    if (!curve->evaluate(curve->context, x, f->used.t, f->used.n, f->fitted, derivative))
        return NAN;
    for (int j = 0; j < count; j++)
        memset(normal[j], 0, sizeof normal[j]);
    for (size_t i = 0; i < f->used.n; i++) {
        const double r = f->used.y[i] - f->fitted[i], *d = derivative + i * (size_t)count;
        sum += r * r;
        for (int j = 0; j < count; j++) {
            for (int k = 0; k <= j; k++)
                normal[j][k] += d[j] * d[k];
            normal[j][EQUATION_PARAMETERS] += d[j] * r;
        }
    }
    return sum;
}

/* (A + lambda diag A) step = b by Cholesky's method; false: not positive. */
static bool damped_step(int n, double normal[EQUATION_PARAMETERS][EQUATION_PARAMETERS + 1], double lambda, double *step)
{
    double l[EQUATION_PARAMETERS][EQUATION_PARAMETERS];
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= i; j++) {
            const double scale = sqrt(normal[i][i] * normal[j][j]);
            double sum = scale > 0 ? normal[i][j] / scale : 0;
            sum += i == j ? lambda : 0;
            for (int k = 0; k < j; k++)
                sum -= l[i][k] * l[j][k];
            if (i == j && !(sum > 0))
                return false;
            l[i][j] = i == j ? sqrt(sum) : sum / l[j][j];
        }
    for (int i = 0; i < n; i++) {
        step[i] = normal[i][EQUATION_PARAMETERS] / sqrt(normal[i][i]);
        for (int k = 0; k < i; k++)
            step[i] -= l[i][k] * step[k];
        step[i] /= l[i][i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            step[i] -= l[k][i] * step[k];
        step[i] /= l[i][i];
    }
    for (int i = 0; i < n; i++)
        step[i] /= sqrt(normal[i][i]);
    return true;
}

/* x becomes the minimum (Marquardt 1963), *best its sum of squares. False: it has not arrived. */
static bool descend(const struct fitting *f, const struct fit_curve *curve, double *x, double *best,
                    double normal[EQUATION_PARAMETERS][EQUATION_PARAMETERS + 1])
{
    double next[EQUATION_PARAMETERS][EQUATION_PARAMETERS + 1], trial[EQUATION_PARAMETERS], step[EQUATION_PARAMETERS];
    double lambda = 1e-3;
    *best = squares(f, curve, x, f->derivative, normal);
    for (int i = 0; i < ITERATIONS && isfinite(*best) && !cancelled(f->cancel); i++) {
        double decrement = 0;
        if (!damped_step(curve->parameters, normal, lambda, step))
            return false;
        for (int j = 0; j < curve->parameters; j++) {
            trial[j] = x[j] + step[j];
            decrement += step[j] * normal[j][EQUATION_PARAMETERS];
        }
        const bool there = lambda < SMALL && decrement < fmax(SETTLED * *best / (double)f->used.n, f->rounding);
        const double sum = squares(f, curve, trial, f->derivative, next);
        if (sum <= *best) {
            memcpy(x, trial, sizeof trial);
            memcpy(normal, next, sizeof next);
            *best = sum;
            lambda *= 0.01;
        } else {
            lambda = fmax(lambda * 10, 1e-6);
        }
        if (there)
            return true;
    }
    return false;
}

/* The values with what they are worth. False: the parameters are not determined. */
static bool judge(const struct fitting *f, int count, double normal[EQUATION_PARAMETERS][EQUATION_PARAMETERS + 1],
                  struct curve_fit *fit)
{
    const struct series *used = &f->used;
    double inverse[EQUATION_PARAMETERS][EQUATION_PARAMETERS], product = 0;
    for (int j = 0; j < count; j++) {
        for (int i = 0; i < count; i++)
            normal[i][EQUATION_PARAMETERS] = i == j;
        if (!damped_step(count, normal, 0, inverse[j]))
            return false;
    }
    for (size_t i = 1; i < used->n; i++)
        product += fit->residual[i] * fit->residual[i - 1];
    fit->autocorrelation = fit->rss > 0 ? product / fit->rss : 0;
    fit->sigma = sqrt(fit->rss / (double)(used->n - (size_t)count));
    const double widen = sqrt(autocorrelation_factor(fit->autocorrelation));
    for (int j = 0; j < count; j++) {
        fit->formal[j] = fit->sigma * sqrt(fmax(inverse[j][j], 0));
        fit->value[j].uncertainty = fit->formal[j] * widen;
    }
    return true;
}

static bool fit_from(struct fitting *f, enum drag_law law, const double *values, struct curve_fit *fit,
                     struct error *error)
{
    struct drag_curve o = {.law = law,
                           .motion = {.t0 = f->t0, .order = f->order},
                           .slope = f->slope,
                           .omega = f->start[EQUATION_OMEGA]};
    int place[EQUATION_PARAMETERS];
    const struct fit_curve curve = {.parameters = places(law, place), .context = &o, .evaluate = evaluate};
    double x[EQUATION_PARAMETERS] = {0}, normal[EQUATION_PARAMETERS][EQUATION_PARAMETERS + 1] = {{0}};
    for (int j = 0; j < curve.parameters; j++)
        x[j] = values[place[j]];
    *fit = (struct curve_fit){.parameters = curve.parameters, .used = f->used.n, .rss = HUGE_VAL};
    fit->residual = arena_array(f->arena, f->used.n, sizeof *fit->residual);
    if (!fit->residual)
        return error_memory(error);
    fit->converged = descend(f, &curve, x, &fit->rss, normal);
    if (cancelled(f->cancel))
        return error_set(error, ERROR_CANCELLED, "the fit was stopped");
    for (int j = 0; j < curve.parameters; j++)
        fit->value[j].value = x[j];
    if (!evaluate(&o, x, f->used.t, f->used.n, f->fitted, NULL)) {
        fit->converged = false;
        fit->rss = HUGE_VAL;
        return true;
    }
    for (size_t i = 0; i < f->used.n; i++)
        fit->residual[i] = f->used.y[i] - f->fitted[i];
    fit->converged = judge(f, curve.parameters, normal, fit) && fit->converged;
    return true;
}

/* What a fit found, as values of the equation. */
static void values_of(const struct curve_fit *fit, enum drag_law law, double *values)
{
    int place[EQUATION_PARAMETERS];
    const int count = places(law, place);
    memset(values, 0, EQUATION_PARAMETERS * sizeof *values);
    for (int j = 0; j < count; j++)
        values[place[j]] = fit->value[j].value;
}

/* The law alone from the rates of the envelope; a sum from the best of what it contains, its further term at 0. */
static bool fit_law(struct fitting *f, int i, const double rate[DRAG_RATES], struct error *error)
{
    const enum drag_law law = (enum drag_law)(i + 1);
    double values[EQUATION_PARAMETERS];
    int part = -1;
    for (int j = 0; j < i; j++)
        if (((j + 1) & (i + 1)) == j + 1 && isfinite(f->fit[j].rss) && (part < 0 || f->fit[j].rss < f->fit[part].rss))
            part = j;
    if (part >= 0) {
        values_of(&f->fit[part], (enum drag_law)(part + 1), values);
    } else {
        memcpy(values, f->start, sizeof values);
        for (int k = 0; k < DRAG_RATES; k++)
            values[EQUATION_RATE + k] = law >> k & 1 ? rate[k] : 0;
    }
    return fit_from(f, law, values, &f->fit[i], error);
}

/* Energy per mass that a rate of 1 takes along the motion: the sums of v^2, |v|^3 and |v|. */
static void losses(struct fitting *f, int i, double loss[DRAG_RATES])
{
    struct equation motion = {.t0 = f->t0, .order = 1};
    double *v = f->slope;
    values_of(&f->fit[i], (enum drag_law)(i + 1), motion.value);
    motion.value[EQUATION_OFFSET] = 0;
    loss[0] = loss[1] = loss[2] = 0;
    if (!equation_solve(&motion, f->used.t, f->used.n, v, NULL))
        return;
    for (size_t k = 0; k < f->used.n; k++) {
        loss[0] += v[k] * v[k];
        loss[1] += fabs(v[k]) * v[k] * v[k];
        loss[2] += fabs(v[k]);
    }
}

/* ---- the report ---- */

static void describe(const struct curve_fit *f, int i, double factor, struct drag_candidate *out)
{
    int place[EQUATION_PARAMETERS];
    const int count = places((enum drag_law)(i + 1), place);
    *out = (struct drag_candidate){.law = (enum drag_law)(i + 1), .converged = f->converged};
    out->rms = sqrt(f->rss / (double)f->used);
    for (int j = FIRST_RATE; j < count; j++)
        out->rate[place[j] - EQUATION_RATE] = (struct measured){f->value[j].value, f->formal[j] * sqrt(factor)};
}

/* The values of a fit that has one law, with the names of the damped sine. */
static void report(const struct fitting *f, int i, double factor, struct fit *out)
{
    const struct curve_fit *fit = &f->fit[i];
    struct drag_fit *drag = &out->drag;
    struct equation *motion = &drag->motion;
    *motion = (struct equation){.t0 = f->t0, .order = f->order};
    values_of(fit, (enum drag_law)(i + 1), motion->value);
    const double widen = sqrt(factor), y = motion->value[EQUATION_START], v = motion->value[EQUATION_SPEED];
    const double gamma = motion->value[EQUATION_RATE], omega = damped(motion->value[EQUATION_OMEGA], gamma);
    /* y = A exp(-gamma s/2) cos(omega s + phi), and how each derivative is larger and earlier */
    const double sine = (v + 0.5 * gamma * y) / omega, a = hypot(y, sine);
    const double grow = pow(hypot(0.5 * gamma, omega), f->order), turn = f->order * atan2(omega, -0.5 * gamma);
    drag->start = (struct measured){y, fit->formal[START] * widen};
    drag->speed = (struct measured){v, fit->formal[SPEED] * widen};
    const double along = hypot(y * drag->start.uncertainty, sine * drag->speed.uncertainty / omega) / a;
    const double across = hypot(sine * drag->start.uncertainty, y * drag->speed.uncertainty / omega) / a;
    out->amplitude = (struct measured){a * grow, along * grow};
    out->phase = (struct measured){remainder(atan2(-sine, y) + turn, TWO_PI), across / a};
    out->offset = (struct measured){fit->value[OFFSET].value, fit->value[OFFSET].uncertainty};
    out->omega = (struct measured){omega, fmax(fit->value[OMEGA].uncertainty, out->omega.uncertainty)};
    out->period.value = TWO_PI / omega;
    out->period.uncertainty = out->period.value * out->omega.uncertainty / omega;
    out->gamma = drag->candidate[i].rate[0];
    out->rms = drag->candidate[i].rms;
    out->used = fit->used;
    out->autocorrelation = fit->autocorrelation;
}

/* Where the search begins: the damped sine at t0, as a position. */
static void begin(const struct motion *m, struct fitting *f)
{
    const struct harmonic *h = &m->harmonic;
    const double back = f->t0 - h->origin, e = exp(-0.5 * h->gamma * back);
    const double c = e * cos(h->omega * back), s = e * sin(h->omega * back);
    double p = h->a * c + h->b * s, q = h->b * c - h->a * s;
    const double damping = -0.5 * h->gamma, square = h->omega * h->omega + damping * damping;
    for (int k = 0; k < f->order; k++) { /* integrate exp(damping s) (p cos + q sin) */
        const double was = p;
        p = (damping * was - h->omega * q) / square;
        q = (damping * q + h->omega * was) / square;
    }
    f->start[EQUATION_START] = p;
    f->start[EQUATION_SPEED] = damping * p + h->omega * q;
    f->start[EQUATION_OMEGA] = sqrt(square);
    f->start[EQUATION_OFFSET] = h->c + h->d * back;
}

bool drag_laws(const struct motion *m, enum quantity quantity, const struct envelope_rates rates[3],
               struct arena *arena, const struct cancel *cancel, struct fit *out, struct error *error)
{
    struct fitting f = {.t0 = m->samples.t0, .arena = arena, .cancel = cancel};
    f.order = quantity == QUANTITY_VELOCITY ? 1 : quantity == QUANTITY_ACCELERATION ? 2 : 0;
    if (!used_samples(&m->samples, m->harmonic.d, arena, &f.used) ||
        !(f.slope = arena_array(arena, f.used.n * EQUATION_PARAMETERS, sizeof *f.slope)) ||
        !(f.derivative = arena_array(arena, f.used.n * EQUATION_PARAMETERS, sizeof *f.slope)) ||
        !(f.fitted = arena_array(arena, f.used.n, sizeof *f.fitted)))
        return error_memory(error);
    begin(m, &f);
    const double omega = f.start[EQUATION_OMEGA], a = hypot(f.start[EQUATION_START], f.start[EQUATION_SPEED] / omega);
    const double span = f.used.t[f.used.n - 1] - f.t0, gamma = fmax(rates[0].gamma, 1e-6 * omega);
    /* A' = -(gamma/2) A - (4 b omega/(3 pi)) A^2 - 2 f/(pi omega): Nayfeh & Mook 1979, 3.3 */
    const double mean = a * -expm1(-0.5 * gamma * span) / (0.5 * gamma * span);
    const double rate[DRAG_RATES] = {gamma, fmax(rates[1].q, 1e-6 * omega) * 3 * PI / (4 * omega * a),
                                     0.25 * PI * omega * gamma * mean};
    const double size = a * pow(omega, f.order);
    f.rounding = INTEGRATED * size * size;
    for (int i = 0; i < DRAG_LAWS; i++)
        if (!fit_law(&f, i, rate, error))
            return false;
    int widest = 0;
    for (int i = 0; i < DRAG_LAWS; i++)
        if (f.fit[i].converged && (!f.fit[widest].converged || f.fit[i].rss < f.fit[widest].rss))
            widest = i;
    if (!f.fit[widest].converged)
        return error_set(error, ERROR_NUMERICAL, "the fit of drag did not converge in %d iterations", ITERATIONS);
    const double factor = amplitude_factor(&f.used, f.t0, &f.fit[widest]);
    struct law_evidence evidence = {.fit = f.fit};
    evidence.variance = factor * fmax(f.fit[widest].sigma * f.fit[widest].sigma, INTEGRATED * size * size);
    struct drag_fit *drag = &out->drag;
    *drag = (struct drag_fit){.candidates = DRAG_LAWS, .independent = fmax((double)f.used.n / factor, 2)};
    for (int i = 0; i < DRAG_LAWS; i++) {
        describe(&f.fit[i], i, factor, &drag->candidate[i]);
        drag->candidate[i].bic = (f.fit[i].parameters - FIRST_RATE) * log(drag->independent) +
                                 (f.fit[i].rss - f.fit[widest].rss) / evidence.variance;
    }
    losses(&f, widest, evidence.loss);
    const int best = law_choose(&evidence, out);
    for (int i = 0; i < 3; i++)
        out->evidence[i] = drag->candidate[i].bic;
    report(&f, best, factor, out);
    return true;
}
