/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Values that a sensor sends when it sees nothing are left out and said, in whatever part of the
 * rows they come; flat tops, rests, levels and coarse steps are values like others.
 */
#include "modules/recording/data/fixture.h"

#include "long_form.h"
#include "unit/random_testing.h"

#define TWO_PI 6.283185307179586

static double between(double low, double high)
{
    return low + (high - low) * random_uniform();
}

struct sensed {
    double value[2000];
    int n;
};

/* A swing about 25 cm in mm, at 10 to 100 Hz. */
static void swing(struct sensed *s, double amplitude, double noise)
{
    const double samples = between(8, 60), phase = between(0, 6), fall = between(0, 1.5);
    s->n = (int)between(300, 2000);
    for (int i = 0; i < s->n; i++)
        s->value[i] = 250 + amplitude * exp(-fall * i / s->n) * cos(TWO_PI * i / samples + phase) +
                      noise * random_normal();
}

static void round_to(struct sensed *s, double step)
{
    for (int i = 0; i < s->n; i++)
        s->value[i] = nearbyint(s->value[i] / step) * step;
}

/* Returns the rows without a value; *warned tells if a reason was given. */
static int rows_left_out(const struct sensed *s, bool *warned)
{
    struct buffer text = {0};
    int missing = 0;
    buffer_put(&text, TEXT("t (ms),x (mm)\n"));
    for (int i = 0; i < s->n; i++)
        buffer_format(&text, "%d,%.10g\n", 20 * i, s->value[i]);
    struct recording *r = fixture_good(text.data, "");
    assert_int_equal(r->rows, s->n);
    for (size_t i = 0; i < r->rows; i++)
        missing += isnan(r->y[i]);
    *warned = fixture_warns(r, "as a sensor without a signal reports");
    recording_destroy(r);
    buffer_free(&text);
    return missing;
}

TEST(sentinels_are_left_out)
{
    static const double sent[] = {0, -1, 400, 8190, 65535, -9999};
    static struct sensed s;
    const int runs = is_long() ? 1500 : 200;
    bool warned;
    random_state = 101;
    for (int run = 0; run < runs; run++) {
        const double share = between(0.01, 0.4), value = sent[run % (int)COUNT_OF(sent)];
        const bool lasts = run % 4 == 3; /* a few rows each */
        int count = 0, left = 0;
        swing(&s, between(5, 60), between(0.05, 2));
        if (run % 2)
            round_to(&s, run % 3 ? 1 : 3);
        for (int i = 0; i < s.n; i++) {
            left = left > 0                                     ? left - 1
                   : random_uniform() < share / (lasts ? 3 : 1) ? 1 + 2 * lasts
                                                                : 0;
            if (left > 0 || (!lasts && random_uniform() < share))
                s.value[i] = value;
            count += s.value[i] == value;
        }
        if (count < 3 || count > 0.42 * s.n)
            continue;
        const int found = rows_left_out(&s, &warned);
        if (found != count || !warned)
            fail_msg("run %d: %d of %d rows read %g, %d were left out", run, count, s.n, value,
                     found);
    }
}

TEST(several_sentinels_are_left_out)
{
    static struct sensed s;
    bool warned;
    random_state = 102;
    for (int run = 0; run < 40; run++) {
        int count = 0;
        swing(&s, 40, 1);
        for (int i = 0; i < s.n; i++) {
            const double lot = random_uniform();
            s.value[i] = lot < 0.1 ? 0 : lot < 0.2 ? 65535 : lot < 0.25 ? 400 : s.value[i];
            count += lot < 0.25;
        }
        assert_int_equal(rows_left_out(&s, &warned), count);
        assert_true(warned);
    }
}

/* Marks rows at random, in short runs, or most of those where the object is out of range. */
static void lose_rows(const struct sensed *s, int kind, double share, double limit, bool *lost)
{
    int left = 0;
    for (int i = 0; i < s->n; i++) {
        if (kind == 1)
            left = left > 0 ? left - 1 : random_uniform() < share / 4 ? (int)between(1, 8) : 0;
        lost[i] = kind == 0   ? random_uniform() < share
                  : kind == 1 ? left > 0
                              : s->value[i] > limit && random_uniform() < 0.7;
    }
}

/* 400 beside 250 +- 40 lies 2.5 ranges off, 330 as much as one of eight, 250 among them; rows may
 * be lost just where the motion comes near the value. */
TEST(near_values_are_left_out)
{
    static const double sent[] = {400, 330, 350, 175, 302, 251.5};
    static struct sensed s;
    static bool lost[COUNT_OF(s.value)];
    const int runs = is_long() ? 1500 : 200;
    int judged = 0, partly = 0;
    bool warned;
    random_state = 104;
    for (int run = 0; run < runs; run++) {
        const size_t which = (size_t)run % COUNT_OF(sent);
        const bool inside = which > 3;
        int count = 0;
        swing(&s, 40, between(0.1, 2.5));
        if (run % 5 == 0 && !inside)
            round_to(&s, 1);
        lose_rows(&s, inside ? 0 : run / 6 % 3, between(0.03, 0.35), 250 + 40 * between(0.3, 0.8),
                  lost);
        for (int i = 0; i < s.n; i++) {
            s.value[i] = lost[i] ? sent[which] : s.value[i];
            count += lost[i];
        }
        if (count < 0.03 * s.n || count > 0.42 * s.n)
            continue;
        const int found = rows_left_out(&s, &warned);
        judged++;
        partly += found != count || !warned;
        if (!inside && found != count)
            fail_msg("run %d: %d of %d rows read %g, %d were left out", run, count, s.n,
                     sent[which], found);
    }
    print_message("%d of %d recordings with some left\n", partly, judged);
    assert_true(judged > 0.6 * runs && partly < 0.05 * judged);
}

/* Noise-free waves of a whole number of samples repeat each value exactly, the highest too. */
TEST(exact_waves_are_kept)
{
    static struct sensed s;
    const int runs = is_long() ? 2000 : 200;
    bool warned;
    random_state = 105;
    for (int run = 0; run < runs; run++) {
        const int kind = run % 7;
        const double samples = run % 3 ? floor(between(6, 60)) : between(6, 60),
                     phase = random_uniform(), width = between(0.05, 0.6);
        s.n = (int)between(300, 1500);
        for (int i = 0; i < s.n; i++) {
            const double turns = i / samples + phase, part = turns - floor(turns),
                         ripple = 0.05 * sin(i / 17.0);
            s.value[i] = kind == 0   ? part
                         : kind == 1 ? fabs(2 * part - 1)
                         : kind == 2 ? exp(-pow((part - 0.5) / 0.03, 2))
                         : kind == 3 ? exp(-3 * part)
                         : kind == 4 ? (part < width ? 1 : ripple)
                         : kind == 5 ? (part < 0.5 ? 1 : -1) * exp(-0.5 * i / s.n)
                                     : 4 * part * (1 - part);
        }
        const int found = rows_left_out(&s, &warned);
        if (found != 0 || warned)
            fail_msg("run %d, kind %d, %g samples: %d of %d rows were left out", run, kind, samples,
                     found, s.n);
    }
}

/* One kind of signal whose values are all true. */
static void make_true(struct sensed *s, int kind)
{
    const double level = between(0.2, 0.9), rest = between(100, 600);
    const int held = (int)between(20, 100), width = (int)between(1, 12), each = width * 4;
    swing(s, 40, kind % 2 ? 0.5 : 0);
    for (int i = 0; i < s->n; i++) {
        double *v = &s->value[i];
        if (kind < 2) /* saturated */
            *v = fmin(*v, 250 + 40 * level);
        else if (kind < 4) /* held before it is let go, at its largest or elsewhere */
            *v = i < held ? (kind == 2 ? 290 : rest) : *v;
        else if (kind < 6) /* at rest in the end */
            *v = i > s->n - 2 * held ? nearbyint(250 + 0.3 * random_normal()) : *v;
        else if (kind < 8) /* a light barrier: noise, and 5000 mV while it is interrupted */
            *v = i % each < width ? 5000 : 40 + random_normal();
        else if (kind < 10) /* two or three levels */
            *v = i % each < width ? 5000 : i % 2;
        else if (kind == 12) /* at rest before a trigger, at a value that is met again by chance */
            *v = i < 50 || i % 150 == 77 ? 250 : i < 52 ? 280 : *v;
    }
    if (kind == 10 || kind == 11) /* coarse steps */
        round_to(s, kind == 10 ? 10 : 25);
}

TEST(true_values_are_kept)
{
    static struct sensed s;
    const int runs = is_long() ? 100 : 20;
    bool warned;
    random_state = 103;
    for (int kind = 0; kind < 13; kind++)
        for (int run = 0; run < runs; run++) {
            make_true(&s, kind);
            const int found = rows_left_out(&s, &warned);
            if (found != 0 || warned)
                fail_msg("kind %d, run %d: %d of %d rows were left out", kind, run, found, s.n);
        }
}

RUN_TESTS(fixture_setup, fixture_teardown)
