/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Units and quantities: tables, conversion to SI, and the unit that suits a value best. */
#include "base/decimal.h"
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>

#include <math.h>
#include <string.h>

/* The units of one quantity that are chosen for display are ordered from the largest down. */
static const struct unit units[] = {
    {{"m", "m", "metre", "", NULL}, QUANTITY_LENGTH, 1.0, UNIT_SHOWN},
    {{"cm", "m", "centimetre", "", NULL}, QUANTITY_LENGTH, 1e-2, UNIT_HOME},
    {{"mm", "m", "millimetre", "", NULL}, QUANTITY_LENGTH, 1e-3, UNIT_SHOWN},
    {{"kg", "kg", "kilogram", "", NULL}, QUANTITY_MASS, 1.0, UNIT_HOME},
    {{"g", "kg", "gram", "", NULL}, QUANTITY_MASS, 1e-3, UNIT_SHOWN},
    {{"mg", "kg", "milligram", "", NULL}, QUANTITY_MASS, 1e-6, UNIT_SHOWN},
    {{"s", "s", "second", "", NULL}, QUANTITY_TIME, 1.0, UNIT_HOME},
    {{"ms", "s", "millisecond", "", NULL}, QUANTITY_TIME, 1e-3, UNIT_SHOWN},
    {{"us", "s", "microsecond", "", NULL}, QUANTITY_TIME, 1e-6, UNIT_READ},
    {{"min", "s", "minute", "", NULL}, QUANTITY_TIME, 60.0, UNIT_READ},
    {{"N", "N", "newton", "", NULL}, QUANTITY_FORCE, 1.0, UNIT_HOME},
    {{"mN", "N", "millinewton", "", NULL}, QUANTITY_FORCE, 1e-3, UNIT_SHOWN},
    {{"N/m", "N/m", "newton per metre", "", NULL}, QUANTITY_STIFFNESS, 1.0, UNIT_HOME},
    {{"N/cm", "N/m", "newton per centimetre", "", NULL}, QUANTITY_STIFFNESS, 100.0, UNIT_READ},
    {{"N/m^3", "N/m^3", "newton per cubic metre", "", NULL},
     QUANTITY_CUBIC_STIFFNESS,
     1.0,
     UNIT_HOME},
    {{"1/s", "1/s", "per second", "", NULL}, QUANTITY_RATE, 1.0, UNIT_HOME},
    {{"kg/s", "kg/s", "kilogram per second", "", NULL}, QUANTITY_MASS_RATE, 1.0, UNIT_HOME},
    {{"g/s", "kg/s", "gram per second", "", NULL}, QUANTITY_MASS_RATE, 1e-3, UNIT_SHOWN},
    {{"N/(m/s)", "kg/s", "newton per metre and second", "", NULL},
     QUANTITY_MASS_RATE,
     1.0,
     UNIT_READ},
    {{"N*s/m", "kg/s", "same as kg/s", "", NULL}, QUANTITY_MASS_RATE, 1.0, UNIT_READ},
    {{"m/s", "m/s", "metre per second", "", NULL}, QUANTITY_VELOCITY, 1.0, UNIT_SHOWN},
    {{"cm/s", "m/s", "centimetre per second", "", NULL}, QUANTITY_VELOCITY, 1e-2, UNIT_HOME},
    {{"mm/s", "m/s", "millimetre per second", "", NULL}, QUANTITY_VELOCITY, 1e-3, UNIT_SHOWN},
    {{"m/s^2", "m/s^2", "metre per second squared", "", NULL},
     QUANTITY_ACCELERATION,
     1.0,
     UNIT_HOME},
    {{"m^2", "m^2", "square metre", "", NULL}, QUANTITY_AREA, 1.0, UNIT_SHOWN},
    {{"cm^2", "m^2", "square centimetre", "", NULL}, QUANTITY_AREA, 1e-4, UNIT_HOME},
    {{"kg/m^3", "kg/m^3", "kilogram per cubic metre", "", NULL}, QUANTITY_DENSITY, 1.0, UNIT_HOME},
    {{"Pa*s", "Pa*s", "pascal second", "", NULL}, QUANTITY_VISCOSITY, 1.0, UNIT_HOME},
    {{"rad", "rad", "radian", "", NULL}, QUANTITY_ANGLE, 1.0, UNIT_HOME},
    {{"deg", "rad", "degree", "", NULL}, QUANTITY_ANGLE, PI / 180.0, UNIT_READ},
    {{"mrad", "rad", "milliradian", "", NULL}, QUANTITY_ANGLE, 1e-3, UNIT_READ},
    {{"rad/s", "rad/s", "radian per second", "", NULL}, QUANTITY_ANGULAR_FREQUENCY, 1.0, UNIT_HOME},
    {{"rad/s^2", "rad/s^2", "radian per second squared", "", NULL},
     QUANTITY_ANGULAR_ACCELERATION,
     1.0,
     UNIT_HOME},
    {{"Hz", "Hz", "hertz", "", NULL}, QUANTITY_FREQUENCY, 1.0, UNIT_HOME},
    {{"mHz", "Hz", "millihertz", "", NULL}, QUANTITY_FREQUENCY, 1e-3, UNIT_SHOWN},
    {{"J", "J", "joule", "", NULL}, QUANTITY_ENERGY, 1.0, UNIT_HOME},
    {{"mJ", "J", "millijoule", "", NULL}, QUANTITY_ENERGY, 1e-3, UNIT_SHOWN},
    {{"uJ", "J", "microjoule", "", NULL}, QUANTITY_ENERGY, 1e-6, UNIT_SHOWN},
    {{"W", "W", "watt", "", NULL}, QUANTITY_POWER, 1.0, UNIT_HOME},
    {{"mW", "W", "milliwatt", "", NULL}, QUANTITY_POWER, 1e-3, UNIT_SHOWN},
    {{"uW", "W", "microwatt", "", NULL}, QUANTITY_POWER, 1e-6, UNIT_SHOWN},
    {{"V", "V", "volt", "", NULL}, QUANTITY_VOLTAGE, 1.0, UNIT_HOME},
    {{"mV", "V", "millivolt", "", NULL}, QUANTITY_VOLTAGE, 1e-3, UNIT_SHOWN},
};

const struct catalog unit_catalog = CATALOG("unit", units);

const struct unit *unit_at(size_t i)
{
    return (const struct unit *)(const void *)catalog_row(&unit_catalog, i);
}

const struct unit *unit_from(const struct row *row)
{
    return (const struct unit *)(const void *)row;
}

/* Name and SI unit of each quantity. */
static const struct {
    const char *name, *unit;
} quantities[QUANTITY_COUNT] = {
    [QUANTITY_NUMBER] = {"number", ""},
    [QUANTITY_LENGTH] = {"length", "m"},
    [QUANTITY_MASS] = {"mass", "kg"},
    [QUANTITY_TIME] = {"time", "s"},
    [QUANTITY_FORCE] = {"force", "N"},
    [QUANTITY_STIFFNESS] = {"stiffness", "N/m"},
    [QUANTITY_CUBIC_STIFFNESS] = {"cubic stiffness", "N/m^3"},
    [QUANTITY_RATE] = {"rate", "1/s"},
    [QUANTITY_MASS_RATE] = {"mass rate", "kg/s"},
    [QUANTITY_VELOCITY] = {"velocity", "m/s"},
    [QUANTITY_ACCELERATION] = {"acceleration", "m/s^2"},
    [QUANTITY_AREA] = {"area", "m^2"},
    [QUANTITY_DENSITY] = {"density", "kg/m^3"},
    [QUANTITY_VISCOSITY] = {"viscosity", "Pa*s"},
    [QUANTITY_ANGLE] = {"angle", "rad"},
    [QUANTITY_ANGULAR_FREQUENCY] = {"angular frequency", "rad/s"},
    [QUANTITY_ANGULAR_ACCELERATION] = {"angular acceleration", "rad/s^2"},
    [QUANTITY_FREQUENCY] = {"frequency", "Hz"},
    [QUANTITY_ENERGY] = {"energy", "J"},
    [QUANTITY_POWER] = {"power", "W"},
    [QUANTITY_VOLTAGE] = {"voltage", "V"},
    [QUANTITY_OTHER] = {"other quantity", ""},
};

const char *quantity_name(enum quantity quantity)
{
    return quantities[quantity].name;
}

/* Returns how often a position or angle is differentiated to give this quantity, or -1. */
int quantity_order(enum quantity quantity)
{
    switch (quantity) {
    case QUANTITY_LENGTH:
    case QUANTITY_ANGLE:
        return 0;
    case QUANTITY_VELOCITY:
    case QUANTITY_ANGULAR_FREQUENCY:
        return 1;
    case QUANTITY_ACCELERATION:
    case QUANTITY_ANGULAR_ACCELERATION:
        return 2;
    default:
        return -1;
    }
}

const char *quantity_article(enum quantity quantity)
{
    return strchr("aeio", quantities[quantity].name[0]) ? "an" : "a";
}

const char *quantity_unit(enum quantity quantity)
{
    return quantities[quantity].unit;
}

/* Returns number * factor; for decimal factors below 1 by division, which rounds once: 57 cm is 57
 * / 100 = 0.57 m, but 57 * 0.01 is another double. */
static double value_in_si(double number, double factor)
{
    return factor < 1 && nearbyint(1 / factor) * factor == 1 ? number / nearbyint(1 / factor)
                                                             : number * factor;
}

/* Converts number to SI in *si, also between frequency and angular frequency. Returns false if the
 * unit does not fit the quantity. */
bool unit_convert(const struct unit *unit, enum quantity wanted, double number, double *si)
{
    const double value = value_in_si(number, unit->factor);
    if (unit->quantity == wanted)
        *si = value;
    else if (unit->quantity == QUANTITY_FREQUENCY && wanted == QUANTITY_ANGULAR_FREQUENCY)
        *si = value * (2 * PI);
    else if (unit->quantity == QUANTITY_ANGULAR_FREQUENCY && wanted == QUANTITY_FREQUENCY)
        *si = value / (2 * PI);
    else
        return false;
    return true;
}

/* Appends the names of units for the quantity: its own first, then those that convert to it (Hz for
 * rad/s). */
void quantity_units(enum quantity quantity, struct buffer *names)
{
    double si;
    bool some = false;
    for (int exact = 1; exact >= 0; exact--)
        for (size_t i = 0; i < COUNT_OF(units); i++)
            if ((units[i].quantity == quantity) == exact &&
                unit_convert(&units[i], quantity, 1.0, &si)) {
                buffer_put(names, some ? TEXT(", ") : TEXT(""));
                buffer_put(names, text_of(units[i].row.name));
                some = true;
            }
}

/* Returns true for bytes that belong to a word, including those of UTF-8 letters. */
static bool continues_word(char c)
{
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '_' ||
           (unsigned char)c >= 0x80;
}

/* Returns the longest unit at the start of text behind which the word ends (a +- sign ends it,
 * too), or NULL. */
const struct unit *unit_match(struct text text)
{
    const struct unit *best = NULL;
    size_t longest = 0;
    for (size_t i = 0; i < COUNT_OF(units) && text.len > 0; i++) {
        if (units[i].row.name[0] != text.data[0])
            continue;
        struct text name = text_of(units[i].row.name);
        if (name.len > longest && text_starts(text, name) &&
            (name.len == text.len || !continues_word(text.data[name.len]) ||
             text_starts(text_after(text, name.len), TEXT("\u00b1")))) {
            best = &units[i];
            longest = name.len;
        }
    }
    return best;
}

const struct unit *unit_find(struct text name)
{
    return (const struct unit *)(const void *)catalog_find(&unit_catalog, name);
}

/* Returns the first, which is the largest, unit in which value is at least 1, or else the smallest;
 * the home unit for 0 and for values that are not finite. */
const struct unit *unit_display(enum quantity quantity, double value)
{
    const struct unit *best = NULL;
    for (size_t i = 0; i < COUNT_OF(units); i++) {
        if (units[i].quantity != quantity || units[i].use == UNIT_READ)
            continue;
        const double shown = fabs(value) / units[i].factor;
        if (value == 0 || !isfinite(value)) {
            if (units[i].use == UNIT_HOME)
                return &units[i];
        } else if (shown >= 1) {
            return &units[i];
        }
        best = &units[i];
    }
    return best;
}

/* Writes the shortest decimal of value in this unit, by moving the decimal point. Returns false if
 * it does not read back to the same value. */
static bool shown_exactly(double value, const struct unit *unit, char output[REAL_TEXT_SIZE])
{
    struct decimal d = decimal_shortest(value);
    if (d.digits != 0)
        d.exponent -= (int)lround(log10(unit->factor));
    decimal_write(d, -4, 17, output);
    double number, si;
    return real_parse(text_of(output), &number) == REAL_OK &&
           unit_convert(unit, unit->quantity, number, &si) && si == value;
}

/* Appends a value with the unit that suits it; if that is not exact with 0 digits, in SI. */
void buffer_quantity(struct buffer *buffer, double value, enum quantity quantity, int digits)
{
    const struct unit *unit = unit_display(quantity, value);
    char z[REAL_TEXT_SIZE];
    if (digits > 0 && unit) {
        buffer_short(buffer, value / unit->factor, digits);
    } else if (unit && isfinite(value) && shown_exactly(value, unit, z)) {
        buffer_put(buffer, text_of(z));
    } else {
        buffer_short(buffer, value, digits);
        unit = NULL;
    }
    const char *name = unit ? unit->row.name : quantity_unit(quantity);
    if (*name) {
        buffer_char(buffer, ' ');
        buffer_put(buffer, text_of(name));
    }
}
