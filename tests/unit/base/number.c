/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers in and out, against libc: every double survives, no decimal could be shorter, every
 * rounding is correct. */
#include "cmocka_testing.h"

#include "long_form.h"
#include <hooke/base/number.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t next_random(uint64_t *state) /* splitmix64, Steele, Lea, Flood 2014 */
{
    uint64_t z = (*state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static double of_bits(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static uint64_t bits_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static double read_back(const char *z)
{
    double value = NAN;
    enum real_status status = real_parse(text_of(z), &value);
    if (status != REAL_OK && status != REAL_UNDERFLOW)
        fail_msg("'%s' does not read back", z);
    return value;
}

static int significant(const char *z)
{
    int count = 0, zeros = 0;
    for (; *z && *z != 'e'; z++) {
        if (*z < '0' || *z > '9')
            continue;
        if (*z != '0') {
            count += zeros + 1;
            zeros = 0;
        } else if (count > 0) {
            zeros++;
        }
    }
    return count;
}

/* Does a decimal of so many digits read as the value? Of those, the two around it are the only
 * candidates. */
static bool has_decimal(double value, int digits)
{
    char z[64];
    for (int way = -1; way <= 1; way++) {
        snprintf(z, sizeof z, "%.*e", digits - 1, value);
        char *e = strchr(z, 'e');
        char number[64], *at = number;
        for (const char *c = z; c < e; c++)
            if (*c != '.' && *c != '-')
                *at++ = *c;
        *at = '\0';
        long long n = strtoll(number, NULL, 10) + way;
        snprintf(z, sizeof z, "%lld%s", n, "");
        int exponent = (int)strtol(e + 1, NULL, 10) - (digits - 1);
        snprintf(z + strlen(z), sizeof z - strlen(z), "e%d", exponent);
        if (strtod(z, NULL) == fabs(value))
            return true;
    }
    return false;
}

static void check_value(double value, bool shortest)
{
    char z[REAL_TEXT_SIZE], long_form[40];
    size_t len = real_format(value, z);
    assert_int_equal(len, strlen(z));
    snprintf(long_form, sizeof long_form, "%.17g", value);
    if (len > strlen(long_form))
        fail_msg("%s is longer than %s", z, long_form);
    if (bits_of(read_back(z)) != bits_of(value) || bits_of(strtod(z, NULL)) != bits_of(value))
        fail_msg("%.17g became %s", value, z);
    if (shortest && significant(z) > 1 && has_decimal(value, significant(z) - 1))
        fail_msg("%.17g has a shorter form than %s", value, z);
}

TEST(every_bit_pattern_survives)
{
    uint64_t seed = 1;
    const long count = is_long() ? 10000000 : 100000;
    for (long i = 0; i < count; i++) {
        double value = of_bits(next_random(&seed));
        if (isfinite(value))
            check_value(value, i % 16 == 0);
    }
}

TEST(every_laboratory_number_survives)
{
    uint64_t seed = 2;
    const long count = is_long() ? 10000000 : 100000;
    for (long i = 0; i < count; i++) {
        uint64_t bits = next_random(&seed);
        /* exponents from 2^-40 to 2^58, so that all 17-digit cases of the exact path and both its
         * borders are met */
        double value = of_bits((bits & 0x800FFFFFFFFFFFFFu) |
                               (uint64_t)(1023 - 40 + (int)((bits >> 52) & 0x7FF) % 99) << 52);
        check_value(value, i % 16 == 0);
        check_value((double)(int64_t)(bits >> 40) / 1000.0, i % 16 == 0);
    }
}

TEST(borders_survive)
{
    for (int e = -1074; e <= 1023; e++) {
        double power = ldexp(1.0, e);
        check_value(power, true);
        check_value(-nextafter(power, 0), true);
        check_value(nextafter(power, INFINITY), true);
    }
    for (int e = -323; e <= 308; e++) {
        char z[16];
        snprintf(z, sizeof z, "1e%d", e);
        double power = strtod(z, NULL);
        check_value(power, true);
        check_value(nextafter(power, 0), true);
        if (power < 1e308)
            check_value(nextafter(power, INFINITY), true);
    }
    check_value(9007199254740993.0, true);
    check_value(1.7976931348623157e308, true);
}

TEST(forms)
{
    static const struct {
        double value;
        const char *text;
    } cases[] = {
        {0.0, "0"},
        {-0.0, "-0"},
        {1.0, "1"},
        {-1.5, "-1.5"},
        {0.1, "0.1"},
        {0.3, "0.3"},
        {1.0 / 3, "0.3333333333333333"},
        {0.0001, "0.0001"},
        {0.00001, "1e-5"},
        {1.25e-7, "1.25e-7"},
        {123456789.0, "123456789"},
        {1e15, "1000000000000000"},
        {1e16, "10000000000000000"},
        {1e17, "1e17"},
        {1.5e300, "1.5e300"},
        {5e-324, "5e-324"},
        {2.2250738585072014e-308, "2.2250738585072014e-308"},
        {5.684341886080802e-14,
         "5.684341886080802e-14"}, /* 2^-44: %.16g does not read back, its neighbour does */
        {9007199254740992.0, "9007199254740992"},
        {NAN, "nan"},
        {INFINITY, "inf"},
        {-INFINITY, "-inf"},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        char z[REAL_TEXT_SIZE];
        real_format(cases[i].value, z);
        assert_string_equal(z, cases[i].text);
    }
}

static void check_against_library(const char *z)
{
    double value = NAN;
    size_t used = 0;
    enum real_status status = real_scan(text_of(z), '.', &value, &used);
    const double expected = strtod(z, NULL);
    if (used != strlen(z) || bits_of(value) != bits_of(expected))
        fail_msg("%s read as %.17g, not %.17g", z, value, expected);
    const bool zero = strpbrk(z, "123456789") == NULL || strpbrk(z, "123456789") > strpbrk(z, "eE");
    const enum real_status right = isinf(expected)                       ? REAL_OVERFLOW
                                   : fabs(expected) < 0x1p-1022 && !zero ? REAL_UNDERFLOW
                                                                         : REAL_OK;
    assert_int_equal(status, right);
}

TEST(reading_rounds_correctly)
{
    uint64_t seed = 3;
    const long count = is_long() ? 10000000 : 100000;
    for (long i = 0; i < count; i++) {
        char z[64];
        uint64_t r = next_random(&seed), digits = next_random(&seed) >> (r & 63);
        int narrow = (int)((r >> 8) % 60) - 30, wide = (int)((r >> 8) % 700) - 360;
        snprintf(z, sizeof z, "%s%ju.%ue%d", r >> 63 ? "-" : "", (uintmax_t)digits,
                 (unsigned)(r >> 40) % 1000, i % 3 ? narrow : wide);
        check_against_library(z);
    }
}

/* Decimals exactly between two doubles, and just beside: the hardest cases. A long double holds the
 * middle exactly. */
TEST(ties_go_to_even)
{
#if __LDBL_MANT_DIG__ >= 64
    uint64_t seed = 4;
    for (long i = 0; i < (is_long() ? 50000 : 10000); i++) {
        char z[1400];
        uint64_t m = (next_random(&seed) >> 11 | (uint64_t)1 << 52) * 2 + 1;
        int e = (int)(next_random(&seed) % (i % 2 ? 120 : 1900)) - (i % 2 ? 120 : 1000);
        snprintf(z, sizeof z, "%.1100Le", ldexpl((long double)m, e));
        check_against_library(z);
        char *tail = strchr(z, 'e') - 1;
        *tail = '1';
        check_against_library(z);
        snprintf(z, sizeof z, "%.18Le", ldexpl((long double)m, e));
        check_against_library(z);
    }
#else
    print_message("long double is no wider than double here\n");
    skip();
#endif
}

TEST(what_is_no_number)
{
    static const struct {
        const char *text;
        enum real_status status;
        size_t used;
        double value;
    } cases[] = {
        {"", REAL_EMPTY, 0, 0},
        {".", REAL_MALFORMED, 0, 0},
        {"-", REAL_MALFORMED, 0, 0},
        {"+.", REAL_MALFORMED, 0, 0},
        {"e5", REAL_MALFORMED, 0, 0},
        {"nan", REAL_MALFORMED, 0, 0},
        {"inf", REAL_MALFORMED, 0, 0},
        {"-inf", REAL_MALFORMED, 0, 0},
        {" 1", REAL_MALFORMED, 0, 0},
        {"--1", REAL_MALFORMED, 0, 0},
        {"0x10", REAL_OK, 1, 0},
        {"3e", REAL_OK, 1, 3},
        {"3em", REAL_OK, 1, 3},
        {"3e+", REAL_OK, 1, 3},
        {"3e-x", REAL_OK, 1, 3},
        {"5cm", REAL_OK, 1, 5},
        {".5", REAL_OK, 2, 0.5},
        {"5.", REAL_OK, 2, 5},
        {"+5.e1", REAL_OK, 5, 50},
        {"1.2.3", REAL_OK, 3, 1.2},
        {"1,5", REAL_OK, 1, 1},
        {"1e5e6", REAL_OK, 3, 1e5},
        {"0e999999999999999999999", REAL_OK, 23, 0},
        {"1e400", REAL_OVERFLOW, 5, INFINITY},
        {"-1e99999999999999999999", REAL_OVERFLOW, 23, -INFINITY},
        {"1e-320", REAL_UNDERFLOW, 6, 1e-320},
        {"1e-99999999999999999999", REAL_UNDERFLOW, 23, 0},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        double value = -7;
        size_t used = 99;
        assert_int_equal(real_scan(text_of(cases[i].text), '.', &value, &used), cases[i].status);
        assert_int_equal(used, cases[i].used);
        if (used)
            assert_true(value == cases[i].value);
        else
            assert_true(value == -7);
    }
    double value = -7;
    assert_int_equal(real_parse(TEXT(""), &value), REAL_EMPTY);
    assert_int_equal(real_parse(TEXT("x"), &value), REAL_MALFORMED);
    assert_int_equal(real_parse(TEXT("1,5"), &value), REAL_MALFORMED);
    assert_int_equal(real_parse(TEXT("1.5 "), &value), REAL_MALFORMED);
    assert_int_equal(real_parse(TEXT("0x10"), &value), REAL_MALFORMED);
    assert_int_equal(real_parse(TEXT("1\0"), &value), REAL_MALFORMED);
    assert_true(value == -7);
    size_t used;
    assert_int_equal(real_scan(TEXT("-1,25;"), ',', &value, &used), REAL_OK);
    assert_true(value == -1.25 && used == 5);
    assert_int_equal(real_scan(TEXT("12345"), '.', &value, &used), REAL_OK);
    /* never beyond the slice */
    assert_int_equal(real_scan((struct text){"12345", 2}, '.', &value, &used), REAL_OK);
    assert_true(value == 12 && used == 2);
    assert_int_equal(real_scan((struct text){"1e56", 3}, '.', &value, &used), REAL_OK);
    assert_true(value == 1e5 && used == 3);
    /* the smallest normal double */
    assert_int_equal(real_parse(TEXT("2.2250738585072014e-308"), &value), REAL_OK);
    assert_int_equal(real_parse(TEXT("2.2250738585072009e-308"), &value), REAL_UNDERFLOW);
}

/* A million digits are read in linear time and still rounded correctly. */
TEST(very_long_numbers)
{
    const size_t len = 1000000;
    char *z = malloc(len);
    assert_non_null(z);
    memset(z, '0', len);
    memcpy(z, "9007199254740993", 16); /* a tie that goes down without the last digit, up with it */
    z[16] = '.';
    double value;
    assert_int_equal(real_parse((struct text){z, len}, &value), REAL_OK);
    assert_true(value == 9007199254740992.0);
    z[len - 1] = '1';
    assert_int_equal(real_parse((struct text){z, len}, &value), REAL_OK);
    assert_true(value == 9007199254740994.0);
    memset(z, '0', len);
    z[1] = '.';
    z[len - 1] = '5';
    assert_int_equal(real_parse((struct text){z, len}, &value), REAL_UNDERFLOW);
    assert_true(value == 0);
    memset(z, '3', len);
    assert_int_equal(real_parse((struct text){z, len}, &value), REAL_OVERFLOW);
    free(z);
}

RUN_TESTS(NULL, NULL)
