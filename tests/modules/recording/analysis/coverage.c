/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What the uncertainties of 'measure period' and of 'fit' are worth: 95 % intervals cover the truth
 * in 90 to 99 % of the recordings of each kind, or a warning says that one number for the whole is
 * doubtful.
 */
#include <stdio.h>
#include <string.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/analysis/testing.h"

#define PI 3.14159265358979323846

struct recorded {
    double *t, *y;
    size_t n;
    double span, period;   /* [s] */
    double gamma, quality; /* [1/s] of the truth, which Coulomb friction and beats do not have */
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
    /* 1 mm, in cm */
    for (size_t i = 0; i < r->n; i++)
        r->y[i] = nearbyint(r->y[i] * 10) / 10;
}

static void coarsely_quantised(struct recorded *r, double amplitude)
{
    (void)amplitude;
    white(r, 0.5);
    /* 3 mm, in cm */
    for (size_t i = 0; i < r->n; i++)
        r->y[i] = nearbyint(r->y[i] / 0.3) * 0.3;
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
    const double bend = amplitude * random_between(-4, 4),
                 slope = amplitude * random_between(-3, 3);
    for (size_t i = 0; i < r->n; i++) {
        const double x = r->t[i] / r->span;
        r->y[i] += slope * x + bend * x * x;
    }
    white(r, 0.2 * amplitude);
}

static void gaps(struct recorded *r, double amplitude)
{
    size_t n = 0;
    const double from = random_between(0.2, 0.5) * r->span,
                 to = from + random_between(0.05, 0.3) * r->span;
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

/* Dry friction alone, x periods from a turning point at 1: half swings about +-d, until it sticks.
 */
static double under_dry_friction(double x, double d)
{
    /* swings, while the amplitude exceeds d */
    const int half = (int)fmin(2 * x, 0.5 * (1 / d - 1) + 1);
    const double sign = half % 2 ? -1 : 1, from = 1 - 2 * d * half;
    return from > d ? sign * (d + (from - d) * cos(PI * (2 * x - half))) : sign * from;
}

enum shape { DECAYING, SHORT, DAMPED, CHIRP, BEATS, COULOMB };

static struct recorded make(enum shape shape, double amplitude)
{
    const double periods = shape == SHORT    ? 2.3
                           : shape == DAMPED ? random_between(5, 20)
                                             : random_between(8, 80);
    const double samples = random_between(15, 60), phase = random_between(-PI, PI);
    const size_t n = (size_t)(periods * samples) + 1;
    struct recorded r = {.t = malloc(n * sizeof(double)), .y = malloc(n * sizeof(double)), .n = n};
    if (!r.t || !r.y)
        abort();
    r.period = samples * 0.01;
    r.span = (double)(n - 1) * 0.01;
    const double quality = 1.5 * pow(200, random_uniform()), change = random_between(0.01, 0.05);
    const double apart = random_between(2, 5) / periods;
    r.quality = shape == DAMPED ? quality : INFINITY;
    r.gamma = shape == DECAYING ? 1.4 / r.span : shape == DAMPED ? 2 * PI / quality / r.period : 0;
    for (size_t i = 0; i < n; i++) {
        const double t = 0.01 * (double)i, x = t / r.period, angle = 2 * PI * x + phase;
        const double first = cos(angle);
        r.t[i] = t;
        r.y[i] = 20 + amplitude *
                          (shape == DECAYING ? slowly_decaying(t, r.period, r.span) * first
                           : shape == SHORT  ? first
                           : shape == DAMPED ? exp(-PI * x / quality) * first
                           : shape == CHIRP  ? cos(angle + 2 * PI * change * periods *
                                                               (x / periods) * (x / periods - 1))
                           : shape == BEATS
                               ? first + 0.8 * cos(angle * (1 + apart))
                               : under_dry_friction(x + (phase + PI) / (2 * PI), 0.25 / periods));
    }
    return r;
}

struct disturbance {
    const char *name;
    enum shape shape;
    void (*disturb)(struct recorded *r, double amplitude);
    bool may_refuse; /* no single damped sine may be near it */
};

static const struct disturbance rows[] = {
    {"white noise", DECAYING, white, false},
    {"1 mm steps", DECAYING, quantised, false},
    {"3 mm steps", DECAYING, coarsely_quantised, false},
    {"random-walk baseline", DECAYING, walking_baseline, false},
    {"quadratic baseline", DECAYING, bent_baseline, true},
    {"gaps", DECAYING, gaps, false},
    {"jitter", DECAYING, jitter, false},
    {"Student t, 2 degrees", DECAYING, heavy_tails, false},
    {"AR(1)", DECAYING, autoregressive, false},
    {"2.3 periods", SHORT, white, false},
    {"Q 1.5 to 300", DAMPED, white, false},
    {"chirp", CHIRP, white, true},
    {"beats", BEATS, white, true},
    {"Coulomb friction", COULOMB, white, false}};

/* What one recording gave: the difference from the truth in standard deviations, NAN where nothing
 * is to be judged. */
enum outcome { JUDGED, WARNED, REFUSED };

struct verdict {
    enum outcome outcome;
    double off;
    char text[240];
};

struct tally {
    int covered, warned, refused, judged;
    double worst;
};

static void count_verdict(struct tally *tally, const struct verdict *v)
{
    tally->warned += v->outcome == WARNED;
    tally->refused += v->outcome == REFUSED;
    if (v->outcome == JUDGED) {
        tally->judged++;
        tally->covered += v->off <= 1.96;
        tally->worst = fmax(tally->worst, v->off);
    }
    if (getenv("SHOW") && (v->outcome != JUDGED || v->off > 3))
        print_message("  %.1f sigma %s\n", v->off, v->text);
}

static struct verdict measured_period(const struct series *series, const struct recorded *r)
{
    struct arena arena = {0};
    struct error error = {0};
    struct period p = {.how = ""};
    struct verdict v = {.outcome = JUDGED};
    if (!series_period(series, &arena, &p, &error)) {
        v.outcome = REFUSED;
        snprintf(v.text, sizeof v.text, "%.200s", error.text);
    } else {
        v.outcome = p.warning[0] ? WARNED : JUDGED;
        v.off = fabs(p.period.value - r->period) / p.period.uncertainty;
        snprintf(v.text, sizeof v.text,
                 "T %g +- %g for %g, %.20s, %zu samples %g periods Q %g: %.80s", p.period.value,
                 p.period.uncertainty, r->period, p.how, r->n, r->span / r->period, r->quality,
                 p.warning);
    }
    arena_reset(&arena);
    return v;
}

/* Warnings that only count samples say nothing of the intervals. */
static bool doubts(const struct fit *fit, char *text, size_t size)
{
    for (int i = 0; i < fit->warnings; i++)
        if (!strstr(fit->warning[i], "rejected") && !strstr(fit->warning[i], "a straight line") &&
            !strstr(fit->warning[i], "poorly separated")) {
            snprintf(text, size, "%s", fit->warning[i]);
            return true;
        }
    return false;
}

static struct verdict fitted(const struct series *series, const struct recorded *r, bool gamma)
{
    struct error error = {0};
    struct fit fit;
    struct verdict v = {.outcome = JUDGED};
    if (!fit_named("damped", series, &fit, &error)) {
        v.outcome = REFUSED;
        snprintf(v.text, sizeof v.text, "%.200s", error.text);
        return v;
    }
    const struct measured *x = gamma ? &fit.gamma : &fit.period;
    const double truth = gamma ? r->gamma : r->period;
    char warning[200] = "";
    v.outcome = doubts(&fit, warning, sizeof warning) ? WARNED : JUDGED;
    v.off = fabs(x->value - truth) / x->uncertainty;
    snprintf(v.text, sizeof v.text, "%s %g +- %g for %g, %zu samples %g periods Q %g: %.100s",
             gamma ? "gamma" : "T", x->value, x->uncertainty, truth, r->n, r->span / r->period,
             r->quality, warning);
    return v;
}

static struct verdict fitted_period(const struct series *series, const struct recorded *r)
{
    return fitted(series, r, false);
}

static struct verdict fitted_gamma(const struct series *series, const struct recorded *r)
{
    return fitted(series, r, true);
}

static bool cover_or_warn(struct verdict (*measure)(const struct series *series,
                                                    const struct recorded *r))
{
    const int runs = is_long() ? 120 : 8;
    bool all_well = true;
    random_state = 71;
    for (size_t k = 0; k < COUNT_OF(rows); k++) {
        struct tally tally = {0};
        for (int run = 0; run < runs; run++) {
            const double amplitude = random_between(2, 6);
            struct recorded r = make(rows[k].shape, amplitude);
            rows[k].disturb(&r, amplitude);
            const struct series series = {
                .t = r.t, .y = r.y, .n = r.n, .quantity = QUANTITY_LENGTH};
            const struct verdict v = measure(&series, &r);
            count_verdict(&tally, &v);
            free(r.t);
            free(r.y);
        }
        const int judged = tally.judged;
        print_message(
            "%-22s %3d of %3d covered (%3.0f %%), %3d warned, %d refused, worst %.1f sigma\n",
            rows[k].name, tally.covered, judged, judged ? 100.0 * tally.covered / judged : 100.0,
            tally.warned, tally.refused, tally.worst);
        const double chance = 3 * sqrt(0.95 * 0.05 * judged);
        all_well = all_well && tally.covered >= 0.9 * judged - (is_long() ? 0 : chance) &&
                   tally.worst < 6 && 20 * tally.refused <= (rows[k].may_refuse ? 4 * runs : runs);
    }
    return all_well;
}

TEST(measured_periods_cover_or_warn)
{
    assert_true(cover_or_warn(measured_period));
}

TEST(fitted_periods_cover_or_warn)
{
    assert_true(cover_or_warn(fitted_period));
}

TEST(fitted_dampings_cover_or_warn)
{
    assert_true(cover_or_warn(fitted_gamma));
}

/* Of positions with noise, or rounded to 3 mm, and of velocities from them: without what the noise
 * adds, 68 of 100. */
TEST(energy_decay_covers_the_truth)
{
    random_state = 27;
    for (int rounded = 0; rounded < 2; rounded++) {
        int inside = 0;
        for (int run = 0; run < 100; run++) {
            const double omega = 6.28318530717958647692 / random_between(0.5, 1.5);
            struct truth truth = {.amplitude = random_between(0.04, 0.12),
                                  .period = 6.28318530717958647692 / omega,
                                  .gamma = omega / random_between(15, 200),
                                  .rate = 100,
                                  .span = random_between(8, 25) * 6.28318530717958647692 / omega,
                                  .noise = rounded ? 2e-4 : 2e-3,
                                  .phase = random_between(-3, 3)};
            struct synthetic s = synthetic_make(&truth);
            struct arena arena = {0};
            struct derivative v;
            struct decay decay;
            struct error error = {0};
            for (size_t i = 0; rounded && i < s.series.n; i++)
                s.y[i] = round(s.y[i] / 3e-3) * 3e-3;
            assert_true(series_derivative(&s.series, DERIVATIVE_POINTS, &arena, &v, &error));
            const double sigma = series_noise(&s.series, &arena), k = omega * omega;
            const struct energy_noise noise = {0.5 * sigma * sigma * (k + v.gain * v.gain),
                                               2 * sigma * sqrt(k)};
            for (size_t i = 0; i < s.series.n; i++)
                s.y[i] = 0.5 * (v.value[i] * v.value[i] + k * s.y[i] * s.y[i]);
            s.series.quantity = QUANTITY_ENERGY;
            assert_true(series_decay(&s.series, &arena, &noise, 0, &decay, &error));
            inside += close_to(decay.gamma.value, truth.gamma, 1.96 * decay.gamma.uncertainty);
            arena_reset(&arena);
            synthetic_free(&s);
        }
        assert_in_range(inside, 90, 100);
    }
}

RUN_TESTS(NULL, NULL)
