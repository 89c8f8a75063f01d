/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Pulse trains and waves about whose period a recording leaves doubt: phases that walk at random,
 * jitter, an amplitude that is modulated, neighbours that differ by about the noise. What is read
 * covers the truth, or a warning says that it may be another.
 */
#include <stdio.h>

#include "cmocka_testing.h"

#include "long_form.h"
#include "unit/detect_recordings.h"

enum { PULSES_MAX = 128, TRUTHS_MAX = 3 };

struct tally {
    int all, silent, beyond, said, refused;
};

static int cases(int quick)
{
    return is_long() ? 10 * quick : quick;
}

/* Counts a reading that is none of some periods within three of its uncertainties. Beyond four it
 * is wrong. */
static void count_reading(struct drawn *d, const double *truth, int truths, const char *name,
                          struct tally *tally)
{
    const struct series series = {.t = d->t, .y = d->y, .n = d->n, .quantity = QUANTITY_LENGTH};
    struct period p = {.period = {NAN, NAN}};
    struct arena arena = {0};
    struct error error = {0};
    double off = HUGE_VAL;
    tally->all++;
    const bool read = series_period(&series, &arena, &p, &error);
    for (int i = 0; i < truths; i++)
        off = fmin(off, fabs(p.period.value - truth[i]) / (p.period.uncertainty + 1e-9 * truth[i]));
    tally->refused += !read;
    tally->said += read && p.warning[0];
    if (read && !p.warning[0] && off > 3) {
        tally->beyond++;
        tally->silent += off > 4;
        print_message("%s: T %.6g read as %.6g +- %.2g (%s, %.3g periods, %zu rows): %.3g sigma\n",
                      name, truth[0], p.period.value, p.period.uncertainty, p.how,
                      d->span / truth[0], d->n, off);
    }
    arena_reset(&arena);
    free(d->t);
    free(d->y);
}

static void assert_tally(const char *name, const struct tally *t, int silent_percent)
{
    print_message("%s: of %d, %d wrong without a word, %d beyond 3 sigma, %d with a word, %d "
                  "refused\n",
                  name, t->all, t->silent, t->beyond, t->said, t->refused);
    assert_true(100 * t->silent <= silent_percent * t->all);
    assert_true(100 * (t->beyond - t->silent) <= 100 + 2 * t->all);
    assert_true(5 * t->refused <= t->all);
}

struct pulses {
    double place[PULSES_MAX], height[PULSES_MAX]; /* [periods] */
    double width, phase;                          /* [periods] */
    int kind;
};

enum { GAUSSIAN, DRAINING, ROUNDED, KINDS };

/* Returns a pulse at some distance after its middle, in widths. */
static double pulse(int kind, double off)
{
    if (kind == DRAINING)
        return off < -1 ? 0 : off < 0 ? 1 + off : exp(-off);
    if (kind == ROUNDED)
        return fabs(off) < 2 ? 0.5 * (1 + cos(0.5 * PI * off)) : 0;
    return exp(-0.5 * off * off);
}

static struct drawn draw_pulses(const struct pulses *p, double cycles, double samples, double noise)
{
    struct drawn d = draw((size_t)(cycles * samples) + 1, 50);
    d.period = samples / 50;
    for (size_t k = 0; k < d.n; k++)
        for (int j = 0; j < PULSES_MAX; j++) {
            const double off = (d.t[k] / d.period - p->place[j]) / p->width;
            if (fabs(off) < 12)
                d.y[k] += p->height[j] * pulse(p->kind, off);
        }
    add_noise(&d, noise);
    return d;
}

/* Sets even pulses of one height. */
static void set_even(struct pulses *p, int kind)
{
    p->width = random_between(0.03, 0.12);
    p->phase = random_uniform();
    p->kind = kind;
    for (int j = 0; j < PULSES_MAX; j++) {
        p->place[j] = j - 3 + p->phase;
        p->height[j] = 1;
    }
}

static double random_cycles(int i)
{
    return i % 2 ? random_between(3.2, 12) : of_random_size(12, 100);
}

/* Each pulse comes some random time after the one before, or off its own place. */
TEST(pulses_that_come_at_random_times)
{
    struct tally tally[2] = {{0}, {0}};
    random_state = 901;
    for (int i = 0; i < cases(48); i++) {
        struct pulses p;
        const bool walks = i % 4 < 2;
        const double jitter = of_random_size(0.003, 0.08), cycles = random_cycles(i);
        set_even(&p, i % KINDS);
        double before = p.place[0];
        for (int j = 1; j < PULSES_MAX; j++) {
            before = walks ? before + 1 + jitter * random_normal() : p.place[j];
            p.place[j] = walks ? before : before + jitter * random_normal();
        }
        struct drawn d =
            draw_pulses(&p, cycles, of_random_size(20, 100), i % 3 ? of_random_size(1e-3, 0.1) : 0);
        const int few = 6;
        const double truth[TRUTHS_MAX] = {
            d.period, d.period * (p.place[(int)cycles + 2] - p.place[3]) / ((int)cycles - 1)};
        char name[60];
        snprintf(name, sizeof name, "%s %.2g kind %d", walks ? "walk" : "jitter", jitter, p.kind);
        count_reading(&d, truth, cycles < few ? 2 : 1, name, &tally[walks]);
    }
    assert_tally("jitter", &tally[0], 0);
    assert_tally("random walk", &tally[1], 2);
}

/* The height is modulated by 5 to 60 % after whole numbers of pulses, or others. */
TEST(pulses_of_modulated_height)
{
    struct tally tally[2] = {{0}, {0}};
    random_state = 902;
    for (int i = 0; i < cases(48); i++) {
        struct pulses p;
        const bool whole = i % 4 < 2;
        const double depth = of_random_size(0.05, 0.6), cycles = random_cycles(i),
                     each = whole ? floor(random_between(2, 9)) : random_between(2.2, 15),
                     angle = random_between(0, 2 * PI);
        set_even(&p, i % KINDS);
        for (int j = 0; j < PULSES_MAX; j++)
            p.height[j] = 1 + depth * cos(2 * PI * p.place[j] / each + angle);
        struct drawn d =
            draw_pulses(&p, cycles, of_random_size(20, 100), i % 3 ? of_random_size(1e-3, 0.1) : 0);
        const double truth[TRUTHS_MAX] = {d.period, each * d.period};
        char name[60];
        snprintf(name, sizeof name, "depth %.2g every %.3g kind %d", depth, each, p.kind);
        count_reading(&d, truth, whole ? 2 : 1, name, &tally[whole]);
    }
    assert_tally("modulated", &tally[0], 0);
    assert_tally("modulated, whole", &tally[1], 0);
}

/* Every second pulse, or wave, is higher by about the noise. Where it is by five standard
 * deviations of what all rows show of it, one period alone is wrong. */
TEST(neighbours_that_differ_by_the_noise)
{
    struct tally tally[2] = {{0}, {0}};
    random_state = 903;
    for (int i = 0; i < cases(48); i++) {
        struct pulses p;
        const double noise = of_random_size(5e-3, 0.1), differ = noise * of_random_size(0.3, 6),
                     samples = of_random_size(20, 100), cycles = random_cycles(i);
        const int turns = i % 5 ? 2 : 3;
        set_even(&p, i % KINDS);
        p.width = fmax(p.width, (p.kind == DRAINING ? 8 : 3) /
                                    samples); /* else samples of a pulse differ by where it falls */
        for (int j = 0; j < PULSES_MAX; j++)
            p.height[j] = j % turns == 0 ? 1 + differ : 1;
        double square = 0;
        struct drawn d = draw_pulses(&p, cycles, samples, 0);
        const double mean = 1 + differ / turns;
        for (size_t k = 0; k < d.n; k++)
            for (int j = 0; j < PULSES_MAX; j++) {
                const double off = (d.t[k] / d.period - p.place[j]) / p.width;
                const double share = fabs(off) < 12 ? (p.height[j] - mean) * pulse(p.kind, off) : 0;
                square += share * share;
            }
        add_noise(&d, noise);
        const bool clear = sqrt(square) > 6 * noise;
        const double truth[TRUTHS_MAX] = {turns * d.period, d.period};
        char name[60];
        snprintf(name, sizeof name, "differ %.2g noise %.2g (%.3g) kind %d", differ, noise,
                 sqrt(square) / noise, p.kind);
        count_reading(&d, truth, clear ? 1 : 2, name, &tally[clear]);
    }
    assert_tally("differ below chance", &tally[0], 0);
    assert_tally("differ clearly", &tally[1], 6);
}

/* Waves that are all alike bring hardly a warning. */
TEST(waves_alike)
{
    struct tally tally = {0};
    random_state = 904;
    for (int i = 0; i < cases(72); i++) {
        const double cycles = random_cycles(i / 2), samples = of_random_size(20, 100),
                     decay = i % 3 ? 0 : random_between(0, 2), phase = random_uniform(),
                     noise = i % 5 ? of_random_size(1e-3, 0.1) : 0;
        struct pulses p;
        set_even(&p, i % KINDS);
        struct drawn d = draw_pulses(&p, cycles, samples, 0);
        for (size_t k = 0; k < d.n; k++) {
            const double x = d.t[k] / d.period + phase;
            d.y[k] = (i % 2 ? cos(2 * PI * x) : d.y[k]) * exp(-decay * d.t[k] / d.span);
        }
        add_noise(&d, noise);
        char name[60];
        snprintf(name, sizeof name, "alike noise %.2g decay %.2g %s", noise, decay,
                 i % 2 ? "sine" : "pulses");
        count_reading(&d, &d.period, 1, name, &tally);
    }
    /* Without noise, 1 of 720 (the long form) is off by 2e-8 of itself, 5.4 of its uncertainties:
     * as the samples fall alike in all pulses, their interpolation is off alike. None of 72 may be.
     */
    assert_tally("alike", &tally, 1);
    assert_true(100 * tally.said <= 4 * tally.all);
}

RUN_TESTS(NULL, NULL)
