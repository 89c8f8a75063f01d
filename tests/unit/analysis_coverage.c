/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What the uncertainty of 'measure period' is worth: 95 % intervals cover the truth in 90 to 99 % of the recordings of
 * each kind, or a warning says that one number for the whole is doubtful.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include <cmocka.h>

#include "analysis_testing.h"

#define PI 3.14159265358979323846

struct recorded {
    double *t, *y;
    size_t n;
    double span, period;
};

static void white(struct recorded *r, double amplitude)
{
    const double sigma = amplitude * random_between(0.005, 0.1);
    for (size_t i = 0; i < r->n; i++)
        r->y[i] += sigma * random_normal();
}

static void quantised(struct recorded *r, double amplitude)
{
    (void)amplitude;
    white(r, 0.02);
    for (size_t i = 0; i < r->n; i++)
        r->y[i] = nearbyint(r->y[i] * 10) / 10; /* 1 mm, in cm */
}

static void walking_baseline(struct recorded *r, double amplitude)
{
    double at = 0;
    for (size_t i = 0; i < r->n; i++)
        r->y[i] += at += 0.01 * amplitude * random_normal();
    white(r, 0.2 * amplitude);
}

static void bent_baseline(struct recorded *r, double amplitude)
{
    const double bend = amplitude * random_between(-4, 4), slope = amplitude * random_between(-3, 3);
    for (size_t i = 0; i < r->n; i++) {
        const double x = r->t[i] / r->span;
        r->y[i] += slope * x + bend * x * x;
    }
    white(r, 0.2 * amplitude);
}

static void gaps(struct recorded *r, double amplitude)
{
    size_t n = 0;
    const double from = random_between(0.2, 0.5) * r->span, to = from + random_between(0.05, 0.3) * r->span;
    white(r, amplitude);
    for (size_t i = 0; i < r->n; i++)
        if ((r->t[i] < from || r->t[i] > to) && random_uniform() > 0.1) {
            r->t[n] = r->t[i];
            r->y[n++] = r->y[i];
        }
    r->n = n;
}

static void jitter(struct recorded *r, double amplitude)
{
    white(r, 0.1 * amplitude);
    for (size_t i = 0; i < r->n; i++)
        r->t[i] += 0.2 * (r->t[1] - r->t[0]) * (random_uniform() - 0.5);
}

static void heavy_tails(struct recorded *r, double amplitude)
{
    for (size_t i = 0; i < r->n; i++) /* Student, 2 degrees of freedom */
        r->y[i] += 0.02 * amplitude * random_normal() / sqrt(-log(1 - random_uniform()));
}

static void autoregressive(struct recorded *r, double amplitude)
{
    double at = 0;
    for (size_t i = 0; i < r->n; i++)
        r->y[i] += at = 0.9 * at + 0.02 * amplitude * random_normal();
}

static double slowly_decaying(double t, double period, double span)
{
    (void)period;
    return exp(-0.7 * t / span);
}

enum shape { DECAYING, SHORT, DAMPED, CHIRP, BEATS, COULOMB };

static struct recorded make(enum shape shape, double amplitude)
{
    const double periods = shape == SHORT ? 2.3 : shape == DAMPED ? random_between(5, 20) : random_between(8, 80);
    const double samples = random_between(15, 60), phase = random_between(-PI, PI);
    const size_t n = (size_t)(periods * samples) + 1;
    struct recorded r = {.t = malloc(n * sizeof(double)), .y = malloc(n * sizeof(double)), .n = n};
    if (!r.t || !r.y)
        abort();
    r.period = samples * 0.01;
    r.span = (double)(n - 1) * 0.01;
    const double quality = 1.5 * pow(200, random_uniform()), change = random_between(0.01, 0.05);
    const double apart = random_between(2, 5) / periods;
    for (size_t i = 0; i < n; i++) {
        const double t = 0.01 * (double)i, x = t / r.period, angle = 2 * PI * x + phase;
        const double first = cos(angle);
        r.t[i] = t;
        r.y[i] = 20 + amplitude * (shape == DECAYING ? slowly_decaying(t, r.period, r.span) * first
                                   : shape == SHORT  ? first
                                   : shape == DAMPED ? exp(-PI * x / quality) * first
                                   : shape == CHIRP
                                       ? cos(angle + 2 * PI * change * periods * (x / periods) * (x / periods - 1))
                                   : shape == BEATS ? first + 0.8 * cos(angle * (1 + apart))
                                                    : fmax(1 - 1.1 * t / r.span, 0) * first);
    }
    return r;
}

struct disturbance {
    const char *name;
    enum shape shape;
    void (*disturb)(struct recorded *r, double amplitude);
};

static const struct disturbance rows[] = {{"white noise", DECAYING, white},
                                  {"1 mm steps", DECAYING, quantised},
                                  {"random-walk baseline", DECAYING, walking_baseline},
                                  {"quadratic baseline", DECAYING, bent_baseline},
                                  {"gaps", DECAYING, gaps},
                                  {"jitter", DECAYING, jitter},
                                  {"Student t, 2 degrees", DECAYING, heavy_tails},
                                  {"AR(1)", DECAYING, autoregressive},
                                  {"2.3 periods", SHORT, white},
                                  {"Q 1.5 to 300", DAMPED, white},
                                  {"chirp", CHIRP, white},
                                  {"beats", BEATS, white},
                                  {"Coulomb friction", COULOMB, white}};

static bool is_long(void)
{
    const char *given = getenv("LONG");
    return given && *given;
}

static void intervals_cover_or_a_warning_says_why_not(void **state)
{
    (void)state;
    const int runs = is_long() ? 120 : 24;
    bool all_well = true;
    random_state = 71;
    for (size_t k = 0; k < COUNT_OF(rows); k++) {
        int covered = 0, warned = 0, refused = 0;
        double worst = 0;
        for (int run = 0; run < runs; run++) {
            const double amplitude = random_between(2, 6);
            struct recorded r = make(rows[k].shape, amplitude);
            rows[k].disturb(&r, amplitude);
            const struct series series = {.t = r.t, .y = r.y, .n = r.n, .quantity = QUANTITY_LENGTH};
            struct arena arena = {0};
            struct error error = {0};
            struct period p = {.how = ""};
            if (!series_period(&series, &arena, &p, &error)) {
                refused++;
                if (getenv("SHOW"))
                    print_message("%s\n", error.text);
            } else if (p.warning[0]) {
                warned++;
            } else {
                const double off = fabs(p.period.value - r.period) / p.period.uncertainty;
                covered += off <= 1.96;
                worst = fmax(worst, off);
                if (off > 4 && getenv("SHOW"))
                    print_message("T %g %g: %.1f sigma, %s, %zu %g periods\n", p.period.value, r.period, off, p.how,
                                  r.n, r.span / r.period);
            }
            arena_reset(&arena);
            free(r.t);
            free(r.y);
        }
        const int judged = runs - warned - refused;
        print_message("%-22s %3d of %3d covered (%3.0f %%), %3d warned, %d refused, worst %.1f sigma\n", rows[k].name,
                      covered, judged, judged ? 100.0 * covered / judged : 100.0, warned, refused, worst);
        const double chance = 3 * sqrt(0.95 * 0.05 * judged);
        all_well = all_well && covered >= 0.9 * judged - (is_long() ? 0 : chance) && 5 * refused <= runs;
    }
    assert_true(all_well);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(intervals_cover_or_a_warning_says_why_not)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
