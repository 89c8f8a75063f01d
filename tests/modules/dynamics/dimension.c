/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The dimension of Kaplan and Yorke from given exponents, against where the sum of exponents,
 * drawn as a chain of straight pieces, crosses 0. */
#include "cmocka_testing.h"
#include <stdlib.h>
#include <string.h>

#include "modules/solving/testing.h"
#include "modules/dynamics/dynamics.h"

#include <hooke/base/numeric.h>

#include "modules/dynamics/orbits/dimension.h"

enum { CASES = 400 };

static double between(uint64_t *seed, double from, double to)
{
    return from + (to - from) * random_fraction(seed);
}

static int fall(const void *a, const void *b)
{
    const struct exponent *x = a, *y = b;
    return (x->value < y->value) - (x->value > y->value);
}

static double chain_height(const struct exponent *e, int n, double at)
{
    double height = 0;
    for (int i = 0; i < n; i++)
        height += e[i].value * fmin(fmax(at - i, 0), 1);
    return height;
}

/* The last crossing of the chain, by bisection: it rises first, if it does, and then falls. */
static double crossing(const struct exponent *e, int n)
{
    double lo = 0, hi = n;
    if (chain_height(e, n, hi) >= 0)
        return n;
    for (int i = 0; i < n; i++)
        if (chain_height(e, n, i) >= 0)
            lo = i;
    for (int k = 0; k < 100; k++) {
        const double middle = (lo + hi) / 2;
        *(chain_height(e, n, middle) >= 0 ? &lo : &hi) = middle;
    }
    return lo;
}

/* Spectra of all sizes; in every other one a partial sum is within its error of 0. */
TEST(test_random_spectra)
{
    uint64_t seed = 17;
    for (int k = 0; k < CASES; k++) {
        struct exponent e[DYNAMICS_VARIABLES], moved[DYNAMICS_VARIABLES];
        double slope[DYNAMICS_VARIABLES];
        const int n = 1 + (int)(7 * random_fraction(&seed));
        double sum = 0;
        for (int i = 0; i < n; i++)
            e[i] = (struct exponent){between(&seed, -3, 1.5), between(&seed, 0.002, 0.05)};
        qsort(e, (size_t)n, sizeof *e, fall);
        for (int i = 0; i < n && k % 2 == 0; i++) {
            const double wanted = between(&seed, -1.5, 1.5) * e[i].error - sum;
            if (i > 0 && sum > 0.5 && wanted < e[i - 1].value - 0.01) {
                e[i].value = wanted;
                qsort(e, (size_t)n, sizeof *e, fall);
                break;
            }
            sum += e[i].value;
        }
        const double wanted = crossing(e, n), found = kaplan_yorke(e, n, n, 1, slope);
        close_to(found, wanted, 1e-12);
        for (int i = 0; i < n && found > 0 && found < n && fabs(found - round(found)) > 0.2; i++) {
            const double by = 1e-6;
            memcpy(moved, e, sizeof moved);
            moved[i].value += by;
            const double change = crossing(moved, n) - wanted;
            close_to(slope[i], change / by, 1e-4 * (1 + slope[i]));
        }
    }
}

/* A cycle and a torus have whole dimensions, whatever the signs of what should be 0; the exponents
 * that are known have to go far enough. */
TEST(test_regular_motion)
{
    double slope[4];
    for (int zeros = 1; zeros <= 3; zeros++)
        for (int sign = -1; sign <= 1; sign++) {
            struct exponent e[4] = {{1e-10, 1e-9}, {1e-10, 1e-9}, {1e-10, 1e-9}, {-1, 1e-9}};
            for (int i = 0; i < zeros; i++)
                e[i].value *= sign * (i + 1);
            for (int i = zeros; i < 3; i++)
                e[i].value = i - 4;
            e[3].value = -4;
            close_to(kaplan_yorke(e, 4, 4, 1, slope), zeros, 1e-8);
            assert_true(isnan(kaplan_yorke(e, zeros, 4, 1, slope)));
        }
    const struct exponent rest[] = {{-0.1, 1e-9}, {-0.2, 1e-9}};
    close_to(kaplan_yorke(rest, 2, 2, 1, slope), 0, 0);
}

/* Lorenz 1996 with 5 variables and F = 8: the sum of three is below 0, within three errors. */
TEST(test_sum_near_zero)
{
    const struct exponent e[] = {
        {0.472, 0.01}, {0.003, 0.005}, {-0.515, 0.02}, {-1.3, 0.02}, {-3.66, 0.02}};
    double slope[5];
    close_to(kaplan_yorke(e, 5, 5, 1, slope), 2 + 0.475 / 0.515, 1e-12);
    /* on the other side of 3 a change goes as far as on this one */
    const struct exponent above[] = {
        {0.52, 0.01}, {0.003, 0.005}, {-0.515, 0.02}, {-1.3, 0.02}, {-3.66, 0.02}};
    close_to(kaplan_yorke(above, 5, 5, 1, slope), 3 + 0.008 / 1.3, 1e-12);
    close_to(slope[0], 1 / 0.515, 1e-12);
}

RUN_TESTS(NULL, NULL)
