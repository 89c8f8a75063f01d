/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Crossings, period, amplitudes, decay and spectrum of synthetic series. */
#include <string.h>

#include "cmocka_testing.h"

#include "modules/recording/analysis/testing.h"

#define TWO_PI 6.283185307179586

/* 50 Hz, 4.2 cm, 0.05 cm noise: what the cursors promise (0.09 % over one period, 0.014 % over
 * eight). */
TEST(crossings_are_as_good_as_promised)
{
    double one = 0, eight = 0, pull = 0;
    int runs = 200, pairs = 0;
    random_state = 21;
    for (int run = 0; run < runs; run++) {
        struct truth truth = {.amplitude = 4.2,
                              .offset = 25,
                              .period = 1.9373,
                              .phase = random_between(-3, 3),
                              .rate = 50,
                              .span = 20,
                              .noise = 0.05};
        struct synthetic s = synthetic_make(&truth);
        struct arena arena = {0};
        struct overview overview;
        struct crossing c[64];
        series_overview(&s.series, &arena, &overview);
        assert_true(overview.oscillates && close_to(overview.noise, 0.05, 0.01));
        size_t n = series_crossings(&s.series, &overview, overview.mean, c, COUNT_OF(c));
        assert_in_range(n, 19, 22);
        for (size_t i = 1; i < n; i++) {
            assert_true(c[i].t > c[i - 1].t && c[i].rising != c[i - 1].rising);
            double phase = TWO_PI / 1.9373 * c[i].t + truth.phase,
                   off = remainder(phase - TWO_PI / 4, TWO_PI / 2);
            pull += pow(off / (TWO_PI / 1.9373) / c[i].uncertainty, 2);
            pairs++;
        }
        one += pow((c[2].t - c[0].t) / 1.9373 - 1, 2);
        eight += pow((c[16].t - c[0].t) / (8 * 1.9373) - 1, 2);
        arena_reset(&arena);
        synthetic_free(&s);
    }
    print_message("rms error of T: %.3f %% over 1 period, %.4f %% over 8\n", 100 * sqrt(one / runs),
                  100 * sqrt(eight / runs));
    assert_true(sqrt(one / runs) < 0.9e-3 && sqrt(eight / runs) < 1.4e-4);
    assert_true(close_to(sqrt(pull / pairs), 1, 0.15)); /* the uncertainties are true */
}

/* Missed echoes before the first true crossing cross the level, too; the periods are counted from
 * where the others agree. */
TEST(spikes_that_cross_first_do_not_matter)
{
    random_state = 24;
    struct truth truth = {.amplitude = 4,
                          .offset = 20,
                          .period = 1.937,
                          .phase = 0.3,
                          .rate = 50,
                          .span = 9.6,
                          .noise = 0.03};
    int wrong = 0, tried = 0;
    for (int at = 2; at < 66; at++) {
        for (int width = 1; width <= 6; width++) {
            for (int side = -1; side <= 1; side += 2) {
                struct synthetic s = synthetic_make(&truth);
                for (int i = at; i < at + width; i++) {
                    s.y[i] = 20 + side * 9.0;
                }
                struct arena arena = {0};
                struct period period;
                struct error error = {0};
                tried++;
                wrong += !series_period(&s.series, &arena, &period, &error) ||
                         !close_to(period.period.value, 1.937, 0.01);
                arena_reset(&arena);
                synthetic_free(&s);
            }
        }
    }
    print_message("%d of %d periods wrong\n", wrong, tried);
    assert_int_equal(wrong, 0);
}

TEST(noise_makes_no_extra_crossings)
{
    random_state = 22;
    struct truth truth = {.amplitude = 1,
                          .offset = 3,
                          .period = 2,
                          .rate = 100,
                          .span = 20.2,
                          .noise = 0.2,
                          .phase = 0.3};
    struct synthetic s = synthetic_make(&truth);
    struct arena arena = {0};
    struct overview overview;
    series_overview(&s.series, &arena, &overview);
    struct crossing c[4];
    assert_int_equal(series_crossings(&s.series, &overview, 3, c, COUNT_OF(c)), 20);
    assert_int_equal(series_crossings(&s.series, &overview, 9, c, COUNT_OF(c)), 0);
    /* another level: where the sine passes it, not where it passes its middle */
    assert_int_equal(series_crossings(&s.series, &overview, 3.2, c, COUNT_OF(c)), 20);
    double expected = (TWO_PI - acos(0.2) - 0.3) / TWO_PI * 2;
    assert_true(c[1].rising && close_to(c[1].t, expected, 4 * c[1].uncertainty));
    arena_reset(&arena);
    synthetic_free(&s);
}

TEST(exact_period)
{
    for (int damped = 0; damped < 2; damped++) {
        struct truth truth = {.amplitude = 0.05,
                              .period = 0.7526,
                              .gamma = damped ? 0.05 : 0,
                              .rate = 100,
                              .span = 20};
        struct synthetic s = synthetic_make(&truth);
        struct arena arena = {0};
        struct period period;
        struct error error = {0};
        assert_true(series_period(&s.series, &arena, &period, &error));
        assert_true(close_to(period.period.value, 0.7526, 1e-8) && period.periods == 25);
        assert_true(period.period.uncertainty > 0 && period.period.uncertainty < 1e-6);
        arena_reset(&arena);
        synthetic_free(&s);
    }
}

/* About a centre that is known, with no analysis of noise: the period itself, or nothing. */
TEST(clean_periods_are_exact_or_none)
{
    static const struct {
        double gamma, period, offset, span;
        bool found;
    } of[] = {{0, 0.7526, 0, 20, true},
              {0.05, 0.7526, 25, 20, true},
              {-0.05, 0.7526, 0, 20, true},
              {0, 0.15, 0, 20, false}, /* 15 samples each */
              {0, 0.7526, 0, 1.2, false} /* too few */};
    for (size_t i = 0; i < COUNT_OF(of); i++) {
        const struct truth truth = {.amplitude = 0.05,
                                    .period = of[i].period,
                                    .gamma = of[i].gamma,
                                    .offset = of[i].offset,
                                    .rate = 100,
                                    .span = of[i].span};
        struct synthetic s = synthetic_make(&truth);
        struct arena arena = {0};
        struct period period, about;
        assert_int_equal(series_clean_period(&s.series, of[i].offset, &arena, &period),
                         of[i].found);
        /* Quintics between 75 samples a period leave (2 pi/75)^6/6! of the amplitude, half of it
         * cancels. */
        assert_true(!of[i].found || close_to(period.period.value, of[i].period, 1e-9));
        /* Away from the centre damped motion does not cross at regular times. */
        if (of[i].gamma > 0 && series_clean_period(&s.series, of[i].offset + 0.03, &arena, &about))
            assert_false(close_to(about.period.value, of[i].period, 1e-6));
        arena_reset(&arena);
        synthetic_free(&s);
    }
}

/* Pulses, in uneven steps: no damped sine comes near. Where they come less and less often there is
 * no period. */
TEST(pulses_have_a_period)
{
    static double t[4000], y[4000];
    const double period = 1.7;
    (void)state;
    for (int late = 0; late < 2; late++) {
        struct arena arena = {0};
        struct period p;
        struct error error;
        for (int i = 0; i < 4000; i++) {
            t[i] = 0.005 * i + 0.002 * sin(i);
            y[i] = exp(40 * (cos(6.283185307179586 * t[i] / period / (1 + late * t[i] / 50)) - 1));
        }
        const struct series series = {t, y, 4000, QUANTITY_NUMBER, NULL, 0};
        assert_true(series_period(&series, &arena, &p, &error));
        assert_true(!late == !p.warning[0]);
        if (!late) {
            assert_true(fabs(p.period.value - period) < 1e-6);
            assert_true(p.periods == 10);
        }
        arena_reset(&arena);
    }
}

TEST(period_covers_the_truth)
{
    int runs = 200, inside = 0;
    random_state = 23;
    for (int run = 0; run < runs; run++) {
        struct truth truth = {.amplitude = 4,
                              .offset = 21,
                              .period = random_between(0.5, 1.5),
                              .gamma = 0.02,
                              .rate = 100,
                              .span = random_between(8, 40),
                              .noise = 0.05,
                              .phase = random_between(-3, 3)};
        struct synthetic s = synthetic_make(&truth);
        struct arena arena = {0};
        struct period period;
        struct error error = {0};
        assert_true(series_period(&s.series, &arena, &period, &error));
        inside += close_to(period.period.value, truth.period, 1.96 * period.period.uncertainty);
        if (strcmp(period.how, "phases") == 0)
            assert_true(close_to(period.level, truth.offset, 0.1 * truth.amplitude));
        arena_reset(&arena);
        synthetic_free(&s);
    }
    print_message("95 %% intervals of the period: %.1f %%\n", 100.0 * inside / runs);
    assert_in_range(inside, (uintmax_t)(0.90 * runs), (uintmax_t)runs);
}

TEST(amplitudes_at_times)
{
    random_state = 24;
    struct truth truth = BOB(.t0 = 2, .gamma = 0.04, .rate = 100, .span = 60, .noise = 0.03);
    struct synthetic s = synthetic_make(&truth);
    struct arena arena = {0};
    double at[] = {2, 10, 30, 62};
    struct reading reading[4];
    struct error error = {0};
    for (int width = 0; width < 2; width++) {
        assert_true(series_amplitudes(&s.series, &arena, at, 4, 4.0 * width, reading, &error));
        for (int i = 0; i < 4; i++) {
            double truth_here = 5 * exp(-0.02 * (at[i] - 2));
            assert_true(reading[i].t == at[i]);
            assert_true(close_to(reading[i].amplitude.value, truth_here,
                                 4 * reading[i].amplitude.uncertainty + 1e-4));
            assert_true(reading[i].amplitude.uncertainty < 0.01);
        }
    }
    at[0] = 1;
    assert_false(series_amplitudes(&s.series, &arena, at, 4, 0, reading, &error));
    assert_int_equal(error.code, ERROR_COMMAND);
    arena_reset(&arena);
    synthetic_free(&s);
}

/* The lab's question: position and energy of the same motion give the same gamma. */
TEST(position_and_energy_agree)
{
    double gamma = 0.025, omega = sqrt(8.4 * 8.4 - gamma * gamma / 4);
    enum { N = 12000 };
    static double t[N], y[N], e[N];
    for (size_t i = 0; i < N; i++) {
        double s = t[i] = 0.01 * (double)i, a = 0.05 * exp(-0.5 * gamma * s);
        y[i] = a * cos(omega * s);
        double v = -0.5 * gamma * y[i] - a * omega * sin(omega * s);
        e[i] = 0.5 * v * v + 0.5 * 8.4 * 8.4 * y[i] * y[i];
    }
    struct series position = {.t = t, .y = y, .n = N},
                  energy = {.t = t, .y = e, .n = N, .quantity = QUANTITY_ENERGY};
    struct arena arena = {0};
    struct decay p, q;
    struct error error = {0};
    assert_true(series_decay(&position, &arena, NULL, 0, &p, &error) && p.readings == 6);
    assert_true(series_decay(&energy, &arena, &(struct energy_noise){0}, 0, &q, &error) &&
                q.readings == 6);
    assert_true(close_to(p.gamma.value, gamma, 1e-7 * gamma) &&
                close_to(q.gamma.value, gamma, 1e-4 * gamma));
    assert_true(close_to(p.initial.value, 0.05, 1e-8) && close_to(p.tau.value, 80, 1e-4));
    assert_true(close_to(p.quality.value, omega / gamma, 1e-3) &&
                close_to(p.decrement.value, gamma * TWO_PI / 2 / omega, 1e-8));
    assert_true(close_to(p.halves[0], gamma, 1e-6) && close_to(q.halves[1], gamma, 1e-4));
    /* The means over parts of the record lie above the exponential; a quarter of the part's ripple
     * is left. */
    const double whole = 0.5 * (omega * omega + 0.25 * gamma * gamma) * 0.05 * 0.05;
    assert_true(close_to(q.initial.value, whole, 1e-4 * whole));
    for (int fast = 1; fast <= 3; fast++) {
        for (size_t i = 0; i < N; i++)
            e[i] = 18.75 * exp(-0.02 * fast * t[i]);
        assert_true(series_decay(&energy, &arena, &(struct energy_noise){0}, 0, &q, &error));
        assert_true(close_to(q.initial.value, 18.75, 1e-3) &&
                    close_to(q.gamma.value, 0.02 * fast, 1e-6));
    }
    /* the classic mix-up would be a factor of two */
    assert_false(series_decay(&position, &arena, NULL, 2, &p, &error));
    arena_reset(&arena);
}

TEST(decay_covers_the_truth)
{
    int runs = 100, inside = 0;
    random_state = 25;
    for (int run = 0; run < runs; run++) {
        struct truth truth = BOB(.gamma = random_between(-0.01, 0.05), .rate = 100, .span = 40,
                                 .noise = 0.05, .phase = random_between(-3, 3));
        struct synthetic s = synthetic_make(&truth);
        struct arena arena = {0};
        struct decay decay;
        struct error error = {0};
        assert_true(series_decay(&s.series, &arena, NULL, 8, &decay, &error) &&
                    decay.readings == 8);
        inside += close_to(decay.gamma.value, truth.gamma, 1.96 * decay.gamma.uncertainty);
        arena_reset(&arena);
        synthetic_free(&s);
    }
    assert_in_range(inside, 88, 100);
}

TEST(spectrum_shows_the_amplitude)
{
    random_state = 26;
    for (int uneven = 0; uneven < 2; uneven++) {
        struct truth truth = {.amplitude = 3,
                              .offset = 21,
                              .period = 0.75,
                              .rate = 40,
                              .span = 30.3,
                              .noise = 0.05,
                              .phase = 1};
        struct synthetic s = synthetic_make(&truth);
        for (size_t i = 0; uneven && i < s.series.n; i++) {
            s.t[i] += 0.4 / 40 * random_uniform();
            s.y[i] = 21 + 3 * cos(TWO_PI / 0.75 * s.t[i] + 1);
        }
        struct arena arena = {0};
        const double *frequency, *amplitude;
        size_t bins, peak = 1;
        assert_true(close_to(series_peak_frequency(&s.series, &arena), TWO_PI / 0.75, 2e-3));
        assert_true(series_spectrum(&s.series, &arena, &frequency, &amplitude, &bins));
        for (size_t k = 1; k < bins; k++) {
            assert_true(frequency[k] > frequency[k - 1] && amplitude[k] >= 0);
            peak = amplitude[k] > amplitude[peak] ? k : peak;
        }
        assert_true(close_to(frequency[peak], 1 / 0.75, 0.02) &&
                    close_to(amplitude[peak], 3, 0.15));
        assert_true(close_to(frequency[bins - 1], 20, 0.5));
        arena_reset(&arena);
        synthetic_free(&s);
    }
}

/* The peak that is drawn is the line that is named, whatever is missing: even times, a rough clock,
 * a gap of two fifths, both, and more samples than there are bins beside each other; at ten samples
 * a period. */
TEST(the_drawn_peak_is_the_named_line)
{
    random_state = 28;
    for (int kind = 0; kind < 20; kind++) {
        struct truth truth = {.amplitude = 3,
                              .offset = 21,
                              .period = 0.4 + 0.0137 * kind,
                              .rate = 25,
                              .noise = 0.002};
        truth.span = kind % 5 == 4 ? 400 : 30.3;
        truth.phase = TWO_PI * random_uniform();
        struct synthetic s = synthetic_make(&truth);
        size_t n = 0;
        for (size_t i = 0; i < s.series.n; i++) {
            const double fraction = (double)i / (double)s.series.n,
                         late = kind % 5 & 1 ? 0.01 * random_uniform() : 0;
            if (kind % 5 >= 2 && kind % 5 < 4 && fraction > 0.35 && fraction < 0.75)
                continue;
            const double at = TWO_PI / truth.period * s.t[i] + truth.phase;
            s.y[n] = s.y[i] + truth.amplitude * (cos(at + TWO_PI / truth.period * late) - cos(at));
            s.t[n++] = s.t[i] + late;
        }
        s.series.n = n;
        struct arena arena = {0};
        struct spectrum_peak named;
        const double *frequency, *amplitude;
        size_t bins, peak = 1;
        assert_int_equal(series_peaks(&s.series, &arena, &named, 1), 1);
        assert_true(series_spectrum(&s.series, &arena, &frequency, &amplitude, &bins));
        for (size_t k = 1; k < bins; k++)
            peak = amplitude[k] > amplitude[peak] ? k : peak;
        assert_true(close_to(named.amplitude.value, 3, 0.003));
        /* The edges of a gap leak, of the line and of that at -f: 1 / (pi 25) at most. */
        const bool gap = kind % 5 >= 2 && kind % 5 < 4;
        assert_true(close_to(amplitude[peak], named.amplitude.value, (gap ? 0.015 : 0.004) * 3));
        assert_true(close_to(frequency[peak], named.frequency.value, 0.1 / truth.span));
        assert_true(close_to(frequency[bins - 1], 12.5, 0.1));
        arena_reset(&arena);
        synthetic_free(&s);
    }
}

/* What is said of a line holds: in white noise 68 of 100 lie within one standard uncertainty, and
 * where the line is not steady most lie within two. */
TEST(peaks_have_honest_uncertainties)
{
    random_state = 27;
    const int draws = 200;
    for (int damped = 0; damped < 2; damped++) {
        int one = 0, two = 0;
        double pulls = 0;
        for (int i = 0; i < draws; i++) {
            struct truth truth = {.amplitude = 3,
                                  .offset = 21,
                                  .period = 0.75,
                                  .rate = 40,
                                  .span = 30.3,
                                  .noise = 0.5};
            truth.phase = TWO_PI * random_uniform();
            truth.gamma = damped ? 0.2 : 0;
            struct synthetic s = synthetic_make(&truth);
            struct arena arena = {0};
            struct spectrum_peak peak[3];
            assert_int_equal(series_peaks(&s.series, &arena, peak, 3), 1);
            const double pull =
                (peak[0].frequency.value - 1 / 0.75) / peak[0].frequency.uncertainty;
            pulls += pull * pull;
            one += fabs(pull) < 1;
            two += fabs(pull) < 2;
            arena_reset(&arena);
            synthetic_free(&s);
        }
        if (!damped)
            assert_in_range(one, draws * 58 / 100, draws * 78 / 100);
        assert_true(two > draws * 9 / 10);
        assert_true(damped || fabs(pulls / draws - 1) < 0.35); /* chi^2 of 200: 1 +- 0.1 */
    }
}

TEST(peaks_are_all_found_and_nothing_else)
{
    random_state = 28;
    static double t[2000], y[2000];
    struct series series = {t, y, 2000, QUANTITY_LENGTH, NULL, 0};
    struct arena arena = {0};
    struct spectrum_peak peak[3];
    for (size_t i = 0; i < 2000; i++) {
        t[i] = 0.02 * (double)i;
        y[i] = 5 + 2 * cos(TWO_PI * 0.16 * t[i] + 1) + 0.3 * cos(TWO_PI * 1.23 * t[i]) +
               0.01 * random_uniform();
    }
    assert_int_equal(series_peaks(&series, &arena, peak, 3), 2);
    assert_true(close_to(peak[0].frequency.value, 0.16, 1e-3) &&
                close_to(peak[0].amplitude.value, 2, 0.02));
    assert_true(close_to(peak[1].frequency.value, 1.23, 1e-3) &&
                close_to(peak[1].amplitude.value, 0.3, 0.02));
    for (double apart = 2.5; apart < 8; apart += 0.7) { /* bins: beats */
        const double second = 1.23 + apart / 40;
        for (size_t i = 0; i < 2000; i++)
            y[i] = 5 * cos(TWO_PI * 1.23 * t[i] + 1) + 3 * cos(TWO_PI * second * t[i]) +
                   0.03 * random_normal();
        assert_int_equal(series_peaks(&series, &arena, peak, 3), 2);
        assert_true(close_to(peak[0].frequency.value, 1.23, 1e-4) &&
                    close_to(peak[0].amplitude.value, 5, 0.002));
        assert_true(close_to(peak[1].frequency.value, second, 1e-4) &&
                    close_to(peak[1].amplitude.value, 3, 0.003));
        assert_true(fabs(peak[1].frequency.value - second) <
                    4 * peak[1].frequency.uncertainty + 1e-5);
    }
    int lines = 0;
    for (int draw = 0; draw < 100; draw++) {
        for (size_t i = 0; i < 2000; i++)
            y[i] = draw % 2 ? random_normal() : random_uniform();
        lines += series_peaks(&series, &arena, peak, 3);
        arena_reset(&arena);
    }
    assert_in_range(lines, 0, 1);
    arena_reset(&arena);
}

TEST(refusals_have_reasons)
{
    static double t[100], y[100];
    for (size_t i = 0; i < 100; i++) {
        t[i] = (double)i;
        y[i] = 3;
    }
    struct series series = {.t = t, .y = y, .n = 100};
    struct arena arena = {0};
    struct period period;
    struct decay decay;
    struct error error = {0};
    assert_false(series_period(&series, &arena, &period, &error));
    assert_int_equal(error.code, ERROR_COMMAND);
    assert_string_equal(error.text, "the signal does not oscillate: it is constant");
    assert_false(series_decay(&series, &arena, NULL, 0, &decay, &error));
    assert_true(isnan(series_peak_frequency(&series, &arena)));
    arena_reset(&arena);
}

TEST(windows_share_memory)
{
    double t[] = {0, 1, 2, 3, 4}, y[] = {5, 6, 7, 8, 9};
    struct series series = {.t = t, .y = y, .n = 5}, part = series_window(series, 0.5, 3);
    assert_true(part.t == t + 1 && part.y == y + 1 && part.n == 3);
    assert_int_equal(series_window(series, 10, 20).n, 0);
    assert_int_equal(series_window(series, -1, 9).n, 5);
}

/* Six swings, then a hand: a rest has no periods. */
TEST(what_rests_has_no_periods)
{
    static double t[3000], y[3000];
    struct series series = {t, y, 3000, QUANTITY_LENGTH, NULL, 0};
    struct arena arena = {0};
    struct period period;
    struct error error;
    random_state = 6;
    for (size_t i = 0; i < 3000; i++) {
        t[i] = 0.02 * (double)i;
        y[i] = (t[i] < 7.8 ? 0.05 * exp(-0.02 * t[i]) * cos(TWO_PI / 1.3 * t[i]) : 0) +
               3e-4 * random_normal();
    }
    assert_true(series_period(&series, &arena, &period, &error));
    assert_in_range((int)period.periods, 5, 7);
    assert_true(period.last < 9);
    arena_reset(&arena);
}

RUN_TESTS(NULL, NULL)
