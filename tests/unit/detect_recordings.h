/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Recordings that oscillate and recordings that do not, drawn at random. Included after <cmocka.h>.
 */
#pragma once

#include "modules/recording/analysis/testing.h"

#define PI 3.14159265358979323846

static inline double of_random_size(double low, double high) /* log-uniform */
{
    return low * pow(high / low, random_uniform());
}

struct drawn {
    double *t, *y;
    size_t n;
    double span, period; /* [s] of the truth */
};

static inline struct drawn draw(size_t n, double rate)
{
    struct drawn d = {
        .t = malloc(n * sizeof(double)), .y = calloc(n, sizeof(double)), .n = n, .period = NAN};
    if (!d.t || !d.y)
        abort();
    for (size_t i = 0; i < n; i++)
        d.t[i] = (double)i / rate;
    d.span = (double)(n - 1) / rate;
    return d;
}

static inline void add_noise(struct drawn *d, double sigma)
{
    for (size_t i = 0; i < d->n; i++)
        d->y[i] += sigma * random_normal();
}

/* ---- what does not oscillate ---- */

static inline struct drawn bump(void)
{
    struct drawn d = draw(600, 50);
    const double at = random_between(0.2, 0.8) * d.span, width = random_between(0.03, 0.2) * d.span;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 5 * exp(-0.5 * pow((d.t[i] - at) / width, 2));
    add_noise(&d, of_random_size(0.005, 0.3));
    return d;
}

static inline struct drawn step(void)
{
    struct drawn d = draw(600, 50);
    const double at = random_between(0.2, 0.8) * d.span,
                 width = of_random_size(0.001, 0.1) * d.span;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 5 * tanh((d.t[i] - at) / width);
    add_noise(&d, of_random_size(0.005, 0.3));
    return d;
}

static inline struct drawn noise(void)
{
    struct drawn d = draw((size_t)random_between(100, 3000), 50);
    add_noise(&d, 1);
    return d;
}

static inline struct drawn walk(void)
{
    struct drawn d = draw((size_t)random_between(100, 3000), 50);
    const double jitter = random_between(0, 1);
    double at = 0;
    for (size_t i = 0; i < d.n; i++) {
        at += random_normal();
        d.y[i] = at;
    }
    add_noise(&d, jitter);
    return d;
}

static inline struct drawn exponential(void)
{
    struct drawn d = draw(600, 50);
    const double tau = of_random_size(0.03, 1) * d.span;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 5 * exp(-d.t[i] / tau);
    add_noise(&d, of_random_size(0.005, 0.3));
    return d;
}

/* ---- what does ---- */

static inline struct drawn sine(double periods, double samples, double sigma)
{
    struct drawn d = draw((size_t)(periods * samples) + 1, 50);
    const double phase = random_between(-PI, PI);
    d.period = samples / 50;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 20 + 3 * cos(2 * PI * (double)i / samples + phase);
    add_noise(&d, sigma);
    return d;
}

static inline struct drawn few_samples(void)
{
    return sine(random_between(20, 300), random_between(2.05, 2.5), of_random_size(1e-3, 0.1));
}

static inline struct drawn many_samples(void)
{
    return sine(random_between(2.3, 100), of_random_size(4, 100), of_random_size(1e-3, 0.3));
}

/* 350 swings over which the period moves by some percent. */
static inline struct drawn drifting(void)
{
    struct drawn d = draw(13220, 20);
    const double change = random_between(-0.08, 0.08), phase = random_between(-PI, PI),
                 swings = random_between(100, 350);
    d.period = d.span / swings;
    for (size_t i = 0; i < d.n; i++) {
        const double x = d.t[i] / d.span;
        d.y[i] = 3 * cos(2 * PI * swings * (x + change * (x * x - x)) + phase);
    }
    add_noise(&d, of_random_size(1e-3, 0.2));
    return d;
}

/* A few swings that friction ends, then rest. */
static inline struct drawn swings_then_rest(void)
{
    const double swings = random_between(4, 8), rest = random_between(0.3, 0.8),
                 phase = random_between(-1, 1);
    struct drawn d = draw(2000, 50);
    const double moving = (1 - rest) * d.span;
    d.period = moving / swings;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 10 + (d.t[i] < moving
                           ? 4 * (1 - d.t[i] / moving) * cos(2 * PI * d.t[i] / d.period + phase)
                           : 0);
    add_noise(&d, of_random_size(1e-3, 0.05));
    return d;
}

/* The baseline wanders by several amplitudes. */
static inline struct drawn wandering(void)
{
    struct drawn d = sine(random_between(8, 60), of_random_size(6, 40), of_random_size(1e-3, 0.1));
    const double bend = random_between(-12, 12), slope = random_between(-10, 10);
    for (size_t i = 0; i < d.n; i++) {
        const double x = d.t[i] / d.span;
        d.y[i] += slope * x + bend * x * x;
    }
    return d;
}

/* Pulses: strong harmonics. */
static inline struct drawn pulses(void)
{
    struct drawn d = draw(2000, 50);
    const double sharp = random_between(1, 6), phase = random_between(-PI, PI);
    d.period = d.span / random_between(5, 40);
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = exp(sharp * (cos(2 * PI * d.t[i] / d.period + phase) - 1));
    add_noise(&d, of_random_size(1e-3, 0.03));
    return d;
}

/* Decays in one to five periods, some of it rest. */
static inline struct drawn strongly_damped(void)
{
    struct drawn d = draw(1000, 50);
    const double quality = random_between(2.5, 20), phase = random_between(-1, 1);
    d.period = d.span / random_between(5, 30);
    for (size_t i = 0; i < d.n; i++)
        d.y[i] =
            3 * exp(-PI * d.t[i] / d.period / quality) * cos(2 * PI * d.t[i] / d.period + phase);
    add_noise(&d, of_random_size(1e-3, 0.03));
    return d;
}

/* Steps of 1 cm under a swing of a few centimetres: that is not clipping. */
static inline struct drawn in_coarse_steps(void)
{
    struct drawn d = sine(random_between(20, 200), random_between(10, 60), 0.1);
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = nearbyint(d.y[i]);
    return d;
}

/* ---- the judgement ---- */

struct kind {
    const char *name;
    struct drawn (*draw)(void);
};

static const struct kind still[] = {{"bump", bump},
                                    {"step", step},
                                    {"noise", noise},
                                    {"random walk", walk},
                                    {"exponential", exponential}};
static const struct kind moving[] = {{"2.05 to 2.5 samples a period", few_samples},
                                     {"4 to 100 samples a period", many_samples},
                                     {"drifting frequency", drifting},
                                     {"swings, then rest", swings_then_rest},
                                     {"drifting baseline", wandering},
                                     {"strong harmonics", pulses},
                                     {"strong damping", strongly_damped},
                                     {"coarse steps", in_coarse_steps}};
