/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Time stamps that were rounded when they were printed: the period of a recording covers the truth
 * at every rate of pictures and with any number of decimals.
 */
#include "modules/recording/data/fixture.h"

#include "long_form.h"
#include "modules/recording/analysis/testing.h"

#include <hooke/data/even_times.h>

#define TWO_PI 6.283185307179586

static const double rates[] = {12, 15, 24, 25, 29.97, 30, 50, 59.94, 60, 119.88, 120, 240}; /* Hz */

enum { DECIMALS = 7 };

struct coverage {
    int judged, covered, refused;
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

/* A film of a swing as text: stamps with so many decimals, values with noise. */
static void write_film(struct buffer *text, double rate, int decimals, double period)
{
    const int n = (int)(rate * random_between(8, 12));
    const double begin = random_between(0, 3), phase = random_between(-3, 3);
    buffer_put(text, TEXT("Time (s),Position (cm)\n"));
    for (int i = 0; i < n; i++) {
        const double t = i / rate;
        buffer_format(text, "%.*f,%.4f\n", decimals, begin + t,
                      4 * exp(-0.02 * t) * cos(TWO_PI * t / period + phase) +
                          0.02 * random_normal());
    }
}

static void film_once(double rate, int decimals, struct coverage of[2])
{
    struct buffer text = {0};
    struct arena arena = {0};
    struct error error = {0};
    struct series series;
    struct period p;
    struct fit fit;
    const double period = random_between(0.5, 1.6);
    write_film(&text, rate, decimals, period);
    struct recording *r = fixture_good(text.data, "");
    assert_true(recording_series(r, &arena, 8, &series, &error));
    assert_int_equal(r->dropped, 0);
    if (series_period(&series, &arena, &p, &error))
        count_value(&of[0], p.period, period);
    else
        of[0].refused++;
    if (fit_named("damped", &series, &fit, &error))
        count_value(&of[1], fit.period, period);
    else
        of[1].refused++;
    recording_destroy(r);
    arena_reset(&arena);
    buffer_free(&text);
}

/* Chance leaves 0.95 of the intervals over the truth; the rounding adds its own share, which is
 * bounded: more is allowed, less is not. */
TEST(periods_of_films_cover_the_truth)
{
    const int runs = is_long() ? 20 : 2;
    struct coverage all[2] = {{0}};
    random_state = 30;
    for (int decimals = 0; decimals < DECIMALS; decimals++) {
        struct coverage of[2] = {{0}};
        for (size_t k = 0; k < COUNT_OF(rates); k++)
            for (int run = 0; run < runs; run++)
                film_once(rates[k], decimals, of);
        for (int i = 0; i < 2; i++) {
            print_message("%d decimals, %s: %d of %d covered, rms %.2f, worst %.2f, %d refused\n",
                          decimals, i ? "fit" : "measure", of[i].covered, of[i].judged,
                          sqrt(of[i].square / of[i].judged), of[i].worst, of[i].refused);
            all[i].judged += of[i].judged;
            all[i].covered += of[i].covered;
            all[i].refused += of[i].refused;
            all[i].worst = fmax(all[i].worst, of[i].worst);
        }
    }
    for (int i = 0; i < 2; i++) {
        assert_int_equal(all[i].refused, 0);
        assert_true(all[i].covered >= 0.91 * all[i].judged);
        assert_true(all[i].worst < 4.5);
    }
}

/* Any step, any rounding up to a third of the span: the stated limits of the step hold, whatever
 * the rounding and the step have in common. */
TEST(steps_lie_within_what_the_rounding_leaves)
{
    const int runs = is_long() ? 20000 : 1000;
    static double t[400];
    int covered = 0, even = 0;
    random_state = 31;
    for (int run = 0; run < runs; run++) {
        const size_t n = (size_t)random_between(40, 400);
        const double rate = pow(10, random_between(-2, 9)),
                     begin = random_between(-1, 1) * (double)n / rate, span = (double)n / rate;
        const int place = (int)floor(log10(span / random_between(4, 4000)));
        struct even_times found;
        for (size_t i = 0; i < n; i++)
            t[i] = nearbyint((begin + (double)i / rate) / pow(10, place)) * pow(10, place);
        even_times_find(t, NULL, n, NULL, &found);
        even += found.even;
        covered += fabs(found.step * rate - 1) <= 2.46 * found.pace + 1e-9 || found.resolution == 0;
        assert_true(fabs(found.step * rate - 1) <= 2 * pow(10, place) / span);
    }
    print_message("%d of %d even, %d covered\n", even, runs, covered);
    assert_true(even == runs && covered == runs);
}

/* Stamps with three significant digits are finer near 0 than far from it, and some repeat. */
TEST(significant_digits_are_a_rounding_too)
{
    random_state = 32;
    for (int run = 0; run < 50; run++) {
        struct buffer text = {0};
        const double step = pow(10, random_between(-10, -1)),
                     begin = -step * random_between(20, 300);
        buffer_put(&text, TEXT("Time (s),CH1 (V)\n"));
        for (int i = 0; i < 600; i++)
            buffer_format(&text, "%.2e,%.4f\n", begin + i * step, sin(0.1 * i));
        struct recording *r = fixture_good(text.data, "");
        assert_int_equal(r->rows, 600);
        assert_true(fabs(r->dt / step - 1) < 2.46 * r->pace + 1e-9 && r->pace < 1e-3);
        recording_destroy(r);
        buffer_free(&text);
    }
}

/* Jitter, dropped pictures and a repeated row are no rounding: these stamps are kept. */
TEST(what_is_uneven_stays_so)
{
    double t[200];
    struct even_times found;
    random_state = 33;
    for (int run = 0; run < 300; run++) {
        const double step = run % 2 ? random_between(0.004, 0.05) : 0.001;
        const int where = (int)random_between(10, 190);
        for (int i = 0; i < 200; i++) {
            double at = i * step;
            if (run % 3 == 0)
                at += random_between(-2, 2) * fmax(step, 0.001);
            else if (run % 3 == 1)
                at += i > where ? step : 0;
            else
                at -= i > where ? step : 0;
            t[i] = nearbyint(at * 1000) / 1000;
        }
        even_times_find(t, NULL, 200, NULL, &found);
        assert_false(found.even);
    }
}

/* Rows lost at equal distances leave the stamps of a longer step that was rounded: the values tell
 * the two apart unless noise hides which it is. */
TEST(regular_losses_are_no_rounding)
{
    static double t[2000], y[2000];
    const int runs = is_long() ? 4000 : 400;
    struct even_times found;
    int hidden[2] = {0, 0};
    random_state = 34;
    for (int run = 0; run < runs; run++) {
        const bool lost = run % 2;
        const int each = (int)random_between(3, 40), wanted = (int)random_between(300, 1800);
        const double unit = pow(10, -(int)random_between(1, 4)), samples = random_between(12, 60),
                     noise = random_between(0, 0.02);
        size_t n = 0;
        for (int i = 0; i < wanted; i++) {
            if (lost && i % each == each - 1)
                continue;
            const double step = lost ? 1 : (double)each / (each - 1), at = i * step;
            t[n] = unit * (lost ? at : floor(at + 1e-9));
            y[n++] = cos(TWO_PI * at / samples) + noise * random_normal();
        }
        even_times_find(t, y, n, NULL, &found);
        if (lost == found.even && noise < 0.3 / samples)
            fail_msg("run %d: every %d-th %s, %.3g samples a period, noise %.3g: even is %d", run,
                     each, lost ? "lost" : "step rounded", samples, noise, found.even);
        hidden[lost] += lost == found.even;
    }
    print_message("lost rows taken as rounded: %d, rounded ones as lost: %d of %d\n", hidden[1],
                  hidden[0], runs);
    assert_int_equal(hidden[0], 0);
}

RUN_TESTS(fixture_setup, fixture_teardown)
