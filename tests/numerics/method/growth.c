/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Growth a step: every row run on both sides of its limit, the windows of instability of splittings
 * and of backward differentiation, and growth without damping to leading order, against independent
 * values.
 */
#include "cmocka_testing.h"

#include "numerics/method/testing.h"

/* Amplitude after n steps, from 1 on. HUGE_VAL: a step failed. */
static double amplitude(const struct method *method, enum drag drag, double x, double zeta, long n)
{
    struct system system = SPRING({"m", 1}, {"k", 1}, {"gamma", 2 * zeta});
    double y[2] = {1, 0.3};
    return advance_as(method, drag, &system, 0, x, n, y) == STEP_OK ? hypot(y[0], y[1]) : HUGE_VAL;
}

/* Steps that make of a mode 1e20 times what it was (a good start leaves little of it); 0: too many.
 */
static long steps_to_grow(double growth, double max)
{
    double n = log(1e20) / log(growth);
    return n > 0 && n < max ? (long)ceil(n) + 10 : 0;
}

/* Grows, and by what is predicted. */
static void check_growth(const char *what, const struct method *method, enum drag drag, double x,
                         double zeta, long n)
{
    double first = amplitude(method, drag, x, zeta, n / 2),
           last = amplitude(method, drag, x, zeta, n);
    assert_above(what, last, 1e6);
    double predicted = (double)(n - n / 2) * log(method_growth(method, drag, x, zeta));
    assert_near(what, log(last / first), predicted, 4);
}

static void check_limit(const struct method *method, enum drag drag, double zeta)
{
    char what[100];
    snprintf(what, sizeof what, "%s drag %d zeta %g", method->row.name, drag, zeta);
    double limit = method_stable_limit(method, drag, zeta);
    if (limit == HUGE_VAL) {
        for (double x = 0.3; x < 1e4; x *= 7)
            assert_below(what, amplitude(method, drag, x, zeta, 300), 20);
        return;
    }
    /* As near to the limit as growth shows in so many steps. */
    for (double off = 1e-3; off < 50; off *= 2) {
        double x = limit > 0 ? limit * (1 + off) : 0.3 + off;
        long n = steps_to_grow(method_growth(method, drag, x, zeta), 2000);
        if (n == 0)
            continue;
        check_growth(what, method, drag, x, zeta, n);
        if (limit > 0)
            assert_below(what, amplitude(method, drag, limit * fmax(1 - off, 0.5), zeta, n), 300);
        return;
    }
    fail_msg("%s: nothing grows beyond the limit %g", what, limit);
}

TEST(test_both_sides_of_every_limit)
{
    static const double some[] = {0, 0.1, 0.5, 2};
    int limits_checked = 0;
    for (size_t m = 0; m < method_catalog.count; m++)
        for (int drag = DRAG_DEFAULT; drag < DRAG_COUNT; drag++)
            for (size_t z = 0; z < COUNT_OF(some); z++) {
                const struct method *method = method_at(m);
                if (method->flags & METHOD_EXTERNAL ||
                    isnan(method_growth(method, (enum drag)drag, 0.1, some[z])))
                    continue;
                check_limit(method, (enum drag)drag, some[z]);
                limits_checked++;
            }
    assert_true(limits_checked > 100);
}

/* ---- windows: stable, unstable, stable again ---- */

static double growth_of(const char *name, double x, double zeta)
{
    return method_growth(method_named(name), DRAG_DEFAULT, x, zeta);
}

static const struct {
    const char *name;
    double from, to, max; /* largest growth inside */
} windows[] = {
    {"blanes-moan6-11", 3.1414311, 3.1423200, 1.00044},
    {"blanes-moan6-14", 3.1409251, 3.1421128, 1.00059},
    {"blanes-moan6", 3.1342475, 3.1508280, 1.0083},
    {"blanes-moan4", 3.1634651, 3.1685387, 1.0024},
    {"blanes-moan4s", 3.1328234, 3.1601087, 1.0136},
    {"kahan-li8", 3.0964387, 3.1401878, 1.0230},
    {"pefrl", 2.98945, 3.50542, 1.249},
};

TEST(test_resonance_windows)
{
    for (size_t i = 0; i < COUNT_OF(windows); i++) {
        const char *name = windows[i].name;
        double width = windows[i].to - windows[i].from, max = 0;
        for (int k = -20; k <= 1020; k++) {
            double x = windows[i].from + width * k / 1000, growth = growth_of(name, x, 0);
            if (k < -10 || k > 1010)
                assert_near(name, growth, 1, 1e-12);
            else if (k > 10 && k < 990)
                assert_above(name, growth, 1 + 1e-6);
            max = fmax(max, growth);
        }
        assert_near(name, max - 1, windows[i].max - 1, 0.02 * (windows[i].max - 1));
        double middle = windows[i].from + width / 2, below = windows[i].from - width / 10;
        long n = steps_to_grow(growth_of(name, middle, 0), 200000);
        check_growth(name, method_named(name), DRAG_DEFAULT, middle, 0, n);
        assert_below(name, amplitude(method_named(name), DRAG_DEFAULT, below, 0, n), 300);
    }
}

/* Where growth passes 1 between two x. */
static double crossing(const char *name, double a, double b)
{
    bool rising = growth_of(name, b, 0) > 1;
    for (int i = 0; i < 60; i++)
        *((growth_of(name, (a + b) / 2, 0) > 1) == rising ? &b : &a) = (a + b) / 2;
    return a;
}

TEST(test_windows_of_differentiation)
{
    assert_near("bdf3", crossing("bdf3", 1.5, 3), sqrt(15) / 2, 1e-9);
    assert_near("bdf4", crossing("bdf4", 4, 6), 10 * sqrt(2) / 3, 1e-9);
    assert_near("bdf5", crossing("bdf5", 0.5, 2), 0.710807671, 2e-9);
    assert_near("bdf5", crossing("bdf5", 5, 15), 9.392019497, 2e-9);
    assert_near("bdf6", crossing("bdf6", 0.5, 2), 0.843138162, 2e-9);
    assert_near("bdf6", crossing("bdf6", 10, 30), 17.5705469, 2e-7);
    assert_near("abm3", crossing("abm3", 0.2, 0.6), 0.42926, 1e-5);
    assert_near("abm3", crossing("abm3", 0.8, 1.5), 1.16423, 1e-5);
}

/* Largest growth over all x, by golden section around the best of a coarse search. */
static double worst_growth(const char *name, double zeta)
{
    double best = 0, at = 0;
    for (double x = 0.1; x < 50; x *= 1.02) {
        double growth = growth_of(name, x, zeta);
        if (growth > best)
            best = growth, at = x;
    }
    double a = at / 1.02, b = at * 1.02;
    for (int i = 0; i < 60; i++) {
        double p = b - 0.618033988749895 * (b - a), q = a + 0.618033988749895 * (b - a);
        *(growth_of(name, p, zeta) > growth_of(name, q, zeta) ? &b : &a) =
            growth_of(name, p, zeta) > growth_of(name, q, zeta) ? q : p;
    }
    return growth_of(name, (a + b) / 2, zeta);
}

/* Backward differentiation is stable at every step from a damping ratio on that is the cosine of
 * its angle A(alpha). */
TEST(test_damping_that_suffices)
{
    static const struct {
        const char *name;
        double zeta, degrees;
    } rows[] = {{"bdf3", 0.0691929304527, 86.0323669},
                {"bdf4", 0.286496619721, 73.3516705},
                {"bdf5", 0.617862963825, 51.8397558},
                {"bdf6", 0.951916933284, 17.8397778}};
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        double low = rows[i].zeta * 0.99, high = rows[i].zeta * 1.01;
        for (int k = 0; k < 34; k++)
            *(worst_growth(rows[i].name, (low + high) / 2) > 1 ? &low : &high) = (low + high) / 2;
        assert_near(rows[i].name, high, rows[i].zeta, 1e-8);
        assert_near(rows[i].name, acos(high) * 180 / acos(-1), rows[i].degrees, 2e-6);
        const struct method *method = method_named(rows[i].name);
        assert_true(method_stable_limit(method, DRAG_DEFAULT, rows[i].zeta * 1.001) == HUGE_VAL);
        assert_true(method_stable_limit(method, DRAG_DEFAULT, rows[i].zeta * 0.995) < 100);
    }
}

/* ---- slow growth and decay without damping: growth - 1 = c x^q to leading order ---- */

TEST(test_leading_growth)
{
    static const struct {
        const char *name;
        double c;
        int q;
    } rows[] = {
        {"euler", 1. / 2, 2},
        {"backward-euler", -1. / 2, 2},
        {"midpoint", 1. / 8, 4},
        {"heun", 1. / 8, 4},
        {"ralston", 1. / 8, 4},
        {"kutta3", -1. / 24, 4},
        {"rk4", -1. / 144, 6},
        {"rk38", -1. / 144, 6},
        {"dopri5", -1. / 3600, 6},
        {"tsit5", -4.332e-5, 6},
        {"ab2", 1. / 4, 4},
        {"ab5", 95. / 288, 6},
        {"abm3", 1. / 24, 4},
        {"abm4", 31. / 192, 6},
        {"bdf1", -1. / 2, 2},
        {"bdf2", -1. / 4, 4},
        {"bdf3", 1. / 4, 4},
        {"bdf4", 1. / 3, 6},
        {"radau3", -1. / 72, 4},
        {"radau5", -1. / 7200, 6},
        {"sdirk2", -0.00367966, 4},
        {"tr-bdf2", -0.00367966, 4},
        {"wilson-theta", -21. / 250, 4},
        {"bogacki-shampine", -1. / 24, 4},
    };
    for (size_t i = 0; i < COUNT_OF(rows); i++) {
        double x = rows[i].q == 2   ? 1e-3
                   : rows[i].q == 4 ? 0.01
                                    : 0.04,
               wanted = rows[i].c * pow(x, rows[i].q);
        assert_near(rows[i].name, growth_of(rows[i].name, x, 0) - 1, wanted,
                    0.02 * fabs(wanted) + 1e-15);
    }
}

RUN_TESTS(NULL, NULL)
