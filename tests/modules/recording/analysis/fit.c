/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Fits of synthetic recordings: do the stated uncertainties cover the truth, and is nothing wrong
 * called right? */
#include <hooke/base/cancel.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/analysis/testing.h"

#include <string.h>

static bool one_in(int many)
{
    return random_uniform() * many < 1;
}

/*
 * A bob over the sensor [cm]: 3–160 periods, 20–125 Hz, noise 0.01–0.3 cm; some with missed echoes,
 * flat tops, an offset that drifts, sway (that has time to show itself: slower than the record it
 * is no different from decay), rounded values.
 */
static struct truth random_recording(void)
{
    struct truth truth = {.t0 = random_between(-5, 20),
                          .rate = random_between(20, 125),
                          .period = random_between(0.4, 2)};
    double periods = 3 * pow(160.0 / 3, random_uniform());
    truth.span = fmax(periods * truth.period, 60 / truth.rate);
    truth.amplitude = random_between(1, 8);
    truth.offset = random_between(15, 30);
    truth.phase = random_between(-3.1, 3.1);
    truth.gamma = random_uniform() * 3 / truth.span;
    truth.noise = 0.01 * pow(30, random_uniform());
    truth.dropouts = one_in(2) ? 0 : random_between(0, 0.1);
    truth.clip =
        one_in(4) ? truth.amplitude * random_between(truth.dropouts > 0 ? 0.93 : 0.85, 0.97) : 0;
    truth.drift = one_in(4) ? truth.amplitude * random_between(-0.2, 0.2) : 0;
    truth.sway = one_in(4) && truth.span > 16 * truth.period ? random_between(0.02, 0.1) : 0;
    truth.sway_period = truth.period * 3 * pow(truth.span / truth.period / 12, random_uniform());
    truth.sway_phase = random_between(-3.1, 3.1);
    truth.quantum = one_in(5) ? 0.1 : 0;
    return truth;
}

static bool within(struct measured fitted, double truth, double deviations)
{
    return close_to(fitted.value, truth, deviations * fitted.uncertainty);
}

static double value_at(const struct fit *fit, double t)
{
    double value;
    fit_values(fit, &t, 1, &value);
    return value;
}

TEST(intervals_cover_the_truth)
{
    int runs = is_long() ? 500 : 24, period = 0, gamma = 0, stiffness = 0, offset = 0, refused = 0;
    random_state = 20180921;
    for (int i = 0; i < runs; i++) {
        struct truth truth = random_recording();
        struct synthetic s = synthetic_make(&truth);
        struct fit fit;
        struct error error = {0};
        if (fit_named("damped", &s.series, &fit, &error)) {
            double omega = 6.283185307179586 / truth.period,
                   k = omega * omega + 0.25 * truth.gamma * truth.gamma;
            assert_true(fit.converged);
            assert_true(fit.amplitude.value >= 0 && fabs(fit.phase.value) <= 3.1415926535897936);
            assert_int_equal(fit.used + fit.rejected, s.series.n);
            /* what is wrong must never be called converged */
            if (!within(fit.period, truth.period, 8) || !within(fit.gamma, truth.gamma, 8)) {
                fail_msg("run %d: T %g +- %g, truth %g; gamma %g +- %g, truth %g (n %zu, noise %g, "
                         "A %g, dropouts %g, clip "
                         "%g, drift %g, sway %g)",
                         i, fit.period.value, fit.period.uncertainty, truth.period, fit.gamma.value,
                         fit.gamma.uncertainty, truth.gamma, s.series.n, truth.noise,
                         truth.amplitude, truth.dropouts, truth.clip, truth.drift, truth.sway);
            }
            period += within(fit.period, truth.period, 1.96);
            gamma += within(fit.gamma, truth.gamma, 1.96);
            stiffness += within(fit_stiffness(&fit, (struct measured){1, 0}), k, 1.96);
            offset += within(fit.offset, truth.offset, 1.96);
        } else {
            print_message(
                "run %d refused: %s (n %zu, periods %g, A %g, noise %g, dropouts %g, gamma %g)\n",
                i, error.text, s.series.n, truth.span / truth.period, truth.amplitude, truth.noise,
                truth.dropouts, truth.gamma);
            refused++;
        }
        synthetic_free(&s);
    }
    int fitted = runs - refused;
    print_message(
        "95 %% intervals of %d fits: T %.1f %%, gamma %.1f %%, k %.1f %%, offset %.1f %%\n", fitted,
        100.0 * period / fitted, 100.0 * gamma / fitted, 100.0 * stiffness / fitted,
        100.0 * offset / fitted);
    assert_true(refused <= runs / 100);
    /* Of few runs: binomial, three standard deviations. */
    double slack = is_long() ? 0.02 : 3 * sqrt(0.95 * 0.05 / fitted), min = (0.95 - slack) * fitted;
    double max = fmin(0.95 + slack, 1) * fitted;
    assert_true(period >= min && gamma >= min && stiffness >= min && offset >= min);
    assert_true(period <= max && gamma <= max && stiffness <= max);
}

TEST(dropouts_are_counted)
{
    random_state = 7;
    struct truth truth = BOB(.gamma = 0.02, .rate = 100, .span = 40, .noise = 0.02);
    struct synthetic s = synthetic_make(&truth);
    for (size_t i = 50; i < s.series.n; i += 50) {
        s.y[i] += i % 100 ? 0.7 : -3; /* 80 echoes off */
    }
    struct fit fit;
    struct error error = {0};
    assert_true(fit_named("damped", &s.series, &fit, &error));
    assert_int_equal(fit.rejected, 80);
    assert_true(fit.warnings == 1 && strstr(fit.warning[0], "80 of"));
    assert_true(close_to(fit.gamma.value, 0.02, 4e-4));
    synthetic_free(&s);
}

TEST(clipped_tops_are_censored)
{
    random_state = 8;
    struct truth truth = BOB(.gamma = 0.005, .rate = 100, .span = 15, .noise = 0.02, .clip = 4.2);
    struct synthetic s = synthetic_make(&truth);
    struct fit fit;
    struct error error = {0};
    assert_true(fit_named("damped", &s.series, &fit, &error));
    assert_true(fit.warnings > 0 && strstr(fit.warning[0], "clipped"));
    assert_true(close_to(fit.amplitude.value, 5, 0.02) && close_to(fit.offset.value, 21, 0.02));
    assert_true(close_to(fit.period.value, 0.75, 4 * fit.period.uncertainty));
    synthetic_free(&s);
}

/* Tops cut so deep that more than a fifth of the samples lies behind them: no fit is made of the
 * rest, and why. */
TEST(deep_cuts_are_no_fit)
{
    random_state = 8;
    struct truth truth = BOB(.gamma = 0.005, .rate = 100, .span = 15, .noise = 0.02, .clip = 2.5);
    struct synthetic s = synthetic_make(&truth);
    struct fit fit;
    struct error error = {0};
    assert_false(fit_named("damped", &s.series, &fit, &error));
    assert_false(fit.converged);
    assert_non_null(strstr(error.text, "leave out"));
    synthetic_free(&s);
}

/* Steps of a fifth to a third of the amplitude are flat wherever the motion is slow: rounded, not
 * cut. */
TEST(coarse_steps_are_not_clipping)
{
    random_state = 31;
    for (int run = 0; run < 20; run++) {
        struct truth truth = {.amplitude = random_between(3, 6),
                              .offset = random_between(15, 30),
                              .period = random_between(0.4, 2),
                              .gamma = random_between(0, 0.01),
                              .phase = random_between(-3, 3),
                              .rate = random_between(30, 100),
                              .span = random_between(30, 120),
                              .noise = run % 2 ? 0.01 : random_between(0.05, 0.4),
                              .quantum = 1};
        struct synthetic s = synthetic_make(&truth);
        struct fit fit;
        struct error error = {0};
        if (!fit_named("damped", &s.series, &fit, &error))
            fail_msg("run %d: %s", run, error.text);
        if (200 * fit.rejected > s.series.n)
            fail_msg("run %d: %zu of %zu rejected", run, fit.rejected, s.series.n);
        assert_true(fit.converged && close_to(fit.period.value, truth.period, 1e-3 * truth.period));
        synthetic_free(&s);
    }
}

TEST(drift_of_the_offset)
{
    random_state = 9;
    struct truth truth = BOB(.gamma = 0.02, .rate = 60, .span = 30, .noise = 0.05, .drift = 0.6);
    struct synthetic s = synthetic_make(&truth);
    struct fit fit;
    struct error error = {0};
    assert_true(fit_named("damped", &s.series, &fit, &error));
    assert_true(within(fit.period, 0.75, 3) && within(fit.gamma, 0.02, 3));
    assert_true(within(fit.offset, 21, 3) && within(fit.drift, 0.6 / 30, 3) &&
                fit.drift.uncertainty < 0.002);
    assert_true(close_to(value_at(&fit, s.t[900]), s.y[900], 0.3));
    synthetic_free(&s);
    truth.drift = 0;
    s = synthetic_make(&truth);
    assert_true(fit_named("damped", &s.series, &fit, &error));
    assert_true(fit.drift.value == 0);
    synthetic_free(&s);
}

TEST(rest_before_release_is_seen)
{
    random_state = 10;
    struct truth truth = BOB(.gamma = 0.02, .rate = 100, .span = 30, .noise = 0.02);
    struct synthetic s = synthetic_make(&truth);
    for (size_t i = 0; i < 400; i++) {
        s.y[i] = 21 + 0.02 * random_normal();
    }
    struct fit fit;
    struct error error = {0};
    assert_true(fit_named("damped", &s.series, &fit, &error));
    /* the window itself is judged by command_window.c, for all commands alike */
    assert_true(fit.warnings > 0);
    const double from = 4.5;
    struct series window = series_window(s.series, from, 30);
    assert_true(fit_named("damped", &window, &fit, &error));
    assert_int_equal(fit.warnings, 0);
    assert_true(close_to(fit.gamma.value, 0.02, 4 * fit.gamma.uncertainty));
    assert_true(fit.t0 >= from && fit.window[0] == fit.t0);
    synthetic_free(&s);
}

/* Samples of a simulation have no noise: every parameter to many digits, t counted from the first
 * sample. */
TEST(exact_samples)
{
    const struct truth truth = {.t0 = 3,
                                .amplitude = 0.05,
                                .offset = 0.2,
                                .period = 0.7526,
                                .gamma = 0.0241,
                                .phase = 2.5,
                                .rate = 100,
                                .span = 20};
    struct synthetic s = synthetic_make(&truth);
    struct fit fit;
    struct error error = {0};
    for (int uneven = 0; uneven < 2; uneven++) {
        assert_true(fit_named("damped", &s.series, &fit, &error));
        assert_true(close_to(fit.period.value, truth.period, 1e-11) &&
                    close_to(fit.gamma.value, truth.gamma, 1e-11));
        assert_true(close_to(fit.amplitude.value, 0.05, 1e-11) &&
                    close_to(fit.phase.value, 2.5, 1e-9));
        assert_true(close_to(fit.offset.value, 0.2, 1e-11) && fit.rejected == 0);
        assert_true(isfinite(fit.period.uncertainty) && fit.period.uncertainty < 1e-10);
        assert_true(close_to(value_at(&fit, s.t[17]), s.y[17], 1e-12));
        for (size_t i = 0; i < s.series.n; i++) { /* the same motion at uneven times */
            s.t[i] += 0.003 * sin((double)(i * i));
            double t = s.t[i] - 3;
            s.y[i] =
                0.2 + 0.05 * exp(-0.5 * 0.0241 * t) * cos(6.283185307179586 / 0.7526 * t + 2.5);
        }
        assert_true(s.t[0] == 3); /* the phase is that at the first sample, which did not move */
    }
    synthetic_free(&s);
}

TEST(stiffness_has_both_uncertainties)
{
    struct fit fit = {.omega = {8, 0.01}, .gamma = {0.4, 0.1}};
    struct measured k = fit_stiffness(&fit, (struct measured){0.2, 0.001});
    assert_true(close_to(k.value, 0.2 * (64 + 0.04), 1e-12));
    double by_mass = 64.04 * 0.001, by_omega = 2 * 0.2 * 8 * 0.01, by_gamma = 0.5 * 0.2 * 0.4 * 0.1;
    assert_true(close_to(
        k.uncertainty, sqrt(by_mass * by_mass + by_omega * by_omega + by_gamma * by_gamma), 1e-12));
}

TEST(laws_of_drag)
{
    static const struct {
        double gamma, quadratic;
        enum drag_law law;
    } cases[] = {{0.04, 0, LAW_LINEAR},
                 {1e-9, 0.04, LAW_QUADRATIC},
                 {0.015, 0.06, LAW_LINEAR | LAW_QUADRATIC}};
    random_state = 11;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct truth truth = BOB(.gamma = cases[i].gamma, .quadratic = cases[i].quadratic,
                                 .rate = 100, .span = 90, .noise = 0.02);
        struct synthetic s = synthetic_make(&truth);
        struct fit fit;
        struct error error = {0};
        assert_true(fit_named("drag", &s.series, &fit, &error));
        assert_int_equal(fit.preferred, cases[i].law);
        assert_true(fit_named("damped", &s.series, &fit, &error));
        assert_int_equal(fit.preferred, LAW_NONE); /* one judgement: that of the motion itself */
        bool halves = false;
        for (int k = 0; k < fit.warnings; k++) {
            halves |= strstr(fit.warning[k], "not one exponential") != NULL;
        }
        assert_true(halves == (cases[i].law != LAW_LINEAR));
        synthetic_free(&s);
    }
    /* too short to tell */
    struct truth truth = BOB(.gamma = 0.04, .rate = 100, .span = 9, .noise = 0.2);
    struct synthetic s = synthetic_make(&truth);
    struct fit fit;
    struct error error = {0};
    assert_true(fit_named("drag", &s.series, &fit, &error));
    assert_int_equal(fit.preferred, LAW_UNDECIDED);
    assert_string_equal(drag_law_name(fit.preferred), "not distinguishable");
    synthetic_free(&s);
}

/* Whatever the span (so the number of windows and periods in each): a wrong law hardly ever; none
 * rather than a wrong one. */
TEST(law_does_not_hang_on_the_windows)
{
    static const struct {
        double gamma, quadratic;
        enum drag_law law;
    } cases[] = {{0.04, 0, LAW_LINEAR},
                 {1e-9, 0.04, LAW_QUADRATIC},
                 {0.015, 0.06, LAW_LINEAR | LAW_QUADRATIC}};
    int runs = is_long() ? 200 : 3, wrong = 0, undecided = 0;
    random_state = 14;
    for (int run = 0; run < runs; run++) {
        for (size_t i = 0; i < COUNT_OF(cases); i++) {
            struct truth truth = {.amplitude = 5,
                                  .offset = 21,
                                  .period = random_between(0.6, 0.9),
                                  .gamma = cases[i].gamma,
                                  .quadratic = cases[i].quadratic,
                                  .rate = 60,
                                  .span = random_between(50, 150),
                                  .noise = 0.03,
                                  .phase = random_between(-3, 3)};
            struct synthetic s = synthetic_make(&truth);
            struct fit fit;
            struct error error = {0};
            assert_true(fit_named("drag", &s.series, &fit, &error));
            wrong += fit.preferred != cases[i].law && fit.preferred != LAW_UNDECIDED;
            undecided += fit.preferred == LAW_UNDECIDED;
            synthetic_free(&s);
        }
    }
    print_message("%d laws: %d wrong, %d undecided\n", 3 * runs, wrong, undecided);
    assert_true(wrong <= 0.005 * 3 * runs && undecided <= 0.05 * 3 * runs + 1);
}

static double flat(size_t i)
{
    (void)i;
    return 21;
}

static double noise(size_t i)
{
    (void)i;
    return 21 + 0.02 * random_normal();
}

static double ramp(size_t i)
{
    return 21 + 0.01 * (double)i + 0.02 * random_normal();
}

static double parabola(size_t i)
{
    return 21 + 1e-5 * (double)(i * i) + 0.02 * random_normal();
}

static double one_cycle(size_t i)
{
    return 21 + 5 * cos(6.283185307179586 * (double)i / 999) + 0.02 * random_normal();
}

static double pulse(size_t i)
{
    return 21 + (i > 300 && i < 500 ? 5 * sin(6.283185307179586 * (double)(i - 300) / 200) : 0) +
           0.02 * random_normal();
}

static double walk(size_t i)
{
    static double at;
    at = i == 0 ? 21 : at + 0.05 * random_normal();
    return at;
}

static double relaxing(size_t i)
{
    return 21 + 5 * exp(-(double)i / 150) + 0.02 * random_normal();
}

TEST(what_does_not_oscillate_is_refused)
{
    static const struct {
        const char *name;
        double (*value)(size_t i);
        int tries;
        double accepted; /* share: a random walk looks like two periods now and then */
    } signals[] = {{"flat", flat, 1, 0},           {"noise", noise, 50, 0},
                   {"ramp", ramp, 50, 0},          {"parabola", parabola, 50, 0},
                   {"pulse", pulse, 5, 0},         {"walk", walk, 50, 0.02},
                   {"one cycle", one_cycle, 5, 0}, {"relaxing", relaxing, 20, 0}};
    static double t[1000], y[1000];
    random_state = 12;
    for (size_t k = 0; k < COUNT_OF(signals); k++) {
        int tries =
                (is_long() ? 20 : 1) * (is_long() ? signals[k].tries : (signals[k].tries + 4) / 5),
            accepted = 0;
        for (int run = 0; run < tries; run++) {
            for (size_t i = 0; i < 1000; i++) {
                t[i] = 0.01 * (double)i;
                y[i] = signals[k].value(i);
            }
            struct series series = {.t = t, .y = y, .n = 1000};
            struct fit fit;
            struct error error = {0};
            if (fit_named("damped", &series, &fit, &error)) {
                accepted++;
                continue;
            }
            /* a walk may also begin to look like a sine on which the fit then does not settle */
            bool unsettled = signals[k].accepted > 0 && error.code == ERROR_NUMERICAL;
            assert_true(unsettled ||
                        (error.code == ERROR_COMMAND && strstr(error.text, "does not oscillate")));
        }
        if (accepted > signals[k].accepted * tries) {
            fail_msg("%s: %d of %d are said to oscillate", signals[k].name, accepted, tries);
        }
    }
    struct series none = {.t = t, .y = y, .n = 0}, few = {.t = t, .y = y, .n = 5};
    struct fit fit;
    struct error error = {0};
    assert_false(fit_named("damped", &none, &fit, &error));
    assert_false(fit_named("sine", &few, &fit, &error));
}

TEST(growing_and_plain_sines)
{
    random_state = 13;
    struct truth truth = {.amplitude = 1,
                          .offset = 0,
                          .period = 0.75,
                          .gamma = -0.1,
                          .rate = 100,
                          .span = 20,
                          .noise = 0.02};
    struct synthetic s = synthetic_make(&truth);
    struct fit fit;
    struct error error = {0};
    assert_true(fit_named("damped", &s.series, &fit, &error));
    assert_true(close_to(fit.gamma.value, -0.1, 4 * fit.gamma.uncertainty));
    assert_true(fit.warnings > 0 && strstr(fit.warning[0], "negative"));
    assert_true(fit.preferred == LAW_NONE && drag_law_name(LAW_NONE) == NULL);
    synthetic_free(&s);
    truth.gamma = 0;
    s = synthetic_make(&truth);
    assert_true(fit_named("sine", &s.series, &fit, &error));
    assert_true(fit.gamma.value == 0 &&
                close_to(fit.amplitude.value, 1, 4 * fit.amplitude.uncertainty));
    assert_true(close_to(fit.period.value, 0.75, 4 * fit.period.uncertainty));
    synthetic_free(&s);
}

TEST(cancellation)
{
    struct truth truth = {.amplitude = 1, .period = 0.75, .rate = 100, .span = 20};
    struct synthetic s = synthetic_make(&truth);
    struct cancel cancel;
    atomic_init(&cancel.requested, 1);
    struct arena arena = {0};
    struct fit fit;
    struct error error = {0};
    const struct fit_model *row = fit_model_at(0);
    assert_false(row->fit(&s.series, &arena, &cancel, &fit, &error));
    assert_int_equal(error.code, ERROR_CANCELLED);
    arena_reset(&arena);
    synthetic_free(&s);
}

RUN_TESTS(NULL, NULL)
