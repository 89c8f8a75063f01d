/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Repeated measurements: what is quoted covers the truth whether or not the stated uncertainties
 * are right. */

#include "cmocka_testing.h"

#include "modules/recording/analysis/testing.h"

enum { TRIALS = 2000, MOST = 12 };

struct outcome {
    int covered, suspected;
    double quoted; /* mean uncertainty */
};

/* n values about 5 whose scatter is sqrt(u^2 + between^2) where u is stated. */
static struct outcome trials(int n, double between)
{
    struct outcome outcome = {0};
    for (int k = 0; k < TRIALS; k++) {
        struct measured x[MOST];
        struct repeat r;
        for (int i = 0; i < n; i++) {
            const double u = random_between(0.01, 0.02);
            x[i] = (struct measured){5 + u * random_normal() + between * random_normal(), u};
        }
        assert_true(repeat_values(x, n, &r));
        outcome.covered += fabs(r.quote.value - 5) <= r.interval;
        outcome.suspected += r.chance < 0.01;
        outcome.quoted += r.quote.uncertainty / TRIALS;
    }
    return outcome;
}

TEST(what_is_quoted_covers)
{
    static const int counts[] = {3, 5, 12};
    random_state = 3;
    for (size_t i = 0; i < COUNT_OF(counts); i++) {
        const int n = counts[i];
        const struct outcome right = trials(n, 0), small = trials(n, 0.05), far = trials(n, 0.15);
        print_message("%2d values: %4.1f %% covered and %4.1f %% suspected where right; 3 times "
                      "too small %4.1f, %4.1f; "
                      "10 times %4.1f, %4.1f\n",
                      n, 100.0 * right.covered / TRIALS, 100.0 * right.suspected / TRIALS,
                      100.0 * small.covered / TRIALS, 100.0 * small.suspected / TRIALS,
                      100.0 * far.covered / TRIALS, 100.0 * far.suspected / TRIALS);
        assert_true(right.covered >= 0.94 * TRIALS && right.suspected <= 0.02 * TRIALS);
        assert_true(small.covered >= 0.90 * TRIALS && small.covered <= 0.99 * TRIALS);
        assert_true(far.covered >= 0.90 * TRIALS && far.covered <= 0.99 * TRIALS);
        assert_true(n == 3 || far.suspected >= 0.95 * TRIALS);
        /* Where they scatter by more it is the scatter that counts. */
        assert_true(close_to(far.quoted, 0.15 / sqrt(n), 0.25 * 0.15 / sqrt(n)));
    }
}

/* 1, 2 and 4 with uncertainties of 1: mean 7/3, sum of squares 14/3. */
TEST(closed_forms)
{
    const struct measured x[] = {{1, 1}, {2, 1}, {4, 1}}, bare[] = {{1, 0}, {2, 0}, {4, 0}};
    struct repeat r;
    assert_false(repeat_values(x, 1, &r));
    assert_true(repeat_values(x, 3, &r));
    assert_true(close_to(r.mean.value, 7.0 / 3, 1e-14));
    assert_true(close_to(r.scatter, sqrt(7.0 / 3), 1e-14));
    assert_true(close_to(r.birge, sqrt(7.0 / 3), 1e-14));
    assert_true(close_to(r.weighted.uncertainty, 1 / sqrt(3.0), 1e-14));
    assert_true(close_to(r.chance, exp(-7.0 / 3), 1e-12)); /* chi2 of 2 degrees */
    assert_true(close_to(r.excess_scatter, sqrt(7.0 / 3 - 1), 1e-12));
    assert_true(close_to(r.quote.uncertainty, sqrt(7.0 / 9), 1e-12));
    /* Student, 2 degrees */
    assert_true(close_to(r.interval, 4.302652729911275 * sqrt(7.0 / 9), 1e-9));
    assert_true(repeat_values(bare, 3, &r));
    assert_true(isnan(r.birge) && isnan(r.weighted.value));
    assert_true(close_to(r.quote.uncertainty, sqrt(7.0 / 9), 1e-14));
}

RUN_TESTS(NULL, NULL)
