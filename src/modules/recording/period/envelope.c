/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits the envelope, with which the search for laws of damping begins, and measures its sway.
 * Averaging y'' + gamma y' + b|y'|y' + Omega^2 y = 0 over a period gives A(s) = A0 exp(-gamma s/2)
 * / (1 + q phi(s)), phi = (1 - exp(-gamma s/2)) 2/gamma, q = 4 b Omega A0/(3 pi); the phase is
 * unaffected (Nayfeh & Mook 1979, Nonlinear Oscillations, 3.3). A linear law has q = 0, a quadratic
 * one gamma = 0 and A = A0/(1 + q s). */
#include "modules/recording/series/internal.h"

#include <gsl/gsl_errno.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <math.h>

/* Largest and smallest number of readings of the envelope. */
enum { WINDOWS_MAX = 64, WINDOWS_MIN = 8 };

/* Mean square to which averaging over a period is accurate; no law is fitted better. */
#define MEAN_SQUARE_MIN 1e-10

/* Readings of the envelope, and the law that is being fitted to them. */
struct envelope {
    size_t count;
    double s[WINDOWS_MAX]; /* time since the start, relative to the span: 0 … 1 */
    double a[WINDOWS_MAX]; /* amplitude relative to the largest one */
    double noise;          /* mean variance of the readings */
    bool gamma, quadratic; /* terms that the law has */
};

/* Returns the amplitude at s >= 0 relative to that at s = 0 for linear and quadratic drag, and sets
 * its derivatives by gamma and q. */
static double envelope_value(const struct envelope_rates *rates, double s, double gradient[2])
{
    /* phi = (1 - exp(-hs))/h, slope = dphi/dh */
    double h = 0.5 * rates->gamma, hs = h * s, phi, slope;
    if (fabs(hs) < 1e-3) {
        phi = s * (1 - hs / 2 * (1 - hs / 3));
        slope = s * s * (-0.5 + hs / 3);
    } else {
        phi = -expm1(-hs) / h;
        slope = (s * exp(-hs) - phi) / h;
    }
    double denominator = 1 + rates->q * phi, value = exp(-hs) / denominator;
    gradient[0] = 0.5 * value * (-s - rates->q * slope / denominator);
    gradient[1] = -value * phi / denominator;
    return value;
}

/* Returns the amplitude of the law at s (time in units of the span). x is ln A0, then the rates
 * that the law has [1/span]. Sets d[3] to the derivatives by ln A0, gamma, q. */
static double law_value(const struct envelope *e, const gsl_vector *x, double s, double d[3])
{
    struct envelope_rates rates = {0};
    if (e->gamma)
        rates.gamma = gsl_vector_get(x, 1);
    if (e->quadratic)
        rates.q = gsl_vector_get(x, 1 + (size_t)e->gamma);
    double gradient[2], a0 = exp(gsl_vector_get(x, 0)),
                        value = a0 * envelope_value(&rates, s, gradient);
    d[0] = value;
    d[1] = a0 * gradient[0];
    d[2] = a0 * gradient[1];
    return value;
}

/* Computes the residuals of the readings in the form that GSL's fit expects. */
static int law_residual(const gsl_vector *x, void *context, gsl_vector *f)
{
    const struct envelope *e = context;
    double d[3];
    for (size_t i = 0; i < e->count; i++) {
        gsl_vector_set(f, i, law_value(e, x, e->s[i], d) - e->a[i]);
    }
    return GSL_SUCCESS;
}

/* Computes the derivatives of the residuals in the form that GSL's fit expects. */
static int law_jacobian(const gsl_vector *x, void *context, gsl_matrix *jacobian)
{
    const struct envelope *e = context;
    double d[3];
    for (size_t i = 0; i < e->count; i++) {
        size_t column = 0;
        law_value(e, x, e->s[i], d);
        gsl_matrix_set(jacobian, i, column++, d[0]);
        if (e->gamma) {
            gsl_matrix_set(jacobian, i, column++, d[1]);
        }
        if (e->quadratic) {
            gsl_matrix_set(jacobian, i, column++, d[2]);
        }
    }
    return GSL_SUCCESS;
}

/* Result of fit_law(); rates in 1/span. */
struct envelope_fit {
    double mean_square, gamma, q;
    bool found;
};

/* Fits the envelope by the law with the terms `gamma` and `quadratic`, from the starting rate
 * `start` [1/span]. Sets result->found if it converged. Returns false if out of memory. */
static bool fit_law(struct envelope *e, bool gamma, bool quadratic, double start,
                    struct envelope_fit *result)
{
    size_t p = 1 + (size_t)gamma + (size_t)quadratic;
    double x0[3] = {log(e->a[0]), gamma && !quadratic ? start : start / 2, start / 4};
    e->gamma = gamma;
    e->quadratic = quadratic;
    gsl_multifit_nlinear_parameters parameters = gsl_multifit_nlinear_default_parameters();
    parameters.trs = gsl_multifit_nlinear_trs_lmaccel;
    gsl_multifit_nlinear_fdf fdf = {
        .f = law_residual, .df = law_jacobian, .n = e->count, .p = p, .params = e};
    gsl_multifit_nlinear_workspace *work =
        gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust, &parameters, e->count, p);
    gsl_vector_view x = gsl_vector_view_array(x0, p);
    int info = 0;
    *result = (struct envelope_fit){0};
    if (!work) {
        return false;
    }
    if (gsl_multifit_nlinear_init(&x.vector, &fdf, work) == GSL_SUCCESS) {
        int status = gsl_multifit_nlinear_driver(100, 1e-8, 1e-10, 0, NULL, NULL, &info, work);
        /* GSL_ENOPROG means the minimum to the last digit */
        result->found = status == GSL_SUCCESS || status == GSL_ENOPROG;
        const gsl_vector *f = gsl_multifit_nlinear_residual(work),
                         *solution = gsl_multifit_nlinear_position(work);
        double square = 0;
        for (size_t i = 0; i < e->count; i++) {
            square += gsl_vector_get(f, i) * gsl_vector_get(f, i);
        }
        result->mean_square = fmax(square / (double)e->count, MEAN_SQUARE_MIN);
        result->gamma = gamma ? gsl_vector_get(solution, 1) : 0;
        result->q = quadratic ? gsl_vector_get(solution, p - 1) : 0;
        result->found = result->found && isfinite(square);
    }
    gsl_multifit_nlinear_free(work);
    return true;
}

/* Reads the amplitudes of consecutive windows of whole periods (fractions would alternate with the
 * shape of the oscillation) into e, without those lost in noise, relative to the largest. */
static void read_envelope(const struct motion *m, struct envelope *e)
{
    const struct samples *x = &m->samples;
    double span = x->t[x->n - 1] - x->t[0], largest = 0, noise = 0;
    double whole = fmax(1, ceil(m->overview.periods / WINDOWS_MAX)),
           width = whole * m->overview.period;
    size_t windows = (size_t)(span / width * (1 + 1e-9));
    for (size_t k = 0; k < windows && e->count < WINDOWS_MAX; k++) {
        struct reading reading;
        size_t begin = samples_index(x, x->t[0] + width * (double)k);
        size_t end = samples_index(x, x->t[0] + width * (double)(k + 1));
        if (!local_amplitude(m, begin, end, &reading) ||
            !(reading.amplitude.uncertainty < 0.3 * reading.amplitude.value)) {
            continue;
        }
        e->s[e->count] = (reading.t - x->t[0]) / span;
        e->a[e->count++] = reading.amplitude.value;
        largest = fmax(largest, reading.amplitude.value);
        noise += reading.amplitude.uncertainty * reading.amplitude.uncertainty;
    }
    for (size_t k = 0; k < e->count; k++) {
        e->a[k] /= largest;
    }
    e->noise = e->count ? noise / (double)e->count / (largest * largest) : 0;
}

/* Fits three laws (linear, quadratic, both) to readings of the amplitude. Sets rates[] and *sway,
 * the relative scatter beyond noise of the best one, NAN if unknown. Returns false if out of
 * memory. */
bool envelope_laws(const struct motion *m, double *sway, struct envelope_rates rates[3])
{
    static const struct {
        bool gamma, quadratic;
    } laws[] = {{true, false}, {false, true}, {true, true}};
    struct envelope_fit law[COUNT_OF(laws)];
    struct envelope readings = {0}, *e = &readings;
    *sway = NAN;
    read_envelope(m, e);
    if (e->count < WINDOWS_MIN) {
        return true;
    }
    double span = m->samples.t[m->samples.n - 1] - m->samples.t[0],
           start = m->harmonic.gamma * span;
    for (size_t i = 0; i < COUNT_OF(laws); i++) {
        if (!fit_law(e, laws[i].gamma, laws[i].quadratic, start, &law[i])) {
            return false;
        }
        if (!law[i].found) {
            return true;
        }
        rates[i] = (struct envelope_rates){.gamma = law[i].gamma / span, .q = law[i].q / span};
    }
    double square = 0;
    for (size_t k = 0; k < e->count; k++) {
        square += e->a[k] * e->a[k];
    }
    double scatter = fmin(fmin(law[0].mean_square, law[1].mean_square), law[2].mean_square);
    *sway = scatter > 10 * e->noise ? sqrt(scatter / (square / (double)e->count)) : 0;
    return true;
}
