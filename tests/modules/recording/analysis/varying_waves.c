/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Waves that are not all alike: a frequency that is modulated, pulses that come with jitter, few
 * cycles that differ in turn, a clock that jumps. The period is right within its uncertainty, or a
 * warning says more.
 */

#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/detect_recordings.h"

struct tally {
    int silent, said, refused, all;
};

/* Counts a period outside of low..high by more than 4 of its uncertainties. */
static void count_range(struct drawn *d, double low, double high, const char *name,
                        struct tally *tally)
{
    const struct series series = {.t = d->t, .y = d->y, .n = d->n, .quantity = QUANTITY_LENGTH};
    struct period p = {.period = {NAN, NAN}};
    struct arena arena = {0};
    struct error error = {0};
    tally->all++;
    if (!series_period(&series, &arena, &p, &error)) {
        tally->refused++;
    } else {
        const double off = fmax(fmax(low - p.period.value, p.period.value - high), 0);
        if (off > 4 * p.period.uncertainty + 1e-9 * low) {
            tally->said += p.warning[0] != 0;
            tally->silent += !p.warning[0];
            if (!p.warning[0])
                print_message("%s: T %.6g..%.6g read as %.6g +- %.2g (%s, %.3g periods)\n", name,
                              low, high, p.period.value, p.period.uncertainty, p.how,
                              d->span / low);
        }
    }
    arena_reset(&arena);
    free(d->t);
    free(d->y);
}

static double narrow_pulse(double phase, double width)
{
    return exp(-0.5 * pow(remainder(phase, 1) / width, 2));
}

static int cases(int quick)
{
    return is_long() ? 10 * quick : quick;
}

static struct drawn draw_waves(double cycles, double samples)
{
    struct drawn d = draw((size_t)(cycles * samples) + 1, 50);
    d.period = samples / 50;
    return d;
}

static void assert_hardly_silent(const char *name, const struct tally *t)
{
    print_message("%s: %d of %d wrong without a word, %d with one, %d refused\n", name, t->silent,
                  t->all, t->said, t->refused);
    assert_true(25 * t->silent <= t->all);
    assert_true(5 * t->refused <= t->all);
}

/* Sines and pulses whose frequency is modulated by 1 to 60 % every 3 to 12 waves. */
TEST(modulated_frequencies)
{
    struct tally tally = {0};
    random_state = 821;
    for (int i = 0; i < cases(60); i++) {
        struct drawn d = draw_waves(random_between(12, 80), of_random_size(20, 120));
        const double waves = random_between(3, 12), index = of_random_size(0.01, 0.6) * waves,
                     width = random_between(0.04, 0.12), angle = random_between(0, 2 * PI);
        double phase = 0, first = 0;
        for (size_t k = 0; k < d.n; k++) {
            const double x = d.t[k] / d.period;
            phase = x + index / (2 * PI) * sin(2 * PI * x / waves + angle);
            first = k == 0 ? phase : first;
            d.y[k] = i % 2 ? narrow_pulse(phase, width) : sin(2 * PI * phase);
        }
        const double mean = d.span / (phase - first);
        add_noise(&d, i % 3 ? of_random_size(1e-3, 0.05) : 0);
        count_range(&d, fmin(mean, d.period), fmax(mean, d.period), i % 2 ? "pulses" : "sine",
                    &tally);
    }
    assert_hardly_silent("modulated frequencies", &tally);
}

/* Pulses each of which comes some random time off its place, or off the pulse before. */
TEST(pulses_with_jitter)
{
    enum { PULSES = 100 };
    struct tally tally = {0};
    random_state = 822;
    for (int i = 0; i < cases(60); i++) {
        const double cycles = random_between(12, 80), jitter = of_random_size(0.005, 0.08),
                     width = random_between(0.04, 0.12);
        struct drawn d = draw_waves(cycles, of_random_size(20, 80));
        double place[PULSES], before = -2;
        for (int k = 0; k < PULSES; k++) {
            before = i % 2 ? before + 1 + jitter * random_normal() : k - 2;
            place[k] = i % 2 ? before : before + jitter * random_normal();
        }
        for (size_t k = 0; k < d.n; k++)
            for (int j = 0; j < PULSES; j++) {
                const double off = (d.t[k] / d.period - place[j]) / width;
                d.y[k] += fabs(off) < 6 ? exp(-0.5 * off * off) : 0;
            }
        add_noise(&d, i % 3 ? of_random_size(1e-3, 0.05) : 0);
        count_range(&d, d.period, d.period, i % 2 ? "random walk" : "jitter", &tally);
    }
    assert_hardly_silent("jitter", &tally);
}

/* 3 to 10 cycles of which every second is alike. */
TEST(few_cycles_in_turn)
{
    struct tally tally = {0};
    random_state = 823;
    for (int i = 0; i < cases(60); i++) {
        struct drawn d = draw_waves(random_between(4, 9.9), of_random_size(30, 120));
        const double phase = random_uniform(), width = random_between(0.05, 0.12),
                     small = random_between(0.55, 0.9), line = of_random_size(0.08, 0.3),
                     angle = random_between(0, 2 * PI);
        for (size_t k = 0; k < d.n; k++) {
            const double x = d.t[k] / d.period + phase,
                         height = fmod(floor(x + 0.5), 2) == 0 ? 1 : small;
            d.y[k] = i % 2 ? height * narrow_pulse(x, width)
                           : sin(2 * PI * x) + line * sin(PI * x + angle);
        }
        add_noise(&d, i % 3 ? of_random_size(1e-3, 0.01) : 0);
        count_range(&d, 2 * d.period, 2 * d.period, i % 2 ? "two heights" : "line", &tally);
    }
    assert_hardly_silent("few cycles", &tally);
}

/* Cycles that are alike, damped or not, stay what they are. */
TEST(few_cycles_alike)
{
    struct tally tally = {0};
    int said = 0;
    random_state = 824;
    for (int i = 0; i < cases(60); i++) {
        struct drawn d = draw_waves(random_between(3.2, 14), of_random_size(30, 120));
        const double phase = random_uniform(), width = random_between(0.05, 0.12),
                     decay = i % 4 < 2 ? random_between(0.1, 2) : 0;
        for (size_t k = 0; k < d.n; k++) {
            const double x = d.t[k] / d.period + phase;
            d.y[k] = exp(-decay * d.t[k] / d.span) *
                     (i % 2 ? narrow_pulse(x, width) : cos(2 * PI * x) + 0.2 * cos(4 * PI * x));
        }
        add_noise(&d, i % 3 ? of_random_size(1e-3, 0.03) : 0);
        count_range(&d, d.period, d.period, i % 2 ? "pulses" : "waves", &tally);
    }
    said = tally.said;
    assert_hardly_silent("cycles alike", &tally);
    assert_true(20 * said <= tally.all);
}

/* A clock that is set on while the motion is recorded evenly, and a recording that pauses. */
TEST(jumps_of_the_clock)
{
    struct tally tally = {0};
    random_state = 825;
    for (int i = 0; i < cases(60); i++) {
        struct drawn d = draw_waves(random_between(12, 60), of_random_size(15, 60));
        const double jump = of_random_size(0.3, 6) * d.period,
                     from = random_between(0.2, 0.8) * d.span,
                     decay = i % 2 ? random_between(0, 1) : 0;
        for (size_t k = 0; k < d.n; k++) {
            const bool later = d.t[k] > from;
            const double x = (d.t[k] + (later && i % 3 == 0 ? jump : 0)) / d.period;
            d.y[k] = exp(-decay * d.t[k] / d.span) * cos(2 * PI * x + 1);
            d.t[k] += later ? jump : 0;
        }
        add_noise(&d, of_random_size(2e-3, 0.03));
        count_range(&d, d.period, d.period, i % 3 ? "clock set" : "pause", &tally);
    }
    assert_int_equal(tally.refused, 0);
    assert_hardly_silent("gaps", &tally);
}

/* Pulses two samples wide, whose place between the samples recurs only after several periods. */
TEST(pulses_of_two_samples)
{
    struct tally tally = {0};
    random_state = 826;
    for (int i = 0; i < cases(60); i++) {
        const double samples = random_between(15, 80), begin = random_between(0, samples);
        struct drawn d = draw_waves(of_random_size(15, 40), samples);
        for (size_t k = 0; k < d.n; k++)
            d.y[k] = fmod((double)k + begin, samples) < 2;
        add_noise(&d, of_random_size(0.01, 0.1));
        count_range(&d, d.period, d.period, "two samples", &tally);
    }
    assert_int_equal(tally.silent, 0);
    assert_hardly_silent("pulses of two samples", &tally);
}

RUN_TESTS(NULL, NULL)
