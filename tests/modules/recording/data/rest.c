/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A motion rests only where a damped sine would still be seen: none does that, dry friction does.
 */
#include "modules/recording/table/load.h"

#include <math.h>

#include "cmocka_testing.h"

#include "unit/random_testing.h"

#define ROWS 2400
#define SEEDS 40
#define TWO_PI 6.283185307179586

static double y[ROWS], t[ROWS];
static unsigned char mask[ROWS];

/* Damped sine of period 1 s, amplitude 1. */
static void make(size_t n, double rate, double q, double noise, uint64_t seed)
{
    const double phase = TWO_PI * uniform_from(&seed);
    for (size_t i = 0; i < n; i++) {
        t[i] = (double)i / rate;
        y[i] =
            exp(-0.5 * TWO_PI / q * t[i]) * cos(TWO_PI * t[i] + phase) + noise * normal_from(&seed);
    }
}

static int rests(size_t n)
{
    return motion_rest(&(struct motion_rows){t, y, mask, 0, n}, 1) < n;
}

TEST(damped_sine_never_rests)
{
    static const double q[] = {1.5, 3, 10, 30, 80}, noise[] = {1e-5, 1e-3, 6e-3, 0.03, 0.1};
    (void)state;
    for (size_t i = 0; i < 5; i++)
        for (size_t j = 0; j < 5; j++) {
            int claimed = 0;
            for (uint64_t seed = 0; seed < SEEDS; seed++) {
                make(ROWS, 50, q[i], noise[j], seed);
                claimed += rests(ROWS);
            }
            if (claimed)
                print_message("Q = %g, noise %g: %d\n", q[i], noise[j], claimed);
            assert_int_equal(claimed, 0);
        }
}

TEST(few_samples_a_period_do_not_rest)
{
    int claimed = 0;
    (void)state;
    for (uint64_t seed = 0; seed < 200; seed++) {
        uint64_t s = seed + 1000;
        const double rate = 2.05 + 0.35 * uniform_from(&s), q = seed % 2 ? 300 : 60;
        make(200, rate, q, 6e-3, seed);
        claimed += rests(200);
    }
    assert_int_equal(claimed, 0);
}

/* Coulomb friction: the amplitude falls by the same in each half swing, and then it stays. */
TEST(dry_friction_rests)
{
    static const double noise[] = {1e-5, 1e-3, 6e-3, 0.03};
    (void)state;
    for (size_t j = 0; j < 4; j++)
        for (uint64_t seed = 0; seed < SEEDS; seed++) {
            uint64_t s = seed;
            /* of the amplitude, each half swing */
            const double half = 0.5 / floor(8 + 40 * uniform_from(&s)), rate = 50;
            for (size_t i = 0; i < ROWS; i++) {
                t[i] = (double)i / rate;
                const double k = floor(2 * t[i]), a = 1 - half - 2 * k * half;
                const double side = fmod(k, 2) < 1 ? 1 : -1,
                             swing = half + a * cos(TWO_PI * (t[i] - 0.5 * k));
                y[i] = (a > 0 ? side * swing : 0) + noise[j] * normal_from(&s);
            }
            assert_true(rests(ROWS));
        }
}

/* Stopped by a hand after six swings. */
TEST(stopped_by_a_hand)
{
    for (uint64_t seed = 0; seed < SEEDS; seed++) {
        uint64_t seed_of_rest = seed + 500;
        make(ROWS, 50, 60, 6e-3, seed);
        for (size_t i = 0; i < ROWS; i++)
            y[i] = t[i] > 6 ? 0.02 + 6e-3 * normal_from(&seed_of_rest) : y[i];
        assert_true(rests(ROWS));
    }
}

/* Returns where a sine of the period that is stopped after `moving` periods rests, in samples of
 * which 50 make a period; `all` if nowhere. */
static size_t quiet_from(double period, double moving, size_t all,
                         size_t (*judge)(const struct motion_rows *, double))
{
    uint64_t seed = 7;
    for (size_t i = 0; i < all; i++) {
        const double swings = (double)i / 50;
        t[i] = swings * period;
        y[i] = (swings < moving ? cos(TWO_PI * swings) : 0) + 1e-3 * normal_from(&seed);
    }
    return judge(&(struct motion_rows){t, y, mask, 0, all}, period);
}

/* The unit of time does not matter: powers of two change no digit. */
TEST(any_period)
{
    size_t (*const judges[])(const struct motion_rows *, double) = {motion_quiet, motion_rest};
    (void)state;
    for (size_t j = 0; j < 2; j++)
        for (double moving = 0.5; moving < 12; moving += 0.5) {
            const size_t rest = quiet_from(1, moving, 600, judges[j]);
            for (int power = -40; power <= 40; power += 5)
                assert_int_equal(quiet_from(ldexp(1, power), moving, 600, judges[j]), rest);
        }
}

/* Two periods of rest and two of motion before it, within half a period. */
TEST(two_periods_of_both)
{
    for (double moving = 0; moving <= 10; moving += 0.5) {
        const size_t rest = quiet_from(1, moving, 500, motion_quiet);
        if (moving < 2 || moving > 8)
            assert_int_equal(rest, 500);
        else if (moving > 3 && moving < 7.5)
            assert_true(fabs((double)rest - 50 * moving) <= 25);
    }
    assert_int_equal(quiet_from(1, 1.9, 199, motion_quiet), 199); /* too short for both */
}

RUN_TESTS(NULL, NULL)
