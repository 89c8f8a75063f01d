/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Elementary functions: within 0.9 units of the last place of long double's, the special values of
 * annex F, many as one, and the very bits that they have on other machines. */
#include "cmocka_testing.h"

#include "base/elementary/logarithm.h"
#include "hooke/base/elementary.h"
#include "hooke/base/numeric.h"
#include "long_form.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define UNITS 0.9L /* off at most */
enum { RANGES = 7 };

typedef double one(double);
typedef long double one_long(long double);

/* POWERS: of two, any sign; their exponents */
struct range {
    double from, to;
    enum { EVENLY = 1, POWERS } how;
};

#define EVEN(from, to)                                                                             \
    {                                                                                              \
        from, to, EVENLY                                                                           \
    }
#define POWER(from, to)                                                                            \
    {                                                                                              \
        from, to, POWERS                                                                           \
    }
#define CIRCLE                                                                                     \
    EVEN(-0.8, 0.8), EVEN(-4, 4), EVEN(-1000, 1000), EVEN(-6e5, 6e5), POWER(-40, 60),              \
        POWER(20, 1023), POWER(-1074, -1)

static const struct {
    const char *name;
    one *fixed;
    one_long *reference;
    struct range range[RANGES];
} rows[] = {
    {"sin", fixed_sin, sinl, {CIRCLE}},
    {"cos", fixed_cos, cosl, {CIRCLE}},
    {"tan", fixed_tan, tanl, {CIRCLE}},
    {"asin", fixed_asin, asinl, {EVEN(-1, 1), EVEN(-0.1, 0.1), EVEN(0.999, 1), POWER(-1074, -1)}},
    {"acos", fixed_acos, acosl, {EVEN(-1, 1), EVEN(-0.1, 0.1), EVEN(0.999, 1), POWER(-1074, -1)}},
    {"atan", fixed_atan, atanl, {EVEN(-1, 1), EVEN(-9, 9), POWER(-60, 60), POWER(-1074, 1023)}},
    {"exp", fixed_exp, expl, {EVEN(-1, 1), EVEN(-708, 709), EVEN(-746, -700), POWER(-1074, -1)}},
    {"expm1", fixed_expm1, expm1l, {EVEN(-1, 1), EVEN(-45, 45), EVEN(0, 709), POWER(-1074, -1)}},
    {"sinh", fixed_sinh, sinhl, {EVEN(-1, 1), EVEN(-45, 45), EVEN(0, 710.4), POWER(-1074, -1)}},
    {"cosh", fixed_cosh, coshl, {EVEN(-1, 1), EVEN(-45, 45), EVEN(0, 710.4), POWER(-1074, -1)}},
    {"tanh", fixed_tanh, tanhl, {EVEN(-1, 1), EVEN(-45, 45), POWER(-1074, 10)}},
    {"log", fixed_log, logl, {EVEN(0.5, 2), EVEN(0.99, 1.01), EVEN(0, 9), POWER(-1074, 1023)}},
    {"log10", fixed_log10, log10l, {EVEN(0.5, 2), EVEN(0.99, 1.01), POWER(-1074, 1023)}},
    {"cbrt", fixed_cbrt, cbrtl, {EVEN(-1, 1), EVEN(1, 8), POWER(-1074, 1023)}},
};

static const struct {
    const char *name;
    double (*fixed)(double, double);
    long double (*reference)(long double, long double);
    struct range first[3], second[3];
} pairs[] = {
    {"pow",
     fixed_pow,
     powl,
     {EVEN(0, 3), EVEN(0.7, 1.4), POWER(-1074, 1023)},
     {EVEN(-60, 60), EVEN(-900, 900), EVEN(-1.1, 1.1)}},
    {"atan2",
     fixed_atan2,
     atan2l,
     {EVEN(-3, 3), POWER(-30, 30), POWER(-1074, 1023)},
     {EVEN(-3, 3), POWER(-30, 30), POWER(-1074, 1023)}},
    {"hypot",
     fixed_hypot,
     hypotl,
     {EVEN(-3, 3), POWER(-30, 30), POWER(-1074, 1023)},
     {EVEN(-3, 3), POWER(-30, 30), POWER(-1074, 1023)}},
};

static double drawn(const struct range *range, uint64_t *state)
{
    const double share = random_fraction(state);
    if (range->how == EVENLY)
        return range->from + (range->to - range->from) * share;
    const double power = floor(range->from + (range->to - range->from) * random_fraction(state));
    return ldexp(random_fraction(state) < 0.5 ? -1 - share : 1 + share, (int)power);
}

/* [units of the last place of the true value] */
static long double units_off(double found, long double wanted)
{
    const double near = (double)wanted;
    if (isnan(near) || isinf(near) || isinf(found) || isnan(found))
        return (isnan(near) && isnan(found)) || near == found ? 0 : 1e9L;
    const int exponent = fabs(near) < DBL_MIN ? -1022 : ilogb(near);
    return fabsl((long double)found - wanted) / ldexpl(1, exponent - 52);
}

static int draws(void)
{
    return is_long() ? 10000000 : 2000;
}

TEST(test_one_unit)
{
    uint64_t random = 1;
    if (LDBL_MANT_DIG < 64)
        skip();
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        for (const struct range *r = rows[i].range; r < rows[i].range + RANGES && r->how; r++)
            for (int k = 0; k < draws(); k++) {
                double x = drawn(r, &random);
                x = rows[i].fixed == fixed_log || rows[i].fixed == fixed_log10 ? fabs(x) : x;
                const long double off =
                    units_off(rows[i].fixed(x), rows[i].reference((long double)x));
                if (!(off <= UNITS))
                    fail_msg("%s(%a) is off by %.3Lf units", rows[i].name, x, off);
            }
    (void)state;
}

TEST(test_one_unit_of_two)
{
    uint64_t random = 2;
    if (LDBL_MANT_DIG < 64)
        skip();
    for (size_t i = 0; i < COUNT_OF(pairs); i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < draws(); k++) {
                double x = drawn(&pairs[i].first[j], &random);
                const double y = drawn(&pairs[i].second[j], &random);
                x = pairs[i].fixed == fixed_pow ? fabs(x) : x;
                const long double off = units_off(
                    pairs[i].fixed(x, y), pairs[i].reference((long double)x, (long double)y));
                if (!(off <= UNITS))
                    fail_msg("%s(%a, %a) is off by %.3Lf units", pairs[i].name, x, y, off);
            }
    (void)state;
}

/* Where tables and series change over: the rows of log, halfway between those of exp, and on from
 * one formula to the next. */
TEST(test_edges)
{
    static const double borders[] = {0x1p-54, 0x1p-28, 0x1p-27, 0.125, 0.1875, 0.25,
                                     0.5,     0.785,   1,       20,    40,     690};
    if (LDBL_MANT_DIG < 64)
        skip();
    for (int i = 0; i < 3 * 12000; i++) {
        const int j = i / 3 - 6000, side = i % 3 - 1;
        const double edge = from_bits(FIRST_M + (uint64_t)(j + 8192) * (UINT64_C(1) << ROW_SHIFT) -
                                      (UINT64_C(64) << EXPONENT_SHIFT)),
                     m = nextafter(edge, side * HUGE_VAL + edge), x = side ? m : edge;
        assert_true(units_off(fixed_log(x), logl((long double)x)) <= UNITS);
        const double half = (j + 0.5 + side * 1e-13) * 0x1.62e42fefa39efp-8;
        assert_true(units_off(fixed_exp(half), expl((long double)half)) <= UNITS);
        assert_true(units_off(fixed_cosh(half), coshl((long double)half)) <= UNITS);
    }
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        for (size_t j = 0; j < COUNT_OF(borders) * 5; j++) {
            const double border = borders[j / 5],
                         x = border * (1 + ((double)(j % 5) - 2) * 0x1p-52);
            const long double off = units_off(rows[i].fixed(x), rows[i].reference((long double)x));
            if (!(off <= UNITS))
                fail_msg("%s(%a) is off by %.3Lf units", rows[i].name, x, off);
        }
    (void)state;
}

/* x^y where it is next to the largest or the smallest numbers, below the normal ones, and of
 * negative x. */
TEST(test_powers_far)
{
    static const struct range bases[] = {POWER(-1074, 1023), EVEN(0.5, 2), EVEN(0.9999, 1.0001)},
                              logs[] = {EVEN(680, 709.7), EVEN(-745, -680), EVEN(-1e-3, 1e-3)};
    uint64_t random = 5;
    if (LDBL_MANT_DIG < 64)
        skip();
    for (int i = 0; i < 9; i++)
        for (int k = 0; k < draws(); k++) {
            const double x = fabs(drawn(&bases[i / 3], &random)),
                         y = drawn(&logs[i % 3], &random) / log(x), whole = rint(y);
            if (!(fabs(y) < 1e300))
                continue;
            const long double off =
                units_off(fixed_pow(x, y), powl((long double)x, (long double)y));
            if (!(off <= UNITS))
                fail_msg("pow(%a, %a) is off by %.3Lf units", x, y, off);
            const double sign = fmod(fabs(whole), 2) == 1 ? -1 : 1;
            assert_true(fixed_pow(-x, whole) == sign * fixed_pow(x, whole));
            assert_true(whole == y || isnan(fixed_pow(-x, y)));
        }
    (void)state;
}

/* Next to multiples of pi/2 what is left has lost most digits. */
TEST(test_next_to_zeros)
{
    if (LDBL_MANT_DIG < 64)
        skip();
    for (int n = 1; n < 400000; n += n < 2000 || is_long() ? 1 : 97) {
        const double x = n * 1.57079632679489661923;
        assert_true(units_off(fixed_sin(x), sinl((long double)x)) <= UNITS);
        assert_true(units_off(fixed_cos(x), cosl((long double)x)) <= UNITS);
        assert_true(units_off(fixed_tan(x), tanl((long double)x)) <= UNITS);
    }
    /* the double next to a multiple of pi/2, of all (Muller 1997, table 11.1) */
    const double worst = 0x1.6ac5b262ca1ffp+849;
    assert_true(units_off(fixed_cos(worst), cosl((long double)worst)) <= UNITS);
    (void)state;
}

/* Also -0 and +0, and where the sign of a NaN does not count. */
static bool same(double a, double b)
{
    return isnan(a) ? isnan(b) : memcmp(&a, &b, sizeof a) == 0;
}

static const double special[] = {
    0,
    -0.0,
    1,
    -1,
    2,
    -2,
    3,
    -3,
    0.5,
    -0.5,
    1e300,
    -1e300,
    1e-300,
    -1e-300,
    5e-324,
    -5e-324,
    DBL_MAX,
    DBL_MIN,
    -DBL_MAX,
    1.5,
    -1.5,
    (double)INFINITY,
    -(double)INFINITY,
    (double)NAN,
    745.5,
    -745.5,
    -746,
    710,
    720,
    -708.5,
    1 + DBL_EPSILON,
    1 - DBL_EPSILON / 2,
    0x1p53 - 1,
    -0x1p53,
};

/* As long double has it, where that is exact or a limit; the library's sign of zero. */
TEST(test_special_values)
{
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        for (size_t j = 0; j < COUNT_OF(special); j++) {
            const double x = special[j], found = rows[i].fixed(x),
                         wanted = (double)rows[i].reference((long double)x);
            const bool limit = isnan(wanted) || isinf(wanted) || wanted == 0 || x == 0;
            if (limit ? !same(found, wanted) : units_off(found, (long double)wanted) > 1)
                fail_msg("%s(%g) = %g, not %g", rows[i].name, x, found, wanted);
        }
    for (size_t i = 0; i < COUNT_OF(pairs); i++)
        for (size_t j = 0; j < COUNT_OF(special) * COUNT_OF(special); j++) {
            const double x = special[j / COUNT_OF(special)], y = special[j % COUNT_OF(special)],
                         found = pairs[i].fixed(x, y),
                         wanted = (double)pairs[i].reference((long double)x, (long double)y);
            const bool limit = isnan(wanted) || isinf(wanted) || wanted == 0;
            if (limit ? !same(found, wanted) : units_off(found, (long double)wanted) > 1)
                fail_msg("%s(%g, %g) = %g, not %g", pairs[i].name, x, y, found, wanted);
        }
    (void)state;
}

/* Powers and logarithms whose value is a double give it. */
TEST(test_exact_values)
{
    double ten = 1;
    for (int i = 0; i <= 22; i++, ten *= 10) {
        assert_true(fixed_pow(10, i) == ten && fixed_log10(ten) == i);
        assert_true(fixed_cbrt((double)(i * i * i)) == i &&
                    fixed_hypot(3 * ten, 4 * ten) == 5 * ten);
    }
    assert_true(fixed_pow(4, 0.5) == 2 && fixed_pow(0.25, -1.5) == 8 && fixed_pow(-2, 3) == -8);
    (void)state;
}

/* ---- many ---- */

static void check_many(const char *name, void (*many)(int, const double *, double *), one *fixed)
{
    uint64_t random = 3;
    for (int turn = 0; turn < 400; turn++) {
        const int n = 1 + turn % 150, powers = turn % 8;
        const struct range ranges[] = {EVEN(-4, 4), EVEN(-1e3, 1e3),
                                       POWER(-60, powers > 3 ? 30 : 8)};
        double x[150], found[150];
        for (int i = 0; i < n; i++)
            x[i] = turn % 50 == 49 && i % 9 == 0 ? special[(i + turn) % (int)COUNT_OF(special)]
                                                 : drawn(&ranges[turn % 3], &random);
        many(n, x, found);
        for (int i = 0; i < n; i++)
            if (!same(found[i], fixed(x[i])))
                fail_msg("%s of many at %a: %a, not %a", name, x[i], found[i], fixed(x[i]));
        many(n, x, x);
        assert_true(memcmp(x, found, (size_t)n * sizeof *x) == 0);
    }
}

TEST(test_many)
{
    check_many("sin", fixed_sines, fixed_sin);
    check_many("cos", fixed_cosines, fixed_cos);
    check_many("exp", fixed_exponentials, fixed_exp);
    (void)state;
}

/* ---- the bits ---- */

/* Products that are rounded once, and in halves: of those machines that can, and of others. */
TEST(test_fused)
{
    uint64_t random = 6;
    for (int j = 0; j < 9; j++)
        for (int k = 0; k < draws(); k++) {
            const double x = fabs(drawn(&pairs[0].first[j % 3], &random)),
                         y = drawn(&pairs[0].second[j / 3], &random);
            if (!(x > 0) || x == 1)
                continue;
            assert_true(same(log_in(x, true), log_in(x, false)));
            assert_true(same(fixed_log(x), log_in(x, false)));
            assert_true(same(log10_in(x, true), log10_in(x, false)));
            assert_true(same(power_in(x, y, true), power_in(x, y, false)));
            assert_true(same(fixed_pow(x, y), power_in(x, y, false)));
        }
    (void)state;
}

static void take(uint64_t *hash, double value) /* FNV-1a; one NaN */
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    bits = isnan(value) ? UINT64_C(0x7FF8000000000000) : bits;
    for (int i = 0; i < 64; i += 8)
        *hash = (*hash ^ (bits >> i & 0xFF)) * UINT64_C(0x100000001B3);
}

/* Of a thousand arguments from each range: another machine, compiler or optimisation would give
 * another number. */
TEST(test_known_bits)
{
    uint64_t random = 4, hash = UINT64_C(0xCBF29CE484222325);
    for (size_t i = 0; i < COUNT_OF(rows); i++)
        for (const struct range *r = rows[i].range; r < rows[i].range + RANGES && r->how; r++)
            for (int k = 0; k < 1000; k++)
                take(&hash, rows[i].fixed(drawn(r, &random)));
    for (size_t i = 0; i < COUNT_OF(pairs); i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 1000; k++) {
                const double x = drawn(&pairs[i].first[j], &random);
                take(&hash, pairs[i].fixed(x, drawn(&pairs[i].second[j], &random)));
            }
    if (hash != UINT64_C(0xa1d645121f6348d2))
        fail_msg("the bits are those of 0x%016llx", (unsigned long long)hash);
    (void)state;
}

RUN_TESTS(NULL, NULL)
