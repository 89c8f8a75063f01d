/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Rates, straight lines and the autocorrelation, against what is known exactly. */
#include <hooke/base/cancel.h>

#include "cmocka_testing.h"

#include "modules/recording/series/analysis.h"

#include <math.h>

#define N 1000

static bool near(double a, double b, double tolerance)
{
    return fabs(a - b) <= tolerance;
}

/* A parabola is differentiated exactly, at uneven times and at the ends too; a gap is not bridged.
 */
TEST(parabolas_are_exact)
{
    double t[N], y[N];
    struct arena arena = {0};
    struct derivative d;
    struct error error;
    for (int i = 0; i < N; i++) {
        t[i] = 3 + 0.01 * i + 0.002 * sin(7.0 * i) + (i >= 500 ? 1 : 0);
        y[i] = 2 - 3 * t[i] + 0.5 * t[i] * t[i] + (i >= 500 ? 100 : 0);
    }
    const struct series series = {t, y, N, QUANTITY_LENGTH, NULL, 0};
    for (int points = 3; points <= 9; points += 2) {
        assert_true(series_derivative(&series, points, &arena, &d, &error));
        assert_int_equal(d.known, N);
        assert_int_equal(d.quantity, QUANTITY_VELOCITY);
        for (int i = 0; i < N; i++)
            if (!near(d.value[i], t[i] - 3, 1e-8))
                fail_msg("%d points, t = %g: %.12g, not %.12g", points, t[i], d.value[i], t[i] - 3);
    }
    assert_false(series_derivative(&series, 4, &arena, &d, &error));
    arena_reset(&arena);
}

/* The loss that is stated is the one there is; so is the gain of noise, 1/(h sqrt(10)) for five
 * points. */
TEST(loss_and_gain_are_as_stated)
{
    double t[N], y[N], largest = 0;
    const double omega = 8.7, h = 0.025;
    struct arena arena = {0};
    struct derivative d;
    struct error error;
    for (int i = 0; i < N; i++) {
        t[i] = h * i;
        y[i] = sin(omega * t[i]);
    }
    const struct series series = {t, y, N, QUANTITY_LENGTH, NULL, 0};
    assert_true(series_derivative(&series, DERIVATIVE_POINTS, &arena, &d, &error));
    for (int i = 2; i < N - 2; i++)
        largest = fmax(largest, fabs(d.value[i] -
                                     (1 - derivative_loss(&d, omega)) * omega * cos(omega * t[i])));
    assert_true(largest < 1e-9);
    assert_true(derivative_loss(&d, omega) > 0.02 && derivative_loss(&d, omega) < 0.03);
    assert_true(near(d.gain * h * sqrt(10), 1, 1e-9));
    arena_reset(&arena);
}

TEST(the_autocorrelation_finds_the_period)
{
    double t[N], y[N];
    struct arena arena = {0};
    struct measured period;
    for (int i = 0; i < N; i++) {
        t[i] = 0.01 * i;
        y[i] = 21.6 + 5 * exp(-0.01 * t[i]) * cos(6.283185307179586 / 0.7226 * t[i] + 1);
    }
    const struct series series = {t, y, N, QUANTITY_LENGTH, NULL, 0};
    const struct period known = {
        .period = {0.73, 0}}; /* 7 % of a period off after as many periods */
    assert_true(series_correlation_period(&series, &known, &arena, &period));
    if (!near(period.value, 0.7226, 1e-3) || !(period.uncertainty < 1e-3))
        fail_msg("%g +- %g", period.value, period.uncertainty);
    for (int i = 0; i < N; i++)
        y[i] = 3;
    assert_false(series_correlation_period(&series, &known, &arena, &period));
    arena_reset(&arena);
}

/* From parts all along it: half the recording has another period, and the mean of both is what they
 * agree on. */
TEST(the_autocorrelation_of_long_recordings)
{
    enum { LONG = 200000 };
    struct arena arena = {0};
    double *t = arena_array(&arena, 2 * LONG, sizeof *t), *y = t + LONG, phase = 0;
    struct measured period;
    assert_non_null(t);
    for (int i = 0; i < LONG; i++) {
        t[i] = 0.01 * i;
        y[i] = 21.6 + 5 * cos(phase);
        phase += 6.283185307179586 * 0.01 / (i < LONG / 2 ? 0.7220 : 0.7240);
    }
    const struct series series = {t, y, LONG, QUANTITY_LENGTH, NULL, 0};
    const struct period known = {.period = {0.7230, 0}};
    assert_true(series_correlation_period(&series, &known, &arena, &period));
    if (!near(period.value, 0.7230, 1e-4))
        fail_msg("%.8g +- %g", period.value, period.uncertainty);
    arena_reset(&arena);
}

/* [s] of processor for the period of so many samples a period, expected so far off: uphill from
 * there each step is a sum over all samples, unless it is read off a transform. */
static double seconds_uphill(int samples, double off)
{
    enum { PERIODS = 10 };
    const int n = PERIODS * samples;
    struct arena arena = {0};
    double *t = arena_array(&arena, 2 * (size_t)n, sizeof *t), *y = t + n;
    struct measured period;
    assert_non_null(t);
    for (int i = 0; i < n; i++) {
        t[i] = i;
        y[i] = cos(6.283185307179586 * i / samples + 1);
    }
    const struct series series = {t, y, (size_t)n, QUANTITY_LENGTH, NULL, 0};
    const struct period known = {.period = {(1 + off) * samples, 0}};
    const int64_t begin = clock_cpu_ns();
    assert_true(series_correlation_period(&series, &known, &arena, &period));
    const double seconds = 1e-9 * (double)(clock_cpu_ns() - begin);
    if (!near(period.value / samples, 1, 1e-3))
        fail_msg("%.9g for %d", period.value, samples);
    arena_reset(&arena);
    return seconds;
}

TEST(a_long_way_to_the_autocorrelation_is_no_square)
{
    enum { SAMPLES = 10000 }; /* 300 steps of 1e5 samples, then 600, .. */
    const double near_by = seconds_uphill(SAMPLES, 0), far = seconds_uphill(SAMPLES, 0.03);
    if (far > 50 * near_by) /* step by step: 165 times; by the transform 10 to 15 */
        fail_msg("%g s, and %g s where it begins at the top", far, near_by);
}

TEST(lines_have_the_uncertainties_of_the_book)
{
    /* The points are y = 1 + 2 x, moved up or down by one sigma of 0.1, so that chi^2 = 4 with 4 -
     * 2 degrees of freedom. Computed by hand: the slope is 2 and sum((x - mean)^2) = 5, which gives
     * sigma/sqrt(5) for the slope and sigma sqrt(1/4 + 1.5^2/5) for the intercept, both times
     * sqrt(chi^2/2) = sqrt(2). */
    const double x[] = {0, 1, 2, 3};
    const struct measured y[] = {{1.1, 0.1}, {2.9, 0.1}, {4.9, 0.1}, {7.1, 0.1}};
    struct line_fit line;
    assert_true(line_fit(x, y, 4, &line));
    assert_true(near(line.slope.value, 2, 1e-12) && near(line.intercept.value, 1, 1e-12));
    assert_true(near(line.chi2, 4, 1e-9) && line.freedom == 2);
    assert_true(near(line.slope.uncertainty, 0.1 * sqrt(2.0 / 5), 1e-12));
    assert_true(near(line.intercept.uncertainty, 0.1 * sqrt(2 * (0.25 + 2.25 / 5)), 1e-12));
    const double same[] = {1, 1};
    assert_false(line_fit(same, y, 2, &line));
}

RUN_TESTS(NULL, NULL)
