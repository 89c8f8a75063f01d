/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Ticks: nice steps, labels inside, distinct and exact, at any magnitude. */
#include <hooke/base/catalog.h>
#include <hooke/base/number.h>
#include "cmocka_testing.h"

#include "long_form.h"
#include "figure/internal.h"

#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint64_t random_state = 88172645463325252U;

static double uniform(void) /* [0, 1) xorshift64, Marsaglia 2003 */
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return (double)(random_state >> 11) / 9007199254740992.0;
}

static void put_label(const struct ticks *ticks, int i, bool log, struct buffer *out)
{
    char text[TICK_TEXT_SIZE];
    const int len = tick_text(ticks, i, log, text);
    buffer_put(out, (struct text){text, (size_t)len});
}

static void labels(const struct ticks *ticks, bool log, char *out, size_t size)
{
    struct buffer buffer = {0};
    for (int i = 0; i < ticks->count; i++) {
        if (i)
            buffer_char(&buffer, ' ');
        put_label(ticks, i, log, &buffer);
    }
    assert_false(buffer.failed);
    snprintf(out, size, "%s", buffer.data ? buffer.data : "");
    buffer_free(&buffer);
}

static bool nice(double step)
{
    static const double good[] = {1, 2, 2.5, 3, 4, 5, 10};
    double mantissa = step / pow(10, floor(log10(step) + 1e-9));
    for (size_t i = 0; i < COUNT_OF(good); i++)
        if (fabs(mantissa / good[i] - 1) < 1e-9)
            return true;
    return false;
}

static void check_range(double from, double to, int want, int max)
{
    struct ticks ticks = ticks_linear(from, to, want, max);
    char text[2][64] = {"", ""};
    double previous = NAN;

    if (ticks.count < (max >= 4 ? 2 : 1) || ticks.count > max || !nice(ticks.step))
        fail_msg("[%g, %g] want %d most %d: %d ticks, step %g", from, to, want, max, ticks.count,
                 ticks.step);
    for (int i = 0; i < ticks.count; i++) {
        double value = ticks.first + i * ticks.step, rounding = 1e-6 * ticks.step;
        struct buffer buffer = {0};
        put_label(&ticks, i, false, &buffer);
        snprintf(text[i % 2], sizeof text[0], "%s", buffer.data);
        buffer_free(&buffer);
        double read = 0;
        assert_int_equal(real_parse(text_of(text[i % 2]), &read), REAL_OK);
        if (value < from - rounding || value > to + rounding)
            fail_msg("[%g, %g]: tick %g outside", from, to, value);
        if (fabs(ticks.offset + read * pow(10, ticks.exponent) - value) > 1e-3 * ticks.step)
            fail_msg("[%g, %g]: label %s for %g", from, to, text[i % 2], value);
        if (i && read <= previous)
            fail_msg("[%g, %g]: label %s after %s", from, to, text[i % 2], text[(i + 1) % 2]);
        if (strncmp(text[i % 2], "-0", 2) == 0 && read == 0)
            fail_msg("[%g, %g]: minus zero", from, to);
        previous = read;
    }
}

TEST(test_random_ranges)
{
    int rounds = is_long() ? 1000000 : 20000;
    (void)state;
    for (int i = 0; i < rounds; i++) {
        double size = pow(10, 590 * uniform() - 290), from = size * (2 * uniform() - 1);
        double span = size * pow(10, -6 * uniform());
        int max = 1 + (int)(40 * uniform());
        check_range(from, from + span, 1 + i % 12, max);
    }
}

/* What narrow ranges have in common stands in the title: labels stay short, and the title says it
 * exactly. */
TEST(test_narrow_ranges_have_an_offset)
{
    static const struct {
        double from, to;
        double offset;
        int exponent;
        const char *labels;
    } known[] = {
        {2.23265, 2.23270, 2.23265, -5, "0 1 2 3 4 5"},
        {-2.23270, -2.23265, -2.2327, -5, "0 1 2 3 4 5"},
        {999000, 999010, 999000, 0, "0 2 4 6 8 10"},
        {9999.5, 10000.5, 9999, 0, "0.5 1.0 1.5"},
        {18.7, 18.8, 0, 0, "18.70 18.72 18.74 18.76 18.78 18.80"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        struct ticks ticks = ticks_linear(known[i].from, known[i].to, i == 3 ? 3 : 6, 12);
        char text[128];
        labels(&ticks, false, text, sizeof text);
        assert_string_equal(text, known[i].labels);
        assert_int_equal(ticks.exponent, known[i].exponent);
        if (fabs(ticks.offset - known[i].offset) > 1e-9 * fabs(known[i].to))
            fail_msg("[%g, %g]: offset %.10g", known[i].from, known[i].to, ticks.offset);
    }
    for (int i = 0; i < 5000;
         i++) { /* short labels whatever the range, none below zero where there is an offset */
        double from = pow(10, 9 * uniform() - 3), to = from * (1 + pow(10, -9 * uniform()));
        struct ticks ticks = ticks_linear(from, to, 5, 9);
        for (int t = 0; t < ticks.count && ticks.offset != 0; t++) {
            struct buffer label = {0};
            put_label(&ticks, t, false, &label);
            if (label.len > 5 || label.data[0] == '-')
                fail_msg("[%.17g, %.17g]: label %s, offset %.17g", from, to, label.data,
                         ticks.offset);
            buffer_free(&label);
        }
    }
}

/* Whatever is how much larger than its variation is drawn over its variation, and what is read off
 * the axis, title and label together, is the value. */
TEST(test_every_ratio_has_an_axis)
{
    const int rounds = is_long() ? 200000 : 5000;
    (void)state;
    for (int i = 0; i < rounds; i++) {
        const double ratio = pow(10, -12.5 * uniform()), sign = uniform() < 0.5 ? -1 : 1;
        const double centre = sign * pow(10, 560 * uniform() - 280), half = fabs(centre) * ratio;
        const struct extent extent = {centre - half, centre + half, 0};
        const struct figure figure = {.curves = 0};
        const struct scale scale = axis_scale(&figure, true, extent, 5, 9);
        if (!(scale.last_value - scale.first_value < 5 * half &&
              scale.last_value - scale.first_value >= 1.9 * half) &&
            ratio < 0.1)
            fail_msg("%g +- %g is drawn from %.17g to %.17g", centre, half, scale.first_value,
                     scale.last_value);
        const double middle = scale_fraction(&scale, centre),
                     wanted = (centre - scale.first_value) / (scale.last_value - scale.first_value);
        if (fabs(middle - wanted) > 1e-6)
            fail_msg("%g +- %g: the middle is drawn at %g, wanted %g", centre, half, middle,
                     wanted);
        const struct ticks ticks = ticks_linear(scale.first_value, scale.last_value, 5, 9);
        char text[TICK_TEXT_SIZE] = "+ 0";
        double offset = 0;
        if (ticks.offset != 0)
            offset_text(&ticks, text);
        assert_int_equal(real_parse(text_of(text + 2), &offset), REAL_OK);
        offset = text[0] == '-' ? offset : -offset;
        if (ticks.count < 2 || strlen(text) > 22)
            fail_msg("%g +- %g: %d labels, offset %s", centre, half, ticks.count, text);
        for (int t = 0; t < ticks.count; t++) {
            struct buffer label = {0};
            double read;
            put_label(&ticks, t, false, &label);
            assert_int_equal(real_parse(buffer_text(&label), &read), REAL_OK);
            const double value = offset + read * pow(10, ticks.exponent);
            if (label.len > 9 || fabs(value - tick_value(&ticks, t, false)) >
                                     0.01 * ticks.step + 4e-16 * fabs(centre))
                fail_msg("%.17g +- %g: label %s with %s for %.17g", centre, half, label.data, text,
                         tick_value(&ticks, t, false));
            buffer_free(&label);
        }
    }
}

TEST(test_known_ranges)
{
    static const struct {
        double from, to;
        int want;
        const char *labels;
        int exponent;
    } known[] = {
        {0, 10, 6, "0 2 4 6 8 10", 0},
        {-4.6, 4.6, 5, "-4 -2 0 2 4", 0},
        {-5, 5, 5, "-5.0 -2.5 0.0 2.5 5.0", 0},
        {-5, 5, 6, "-4 -2 0 2 4", 0},
        {0, 1, 5, "0.00 0.25 0.50 0.75 1.00", 0},
        {-1e300, 1e300, 3, "-1 0 1", 300},
        {0, 2e-6, 3, "0 1 2", -6},
        {0, 3e-7, 4, "0 100 200 300", -9},
        {999.5, 1000.5, 3, "999.5 1000.0 1000.5", 0},
        {0, 20000, 3, "0 10000 20000", 0},
        {0, 200000, 3, "0 100 200", 3},
        {0, 0.002, 3, "0.000 0.001 0.002", 0},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        struct ticks ticks = ticks_linear(known[i].from, known[i].to, known[i].want, 20);
        char text[256];
        labels(&ticks, false, text, sizeof text);
        assert_string_equal(text, known[i].labels);
        assert_int_equal(ticks.exponent, known[i].exponent);
    }
}

TEST(test_no_range_no_ticks)
{
    assert_int_equal(ticks_linear(1, 1, 5, 10).count, 0);
    assert_int_equal(ticks_linear(2, 1, 5, 10).count, 0);
    assert_int_equal(ticks_linear(NAN, 1, 5, 10).count, 0);
    assert_int_equal(ticks_linear(0, (double)INFINITY, 5, 10).count, 0);
    assert_int_equal(ticks_linear(0, 1, 5, 0).count, 0);
    assert_int_equal(ticks_linear(1, nextafter(1, 2), 5, 10).count, 0);
    assert_int_equal(ticks_log(0, 1, 10).count, 0);
    assert_int_equal(ticks_log(-1, 1, 10).count, 0);
    assert_int_equal(ticks_log(1, (double)INFINITY, 10).count, 0);
    assert_int_equal(ticks_log(2, 9, 10).count, 0);
}

TEST(test_decades)
{
    static const struct {
        double from, to;
        int max;
        const char *labels;
    } known[] = {
        {1e-3, 1, 10, "0.001 0.01 0.1 1"},         {1, 1e4, 10, "1 10 100 1000 10000"},
        {1e-12, 1e-3, 4, "1e-12 1e-9 1e-6 1e-3"},  {1e-300, 1e300, 4, "1e-200 1e0 1e200"},
        {0.5, 2e5, 10, "1e0 1e1 1e2 1e3 1e4 1e5"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(known); i++) {
        struct ticks ticks = ticks_log(known[i].from, known[i].to, known[i].max);
        char text[256];
        labels(&ticks, true, text, sizeof text);
        assert_string_equal(text, known[i].labels);
    }
}

TEST(test_random_decades)
{
    for (int i = 0; i < 5000; i++) {
        double low = 600 * uniform() - 300, high = low + 1 + (299 - low) * uniform();
        int max = 2 + (int)(20 * uniform());
        struct ticks ticks = ticks_log(pow(10, low), pow(10, high), max);
        if (ticks.count < 1 || ticks.count > max || ticks.first < low - 1e-6 ||
            ticks.first + (ticks.count - 1) * ticks.step > high + 1e-6)
            fail_msg("[1e%g, 1e%g] most %d: %d from %g step %g", low, high, max, ticks.count,
                     ticks.first, ticks.step);
    }
}

TEST(test_locale_does_not_matter)
{
    char text[64];
    (void)state;
    if (!setlocale(LC_ALL, "de_DE.UTF-8") && !setlocale(LC_ALL, "pl_PL.UTF-8") &&
        !setlocale(LC_ALL, "fr_FR.UTF-8")) {
        print_message("no locale with a decimal comma is installed\n");
        skip();
    }
    struct ticks ticks = ticks_linear(0, 1, 3, 4);
    labels(&ticks, false, text, sizeof text);
    setlocale(LC_ALL, "C");
    assert_string_equal(text, "0.0 0.5 1.0");
}

RUN_TESTS(NULL, NULL)
