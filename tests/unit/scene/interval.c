/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Intervals hold every result of numbers in them, to the last bit, and are no wider than that
 * needs. The judge is exact: what rounding leaves of a sum (Knuth's two-sum), fma() for products
 * and quotients; functions are judged by long double.
 */
#include "long_form.h"
#include "unit/scene/testing.h"

#include <hooke/scene/formula.h>
#include <hooke/scene/interval.h>

#include <float.h>
#include <math.h>

static const double special[] = {
    0,        -0.0,     1,       -1,       0x1p-53,     -0x1p-53,  1 + 0x1p-52, 1 - 0x1p-53,
    0x1p-54,  3,        1.0 / 3, 2,        -2,          0x1p-1074, -0x1p-1074,  0x1p-1022,
    0x1p-600, -0x1p600, DBL_MAX, -DBL_MAX, 0x1.8p-1021, 0x1p53,    0x1p-1040,   5};

static double random_number(uint64_t *seed)
{
    const double kind = random_unit(seed);
    if (kind < 0.3)
        return special[(size_t)(random_unit(seed) * (double)COUNT_OF(special))];
    if (kind < 0.6)
        return floor(random_between(seed, -9, 9));
    return random_between(seed, -1, 1) * pow(2, floor(random_between(seed, -60, 60)));
}

static struct interval random_interval(uint64_t *seed)
{
    const double a = random_number(seed), b = random_unit(seed) < 0.3 ? a : random_number(seed);
    struct interval out = {fmin(a, b), fmax(a, b)};
    if (random_unit(seed) < 0.05)
        out.lo = -HUGE_VAL;
    if (random_unit(seed) < 0.05)
        out.hi = HUGE_VAL;
    return out;
}

static double point_in(uint64_t *seed, struct interval a)
{
    const double lo = fmax(a.lo, -DBL_MAX), hi = fmin(a.hi, DBL_MAX), kind = random_unit(seed);
    if (kind < 0.4 || lo == hi)
        return kind < 0.2 ? lo : hi;
    const double x = kind < 0.7 ? random_number(seed) : lo / 2 + hi / 2;
    return fmin(fmax(x, lo), hi);
}

/* ---- the sign of bound - result ---- */

static int sign(long double value)
{
    return (value > 0) - (value < 0);
}

static bool is_moderate(double x)
{
    return fabs(x) > 0x1p-400 && fabs(x) < 0x1p400;
}

static int beside_sum(double bound, double x, double y)
{
    const double sum = x + y, part = sum - x, rest = (x - (sum - part)) + (y - part);
    if (bound == sum && fabs(sum) < 0x1p1000 && fabs(x) < 0x1p1000)
        return -sign((long double)rest);
    return sign((long double)bound - ((long double)x + (long double)y));
}

static int beside_product(double bound, double x, double y)
{
    if (is_moderate(x) && is_moderate(y) && isfinite(bound))
        return -sign((long double)fma(x, y, -bound));
    return sign((long double)bound - (long double)x * (long double)y);
}

static int beside_quotient(double bound, double x, double y)
{
    if (is_moderate(x) && is_moderate(y) && is_moderate(bound))
        return sign((long double)fma(bound, y, -x)) * sign((long double)y);
    return sign((long double)bound - (long double)x / (long double)y);
}

static const struct {
    const char *name;
    struct interval (*bounds)(struct interval a, struct interval b);
    int (*beside)(double bound, double x, double y);
} operation[] = {
    {"+", interval_add, beside_sum},
    {"*", interval_mul, beside_product},
    {"/", interval_div, beside_quotient},
};

/* Every number of two intervals gives one inside of the bounds; of single numbers these are the
 * neighbours of what it is rounded to, and 0 is known exactly. */
TEST(test_operations)
{
    uint64_t seed = 5;
    const int count = is_long() ? 3000000 : 300000;
    for (int k = 0; k < count; k++) {
        const struct interval a = random_interval(&seed), b = random_interval(&seed);
        for (size_t i = 0; i < COUNT_OF(operation); i++) {
            const struct interval bounds = operation[i].bounds(a, b);
            const double x = point_in(&seed, a), y = point_in(&seed, b);
            if (operation[i].beside == beside_quotient && y == 0)
                continue;
            if (operation[i].beside(bounds.lo, x, y) > 0 ||
                operation[i].beside(bounds.hi, x, y) < 0)
                fail_msg("%a %s %a is not in %a .. %a, of [%a, %a] and [%a, %a]", x,
                         operation[i].name, y, bounds.lo, bounds.hi, a.lo, a.hi, b.lo, b.hi);
        }
    }
}

static void assert_neighbours(struct interval bounds, double value)
{
    if (fabs(value) < 0x1p-900 || !isfinite(value))
        return;
    assert_true(bounds.lo >= nextafter(value, -HUGE_VAL) &&
                bounds.hi <= nextafter(value, HUGE_VAL));
}

TEST(test_tightness)
{
    uint64_t seed = 6;
    for (int k = 0; k < 100000; k++) {
        const double x = random_number(&seed), y = random_number(&seed);
        const struct interval a = interval_point(x), b = interval_point(y);
        assert_neighbours(interval_add(a, b), x + y);
        assert_neighbours(interval_sub(a, b), x - y);
        assert_neighbours(interval_mul(a, b), x * y);
        assert_neighbours(interval_div(a, b), x / y);
        assert_neighbours(interval_square(a), x * x);
    }
    const struct interval up = {0, 3}, down = {-2, 0}, both = {-1, 2};
    assert_true(interval_mul(up, up).lo == 0 && interval_mul(down, down).lo == 0 &&
                interval_mul(up, down).hi == 0 && interval_add(up, up).lo == 0 &&
                interval_div(up, interval_point(-7)).hi == 0 && interval_square(both).lo == 0 &&
                interval_power(both, 1).lo == -1 && interval_power(up, -2).lo == -HUGE_VAL);
}

/* ---- functions and powers, by long double ---- */

#define SLACK (8 * LDBL_EPSILON)

static bool holds(struct interval bounds, long double value)
{
    const long double off = SLACK * fabsl(value);
    return (long double)bounds.lo <= value + off && value - off <= (long double)bounds.hi;
}

static long double power_of(double x, int n)
{
    long double out = 1;
    for (int k = 0; k < abs(n); k++)
        out *= (long double)x;
    return n < 0 ? 1 / out : out;
}

TEST(test_powers)
{
    uint64_t seed = 7;
    for (int k = 0; k < 200000; k++) {
        const int n = (int)random_between(&seed, -8, 9);
        const struct interval a = random_interval(&seed), bounds = interval_power(a, n);
        const double x = point_in(&seed, a);
        const long double value = power_of(x, n);
        if (n < 0 && x == 0)
            continue;
        if (!holds(bounds, value))
            fail_msg("(%a)^%d is not in %a .. %a, of [%a, %a]", x, n, bounds.lo, bounds.hi, a.lo,
                     a.hi);
    }
}

static bool find_name(const void *context, struct text name, int *slot)
{
    (void)context;
    *slot = 0;
    return name.len == 1;
}

/* Long and short ranges, far from 0 and near, with their middles, ends and what lies between. */
TEST(test_functions)
{
    static const struct {
        const char *text;
        long double (*value)(long double x);
        double from, to;
    } row[] = {
        {"sin(x)", sinl, -1e6, 1e6}, {"cos(x)", cosl, -1e6, 1e6},   {"tan(x)", tanl, -50, 50},
        {"asin(x)", asinl, -1, 1},   {"acos(x)", acosl, -1, 1},     {"atan(x)", atanl, -1e3, 1e3},
        {"sinh(x)", sinhl, -30, 30}, {"cosh(x)", coshl, -30, 30},   {"tanh(x)", tanhl, -30, 30},
        {"sqrt(x)", sqrtl, 0, 1e6},  {"cbrt(x)", cbrtl, -1e6, 1e6}, {"exp(x)", expl, -750, 700},
        {"log(x)", logl, 0, 1e9},    {"log10(x)", log10l, 0, 1e9}};
    const struct expr_scope scope = {.find = find_name};
    const int count = is_long() ? 200000 : 20000;
    uint64_t seed = 8;
    struct arena arena = {0};
    (void)state;
    for (size_t i = 0; i < COUNT_OF(row); i++) {
        struct error error = {0};
        size_t used;
        const struct expr *expr = expr_compile(text_of(row[i].text), &scope, &arena, &used, &error);
        assert_non_null(expr);
        for (int k = 0; k < count; k++) {
            const double scale = pow(10, random_between(&seed, -8, 0)),
                         width = pow(10, random_between(&seed, -16, 1)),
                         a = scale * random_between(&seed, row[i].from, row[i].to),
                         b = fmin(row[i].to, a + width * fabs(a));
            const struct jet x = {{a, b}, {1, 1}, {0, 0}};
            const struct interval bounds = expr_jet(expr, &x).value;
            const double point[] = {a, b, a + (b - a) / 2, random_between(&seed, a, b)};
            for (size_t p = 0; p < COUNT_OF(point); p++) {
                const double at = fmin(fmax(point[p], a), b);
                const long double value = row[i].value((long double)at);
                if (!holds(bounds, value))
                    fail_msg("%s at %a is %La, not in %a .. %a, of [%a, %a]", row[i].text, at,
                             value, bounds.lo, bounds.hi, a, b);
            }
        }
    }
    arena_reset(&arena);
}

RUN_TESTS(NULL, NULL)
