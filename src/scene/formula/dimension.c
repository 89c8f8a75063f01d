/* SPDX-License-Identifier: GPL-3.0-or-later */
#include <hooke/base/numeric.h>
#include <hooke/scene/dimension.h>

#include <math.h>

static const char *const base_unit[DIMENSION_BASES] = {"kg", "m", "s", "V", "rad", "cycles"};

static const signed char quantity_power[QUANTITY_COUNT][DIMENSION_BASES] = {
    /* kg m s V rad cycle */
    [QUANTITY_LENGTH] = {0, 1},
    [QUANTITY_MASS] = {1},
    [QUANTITY_TIME] = {0, 0, 1},
    [QUANTITY_FORCE] = {1, 1, -2},
    [QUANTITY_STIFFNESS] = {1, 0, -2},
    [QUANTITY_CUBIC_STIFFNESS] = {1, -2, -2},
    [QUANTITY_RATE] = {0, 0, -1},
    [QUANTITY_MASS_RATE] = {1, 0, -1},
    [QUANTITY_VELOCITY] = {0, 1, -1},
    [QUANTITY_ACCELERATION] = {0, 1, -2},
    [QUANTITY_AREA] = {0, 2},
    [QUANTITY_DENSITY] = {1, -3},
    [QUANTITY_VISCOSITY] = {1, -1, -1},
    [QUANTITY_ANGLE] = {0, 0, 0, 0, 1},
    [QUANTITY_ANGULAR_FREQUENCY] = {0, 0, -1, 0, 1},
    [QUANTITY_ANGULAR_ACCELERATION] = {0, 0, -2, 0, 1},
    [QUANTITY_FREQUENCY] = {0, 0, -1, 0, 0, 1},
    [QUANTITY_ENERGY] = {1, 2, -2},
    [QUANTITY_POWER] = {1, 2, -3},
    [QUANTITY_VOLTAGE] = {0, 0, 0, 1},
};

/* Powers are sums of fractions such as 1/2 and 1/3 in single precision. */
static bool is_zero(double power)
{
    return fabs(power) < 1e-4;
}

struct dimension dimension_of_name(enum quantity quantity)
{
    struct dimension made = {.kind = DIMENSION_UNKNOWN, .has_name = true, .is_single = true};
    if (quantity == QUANTITY_OTHER)
        return made;
    made.kind = DIMENSION_KNOWN;
    for (int i = 0; i < DIMENSION_BASES; i++)
        made.power[i] = quantity_power[quantity][i];
    return made;
}

struct dimension dimension_of_unit(const struct unit *unit)
{
    struct dimension made = dimension_of_name(unit->quantity);
    made.has_name = false;
    made.unit = unit;
    return made;
}

/* What both have typed, with the powers of a. */
static struct dimension both(const struct dimension *a, const struct dimension *b)
{
    struct dimension made = *a;
    made.unit = a->unit ? a->unit : b->unit;
    made.has_name = a->has_name || b->has_name;
    made.is_single = false;
    return made;
}

struct dimension dimension_product(const struct dimension *a, const struct dimension *b,
                                   bool divides)
{
    struct dimension made = both(a, b);
    if (a->kind == DIMENSION_UNKNOWN || b->kind == DIMENSION_UNKNOWN)
        made.kind = DIMENSION_UNKNOWN;
    else if (b->kind == DIMENSION_KNOWN)
        made.kind = DIMENSION_KNOWN;
    for (int i = 0; i < DIMENSION_BASES; i++)
        made.power[i] += divides ? -b->power[i] : b->power[i];
    return made;
}

struct dimension dimension_power(const struct dimension *a, double exponent)
{
    struct dimension made = *a;
    made.is_single = false;
    for (int i = 0; i < DIMENSION_BASES; i++)
        made.power[i] *= exponent;
    return made;
}

bool dimension_is_pure(const struct dimension *a)
{
    bool pure = true;
    for (int i = 0; i < BASE_RADIAN; i++)
        pure &= is_zero(a->power[i]);
    return pure;
}

static bool has_angle(const struct dimension *a)
{
    return !is_zero(a->power[BASE_RADIAN]) || !is_zero(a->power[BASE_CYCLE]);
}

/* Compares all but angles. */
static bool is_alike(const struct dimension *a, const struct dimension *b)
{
    bool alike = true;
    for (int i = 0; i < BASE_RADIAN; i++)
        alike &= is_zero(a->power[i] - b->power[i]);
    return alike;
}

/* The power of 2 pi that makes cycles radians: b is to count angles as a does. */
static int turns_between(const struct dimension *a, const struct dimension *b)
{
    const double a_cycles = a->power[BASE_CYCLE], b_cycles = b->power[BASE_CYCLE];
    if (is_zero(a_cycles) && !is_zero(b_cycles) &&
        is_zero((double)a->power[BASE_RADIAN] - b_cycles))
        return b_cycles > 0 ? 1 : -1;
    if (is_zero(b_cycles) && !is_zero(a_cycles) &&
        is_zero((double)b->power[BASE_RADIAN] - a_cycles))
        return a_cycles > 0 ? -1 : 1;
    return 0;
}

/* Numbers without a unit count in SI beside names and pure numbers. */
static bool takes_bare(const struct dimension *a)
{
    return a->has_name || !a->unit || (dimension_is_pure(a) && !has_angle(a));
}

bool dimension_sum(const struct dimension *a, const struct dimension *b, struct dimension *sum,
                   int *turns)
{
    *turns = 0;
    *sum = both(a, b);
    const bool takes_b =
        a->kind != DIMENSION_KNOWN || (b->kind == DIMENSION_KNOWN && !has_angle(a) && has_angle(b));
    if (takes_b && (b->kind == DIMENSION_KNOWN || a->kind == DIMENSION_BARE)) {
        sum->kind = b->kind;
        for (int i = 0; i < DIMENSION_BASES; i++)
            sum->power[i] = b->power[i];
    }
    if (a->kind == DIMENSION_UNKNOWN || b->kind == DIMENSION_UNKNOWN)
        return true;
    if (a->kind == DIMENSION_BARE || b->kind == DIMENSION_BARE)
        return takes_bare(a) && takes_bare(b);
    if (!sum->unit) {
        if (!is_alike(a, b))
            sum->kind = DIMENSION_UNKNOWN;
        return true;
    }
    *turns = turns_between(a, b);
    return is_alike(a, b);
}

bool dimension_fits(const struct dimension *a, enum quantity wanted, int *turns)
{
    const struct dimension goal = dimension_of_name(wanted);
    *turns = 0;
    if (wanted == QUANTITY_OTHER || a->kind != DIMENSION_KNOWN || (!a->unit && !is_alike(&goal, a)))
        return true;
    *turns = turns_between(&goal, a);
    if (!a->unit)
        return true;
    if (a->is_single) {
        double si;
        return unit_convert(a->unit, wanted, 1, &si);
    }
    return is_alike(&goal, a) && !(wanted == QUANTITY_NUMBER && has_angle(a));
}

double dimension_turned(double x, int turns)
{
    if (turns == 0)
        return x;
    return turns > 0 ? x * (2 * PI) : x / (2 * PI);
}

enum quantity dimension_quantity(const struct dimension *a)
{
    if (a->kind != DIMENSION_KNOWN)
        return QUANTITY_OTHER;
    for (int q = 0; q < QUANTITY_COUNT; q++) {
        bool same = q != QUANTITY_OTHER;
        for (int i = 0; i < DIMENSION_BASES; i++)
            same &= is_zero(a->power[i] - quantity_power[q][i]);
        if (same)
            return (enum quantity)q;
    }
    return QUANTITY_OTHER;
}

void dimension_put_unit(const struct dimension *a, struct buffer *text)
{
    const enum quantity quantity = dimension_quantity(a);
    bool some = false;
    if (quantity != QUANTITY_OTHER) {
        buffer_put(text, text_of(quantity_unit(quantity)));
        return;
    }
    for (int i = 0; i < DIMENSION_BASES; i++) {
        if (is_zero(a->power[i]))
            continue;
        buffer_format(text, "%s%s", some ? " " : "", base_unit[i]);
        if (!is_zero(a->power[i] - 1))
            buffer_format(text, "^%.3g", (double)a->power[i]);
        some = true;
    }
}

void dimension_put(const struct dimension *a, struct buffer *text)
{
    const enum quantity quantity = dimension_quantity(a);
    if (quantity != QUANTITY_OTHER)
        buffer_put(text, text_of(quantity_name(quantity)));
    else if (a->kind == DIMENSION_KNOWN)
        dimension_put_unit(a, text);
    else
        buffer_put(text, TEXT("number"));
}
