/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The two cursors: what they snap to, how they move, what they say. */
#include "cmocka_testing.h"

#include <hooke/plot.h>
#include "unit/command/testing.h"

#define PI 3.14159265358979323846
#define T0 (2 * PI / sqrt(15 / 0.2))

static void assert_near(double a, double b, double tolerance)
{
    if (!(fabs(a - b) <= tolerance))
        fail_msg("%.17g is not %.17g to within %g", a, b, tolerance);
}

static const struct cursors *cursors(const struct bench *b)
{
    return &b->session->view.cursors;
}

static struct cursor_reading read_them(const struct bench *b)
{
    struct cursor_reading r;
    assert_true(session_cursor_reading(b->session, &r));
    return r;
}

TEST(crossings_of_a_run)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "method exact; run 10 s; cursor");
    const struct cursors *c = cursors(&b);
    /* y = A cos(omega t): up-crossing n at (n - 1/4) T. */
    assert_int_equal(c->cursor[0].crossing, 1);
    assert_near(c->cursor[0].t, 0.75 * T0, 1e-6);
    assert_int_equal(c->cursor[1].crossing, 14);
    struct cursor_reading r = read_them(&b);
    assert_near(r.periods, 13, 0);
    assert_near(r.period.value, T0, 1e-7);
    assert_true(r.period.uncertainty < 1e-5);
    assert_near(r.frequency.value, 1 / T0, 1e-6);
    assert_near(r.theory, T0, 1e-12);
    assert_near(r.deviation, 0, 1e-7);
    assert_string_equal(r.theory_name, "T0");
    /* The same numbers as measure period. */
    type_ok(&b, "measure period");
    assert_near(b.session->measurement[0].value.value, r.period.value, 1e-8);

    type_ok(&b, "cursor A 3 s; cursor periods 4");
    assert_near(c->cursor[0].t, 3.75 * T0, 1e-6); /* the nearest to 3 s is at 2.72 s */
    assert_int_equal(c->cursor[1].crossing - c->cursor[0].crossing, 4);
    assert_near(read_them(&b).dt, 4 * T0, 1e-6);
    type_ok(&b, "cursor more");
    assert_near(read_them(&b).periods, 5, 0);
    type_ok(&b, "cursor less; cursor less");
    assert_near(read_them(&b).periods, 3, 0);
    type_ok(&b, "cursor next");
    assert_int_equal(c->cursor[0].crossing, 5);
    assert_near(read_them(&b).periods, 2, 0);
    type_ok(&b, "cursor previous; cursor previous; cursor other; cursor next");
    assert_int_equal(c->cursor[0].crossing, 3);
    assert_int_equal(c->cursor[1].crossing, 8);
    type_ok(&b, "cursor go 0.5 s"); /* B is the active one now */
    assert_int_equal(c->cursor[1].crossing, 1);
    assert_near(read_them(&b).dt, -2 * T0, 1e-6);
    assert_near(read_them(&b).period.value, T0, 1e-6);
    bench_close(&b);
}

TEST(columns_never_stick)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "method exact; run 10 s; cursor");
    const struct cursors *c = cursors(&b);
    /* A move by more than a little leaves the crossing, and moves that come near the next one find
     * it. */
    int found = 0;
    double before = c->cursor[0].t;
    for (int i = 0; i < 40; i++) {
        type_ok(&b, "cursor right 0.05");
        assert_true(c->cursor[0].t > before + 0.02);
        before = c->cursor[0].t;
        found += c->cursor[0].crossing > 0;
    }
    assert_in_range(found, 2, 3);
    type_ok(&b, "cursor snap sample; cursor A 1.004; cursor right");
    assert_near(c->cursor[0].t, 1.01, 1e-9);
    type_ok(&b, "cursor left 20 s"); /* stops at the start */
    assert_near(c->cursor[0].t, 0, 0);
    type_ok(&b, "cursor snap none; cursor A 1.2345; cursor lock; cursor right 0.5");
    assert_near(c->cursor[0].t, 1.7345, 1e-12);
    assert_int_equal(c->cursor[0].crossing, 0);
    assert_near(read_them(&b).dt, c->cursor[1].t - 1.7345, 0);
    bench_close(&b);
}

TEST(peaks_and_decrement)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "method exact; gamma = 0.2; run 20 s; cursor snap peak");
    const double omega = sqrt(75 - 0.01), period = 2 * PI / omega;
    const struct cursors *c = cursors(&b);
    /* y' = 0 where tan(omega t) = -gamma/(2 omega): peaks a whole number of periods after t = 0. */
    type_ok(&b, "cursor A 1.4; cursor B 8.7");
    assert_near(c->cursor[0].t, 2 * period, 2e-4);
    assert_near(c->cursor[1].t, 12 * period, 2e-4);
    struct cursor_reading r = read_them(&b);
    assert_near(r.periods, 10, 0);
    assert_near(r.period.value, period, 5e-5);
    assert_string_equal(r.theory_name, "T_d");
    assert_near(r.theory, period, 1e-9);
    assert_near(r.decrement, 0.1 * period, 1e-4); /* gamma T / 2 */
    assert_near(r.quality, PI / (0.1 * period), 0.1);
    type_ok(&b, "cursor next");
    assert_near(c->cursor[0].t, 3 * period, 2e-4);
    assert_says(&b.out, "log decrement");
    assert_says(&b.out, "theory T_d");
    bench_close(&b);
}

static void write_recording(double noise, double spike)
{
    struct buffer text = {0};
    uint32_t seed = 1;
    buffer_put(&text, TEXT("time\tdistance\ns\tcm\n"));
    for (int i = 0; i < 500; i++) {
        double sum = 0; /* nearly normal: twelve uniform numbers */
        for (int k = 0; k < 12; k++)
            sum += (double)((seed = seed * 1664525u + 1013904223u) >> 8) / 16777216.0;
        const double y = 20 + 4.2 * sin(2 * PI * 0.02 * i / 1.9373) + noise * (sum - 6);
        buffer_format(&text, "%.2f\t%.5f\n", 0.02 * i, i == 60 || i == 420 ? y + spike : y);
    }
    write_file("swing.txt", text.data, text.len);
    buffer_free(&text);
}

TEST(noisy_recording)
{
    struct bench b;
    bench_open(&b, false);
    write_recording(0.05, 0);
    type_ok(&b, "load swing.txt; cursor");
    const struct cursors *c = cursors(&b);
    assert_true(c->on_data);
    assert_string_equal(c->subject, "data swing");
    struct cursor_reading r = read_them(&b);
    assert_near(r.periods, 4, 0);
    assert_near(r.period.value, 1.9373, 0.003);
    assert_true(r.period.uncertainty > 1e-5 && r.period.uncertainty < 2e-3);
    assert_true(isnan(r.theory)); /* nobody has said what the spring is */
    type_ok(&b, "k = 2.1; m = 200 g");
    assert_near(read_them(&b).theory, 2 * PI / sqrt(2.1 / 0.2), 1e-12);
    assert_says(&b.out, "m = ");
    type_ok(&b, "cursor keep");
    assert_int_equal(b.session->measurements, 1);
    assert_string_equal(b.session->measurement[0].source, "data swing");
    assert_string_equal(b.session->measurement[0].quantity, "period");
    assert_near(b.session->measurement[0].value.value, r.period.value, 0);
    /* The run and back. */
    type_ok(&b, "method verlet; run 9 s; cursor series");
    assert_string_equal(c->subject, "run 1");
    type_ok(&b, "cursor series");
    assert_string_equal(c->subject, "data swing");
    bench_close(&b);
}

/* Missed echoes of a motion sensor cross the level and stand above every peak: they are neither. */
TEST(spikes_are_no_places)
{
    static const double spikes[] = {15, -15};
    for (size_t i = 0; i < COUNT_OF(spikes); i++) {
        struct bench b;
        bench_open(&b, false);
        write_recording(0.05, spikes[i]);
        type_ok(&b, "load swing.txt; cursor; cursor A 1.9; cursor B 9.7");
        assert_near(read_them(&b).periods, 4, 0);
        assert_near(read_them(&b).period.value, 1.9373, 0.005);
        type_ok(&b, "cursor snap peak; cursor A 2.4; cursor B 8.2");
        assert_near(read_them(&b).periods, 3, 0);
        assert_near(read_them(&b).period.value, 1.9373, 0.004);
        bench_close(&b);
    }
}

TEST(follow_what_they_stand_on)
{
    struct bench b;
    bench_open(&b, false);
    type_ok(&b, "method exact; run 5 s; cursor; cursor A 2 s");
    const struct cursors *c = cursors(&b);
    const double t = c->cursor[0].t;
    type_ok(&b, "k = 60; run 5 s"); /* twice the frequency */
    assert_string_equal(c->subject, "run 2");
    assert_true(c->cursor[0].crossing > 0 && fabs(c->cursor[0].t - t) < T0 / 4);
    assert_near(read_them(&b).period.value, T0 / 2, 1e-6);
    type_ok(&b, "drop all");
    assert_false(c->shown);
    struct cursor_reading r;
    assert_false(session_cursor_reading(b.session, &r));
    bench_close(&b);
}

TEST(refusals_leave_them)
{
    struct bench b;
    bench_open(&b, false);
    assert_false(type(&b, "cursor"));
    assert_says(&b.err, "neither a run nor a recording");
    type_ok(&b, "method exact; run 3 s; cursor");
    const struct cursors before = *cursors(&b);
    static const struct {
        const char *line, *says;
    } wrong[] = {{"cursor A 5 s", "t = 5 s is outside run 1 (0..3 s)"},
                 {"cursor periods 40", "has up-crossings up to #4"},
                 {"cursor other; cursor next", "no up-crossing after"},
                 {"cursor series", "only one series"},
                 {"cursor snap peek", "peak"},
                 {"cursor A 5 cm", "A needs a time"},
                 {"cursor A 1 s; cursor B 1 s; cursor keep", "no period between the cursors"}};
    for (size_t i = 0; i < COUNT_OF(wrong); i++) {
        assert_false(type(&b, wrong[i].line));
        assert_says(&b.err, wrong[i].says);
    }
    type_ok(&b, "cursor off; cursor off");
    assert_false(cursors(&b)->shown);
    assert_true(before.shown);
    /* What does not oscillate has no crossings but can be measured. */
    type_ok(&b, "gamma = 40; run 1 s; cursor; cursor A 0.1; cursor B 0.3");
    assert_near(read_them(&b).dt, 0.2, 1e-9);
    assert_true(isnan(read_them(&b).periods));
    assert_false(type(&b, "cursor periods 2"));
    assert_says(&b.err, "no period to count");
    bench_close(&b);
}

RUN_TESTS(enter_folder, leave_folder)
