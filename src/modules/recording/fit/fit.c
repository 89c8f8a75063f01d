/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits of fit_catalog that need no guess (damped and plain sine, laws), from the harmonic fit of a
 * struct motion to values with uncertainties. */
#include <hooke/base/cancel.h>
#include <hooke/base/catalog.h>
#include "modules/recording/fit/least_squares.h"
#include "modules/recording/series/internal.h"

#include <math.h>
#include <stdio.h>

/* Returns the covariance of two linear combinations a and b of the harmonic's parameters, in units
 * of the variance of a residual. */
static double combination_covariance(const struct harmonic *h, const double *a, const double *b)
{
    return quadratic_form(HARMONIC_PARAMETERS, HARMONIC_PARAMETERS, a, &h->inverse[0][0], b);
}

/* Scales the row and the column of the parameter, so that its correlations remain. */
void fit_covariance_widen(struct fit_covariance *covariance, int i, double uncertainty)
{
    const double previous = sqrt(covariance->entry[i][i]),
                 factor = previous > 0 ? uncertainty / previous : 0;
    for (int j = 0; j < covariance->n; j++) {
        covariance->entry[i][j] *= factor;
        covariance->entry[j][i] *= factor;
    }
}

/* Fills the covariances of amplitude, phase, omega and gamma. gradient[i] has the derivatives of
 * value i by the harmonic's parameters, and deviation[i] is the standard deviation of a residual as
 * it acts on value i. */
static void covariances_fill(const struct harmonic *h, const double *const gradient[],
                             const double deviation[], struct fit_covariance *result)
{
    result->n = SINE_PARAMETERS;
    for (int i = 0; i < SINE_PARAMETERS; i++)
        for (int j = 0; j < SINE_PARAMETERS; j++)
            result->entry[i][j] =
                deviation[i] * deviation[j] * combination_covariance(h, gradient[i], gradient[j]);
}

/* Stores the harmonic as y = c + A exp(-gamma t/2) cos(omega t + phi) in fit, with t counted from
 * t0, A >= 0 and phi in (-pi, pi]. Uncertainties come from the covariance of the `unknowns` fitted
 * parameters, widened for what the residuals have in common with each parameter (sway, drift). The
 * caller adds the difference between the halves; other errors of the model are not included (see
 * the warnings). */
static void sine_values_set(const struct samples *x, const double *residual,
                            const struct harmonic *h, int unknowns, double t0, struct fit *fit)
{
    double back = h->origin - t0, square = h->a * h->a + h->b * h->b;
    double amplitude = sqrt(square) * exp(0.5 * h->gamma * back);
    double phase = remainder(atan2(-h->b, h->a) - h->omega * back, TWO_PI);
    struct oscillation o = {h->a, h->b, h->omega, h->gamma, h->origin};
    struct widening widen = residual_widening(x, residual, &o, 2);
    double sigma = harmonic_sigma(h, unknowns), slow = sigma * sqrt(widen.amplitude),
           fast = sigma * sqrt(widen.phase);
    double wander = sigma * sqrt(widen.offset);
    double of_amplitude[HARMONIC_PARAMETERS] = {
        h->a / square, h->b / square, [RATE_GAMMA] = 0.5 * back}; /* d ln A */
    double of_phase[HARMONIC_PARAMETERS] = {h->b / square, -h->a / square, [RATE_OMEGA] = -back};
    double of_offset[HARMONIC_PARAMETERS] = {[LINEAR_C] = 1, [LINEAR_D] = -back};
    fit->omega = (struct measured){h->omega, fast * sqrt(h->inverse[RATE_OMEGA][RATE_OMEGA])};
    fit->period.value = TWO_PI / h->omega;
    fit->period.uncertainty = fit->period.value * fit->omega.uncertainty / h->omega;
    fit->gamma = (struct measured){h->gamma, slow * sqrt(h->inverse[RATE_GAMMA][RATE_GAMMA])};
    fit->amplitude = (struct measured){
        amplitude, amplitude * slow * sqrt(combination_covariance(h, of_amplitude, of_amplitude))};
    fit->phase = (struct measured){phase <= -PI ? PI : phase,
                                   fast * sqrt(combination_covariance(h, of_phase, of_phase))};
    fit->offset = (struct measured){h->c - h->d * back,
                                    wander * sqrt(combination_covariance(h, of_offset, of_offset))};
    fit->drift = (struct measured){h->d, wander * sqrt(h->inverse[LINEAR_D][LINEAR_D])};
    static const double by_omega[HARMONIC_PARAMETERS] = {[RATE_OMEGA] = 1},
                        by_gamma[HARMONIC_PARAMETERS] = {[RATE_GAMMA] = 1};
    const double *const gradient[] = {of_amplitude, of_phase, by_omega, by_gamma};
    const double deviation[] = {amplitude * slow, fast, fast, slow};
    covariances_fill(h, gradient, deviation, &fit->covariance);
}

/* Fits one half of the samples, begin to end - 1, starting from the whole's frequency and damping,
 * and stores gamma and period as half i. Leaves them NAN where the half does not determine them. */
static void fit_half(const struct motion *m, size_t begin, size_t end, int i, struct fit *fit)
{
    struct samples part = samples_part(&m->samples, begin, end);
    struct harmonic h = {
        .omega = m->harmonic.omega, .gamma = m->harmonic.gamma, .drifts = m->harmonic.drifts};
    struct fit half;
    if (part.n < 8) {
        return;
    }
    h.origin = 0.5 * (part.t[0] + part.t[part.n - 1]);
    if (harmonic_fit(&part, FREE_GAMMA, &h, m->scratch) && h.converged) {
        sine_values_set(&part, m->scratch, &h, FREE_GAMMA, part.t[0], &half);
        fit->halves[i] = half.gamma;
        fit->half_periods[i] = half.period;
    }
}

/* Widens the uncertainty of *whole to half the difference of its halves if they differ by more than
 * chance: one value for the whole is then not more certain than that. */
static void widen_by_halves(const struct measured half[2], struct measured *whole)
{
    double difference = fabs(half[0].value - half[1].value),
           chance = hypot(half[0].uncertainty, half[1].uncertainty);
    if (difference > HALVES_DIFFER * chance) {
        whole->uncertainty = fmax(whole->uncertainty, 0.5 * difference);
    }
}

/* Size of the text of say_left_out(). */
enum { LEFT_OUT_SIZE = 120 };

/* Writes how many samples a fit would leave out, as ": it would leave out 205 of 600 samples, 200
 * of them at flat tops (clipped)", or an empty text if none. */
static void say_left_out(const struct motion *m, char output[LEFT_OUT_SIZE])
{
    char flat[64] = "";
    if (m->clipped > 0)
        snprintf(flat, sizeof flat, ", %zu of them at flat tops (clipped)", m->clipped);
    output[0] = 0;
    if (m->rejected > 0)
        snprintf(output, LEFT_OUT_SIZE, ": it would leave out %zu of %zu samples%s", m->rejected,
                 m->samples.n, flat);
}

/* Adds a hint to the error: the window that one damped sine describes, if one exists. Returns
 * false. */
static bool hint_swing(const struct motion *m, const struct series *series, struct error *error)
{
    static const double same_period_log = 0.2;
    struct swing swing;
    if (find_swing(series, &swing) ||
        (find_first_swing(series, &swing) &&
         fabs(log(swing.period / m->overview.period)) < same_period_log))
        return error_hint(error, "one damped sine fits a part of it: add window=%.9g:%.9g",
                          swing.window[0], swing.window[1]);
    return error_hint(error,
                      "fit a shorter window; 'measure period' also works when the period changes");
}

/* Sets the error of a series that oscillates but is described by no law of damping. Returns
 * false. */
static bool refuse_laws(const struct motion *m, const struct series *series, struct fit *fit,
                        struct error *error)
{
    char left_out[LEFT_OUT_SIZE];
    fit->converged = false;
    say_left_out(m, left_out);
    error_set(error, ERROR_NUMERICAL,
              "it oscillates with a mean period of %.4g s, but no law of damping fits it%s",
              m->overview.period, left_out);
    return hint_swing(m, series, error);
}

/* Laws that are integrated beside the sine: none, laws of damping, or these and restoring
 * forces. */
enum laws { LAWS_NONE, LAWS_OF_DAMPING, LAWS_ALL };

/* Fits a damped or plain sine to the series and, if asked for, laws; this is the common body of the
 * catalog's rows. Fills *fit. Returns false with the error if the series does not oscillate, the
 * fit does not converge, or it was cancelled. */
static bool fit_harmonic(const char *model, enum harmonic_free unknowns, enum laws laws,
                         const struct series *series, struct arena *arena,
                         const struct cancel *cancel, struct fit *fit, struct error *error)
{
    const bool drag = laws != LAWS_NONE;
    struct motion m;
    *fit = (struct fit){.model = model};
    fit->halves[0] = fit->halves[1] = fit->half_periods[0] = fit->half_periods[1] =
        (struct measured){NAN, NAN};
    if (!motion_require(&m, series, arena, cancel, error)) {
        return false;
    }
    /* The motion was fitted with damping; a plain sine is fitted again without. */
    if (unknowns == FREE_OMEGA) {
        m.harmonic.gamma = 0;
        m.harmonic.a = m.harmonic.b = m.harmonic.d = 0;
        m.harmonic.origin = 0.5 * (series->t[0] + series->t[series->n - 1]);
        m.harmonic.converged = harmonic_fit(&m.samples, unknowns, &m.harmonic, m.residual) &&
                               m.harmonic.converged && !fit_discards_much(m.rejected, m.samples.n);
        m.autocorrelation = residual_autocorrelation(&m.samples, m.residual);
    }
    if (cancelled(cancel)) {
        return error_set(error, ERROR_CANCELLED, "the fit was stopped");
    }
    /* The answer of the sine, which is also the start of the laws. */
    fit->t0 = fit->window[0] = series->t[0];
    fit->window[1] = series->t[series->n - 1];
    fit->rms = sqrt(m.harmonic.rss / (double)m.harmonic.used);
    fit->used = m.harmonic.used;
    fit->rejected = m.rejected;
    fit->converged = m.harmonic.converged;
    fit->iterations = m.harmonic.iterations;
    fit->autocorrelation = m.autocorrelation;
    sine_values_set(&m.samples, m.residual, &m.harmonic, (int)unknowns, fit->t0, fit);
    /* One sine does not fit. Laws get their chance; otherwise the error names two frequencies or a
     * better window. */
    if (m.tracked && !fit->converged && !drag) {
        char left_out[LEFT_OUT_SIZE];
        say_left_out(&m, left_out);
        error_set(error, ERROR_NUMERICAL,
                  "it oscillates with a mean period of %.4g s, but one %s sine does not fit it%s",
                  m.overview.period, unknowns == FREE_GAMMA ? "damped" : "plain", left_out);
        struct mode_pair pair;
        if (two_lines(&m.samples, &pair))
            return error_hint(error,
                              "it has two frequencies, T = %.5g and %.5g s; type: fit modes 2",
                              pair.period[0], pair.period[1]);
        return hint_swing(&m, series, error);
    }
    const bool determined =
        isfinite(fit->amplitude.value) && fit->amplitude.uncertainty < fit->amplitude.value;
    if ((!fit->converged || !determined) && !drag) {
        fit->converged = false;
        error_set(error, ERROR_NUMERICAL, "the fit of %s did not converge in %d iterations",
                  fit->model, fit->iterations);
        return hint_swing(&m, series, error);
    }
    double sway = NAN;
    if (unknowns == FREE_GAMMA) {
        /* A recording has no halves to compare where it is at rest. */
        const size_t moves = samples_quiet(&m.samples, TWO_PI / m.harmonic.omega);
        size_t middle = samples_index(&m.samples, 0.5 * (fit->window[0] + series->t[moves - 1]));
        fit_half(&m, 0, middle, 0, fit);
        fit_half(&m, middle, moves, 1, fit);
        widen_by_halves(fit->halves, &fit->gamma);
        widen_by_halves(fit->half_periods, &fit->period);
        fit->omega.uncertainty = fit->omega.value * fit->period.uncertainty / fit->period.value;
        fit_covariance_widen(&fit->covariance, SINE_OMEGA, fit->omega.uncertainty);
        fit_covariance_widen(&fit->covariance, SINE_GAMMA, fit->gamma.uncertainty);
        const double rate = fmax(m.harmonic.gamma, 0);
        struct envelope_rates rates[3] = {{rate, 0}, {0, 0.5 * rate}, {0.5 * rate, 0.25 * rate}};
        if (!envelope_laws(&m, &sway, rates)) {
            return error_memory(error);
        }
        if (drag && !drag_laws(&m, series->quantity, laws == LAWS_ALL, rates, arena, fit, error)) {
            return false;
        }
        if (drag && fit_discards_much(m.rejected, m.samples.n))
            return refuse_laws(&m, series, fit, error);
    }
    /* The uncertainty of the recording's clock comes last: it is common to all times. */
    if (m.samples.pace > 0) {
        fit->period = measured_at_pace(fit->period, m.samples.pace);
        fit->omega = measured_at_pace(fit->omega, m.samples.pace);
        fit->gamma = measured_at_pace(fit->gamma, m.samples.pace);
        fit_covariance_widen(&fit->covariance, SINE_OMEGA, fit->omega.uncertainty);
        if (unknowns == FREE_GAMMA)
            fit_covariance_widen(&fit->covariance, SINE_GAMMA, fit->gamma.uncertainty);
    }
    fit_diagnose(&m, sway, fit);
    return true;
}

static bool fit_damped(const struct series *series, struct arena *arena,
                       const struct cancel *cancel, struct fit *fit, struct error *error)
{
    return fit_harmonic("damped", FREE_GAMMA, LAWS_NONE, series, arena, cancel, fit, error);
}

static bool fit_sine(const struct series *series, struct arena *arena, const struct cancel *cancel,
                     struct fit *fit, struct error *error)
{
    return fit_harmonic("sine", FREE_OMEGA, LAWS_NONE, series, arena, cancel, fit, error);
}

static bool fit_drag(const struct series *series, struct arena *arena, const struct cancel *cancel,
                     struct fit *fit, struct error *error)
{
    return fit_harmonic("drag", FREE_GAMMA, LAWS_OF_DAMPING, series, arena, cancel, fit, error);
}

static bool fit_law(const struct series *series, struct arena *arena, const struct cancel *cancel,
                    struct fit *fit, struct error *error)
{
    return fit_harmonic("law", FREE_GAMMA, LAWS_ALL, series, arena, cancel, fit, error);
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
    {.row = {.name = "drag",
             .unit = "",
             .brief = "finds the law of drag: linear, quadratic, dry friction or their sums",
             .citation = "Moore 1966 (Taylor series); Schwarz 1978 (BIC)"},
     .fit = fit_drag},
    {.row = {.name = "law",
             .unit = "",
             .brief =
                 "like drag, and finds the restoring force: a spring, a Duffing spring, a pendulum",
             .citation = "Nayfeh & Mook 1979; Schwarz 1978 (BIC)"},
     .fit = fit_law},
    {.row = {"scene", "", "the scene's own equation of motion, integrated", "", NULL},
     .kind = FIT_SCENE},
    {.row = {"modes", "", "several damped sines at once: normal modes, beats, coupling", "", NULL},
     .kind = FIT_MODES},
};

const struct catalog fit_catalog = CATALOG("model", models);

const struct fit_model *fit_model_by_name(struct text name)
{
    return (const struct fit_model *)(const void *)catalog_find(&fit_catalog, name);
}

const struct fit_model *fit_model_at(size_t i)
{
    return (const struct fit_model *)(const void *)catalog_row(&fit_catalog, i);
}

const struct fit_model *fit_model_from(const struct row *row)
{
    return (const struct fit_model *)(const void *)row;
}

/* Computes value [n] of the fit at times t [n]: the damped sine, or the integrated motion of a law,
 * with the drift; NAN where the law has no value. */
void fit_values(const struct fit *fit, const double *t, size_t n, double *value)
{
    const double gamma = fit->gamma.value, omega = fit->omega.value;
    if (fit->drag.candidates > 0) {
        if (!equation_solve(&fit->drag.motion, t, n, value, NULL))
            for (size_t i = 0; i < n; i++)
                value[i] = NAN;
    } else {
        for (size_t i = 0; i < n; i++) {
            const double s = t[i] - fit->t0, decay = isfinite(gamma) ? exp(-0.5 * gamma * s) : 1;
            value[i] = fit->offset.value +
                       fit->amplitude.value * decay * cos(omega * s + fit->phase.value);
        }
    }
    for (size_t i = 0; i < n; i++)
        value[i] += fit->drift.value * (t[i] - fit->t0);
}

/* Adds the contributions of the mass, omega and gamma in quadrature, without correlations. */
struct measured fit_stiffness(const struct fit *fit, struct measured mass)
{
    double w = fit->omega.value, g = fit->gamma.value, square = w * w + 0.25 * g * g,
           m = mass.value;
    double by_mass = isfinite(mass.uncertainty) ? square * mass.uncertainty : 0;
    double by_omega = 2 * m * w * fit->omega.uncertainty,
           by_gamma = 0.5 * m * g * fit->gamma.uncertainty;
    return (struct measured){m * square,
                             sqrt(by_mass * by_mass + by_omega * by_omega + by_gamma * by_gamma)};
}
