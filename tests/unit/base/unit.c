/* SPDX-License-Identifier: GPL-3.0-or-later */
#include "cmocka_testing.h"

#include <hooke/base/number.h>
#include <hooke/base/unit.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PI 3.14159265358979323846

TEST(every_unit_is_found_and_fits_its_quantity)
{
    for (size_t i = 0; i < unit_catalog.count; i++) {
        const struct unit *unit = unit_at(i);
        assert_ptr_equal(unit_find(text_of(unit->row.name)), unit);
        assert_ptr_equal(unit_match(text_of(unit->row.name)), unit);
        assert_string_equal(unit->row.unit, quantity_unit(unit->quantity));
        double si;
        assert_true(unit_convert(unit, unit->quantity, 1, &si));
        assert_true(si == unit->factor);
        for (int q = 0; q < QUANTITY_COUNT; q++) {
            const bool other_form =
                (unit->quantity == QUANTITY_FREQUENCY && q == QUANTITY_ANGULAR_FREQUENCY) ||
                (unit->quantity == QUANTITY_ANGULAR_FREQUENCY && q == QUANTITY_FREQUENCY);
            assert_int_equal(unit_convert(unit, (enum quantity)q, 1, &si),
                             q == (int)unit->quantity || other_form);
        }
    }
}

TEST(every_quantity_has_a_name_and_its_si_unit)
{
    for (int q = 0; q < QUANTITY_COUNT; q++) {
        assert_true(quantity_name((enum quantity)q)[0] != '\0');
        const char *si_name = quantity_unit((enum quantity)q);
        if (!*si_name)
            continue;
        const struct unit *unit = unit_find(text_of(si_name));
        assert_non_null(unit);
        assert_true(unit->factor == 1 && unit->quantity == (enum quantity)q);
    }
    struct buffer b = {0};
    quantity_units(QUANTITY_MASS, &b);
    assert_string_equal(b.data, "kg, g, mg");
    buffer_clear(&b);
    quantity_units(QUANTITY_ANGULAR_FREQUENCY, &b);
    assert_string_equal(b.data, "rad/s, Hz, mHz");
    buffer_clear(&b);
    quantity_units(QUANTITY_NUMBER, &b);
    assert_int_equal(b.len, 0);
    buffer_free(&b);
}

TEST(the_longest_whole_unit_matches)
{
    static const struct {
        const char *text, *unit;
    } cases[] = {
        {"m/s^2", "m/s^2"},   {"m/s", "m/s"},     {"m", "m"},           {"min", "min"},
        {"m/s^2+1", "m/s^2"}, {"m/s ", "m/s"},    {"m/stone", "m"},     {"mm", "mm"},
        {"m^2", "m^2"},       {"m^3", "m"},       {"cm^2;", "cm^2"},    {"cm*2", "cm"},
        {"1/s", "1/s"},       {"1/sx", NULL},     {"kg/m^3", "kg/m^3"}, {"kg/s", "kg/s"},
        {"kg", "kg"},         {"Pa*s", "Pa*s"},   {"mx", NULL},         {"m2", NULL},
        {"m_", NULL},         {"minute", NULL},   {"s", "s"},           {"sin(1)", NULL},
        {"N/cm", "N/cm"},     {"rad/s", "rad/s"}, {"mrad", "mrad"},     {"mHz)", "mHz"},
        {"uJ", "uJ"},         {"", NULL},         {"M", NULL},          {"m\xC2\xB5", NULL},
        {" m", NULL},         {"Pa", NULL},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        const struct unit *unit = unit_match(text_of(cases[i].text));
        if (cases[i].unit == NULL)
            assert_null(unit);
        else
            assert_true(unit && strcmp(unit->row.name, cases[i].unit) == 0);
    }
    for (int c = 1; c < 256; c++) {
        const char z[] = {'k', 'g', (char)c, '\0'};
        const bool word =
            c >= 0x80 ||
            (c && strchr("0123456789_abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ", c));
        assert_int_equal(unit_match(text_of(z)) == NULL, word);
    }
    /* not beyond the slice */
    assert_string_equal(unit_match((struct text){"m/s^2", 3})->row.name, "m/s");
    assert_null(unit_find(TEXT("m/")));
}

static double converted(double number, const char *unit, enum quantity wanted)
{
    double si = NAN;
    assert_true(unit_convert(unit_find(text_of(unit)), wanted, number, &si));
    return si;
}

TEST(conversion_rounds_once)
{
    assert_true(converted(57, "cm", QUANTITY_LENGTH) == 0.57);
    assert_true(converted(5.7, "cm", QUANTITY_LENGTH) == 0.057);
    assert_true(converted(1.1, "mg", QUANTITY_MASS) == 1.1e-6);
    assert_true(converted(3, "cm^2", QUANTITY_AREA) == 3e-4);
    assert_true(converted(2, "min", QUANTITY_TIME) == 120);
    assert_true(converted(5, "us", QUANTITY_TIME) == 5e-6);
    assert_true(converted(1.5, "N/cm", QUANTITY_STIFFNESS) == 150);
    assert_true(converted(180, "deg", QUANTITY_ANGLE) == PI);
    assert_true(converted(1, "Hz", QUANTITY_ANGULAR_FREQUENCY) == 2 * PI);
    assert_true(fabs(converted(500, "mHz", QUANTITY_ANGULAR_FREQUENCY) - PI) < 1e-15);
    assert_true(converted(2 * PI, "rad/s", QUANTITY_FREQUENCY) == 1);
    /* every decimal typed in a decimal unit is the double nearest to the SI value */
    for (int i = 1; i < 100000; i++) {
        char z[32];
        double expected;
        snprintf(z, sizeof z, "%de-4", i);
        assert_int_equal(real_parse(text_of(z), &expected), REAL_OK);
        assert_true(converted(i, "cm^2", QUANTITY_AREA) == expected);
    }
}

static const char *shown(struct buffer *b, double value, enum quantity quantity, int digits)
{
    buffer_clear(b);
    buffer_quantity(b, value, quantity, digits);
    return b->data;
}

TEST(display)
{
    static const struct {
        double value;
        enum quantity quantity;
        int digits;
        const char *text;
    } cases[] = {
        {0.2, QUANTITY_MASS, 4, "200 g"},
        {0.2, QUANTITY_MASS, 0, "200 g"},
        {1.5, QUANTITY_MASS, 0, "1.5 kg"},
        {0.05, QUANTITY_LENGTH, 0, "5 cm"},
        {-0.0125, QUANTITY_LENGTH, 0, "-1.25 cm"},
        {0.0005, QUANTITY_LENGTH, 3, "0.5 mm"},
        {2, QUANTITY_LENGTH, 3, "2 m"},
        {0, QUANTITY_LENGTH, 0, "0 cm"},
        {0, QUANTITY_LENGTH, 3, "0 cm"},
        {0, QUANTITY_MASS, 3, "0 kg"},
        {0.01, QUANTITY_TIME, 0, "10 ms"},
        {10, QUANTITY_TIME, 0, "10 s"},
        {7200, QUANTITY_TIME, 0, "7200 s"},
        {15, QUANTITY_STIFFNESS, 0, "15 N/m"},
        {1500, QUANTITY_STIFFNESS, 0, "1500 N/m"},
        {0.07, QUANTITY_RATE, 0, "0.07 1/s"},
        {1.741e-3, QUANTITY_ENERGY, 4, "1.741 mJ"},
        {18.75e-6, QUANTITY_ENERGY, 0, "18.75 uJ"},
        {2.5, QUANTITY_VELOCITY, 3, "2.5 m/s"},
        {0.43, QUANTITY_VELOCITY, 3, "43 cm/s"},
        {0.004, QUANTITY_VELOCITY, 3, "4 mm/s"},
        {9.81, QUANTITY_ACCELERATION, 0, "9.81 m/s^2"},
        {0.00785, QUANTITY_AREA, 3, "78.5 cm^2"},
        {0.5, QUANTITY_ANGLE, 0, "0.5 rad"},
        {0.516, QUANTITY_FREQUENCY, 3, "516 mHz"},
        {8.66, QUANTITY_ANGULAR_FREQUENCY, 3, "8.66 rad/s"},
        {1.8e-5, QUANTITY_VISCOSITY, 0, "1.8e-5 Pa*s"},
        {1.2, QUANTITY_DENSITY, 0, "1.2 kg/m^3"},
        {0.003, QUANTITY_POWER, 2, "3 mW"},
        {42.5, QUANTITY_NUMBER, 0, "42.5"},
        {42.5, QUANTITY_OTHER, 3, "42.5"},
        {NAN, QUANTITY_LENGTH, 3, "nan cm"},
        {INFINITY, QUANTITY_MASS, 0, "inf kg"},
    };
    struct buffer b = {0};
    for (size_t i = 0; i < COUNT_OF(cases); i++)
        assert_string_equal(shown(&b, cases[i].value, cases[i].quantity, cases[i].digits),
                            cases[i].text);
    buffer_free(&b);
}

/* What is shown with all digits reads back to the same double, the way the command line reads it.
 */
TEST(quantities_read_back)
{
    struct buffer b = {0};
    uint64_t r = 88172645463325252u;
    for (int i = 0; i < 200000; i++) {
        r ^= r << 13, r ^= r >> 7, r ^= r << 17; /* xorshift64, Marsaglia 2003 */
        double value;
        uint64_t bits = (r & 0x800FFFFFFFFFFFFFu) | ((uint64_t)(1023 - 30) + (r >> 52) % 40) << 52;
        memcpy(&value, &bits, sizeof value);
        if (i % 2)
            value = (double)(int64_t)(r % 2000000) / 1e6;
        const enum quantity quantity = (enum quantity)((r >> 32) % QUANTITY_COUNT);
        struct text rest = text_of(shown(&b, value, quantity, 0));
        double number, si;
        size_t used;
        assert_int_equal(real_scan(rest, '.', &number, &used), REAL_OK);
        rest = text_trim((struct text){rest.data + used, rest.len - used});
        si = number;
        if (rest.len > 0) {
            assert_non_null(unit_find(rest));
            assert_true(unit_convert(unit_find(rest), quantity, number, &si));
        }
        if (memcmp(&si, &value, sizeof si) != 0)
            fail_msg("%.17g shown as %s reads as %.17g", value, b.data, si);
    }
    buffer_free(&b);
}

RUN_TESTS(NULL, NULL)
