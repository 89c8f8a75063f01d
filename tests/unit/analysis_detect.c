/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What is an oscillation and what is not: synthetic recordings with a known truth. Things that do not oscillate are
 * never fitted as converged; clean oscillations are found with their period, whatever drifts.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "analysis_testing.h"

#define PI 3.14159265358979323846

static double of_random_size(double low, double high) /* log-uniform */
{
    return low * pow(high / low, random_uniform());
}

struct drawn {
    double *t, *y;
    size_t n;
    double span, period; /* [s] of the truth */
};

static struct drawn draw(size_t n, double rate)
{
    struct drawn d = {.t = malloc(n * sizeof(double)), .y = calloc(n, sizeof(double)), .n = n, .period = NAN};
    if (!d.t || !d.y)
        abort();
    for (size_t i = 0; i < n; i++)
        d.t[i] = (double)i / rate;
    d.span = d.t[n - 1];
    return d;
}

static void add_noise(struct drawn *d, double sigma)
{
    for (size_t i = 0; i < d->n; i++)
        d->y[i] += sigma * random_normal();
}

/* ---- what does not oscillate ---- */

static struct drawn bump(void)
{
    struct drawn d = draw(600, 50);
    const double at = random_between(0.2, 0.8) * d.span, width = random_between(0.03, 0.2) * d.span;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 5 * exp(-0.5 * pow((d.t[i] - at) / width, 2));
    add_noise(&d, of_random_size(0.005, 0.3));
    return d;
}

static struct drawn step(void)
{
    struct drawn d = draw(600, 50);
    const double at = random_between(0.2, 0.8) * d.span, width = of_random_size(0.001, 0.1) * d.span;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 5 * tanh((d.t[i] - at) / width);
    add_noise(&d, of_random_size(0.005, 0.3));
    return d;
}

static struct drawn noise(void)
{
    struct drawn d = draw((size_t)random_between(100, 3000), 50);
    add_noise(&d, 1);
    return d;
}

static struct drawn walk(void)
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

static struct drawn exponential(void)
{
    struct drawn d = draw(600, 50);
    const double tau = of_random_size(0.03, 1) * d.span;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 5 * exp(-d.t[i] / tau);
    add_noise(&d, of_random_size(0.005, 0.3));
    return d;
}

/* ---- what does ---- */

static struct drawn sine(double periods, double samples, double sigma)
{
    struct drawn d = draw((size_t)(periods * samples) + 1, 50);
    const double phase = random_between(-PI, PI);
    d.period = samples / 50;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 20 + 3 * cos(2 * PI * (double)i / samples + phase);
    add_noise(&d, sigma);
    return d;
}

static struct drawn few_samples(void)
{
    return sine(random_between(20, 300), random_between(2.05, 2.5), of_random_size(1e-3, 0.1));
}

static struct drawn many_samples(void)
{
    return sine(random_between(2.3, 100), of_random_size(4, 100), of_random_size(1e-3, 0.3));
}

/* 350 swings over which the period moves by some percent. */
static struct drawn drifting(void)
{
    struct drawn d = draw(13220, 20);
    const double change = random_between(-0.08, 0.08), phase = random_between(-PI, PI), swings = random_between(100, 350);
    d.period = d.span / swings;
    for (size_t i = 0; i < d.n; i++) {
        const double x = d.t[i] / d.span;
        d.y[i] = 3 * cos(2 * PI * swings * (x + change * (x * x - x)) + phase);
    }
    add_noise(&d, of_random_size(1e-3, 0.2));
    return d;
}

/* A few swings that friction ends, then rest. */
static struct drawn swings_then_rest(void)
{
    const double swings = random_between(4, 8), rest = random_between(0.3, 0.8), phase = random_between(-1, 1);
    struct drawn d = draw(2000, 50);
    const double moving = (1 - rest) * d.span;
    d.period = moving / swings;
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 10 + (d.t[i] < moving ? 4 * (1 - d.t[i] / moving) * cos(2 * PI * d.t[i] / d.period + phase) : 0);
    add_noise(&d, of_random_size(1e-3, 0.05));
    return d;
}

/* The baseline wanders by several amplitudes. */
static struct drawn wandering(void)
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
static struct drawn pulses(void)
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
static struct drawn strongly_damped(void)
{
    struct drawn d = draw(1000, 50);
    const double quality = random_between(2.5, 20), phase = random_between(-1, 1);
    d.period = d.span / random_between(5, 30);
    for (size_t i = 0; i < d.n; i++)
        d.y[i] = 3 * exp(-PI * d.t[i] / d.period / quality) * cos(2 * PI * d.t[i] / d.period + phase);
    add_noise(&d, of_random_size(1e-3, 0.03));
    return d;
}

/* Steps of 1 cm under a swing of a few centimetres: that is not clipping. */
static struct drawn in_coarse_steps(void)
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

static const struct kind still[] = {
    {"bump", bump}, {"step", step}, {"noise", noise}, {"random walk", walk}, {"exponential", exponential}};
static const struct kind moving[] = {{"2.05 to 2.5 samples a period", few_samples},
                                     {"4 to 100 samples a period", many_samples},
                                     {"drifting frequency", drifting},
                                     {"swings, then rest", swings_then_rest},
                                     {"drifting baseline", wandering},
                                     {"strong harmonics", pulses},
                                     {"strong damping", strongly_damped},
                                     {"coarse steps", in_coarse_steps}};

static int runs(void)
{
    const char *given = getenv("LONG");
    return given && *given ? 60 : 10;
}

static void what_does_not_oscillate_is_refused(void **state)
{
    (void)state;
    int fitted = 0;
    random_state = 61;
    for (size_t k = 0; k < COUNT_OF(still); k++) {
        int here = 0;
        for (int run = 0; run < runs(); run++) {
            struct drawn d = still[k].draw();
            const struct series series = {.t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
            struct fit fit;
            struct period period;
            struct arena arena = {0};
            struct error error = {0}, other = {0};
            const bool fitted_so = fit_named("damped", &series, &fit, &error);
            const bool measured_so = series_period(&series, &arena, &period, &other);
            here += fitted_so || measured_so;
            if (!fitted_so)
                assert_true(error.text[0] != 0);
            if (measured_so)
                print_message("%s has a period of %g s by %s\n", still[k].name, period.period.value, period.how);
            arena_reset(&arena);
            free(d.t);
            free(d.y);
        }
        if (here > 0)
            print_message("%s: %d of %d fitted as an oscillation\n", still[k].name, here, runs());
        fitted += here;
    }
    assert_int_equal(fitted, 0);
}

static void every_clean_oscillation_is_found(void **state)
{
    (void)state;
    int missed = 0, all = 0;
    random_state = 62;
    for (size_t k = 0; k < COUNT_OF(moving); k++) {
        int here = 0;
        char reason[200] = "";
        for (int run = 0; run < runs(); run++) {
            struct drawn d = moving[k].draw();
            const struct series series = {.t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
            struct arena arena = {0};
            struct overview o;
            series_overview(&series, &arena, &o);
            const bool found = o.oscillates && fabs(o.period / d.period - 1) < 0.03;
            if (!found)
                snprintf(reason, sizeof reason, "T %g for %g (%zu samples, %g periods), %.120s", o.period, d.period, d.n,
                         d.span / d.period, o.oscillates ? "" : o.reason);
            here += !found;
            all++;
            arena_reset(&arena);
            free(d.t);
            free(d.y);
        }
        if (here > 0)
            print_message("%s: %d of %d not found, the last: %s\n", moving[k].name, here, runs(), reason);
        missed += here;
    }
    print_message("%d of %d oscillations missed\n", missed, all);
    assert_true(50 * missed <= all);
}

/* A fit that uses less than four fifths of the samples says so instead of "converged". */
static void no_fit_that_discards_much_is_called_converged(void **state)
{
    (void)state;
    random_state = 63;
    for (size_t k = 0; k < COUNT_OF(moving); k++)
        for (int run = 0; run < runs() / 4; run++) {
            struct drawn d = moving[k].draw();
            const struct series series = {.t = d.t, .y = d.y, .n = d.n, .quantity = QUANTITY_LENGTH};
            struct fit fit;
            struct error error = {0};
            if (fit_named("damped", &series, &fit, &error) && fit.converged && 5 * fit.rejected > d.n)
                fail_msg("%s: %zu of %zu rejected, converged", moving[k].name, fit.rejected, d.n);
            free(d.t);
            free(d.y);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_does_not_oscillate_is_refused),
                                       cmocka_unit_test(every_clean_oscillation_is_found),
                                       cmocka_unit_test(no_fit_that_discards_much_is_called_converged)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
