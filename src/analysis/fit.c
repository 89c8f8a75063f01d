/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits that need no guess: damped and plain sine, with what they are worth. */
#include "internal.h"

#include <gsl/gsl_errno.h>
#include <math.h>

#define SIGNIFICANT 3.0 /* standard deviations of gamma above 0 before laws of drag are compared */

/* Variance of the linear combination g of the parameters. */
static double variance(const struct harmonic *h, const double g[HARMONIC_PARAMETERS])
{
    double sum = 0;
    for (int i = 0; i < HARMONIC_PARAMETERS; i++) {
        for (int j = 0; j < HARMONIC_PARAMETERS; j++) {
            sum += g[i] * h->inverse[i][j] * g[j];
        }
    }
    return sum;
}

/*
 * From the parameters at the origin to those of y = c + A exp(-gamma t/2) cos(omega t + phi), t from t0, A >= 0, phi in
 * (-pi, pi]. Uncertainties: covariance of the least-squares problem times the variance of the residuals, widened for
 * their lag-1 autocorrelation by (1 + rho)/(1 - rho). To that the caller adds what two halves tell. Not included: other
 * ways in which the model itself may miss (see the warnings).
 */
static void report(const struct harmonic *h, int unknowns, double rho, double t0, struct fit *fit)
{
    double back = h->origin - t0, square = h->a * h->a + h->b * h->b;
    double amplitude = sqrt(square) * exp(0.5 * h->gamma * back);
    double phase = remainder(atan2(-h->b, h->a) - h->omega * back, TWO_PI);
    double sigma = harmonic_sigma(h, unknowns) * sqrt(autocorrelation_factor(rho));
    double of_amplitude[HARMONIC_PARAMETERS] = {h->a / square, h->b / square, 0, 0, 0.5 * back}; /* d ln A */
    double of_phase[HARMONIC_PARAMETERS] = {h->b / square, -h->a / square, 0, -back, 0};
    fit->omega = (struct measured){h->omega, sigma * sqrt(h->inverse[RATE_OMEGA][RATE_OMEGA])};
    fit->period.value = TWO_PI / h->omega;
    fit->period.uncertainty = fit->period.value * fit->omega.uncertainty / h->omega;
    fit->gamma = (struct measured){h->gamma, sigma * sqrt(h->inverse[RATE_GAMMA][RATE_GAMMA])};
    fit->amplitude = (struct measured){amplitude, amplitude * sigma * sqrt(variance(h, of_amplitude))};
    fit->phase = (struct measured){phase <= -PI ? PI : phase, sigma * sqrt(variance(h, of_phase))};
    fit->offset = (struct measured){h->c, sigma * sqrt(h->inverse[LINEAR_C][LINEAR_C])};
}

/* One half of the samples on its own, from the whole's frequency and damping on. NAN where it determines nothing. */
static void fit_half(const struct motion *m, size_t from, size_t to, int i, struct fit *fit)
{
    struct samples part = samples_part(&m->samples, from, to);
    struct harmonic h = {.omega = m->harmonic.omega, .gamma = m->harmonic.gamma};
    struct fit half;
    if (part.n < 8) {
        return;
    }
    h.origin = 0.5 * (part.t[0] + part.t[part.n - 1]);
    if (harmonic_fit(&part, FREE_GAMMA, &h, m->scratch) && h.converged) {
        report(&h, FREE_GAMMA, residual_autocorrelation(&part, m->scratch), part.t[0], &half);
        fit->halves[i] = half.gamma;
        fit->half_periods[i] = half.period;
    }
}

/* Halves that differ by more than chance: the one number for the whole is only as good as half their difference. */
static void widen_by_halves(const struct measured half[2], struct measured *whole)
{
    double difference = fabs(half[0].value - half[1].value), chance = hypot(half[0].uncertainty, half[1].uncertainty);
    if (difference > HALVES_DIFFER * chance) {
        whole->uncertainty = fmax(whole->uncertainty, 0.5 * difference);
    }
}

static bool fit_harmonic(const char *model, enum harmonic_free unknowns, const struct series *series,
                         struct arena *arena, const struct cancel *cancel, struct fit *fit, struct error *error)
{
    struct motion m;
    *fit = (struct fit){.model = model, .evidence = {NAN, NAN, NAN}};
    fit->halves[0] = fit->halves[1] = fit->half_periods[0] = fit->half_periods[1] = (struct measured){NAN, NAN};
    gsl_set_error_handler_off(); /* GSL's default ends the program; statuses are checked here */
    if (!motion_require(&m, series, arena, error)) {
        return false;
    }
    if (unknowns == FREE_OMEGA) {
        m.harmonic.gamma = 0;
        m.harmonic.a = m.harmonic.b = 0;
        m.harmonic.origin = 0.5 * (series->t[0] + series->t[series->n - 1]);
        m.harmonic.converged = harmonic_fit(&m.samples, unknowns, &m.harmonic, m.residual) && m.harmonic.converged;
        m.autocorrelation = residual_autocorrelation(&m.samples, m.residual);
    }
    if (cancelled(cancel)) {
        return error_set(error, ERROR_CANCELLED, "the fit was stopped");
    }
    fit->t0 = fit->window[0] = series->t[0];
    fit->window[1] = series->t[series->n - 1];
    fit->rms = sqrt(m.harmonic.rss / (double)m.harmonic.used);
    fit->used = m.harmonic.used;
    fit->rejected = m.rejected;
    fit->converged = m.harmonic.converged;
    fit->iterations = m.harmonic.iterations;
    fit->autocorrelation = m.autocorrelation;
    report(&m.harmonic, (int)unknowns, m.autocorrelation, fit->t0, fit);
    if (!fit->converged || !isfinite(fit->amplitude.value) || !(fit->amplitude.uncertainty < fit->amplitude.value)) {
        fit->converged = false;
        return error_set(error, ERROR_NUMERICAL, "the fit of %s did not converge in %d iterations", fit->model,
                         fit->iterations);
    }
    double sway = NAN;
    if (unknowns == FREE_GAMMA) {
        size_t middle = samples_index(&m.samples, 0.5 * (fit->window[0] + fit->window[1]));
        fit_half(&m, 0, middle, 0, fit);
        fit_half(&m, middle, series->n, 1, fit);
        double formal = fit->gamma.uncertainty;
        widen_by_halves(fit->halves, &fit->gamma);
        widen_by_halves(fit->half_periods, &fit->period);
        fit->omega.uncertainty = fit->omega.value * fit->period.uncertainty / fit->period.value;
        if (!envelope_laws(&m, fit, &sway)) {
            return error_memory(error);
        }
        if (!(fit->gamma.value > SIGNIFICANT * formal)) {
            fit->preferred = LAW_NONE;
        }
    }
    fit_diagnose(&m, sway, fit);
    return true;
}

static bool fit_damped(const struct series *series, struct arena *arena, const struct cancel *cancel, struct fit *fit,
                       struct error *error)
{
    return fit_harmonic("damped", FREE_GAMMA, series, arena, cancel, fit, error);
}

static bool fit_sine(const struct series *series, struct arena *arena, const struct cancel *cancel, struct fit *fit,
                     struct error *error)
{
    return fit_harmonic("sine", FREE_OMEGA, series, arena, cancel, fit, error);
}

static const struct fit_model models[] = {
    {.row = {.name = "damped",
             .unit = "",
             .brief = "y = c + A exp(-gamma t/2) cos(omega t + phi), no guess needed",
             .citation = "Golub & Pereyra 2003 (variable projection)"},
     .fit = fit_damped},
    {.row = {.name = "sine",
             .unit = "",
             .brief = "y = c + A cos(omega t + phi), no guess needed",
             .citation = "Golub & Pereyra 2003 (variable projection)"},
     .fit = fit_sine},
};

const struct catalog fit_catalog = CATALOG("model", models);

double fit_value(const struct fit *fit, double t)
{
    double s = t - fit->t0;
    return fit->offset.value +
           fit->amplitude.value * exp(-0.5 * fit->gamma.value * s) * cos(fit->omega.value * s + fit->phase.value);
}

struct measured fit_stiffness(const struct fit *fit, struct measured mass)
{
    double w = fit->omega.value, g = fit->gamma.value, square = w * w + 0.25 * g * g, m = mass.value;
    double by_mass = isfinite(mass.uncertainty) ? square * mass.uncertainty : 0;
    double by_omega = 2 * m * w * fit->omega.uncertainty, by_gamma = 0.5 * m * g * fit->gamma.uncertainty;
    return (struct measured){m * square, sqrt(by_mass * by_mass + by_omega * by_omega + by_gamma * by_gamma)};
}

const char *drag_law_name(enum drag_law law)
{
    static const char *const names[] = {[LAW_LINEAR] = "linear",
                                        [LAW_QUADRATIC] = "quadratic",
                                        [LAW_MIXED] = "mixed",
                                        [LAW_UNDECIDED] = "not distinguishable"};
    return names[law];
}
