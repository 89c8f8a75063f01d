/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Synthetic recordings with a known truth, from a fixed seed. */
#pragma once

#include "modules/recording/series/analysis.h"

#include "unit/random_testing.h"

#include <math.h>
#include <stdlib.h>

static inline double random_between(double low, double high)
{
    return low + (high - low) * random_uniform();
}

struct truth {
    double amplitude, offset, period, gamma, phase; /* gamma as in exp(-gamma t/2) */
    double quadratic; /* [1/s] q: amplitude divided by 1 + q (1 - exp(-gamma t/2)) 2/gamma */
    double t0, rate, span;
    double noise;                         /* standard deviation */
    double dropouts;                      /* share of samples that read 0 */
    double drift;                         /* of the offset over the whole span */
    double clip;                          /* values above offset + clip are cut; 0: none */
    double sway, sway_period, sway_phase; /* relative modulation of the amplitude, [s] */
    double quantum;                       /* values are rounded to multiples of it; 0: not */
};

/* A bob 21 cm above the sensor that swings by 5 cm in 0.75 s, and what else is said of it. */
#define BOB(...) ((struct truth){.amplitude = 5, .offset = 21, .period = 0.75, __VA_ARGS__})

struct synthetic {
    double *t, *y;
    struct series series;
};

static inline struct synthetic synthetic_make(const struct truth *truth)
{
    size_t n = (size_t)(truth->span * truth->rate) + 1;
    struct synthetic s = {.t = malloc(n * sizeof(double)), .y = malloc(n * sizeof(double))};
    if (!s.t || !s.y) {
        abort();
    }
    for (size_t i = 0; i < n; i++) {
        double t = (double)i / truth->rate, g = truth->gamma;
        double phi = fabs(g) > 1e-12 ? -expm1(-0.5 * g * t) * 2 / g : t;
        double envelope = truth->amplitude * exp(-0.5 * g * t) / (1 + truth->quadratic * phi);
        if (truth->sway > 0)
            envelope *= 1 + truth->sway *
                                cos(6.283185307179586 * t / truth->sway_period + truth->sway_phase);
        double y = truth->offset + truth->drift * t / truth->span +
                   envelope * cos(6.283185307179586 / truth->period * t + truth->phase);
        y = truth->clip > 0 ? fmin(y, truth->offset + truth->clip) : y;
        y += truth->noise * random_normal();
        y = truth->quantum > 0 ? nearbyint(y / truth->quantum) * truth->quantum : y;
        s.t[i] = truth->t0 + t;
        s.y[i] = random_uniform() < truth->dropouts ? 0 : y;
    }
    s.series = (struct series){.t = s.t, .y = s.y, .n = n, .quantity = QUANTITY_LENGTH};
    return s;
}

static inline void synthetic_free(struct synthetic *s)
{
    free(s->t);
    free(s->y);
}

static inline bool fit_named(const char *model, const struct series *series, struct fit *fit,
                             struct error *error)
{
    struct arena arena = {0};
    const struct fit_model *row = fit_model_by_name(text_of(model));
    bool ok = row && row->fit(series, &arena, NULL, fit, error);
    arena_reset(&arena);
    return ok;
}

static inline bool close_to(double a, double b, double tolerance)
{
    return fabs(a - b) <= tolerance;
}
