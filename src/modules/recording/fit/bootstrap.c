/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Parametric bootstrap (Efron & Tibshirani 1993, chapter 6.5) of curve_fit(): the fitted curve with
 * new normal noise of the residuals' size and lag-1 autocorrelation is fitted repeatedly; the 2.5 %
 * and 97.5 % quantiles of the fitted values are the interval. */
#include "modules/recording/fit/curve_problem.h"

/* Returns a standard normal random number (Box & Muller 1958) and advances *state. */
static double random_normal(uint64_t *state)
{
    double u = 1 - random_fraction(state), v = random_fraction(state);
    return sqrt(-2 * log(u)) * cos(TWO_PI * v);
}

/* Returns the standard deviation of the noise to simulate. Simulated samples have no outliers, so
 * after a robust fit only samples with weight count. */
static double simulated_noise(const struct curve_problem *p, const struct curve_fit *fit)
{
    double square = 0, weight = 0;
    for (size_t i = 0; i < p->n && p->robust; i++) {
        square += p->weight[i] * fit->residual[i] * fit->residual[i];
        weight += p->weight[i];
    }
    return p->robust && weight > 0 ? fmax(p->scale, sqrt(square / weight)) : fit->sigma;
}

/* Replaces the intervals in *fit by the 2.5 and 97.5 % quantiles of fits to options->bootstrap
 * simulated series, which are the fitted curve plus noise with the residuals' size and correlation.
 * Returns false with the error. */
bool fit_bootstrap(const struct curve_problem *p, const struct series *series,
                   const struct curve_options *options, struct arena *arena, struct curve_fit *fit,
                   struct error *error)
{
    int count = fit->parameters, rounds = options->bootstrap;
    double *y = arena_array(arena, p->n, sizeof *y),
           *model = arena_array(arena, p->n, sizeof *model);
    double *found = arena_array(arena, (size_t)(count * rounds), sizeof *found),
           start[CURVE_PARAMETERS];
    if (!y || !model || !found)
        return error_memory(error);
    for (int j = 0; j < count; j++)
        start[j] = fit->value[j].value;
    for (size_t i = 0; i < p->n; i++)
        model[i] = series->y[i] - fit->residual[i];
    struct curve_options plain = *options;
    plain.bootstrap = 0;
    plain.robust = false;
    double sigma = simulated_noise(p, fit), rho = fmax(fit->autocorrelation, 0),
           fresh = sqrt(1 - rho * rho);
    uint64_t state = options->seed;
    for (int k = 0; k < rounds; k++) {
        struct arena scratch = {0};
        struct curve_fit refit;
        struct series simulated = *series;
        /* New samples: curve + first-order autoregressive noise with the residuals' correlation
         * rho. */
        double noise = random_normal(&state);
        for (size_t i = 0; i < p->n; i++) {
            y[i] = model[i] + sigma * noise;
            noise = rho * noise + fresh * random_normal(&state);
        }
        simulated.y = y;
        bool fitted = curve_fit(p->curve, &simulated, start, &plain, &scratch, &refit, error);
        arena_reset(&scratch);
        if (!fitted)
            return false;
        for (int j = 0; j < count && refit.converged; j++)
            found[j * rounds + fit->bootstrapped] = refit.value[j].value;
        fit->bootstrapped += refit.converged;
    }
    /* The 2.5 % quantile of fewer than 40 values would only be the smallest one. */
    for (int j = 0; j < count && fit->bootstrapped >= 40; j++) {
        size_t n = (size_t)fit->bootstrapped;
        fit->interval[j][0] = values_quantile(found + j * rounds, n, 0.025);
        fit->interval[j][1] = values_quantile(found + j * rounds, n, 0.975);
    }
    return true;
}
