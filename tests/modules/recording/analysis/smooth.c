/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Periods of series without noise: exact, whatever the decay and the centre, or not claimed. */

#include "cmocka_testing.h"

#include "long_form.h"
#include "modules/recording/analysis/testing.h"

/* From steady motion to what underflows or grows by 200 powers of ten, about any centre. */
TEST(smooth_periods_are_exact)
{
    const int runs = is_long() ? 4000 : 400;
    double square = 0, largest = 0;
    int pulls = 0;
    random_state = 91;
    for (int run = 0; run < runs; run++) {
        struct truth truth = {.amplitude = 1,
                              .offset = run % 3 ? random_between(-30, 30) : 0,
                              .period = 1,
                              .phase = random_between(-3, 3),
                              .rate = random_between(45, 400),
                              .span = random_between(6, 60)};
        truth.gamma = 2 * random_between(-1, 1) * (run % 2 ? 0.02 : 0.8);
        truth.gamma = truth.offset == 0 && run % 5 == 0 ? 4 * truth.gamma : truth.gamma;
        truth.amplitude = truth.gamma < 0 ? exp(0.5 * truth.gamma * truth.span) : 1;
        struct synthetic s = synthetic_make(&truth);
        struct arena arena = {0};
        struct error error = {0};
        struct period p;
        if (!series_period(&s.series, &arena, &p, &error))
            fail_msg("%s: gamma %g, offset %g, %g samples a period, %g periods", error.text,
                     truth.gamma, truth.offset, truth.rate, truth.span);
        const double off = fabs(p.period.value - 1), pull = off / p.period.uncertainty;
        if (!(off < 6 * p.period.uncertainty + 1e-13) || !(p.period.uncertainty < 1e-5))
            fail_msg("T off by %g, stated %g: gamma %g, %g samples a period", off,
                     p.period.uncertainty, truth.gamma, truth.rate);
        if (off > 1e-13) {
            square += pull * pull;
            largest = fmax(largest, pull);
            pulls++;
        }
        arena_reset(&arena);
        synthetic_free(&s);
    }
    print_message("%d of %d are exact to rounding, the others off by %.2f (at most %.2f)\n",
                  runs - pulls, runs, sqrt(square / fmax(pulls, 1)), largest);
}

/* A wave whose lobes alternate repeats after two of them, however even its crossings are. */
TEST(even_crossings_are_not_all)
{
    static double t[4000], y[4000];
    struct arena arena = {0};
    struct error error = {0};
    struct period p;
    for (int i = 0; i < 4000; i++) {
        t[i] = 0.01 * i;
        const double phase = 6.283185307179586 * t[i];
        y[i] = sin(phase) * (1 + 0.4 * sin(0.5 * phase));
    }
    const struct series series = {t, y, 4000, QUANTITY_NUMBER, NULL, 0};
    assert_true(series_period(&series, &arena, &p, &error));
    assert_true(close_to(p.period.value, 2, 1e-3));
    arena_reset(&arena);
}

RUN_TESTS(NULL, NULL)
