/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Turns the fits of laws into results: factors of uncertainties, energy losses, and the values
 * under the names of the damped sine. */
#include <hooke/base/cancel.h>
#include "modules/recording/law/drag.h"

/* Largest number of windows for slow changes. */
enum { WINDOWS_MAX = 256 };

/* Returns the frequency of the damped oscillation. */
static double damped_frequency(double omega, double gamma)
{
    return sqrt(fmax(omega * omega - 0.25 * gamma * gamma, 0));
}

/* ---- uncertainties ---- */

/* Sums over windows of the residuals' component in one direction (in phase or in quadrature). */
struct windows {
    double square, product, expected, previous, count;
};

/* Adds a window: its sum of residual times direction, the squared norm of the direction, and the
 * variance expected of independent residuals. */
static void add_window(struct windows *w, double sum, double norm, double variance)
{
    const double z = sum / sqrt(norm);
    w->square += z * z;
    w->product += z * w->previous;
    w->expected += variance;
    w->previous = z;
    w->count++;
}

/* Returns the factor of the variance, including the correlation of neighbouring windows; from the
 * lag-1 autocorrelation if there are too few windows. */
static double factor_of(const struct windows *w, double lag)
{
    if (w->count < DRAG_WINDOWS_MIN || !(w->expected > 0))
        return autocorrelation_factor(lag);
    /* The envelope has up to three fitted parameters. */
    const double left = w->count / fmax(w->count - 3, 1);
    return fmax(1, w->square / w->expected * left * autocorrelation_factor(w->product / w->square));
}

/* Computes the factors by which slow changes of amplitude and phase (sway), which correlate the
 * residuals, increase the variances of rates (factors->amplitude) and of the frequency
 * (factors->phase). The residuals' components in phase with the motion and in quadrature (with its
 * velocity) are summed in windows of two periods; their scatter beyond that of independent
 * residuals gives the factors. Returns false if the motion cannot be computed or if cancelled. */
bool drag_factors(const struct drag_fitting *f, const struct law_fit *fit,
                  struct drag_factors *factors)
{
    const struct samples *x = &f->motion->samples;
    const double *residual = f->motion->residual;
    struct equation turned = fit->motion;
    turned.order = fit->motion.order == 0 ? 1 : fit->motion.order - 1;
    struct equation_walk in_phase, quadrature;
    struct windows w[2] = {{0}};
    const double span = x->t[x->n - 1] - x->t[0], n = (double)fit->used - fit->parameters;
    const size_t count =
        (size_t)fmin(WINDOWS_MAX, 0.5 * fit->motion.value[EQUATION_OMEGA] * span / TWO_PI);
    double product = 0, square = 0, previous = 0, energy = 0, largest = 0;
    *factors = (struct drag_factors){
        .sigma = sqrt(fit->rss / fmax(n - (double)f->samples.baseline.blocks, 1))};
    if (!equation_begin(&fit->motion, EQUATION_VALUES, &in_phase) ||
        !equation_begin(&turned, EQUATION_VALUES, &quadrature))
        return false;
    size_t i = 0;
    for (size_t k = 0; k < (count > 0 ? count : 1); k++) {
        const double end = x->t[0] + span * (double)(k + 1) / (double)count;
        double sum[2] = {0}, norm[2] = {0};
        for (; i < x->n && (x->t[i] <= end || k + 1 >= count); i++) {
            if (i % LOOK_EACH_ROWS == 0 && cancelled(x->cancel))
                return false;
            double u[2];
            const double t = x->uniform ? x->t0 + (double)i * x->dt : x->t[i];
            if (!f->use[i])
                continue;
            if (!equation_values(&in_phase, &t, 1, &u[0], NULL) ||
                !equation_values(&quadrature, &t, 1, &u[1], NULL))
                return false;
            for (int d = 0; d < 2; d++) {
                sum[d] += u[d] * residual[i];
                norm[d] += u[d] * u[d];
            }
            product += residual[i] * previous;
            square += residual[i] * residual[i];
            previous = residual[i];
            energy += u[0] * u[0];
        }
        largest = fmax(largest, norm[0]);
        for (int d = 0; d < 2; d++)
            if (norm[d] > 0 && norm[0] > 1e-3 * largest)
                add_window(&w[d], sum[d], norm[d], factors->sigma * factors->sigma);
    }
    factors->lag = square > 0 ? product / square : 0;
    factors->amplitude = factor_of(&w[0], factors->lag);
    factors->phase = factor_of(&w[1], factors->lag);
    factors->windows = w[0].count;
    factors->signal = sqrt(energy / (double)fit->used);
    return true;
}

/* Sums v^2, |v|^3 and |v| over points of the motion in loss[]: the energy that each rate would
 * dissipate. */
void drag_losses(const struct drag_fitting *f, const struct law_fit *fit, double loss[DRAG_RATES])
{
    enum { POINTS = 4096 };
    const struct samples *x = &f->motion->samples;
    struct equation motion = fit->motion;
    struct equation_walk walk;
    motion.order = 1;
    loss[0] = loss[1] = loss[2] = 0;
    if (!equation_begin(&motion, EQUATION_VALUES, &walk))
        return;
    for (size_t k = 0; k < POINTS;
         k++) { /* spread evenly: the golden ratio keeps them off the period */
        const double t = f->t0 + (x->t[x->n - 1] - f->t0) *
                                     ((double)k + fmod(0.6180339887 * (double)k, 1)) / POINTS;
        double v;
        if (!equation_values(&walk, &t, 1, &v, NULL))
            return;
        loss[0] += v * v;
        loss[1] += fabs(v) * v * v;
        loss[2] += fabs(v);
    }
}

/* ---- the report ---- */

/* Copies the rates of the law with their uncertainties; a cubic term is not one of them. */
void drag_describe(const struct law_fit *fit, int i, double deviation,
                   struct drag_candidate *candidate)
{
    *candidate =
        (struct drag_candidate){.law = (enum drag_law)(i + 1), .converged = fit->converged};
    candidate->rms = sqrt(fit->rss / (double)fit->used);
    for (int j = FIRST_RATE; j < fit->parameters; j++) {
        const struct measured value = {fit->motion.value[fit->index[j]],
                                       deviation * law_formal(fit, j)};
        if (fit->index[j] < EQUATION_CUBIC)
            candidate->rate[fit->index[j] - EQUATION_RATE] = value;
    }
}

/* Sets offset at t0, drift and wandering of *result from the law's baseline. Returns false if out
 * of memory or if the motion cannot be computed. */
bool drag_report_offset(struct drag_fitting *f, const struct law_fit *fit,
                        const struct drag_factors *factors, struct arena *arena, struct fit *result)
{
    const struct samples *x = &f->motion->samples;
    const size_t blocks = f->samples.baseline.blocks;
    double *level = arena_array(arena, blocks, sizeof *level),
           *slope = arena_array(arena, blocks, sizeof *slope);
    double sum = 0, square = 0;
    if (!level || !slope || !law_residuals(&f->samples, fit, f->motion->residual, level, slope))
        return false;
    for (size_t k = 0; k < blocks; k++)
        sum += level[k];
    const double mean = sum / (double)blocks, middle = 0.5 * (x->t[0] + x->t[x->n - 1]);
    for (size_t k = 0; k < blocks; k++)
        square += (level[k] - mean) * (level[k] - mean);
    const double wander = blocks > 1 ? sqrt(square / (double)(blocks - 1)) : 0;
    const double still =
        factors->sigma * sqrt(autocorrelation_factor(factors->lag) / (double)fit->used);
    const bool line = blocks == 1 && f->samples.baseline.terms > 1;
    result->drift = (struct measured){line ? slope[0] : 0, 0};
    result->offset =
        (struct measured){mean - result->drift.value * (middle - f->t0), hypot(still, wander)};
    result->drag.wander = wander;
    return true;
}

/* Sets the covariances of all fitted parameters, with the standard deviations [parameters] that are
 * reported. */
static void covariances_fill(const struct law_fit *fit, const double *deviation,
                             struct fit_covariance *result)
{
    *result = (struct fit_covariance){.n = EQUATION_OFFSET};
    for (int i = 0; i < fit->parameters; i++)
        for (int j = 0; j < fit->parameters; j++)
            result->entry[fit->index[i]][fit->index[j]] =
                deviation[i] * deviation[j] * fit->inverse[i][j];
}

/* Converts state and rates of law i to amplitude, phase, frequency and covariances of *result,
 * whose uncertainties are widened by the factors. */
void drag_report(const struct drag_fitting *f, int i, const struct drag_factors *factors,
                 struct fit *result)
{
    const struct law_fit *fit = &f->fit[i];
    struct drag_fit *drag = &result->drag;
    const double widen = factors->sigma * sqrt(factors->amplitude),
                 phase_widening = factors->sigma * sqrt(factors->phase);
    const double y = fit->motion.value[EQUATION_START], v = fit->motion.value[EQUATION_SPEED];
    const double gamma = fit->motion.value[EQUATION_RATE],
                 omega = damped_frequency(fit->motion.value[EQUATION_OMEGA], gamma);
    const int order = fit->motion.order;
    /* y = A exp(-gamma s/2) cos(omega s + phi); derivatives are larger by `grow`, ahead by `turn`
     */
    const double sine = (v + 0.5 * gamma * y) / omega, a = hypot(y, sine);
    const double grow = pow(hypot(0.5 * gamma, omega), order),
                 turn = order * atan2(omega, -0.5 * gamma);
    const double worse = fmax(widen, phase_widening);
    drag->start = (struct measured){y, law_formal(fit, START) * worse};
    drag->speed = (struct measured){v, law_formal(fit, SPEED) * worse};
    const double radial =
        hypot(y * drag->start.uncertainty, sine * drag->speed.uncertainty / omega) / a;
    const double turned =
        hypot(sine * drag->start.uncertainty, y * drag->speed.uncertainty / omega) / a;
    result->amplitude = (struct measured){a * grow, radial * grow};
    result->phase = (struct measured){remainder(atan2(-sine, y) + turn, TWO_PI), turned / a};
    result->omega = (struct measured){omega, law_formal(fit, OMEGA) * phase_widening};
    /* If the period drifts, its uncertainty is at least half the difference of the halves. */
    const struct measured *half = result->half_periods;
    const double drifts = fabs(half[0].value - half[1].value);
    if (fit->motion.force == RESTORING_LINEAR &&
        drifts > HALVES_DIFFER * hypot(half[0].uncertainty, half[1].uncertainty))
        result->omega.uncertainty =
            fmax(result->omega.uncertainty, 0.5 * drifts * omega * omega / TWO_PI);
    result->period.value = TWO_PI / omega;
    result->period.uncertainty = result->period.value * result->omega.uncertainty / omega;
    result->gamma = drag->candidate[i].rate[0];
    drag->force = fit->motion.force;
    if (fit->motion.force == RESTORING_CUBIC)
        drag->cubic = (struct measured){fit->motion.value[EQUATION_CUBIC],
                                        law_formal(fit, fit->parameters - 1) * worse};
    double deviation[LAW_PARAMETERS];
    for (int j = 0; j < fit->parameters; j++)
        deviation[j] = j > OMEGA && fit->index[j] < EQUATION_CUBIC ? widen : worse;
    deviation[OMEGA] = phase_widening;
    covariances_fill(fit, deviation, &result->covariance);
    fit_covariance_widen(&result->covariance, EQUATION_OMEGA, result->omega.uncertainty);
    result->rms = drag->candidate[i].rms;
    result->used = fit->used;
    result->rejected = f->motion->samples.n - fit->used;
    result->autocorrelation = factors->lag;
    result->converged = fit->converged;
    drag->motion = fit->motion;
    drag->motion.value[EQUATION_OFFSET] = result->offset.value;
    drag->signal = factors->signal;
}
