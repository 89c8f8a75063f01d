/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * What the uncertainties of single readings are worth: the period by the autocorrelation, the
 * amplitude at a time, the lines of a spectrum, of recordings whose truth is known.
 */
#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/analysis/testing.h"

#define TWO_PI 6.283185307179586

struct coverage {
    int judged, covered;
    double worst, square;
};

static void count_value(struct coverage *c, struct measured value, double truth)
{
    const double off = fabs(value.value - truth) / value.uncertainty;
    c->judged++;
    c->covered += off <= 1.96;
    c->worst = fmax(c->worst, off);
    c->square += off * off;
}

static void print_coverage(const char *of, const struct coverage *c)
{
    print_message("%s: %d of %d covered, rms %.2f, worst %.2f\n", of, c->covered, c->judged,
                  sqrt(c->square / c->judged), c->worst);
}

static struct truth random_truth(double decay)
{
    struct truth truth = {.amplitude = random_between(2, 6),
                          .offset = 20,
                          .period = random_between(0.5, 1.5),
                          .rate = random_between(20, 120),
                          .span = random_between(8, 40),
                          .noise = random_between(0.005, 0.15),
                          .phase = random_between(-3, 3)};
    truth.gamma = decay / truth.span;
    return truth;
}

TEST(periods_by_the_autocorrelation_cover_the_truth)
{
    const int runs = is_long() ? 1000 : 120;
    random_state = 81;
    for (int kind = 0; kind < 3; kind++) {
        struct coverage of = {0};
        for (int run = 0; run < runs; run++) {
            struct truth truth = random_truth(kind == 0 ? 0 : random_between(0.2, 4));
            truth.quadratic = kind == 2 ? 3 / truth.span : 0;
            struct synthetic s = synthetic_make(&truth);
            struct arena arena = {0};
            struct error error = {0};
            struct period p;
            struct measured alike;
            if (series_period(&s.series, &arena, &p, &error) &&
                series_correlation_period(&s.series, &p, &arena, &alike))
                count_value(&of, alike, truth.period);
            arena_reset(&arena);
            synthetic_free(&s);
        }
        print_coverage(kind == 0 ? "undamped" : kind == 1 ? "damped" : "quadratic drag", &of);
        assert_true(of.judged >= 0.97 * runs);
        assert_true(of.covered >= 0.89 * of.judged && of.worst < 5);
    }
}

/* Exact amplitude at time t of the generator's envelope. */
static double true_amplitude(const struct truth *truth, double t)
{
    const double phi =
        truth->gamma > 1e-12 ? -expm1(-0.5 * truth->gamma * t) * 2 / truth->gamma : t;
    return truth->amplitude * exp(-0.5 * truth->gamma * t) / (1 + truth->quadratic * phi);
}

TEST(amplitudes_cover_the_truth)
{
    const int runs = is_long() ? 600 : 80;
    random_state = 82;
    for (int kind = 0; kind < 2; kind++) {
        struct coverage of[3] = {{0}};
        for (int run = 0; run < runs; run++) {
            struct truth truth = random_truth(random_between(0.2, 2));
            truth.quadratic = kind == 1 ? random_between(1, 8) / truth.span : 0;
            struct synthetic s = synthetic_make(&truth);
            struct arena arena = {0};
            struct error error = {0};
            struct reading reading[3];
            const double end = s.t[s.series.n - 1],
                         at[3] = {0, random_between(0.2, 0.8) * end, end};
            if (series_amplitudes(&s.series, &arena, at, 3, 0, reading, &error))
                for (int i = 0; i < 3; i++)
                    count_value(&of[i], reading[i].amplitude, true_amplitude(&truth, at[i]));
            arena_reset(&arena);
            synthetic_free(&s);
        }
        for (int i = 0; i < 3; i++) {
            print_coverage(i == 0 ? "start" : i == 1 ? "inside" : "end", &of[i]);
            assert_true(of[i].judged >= 0.95 * runs);
            assert_true(of[i].covered >= 0.85 * of[i].judged && of[i].worst < 5.5);
        }
    }
}

/* Within a window of two periods out of four, an envelope under quadratic drag bends by much more
 * than the noise. */
TEST(amplitudes_of_bent_envelopes_are_wider)
{
    const int runs = is_long() ? 600 : 80;
    struct coverage of = {0}, periods = {0};
    random_state = 86;
    for (int run = 0; run < runs; run++) {
        struct truth truth = random_truth(0);
        truth.span = truth.period * random_between(3.5, 6);
        truth.rate = random_between(50, 150);
        truth.quadratic = random_between(1, 6) / truth.span;
        struct synthetic s = synthetic_make(&truth);
        struct arena arena = {0};
        struct error error = {0};
        struct reading reading;
        const double at = random_between(0.3, 0.7) * truth.span;
        if (series_amplitudes(&s.series, &arena, &at, 1, 0, &reading, &error))
            count_value(&of, reading.amplitude, true_amplitude(&truth, at));
        struct period p;
        if (series_period(&s.series, &arena, &p, &error))
            count_value(&periods, p.period, truth.period);
        arena_reset(&arena);
        synthetic_free(&s);
    }
    print_coverage("bent envelopes", &of);
    print_coverage("their periods", &periods);
    assert_true(periods.judged >= 0.9 * runs && periods.covered >= 0.85 * periods.judged &&
                periods.worst < 5);
    assert_true(of.judged >= 0.9 * runs && of.covered >= 0.85 * of.judged && of.worst < 7);
}

/* Covered, and no more uncertain than the noise makes it: for a tone that decays as exp(-gamma t/2)
 * the bound is some times that of a steady one. */
TEST(lines_of_spectra_cover_the_truth)
{
    const int runs = is_long() ? 600 : 80;
    random_state = 83;
    for (int kind = 0; kind < 2; kind++) {
        struct coverage of = {0};
        double widest = 0;
        for (int run = 0; run < runs; run++) {
            struct truth truth = random_truth(kind ? random_between(0.3, 6) : 0);
            struct synthetic s = synthetic_make(&truth);
            struct arena arena = {0};
            struct spectrum_peak peak[3];
            const double n = (double)s.series.n,
                         a = truth.amplitude * exp(-0.25 * truth.gamma * truth.span),
                         bound = sqrt(24 / n) * truth.noise / (TWO_PI * a * truth.span);
            if (series_peaks(&s.series, &arena, peak, 3) > 0) {
                count_value(&of, peak[0].frequency, 1 / truth.period);
                widest = fmax(widest, peak[0].frequency.uncertainty / bound);
            }
            arena_reset(&arena);
            synthetic_free(&s);
        }
        print_coverage(kind ? "decaying lines" : "steady lines", &of);
        print_message("at most %.1f times the bound of a steady tone\n", widest);
        assert_true(of.judged == runs && of.covered >= 0.89 * runs && of.worst < 5);
        assert_true(widest < 3);
    }
}

/* 1/gamma of a gamma that may be 0 is not a number with an uncertainty, but more than something. */
TEST(reciprocals_of_what_may_be_zero_have_a_bound)
{
    double least;
    struct measured tau = measured_reciprocal(2, (struct measured){0.05, 0.001}, &least);
    assert_true(close_to(tau.value, 40, 1e-9) && close_to(tau.uncertainty, 0.8, 1e-9));
    assert_true(isnan(least));
    tau = measured_reciprocal(2, (struct measured){0.001, 0.012}, &least);
    assert_true(isnan(tau.value) && close_to(least, 80, 1e-9));
    tau = measured_reciprocal(2, (struct measured){0, 0.0125}, &least);
    assert_true(isnan(tau.value) && close_to(least, 80, 1e-9));
    tau = measured_reciprocal(2, (struct measured){-1, 0.01}, &least);
    assert_true(isnan(tau.value) && isnan(least));
}

/* A simulation of one period: the interpolation between its samples is all that is uncertain. */
TEST(one_clean_period_is_as_good_as_its_interpolation)
{
    random_state = 84;
    for (int run = 0; run < 60; run++) {
        struct truth truth = {.amplitude = 1,
                              .period = 1,
                              .phase = random_between(-3, 3),
                              .rate = random_between(12, 200),
                              .span = random_between(2.05, 2.9)};
        struct synthetic s = synthetic_make(&truth);
        struct arena arena = {0};
        struct error error = {0};
        struct period p;
        assert_true(series_period(&s.series, &arena, &p, &error));
        const double off = fabs(p.period.value - 1);
        if (!(off < 6 * p.period.uncertainty + 3e-15) || p.period.uncertainty > 3e-4)
            fail_msg("T off by %g, stated %g, %g samples a period", off, p.period.uncertainty,
                     truth.rate);
        arena_reset(&arena);
        synthetic_free(&s);
    }
}

/*
 * A sensor without noise whose step is 1/2 to 1/13 of the amplitude: what lies within a step is not
 * known, though no scatter shows it, least of all where a period is nearly a whole number of rows.
 */
TEST(coarse_steps_leave_the_period_open)
{
    static const double steps[] = {1.5, 2, 3, 5, 8, 13};
    const int runs = is_long() ? 1500 : 200;
    struct coverage of[2] = {{0}};
    random_state = 85;
    for (int run = 0; run < runs; run++) {
        struct truth truth = {.amplitude = 40,
                              .offset = run % 3 ? 200 : 0,
                              .rate = 50,
                              .phase = random_between(-3, 3)};
        const double samples = random_between(8, 120);
        truth.period =
            (run % 2 ? samples : nearbyint(samples) + random_between(-0.05, 0.05)) / truth.rate;
        truth.span = truth.period * random_between(2.2, 25);
        truth.gamma = run % 4 == 3 ? random_between(0.1, 1) / truth.span : 0;
        truth.quantum = truth.amplitude / steps[run % (int)COUNT_OF(steps)];
        struct synthetic s = synthetic_make(&truth);
        struct arena arena = {0};
        struct error error = {0};
        struct period p;
        struct fit fit;
        if (series_period(&s.series, &arena, &p, &error))
            count_value(&of[0], p.period, truth.period);
        if (fit_named("damped", &s.series, &fit, &error))
            count_value(&of[1], fit.period, truth.period);
        arena_reset(&arena);
        synthetic_free(&s);
    }
    print_coverage("period of coarse steps", &of[0]);
    print_coverage("fit of coarse steps", &of[1]);
    for (int i = 0; i < 2; i++)
        assert_true(of[i].judged >= 0.95 * runs && of[i].covered >= 0.9 * of[i].judged &&
                    of[i].worst < 5);
}

RUN_TESTS(NULL, NULL)
