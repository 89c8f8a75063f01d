/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Numbers as people read them: few digits, uncertainties, and the same in every locale. */
#include "cmocka_testing.h"

#include <hooke/base/number.h>

#include <ftw.h>
#include <locale.h>
#include <math.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

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

static const char *shown(struct buffer *b, double value, int digits)
{
    buffer_clear(b);
    buffer_short(b, value, digits);
    return b->data;
}

static const char *uncertain(struct buffer *b, double value, double uncertainty)
{
    buffer_clear(b);
    buffer_uncertain(b, value, uncertainty);
    return b->data;
}

TEST(numbers_for_people)
{
    struct buffer b = {0};
    assert_string_equal(shown(&b, 0.1 + 0.2, 3), "0.3");
    assert_string_equal(shown(&b, 1.9390, 4), "1.939");
    assert_string_equal(shown(&b, 9.996, 3), "10");
    assert_string_equal(shown(&b, 123456, 3), "123000");
    assert_string_equal(shown(&b, 1234567, 3), "1.23e6");
    assert_string_equal(shown(&b, 1234567, 7), "1234567");
    assert_string_equal(shown(&b, -0.00012345, 2), "-0.00012");
    assert_string_equal(shown(&b, 4.4321e-6, 2), "4.4e-6");
    assert_string_equal(shown(&b, 0, 3), "0");
    assert_string_equal(shown(&b, NAN, 3), "nan");
    assert_string_equal(shown(&b, 0.1, 0), "0.1");

    assert_string_equal(uncertain(&b, 1.93732, 0.00018), "1.93732 +- 0.00018");
    assert_string_equal(uncertain(&b, 1.93732, 0.0002), "1.9373 +- 0.0002");
    assert_string_equal(uncertain(&b, 15.1123, 0.04), "15.11 +- 0.04");
    assert_string_equal(uncertain(&b, 15.1, 0.04), "15.10 +- 0.04");
    assert_string_equal(uncertain(&b, 9.996, 0.03), "10.00 +- 0.03");
    assert_string_equal(uncertain(&b, 2.5, 0.096), "2.50 +- 0.10");
    assert_string_equal(uncertain(&b, 2.5, 0.0196), "2.50 +- 0.02");
    assert_string_equal(uncertain(&b, 15123, 400), "15100 +- 400");
    assert_string_equal(uncertain(&b, 15123, 1400), "15100 +- 1400");
    assert_string_equal(uncertain(&b, 0.001, 0.5), "0.0 +- 0.5");
    assert_string_equal(uncertain(&b, -0.001, 0.5), "0.0 +- 0.5");
    assert_string_equal(uncertain(&b, -0.07, 0.5), "-0.1 +- 0.5");
    assert_string_equal(uncertain(&b, 0, 0.02), "0.00 +- 0.02");
    assert_string_equal(uncertain(&b, -0.9, 20), "0 +- 20");
    assert_string_equal(uncertain(&b, 6, 20), "10 +- 20");
    assert_string_equal(uncertain(&b, 1.2344e-6, 5e-9), "1.234e-6 +- 5e-9");
    assert_string_equal(uncertain(&b, 1.2e9, 3e7), "1.20e9 +- 3e7");
    assert_string_equal(uncertain(&b, 1234567, 1), "1234567.0 +- 1.0");
    assert_string_equal(uncertain(&b, 2.5, 0), "2.5");
    assert_string_equal(uncertain(&b, 3.14159265, NAN), "3.14159");
    assert_string_equal(uncertain(&b, 2.5, INFINITY), "2.5");
    assert_string_equal(uncertain(&b, NAN, 0.1), "nan");
    assert_string_equal(uncertain(&b, 1e10, 3e-9), "10000000000 +- 3e-9");
    buffer_free(&b);
}

/* Whatever the value and its uncertainty, both read back within half of the last place shown (1
 * unit of 1.95 at worst).
 */
TEST(uncertainties_read_back)
{
    struct buffer b = {0};
    uint64_t seed = 5;
    for (int i = 0; i < 200000; i++) {
        double value = of_bits(next_random(&seed)), u = fabs(of_bits(next_random(&seed)));
        if (i % 2) {
            value = (double)(int64_t)next_random(&seed) * 1e-19;
            u = fabs(value) * pow(10, -(double)(next_random(&seed) % 1800) / 100);
        }
        if (!isfinite(value) || !isfinite(u) || u < 1e-290 || fabs(value) < 1e-290 ||
            fabs(value) > 1e300 || u > 1e300)
            continue;
        struct text rest = text_of(uncertain(&b, value, u));
        double v2, u2;
        size_t used;
        assert_int_equal(real_scan(rest, '.', &v2, &used), REAL_OK);
        rest = (struct text){rest.data + used, rest.len - used};
        assert_true(text_starts(rest, TEXT(" +- ")));
        assert_int_equal(real_parse((struct text){rest.data + 4, rest.len - 4}, &u2), REAL_OK);
        if (fabs(v2 - value) > 0.5 / 1.94 * u + 1e-15 * fabs(value) || fabs(u2 - u) > 0.21 * u)
            fail_msg("%.17g +- %.17g shown as %s", value, u, b.data);
    }
    buffer_free(&b);
}

/* Sets a locale with a decimal comma, one made by localedef in `folder` if none is installed. */
static bool set_comma_locale(char *folder)
{
    static const char *const names[] = {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "fr_FR"};
    for (size_t i = 0; i < COUNT_OF(names); i++)
        if (setlocale(LC_ALL, names[i]))
            return true;
    char path[300];
    snprintf(path, sizeof path, "%s/de_DE.UTF-8", folder);
    char *const arguments[] = {(char[]){"localedef"},
                               (char[]){"-i"},
                               (char[]){"de_DE"},
                               (char[]){"-f"},
                               (char[]){"UTF-8"},
                               path,
                               NULL};
    pid_t child;
    int status;
    if (posix_spawnp(&child, arguments[0], NULL, NULL, arguments, environ) != 0 ||
        waitpid(child, &status, 0) != child)
        return false;
    setenv("LOCPATH", folder, 1);
    return setlocale(LC_ALL, "de_DE.UTF-8") != NULL;
}

static int forget(const char *path, const struct stat *st, int kind, struct FTW *level)
{
    (void)st, (void)kind, (void)level;
    return remove(path);
}

TEST(a_comma_locale_changes_nothing)
{
    const char *base = getenv("TMPDIR");
    char folder[256], z[REAL_TEXT_SIZE];
    snprintf(folder, sizeof folder, "%s/hooke-locale-XXXXXX", base && *base ? base : "/tmp");
    assert_non_null(mkdtemp(folder));
    const bool found = set_comma_locale(folder);
    nftw(folder, forget, 8, FTW_DEPTH | FTW_PHYS);
    if (!found) {
        print_message("no locale with a decimal comma, and localedef cannot make one\n");
        skip();
    }
    snprintf(z, sizeof z, "%.1f", 1.5);
    assert_string_equal(z, "1,5"); /* libc does change */
    struct buffer b = {0};
    double value;
    real_format(1.5e-300, z);
    assert_string_equal(z, "1.5e-300");
    assert_int_equal(real_parse(TEXT("1.5e-300"), &value), REAL_OK);
    assert_true(value == 1.5e-300);
    assert_string_equal(shown(&b, 1.25, 3), "1.25");
    assert_string_equal(uncertain(&b, 1.25, 0.03), "1.25 +- 0.03");
    buffer_free(&b);
    setlocale(LC_ALL, "C");
}

TEST(phases_say_their_turns)
{
    static const struct {
        double degrees;
        const char *text;
    } cases[] = {{0, "0.0 deg"},
                 {-0.01, "0.0 deg"},
                 {-12.34, "-12.3 deg"},
                 {179.9, "179.9 deg"},
                 {358, "1 turn - 2.0 deg"},
                 {-358, "-1 turn + 2.0 deg"},
                 {359.97, "1 turn + 0.0 deg"},
                 {137364.9, "382 turns - 155.1 deg"},
                 {-725.04, "-2 turns - 5.0 deg"}};
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct buffer b = {0};
        buffer_phase(&b, cases[i].degrees / 180 * 3.14159265358979323846);
        buffer_char(&b, 0);
        assert_string_equal(b.data, cases[i].text);
        buffer_free(&b);
    }
    struct buffer b = {0};
    buffer_phase(&b, NAN);
    assert_int_equal(b.data[0], '-');
    buffer_free(&b);
}

RUN_TESTS(NULL, NULL)
