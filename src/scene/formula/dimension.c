/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Dimensions of expressions with units: powers of base units, of radians and cycles, and of pi,
 * which may convert one into the other. They decide which values can be added, and convert between
 * Hz and rad/s. */
#include <hooke/base/unit.h>
#include <hooke/base/numeric.h>
#include <hooke/scene/dimension.h>

#include <math.h>

static const char *const base_unit[DIMENSION_BASES] = {"kg", "m", "s", "V", "rad", "cycles", "pi"};

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

/* Returns true if a power is 0 but for rounding: powers are sums of fractions such as 1/2 and 1/3
 * in single precision. */
static bool is_zero(double power)
{
    return fabs(power) < 1e-4;
}

/* Returns the dimension of a name with this quantity; unknown for QUANTITY_OTHER. */
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

struct dimension dimension_of_pi(void)
{
    struct dimension made = {.kind = DIMENSION_BARE};
    made.power[BASE_PI] = 1;
    return made;
}

struct dimension dimension_of_unit(const struct unit *unit)
{
    struct dimension made = dimension_of_name(unit->quantity);
    made.has_name = false;
    made.unit = unit;
    return made;
}

/* Returns a dimension with the powers of a, and with what users typed in either operand. */
static struct dimension dimension_merge(const struct dimension *a, const struct dimension *b)
{
    struct dimension made = *a;
    made.unit = a->unit ? a->unit : b->unit;
    made.has_name = a->has_name || b->has_name;
    made.is_single = false;
    made.is_product = a->is_product || b->is_product;
    return made;
}

/* Adds the powers of both, or subtracts those of b if it `divides`. */
struct dimension dimension_product(const struct dimension *a, const struct dimension *b,
                                   bool divides)
{
    struct dimension made = dimension_merge(a, b);
    made.is_product = true;
    if (a->kind == DIMENSION_MIXED || b->kind == DIMENSION_MIXED)
        made.kind = DIMENSION_MIXED;
    else if (a->kind == DIMENSION_UNKNOWN || b->kind == DIMENSION_UNKNOWN)
        made.kind = DIMENSION_UNKNOWN;
    else if (b->kind == DIMENSION_KNOWN)
        made.kind = DIMENSION_KNOWN;
    for (int i = 0; i < DIMENSION_BASES; i++)
        made.power[i] += divides ? -b->power[i] : b->power[i];
    return made;
}

/* Multiplies all powers by the exponent. */
struct dimension dimension_power(const struct dimension *a, double exponent)
{
    struct dimension made = *a;
    made.is_single = false;
    made.is_product = true;
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

/* Powers of both units of angles. */
struct angles {
    double radians, cycles;
};

/* Returns the powers of angles, after factors of pi have made radians of cycles (2 pi f) or cycles
 * of radians (omega/(2 pi)). */
static struct angles angles_of(const struct dimension *a)
{
    const double pi = a->power[BASE_PI], sign = pi < 0 ? -1 : 1;
    struct angles is = {a->power[BASE_RADIAN], a->power[BASE_CYCLE]};
    double moved = fmin(fabs(pi), fmax(sign * is.cycles, 0));
    if (moved == 0)
        moved = fmin(fabs(pi), fmax(-sign * is.radians, 0));
    is.cycles -= sign * moved;
    is.radians += sign * moved;
    return is;
}

/* Returns true if the dimension contains an angle. */
static bool has_angle(const struct dimension *a)
{
    const struct angles is = angles_of(a);
    return !is_zero(is.radians) || !is_zero(is.cycles);
}

bool dimension_counts_cycles(const struct dimension *a)
{
    return a->unit && a->kind == DIMENSION_KNOWN && angles_of(a).cycles > 1e-4;
}

/* Returns true if the dimensions agree in all but angles. */
static bool is_alike(const struct dimension *a, const struct dimension *b)
{
    bool alike = true;
    for (int i = 0; i < BASE_RADIAN; i++)
        alike &= is_zero(a->power[i] - b->power[i]);
    return alike;
}

/* Returns the power of 2 pi with which b counts angles in the unit of a; 0 if it does so already or
 * if the dimensions do not match. */
static double turns_between(const struct dimension *a, const struct dimension *b)
{
    const struct angles is = angles_of(a), other = angles_of(b);
    const bool alike = is_zero(is.radians + is.cycles - other.radians - other.cycles);
    return alike && !is_zero(other.cycles - is.cycles) ? other.cycles - is.cycles : 0;
}

/* Returns true if the value is known to be in the unit that its dimension names: a product with a
 * number could have converted it (6.28*2 Hz could be in rad/s), but 2*pi rad/s could not. */
static bool is_sure(const struct dimension *a)
{
    return !a->is_product || (a->power[BASE_PI] > 0 && a->power[BASE_RADIAN] > 0);
}

/* Sets *turns to the power of 2 pi between two values. Returns false if their units of angles are
 * not sure enough to convert. */
static bool find_turns(const struct dimension *a, const struct dimension *b, int *turns)
{
    const double power = turns_between(a, b);
    *turns = (int)lround(power);
    return power == 0 || (fabs(power) < 1.5 && is_sure(a) && is_sure(b));
}

/* Returns true if `rate`, in 1/s without an angle, cannot be added to b, in Hz or rad/s. Only a
 * rate over pi is known to count cycles; any other may be in radians. */
static bool is_other_rate(const struct dimension *rate, const struct dimension *b)
{
    const struct angles other = angles_of(b);
    const bool over_pi = rate->power[BASE_PI] < -1e-4;
    return is_zero(rate->power[BASE_KILOGRAM]) && is_zero(rate->power[BASE_METRE]) &&
           is_zero(rate->power[BASE_VOLT]) && !has_angle(rate) &&
           (over_pi ? other.radians > 1e-4 : other.cycles > 1e-4);
}

/* Returns true if a number without a unit can be added: to names, for which it is in SI, and to
 * pure numbers. */
static bool takes_bare(const struct dimension *a)
{
    return a->has_name || !a->unit || (dimension_is_pure(a) && !has_angle(a));
}

/* Sets *sum to the dimension of a + b, and *turns to the power of 2 pi by which b is multiplied to
 * count angles in the unit of a (cycles or radians), 0 for none. Returns true if they can be added:
 * - a sum with a MIXED value is MIXED, and cannot contain a unit;
 * - an UNKNOWN value can be added to all but these;
 * - a BARE number can be added to names, to values without a unit and to pure numbers;
 * - KNOWN values without a unit can be added, and the sum is MIXED if their dimensions differ;
 * - KNOWN values with a unit need the same dimension, apart from angles that can be converted.
 * The sum has the powers of a, or those of b (`takes_b`) if a has none or only b has an angle. */
bool dimension_sum(const struct dimension *a, const struct dimension *b, struct dimension *sum,
                   int *turns)
{
    *turns = 0;
    *sum = dimension_merge(a, b);
    const bool takes_b =
        a->kind != DIMENSION_KNOWN || (b->kind == DIMENSION_KNOWN && !has_angle(a) && has_angle(b));
    if (takes_b && (b->kind == DIMENSION_KNOWN || a->kind == DIMENSION_BARE)) {
        sum->kind = b->kind;
        for (int i = 0; i < DIMENSION_BASES; i++)
            sum->power[i] = b->power[i];
    }
    if (a->kind == DIMENSION_MIXED || b->kind == DIMENSION_MIXED) {
        sum->kind = DIMENSION_MIXED;
        return !sum->unit;
    }
    if (a->kind == DIMENSION_UNKNOWN || b->kind == DIMENSION_UNKNOWN)
        return true;
    if (a->kind == DIMENSION_BARE || b->kind == DIMENSION_BARE)
        return takes_bare(a) && takes_bare(b);
    if (!sum->unit) {
        if (!is_alike(a, b))
            sum->kind = DIMENSION_MIXED;
        return true;
    }
    return is_alike(a, b) && !is_other_rate(a, b) && !is_other_rate(b, a) &&
           find_turns(a, b, turns);
}

/* Returns true if the value can be one of the quantity `wanted`, perhaps after multiplication by 2
 * pi to the power *turns, which converts cycles and radians. */
bool dimension_fits(const struct dimension *a, enum quantity wanted, int *turns)
{
    const struct dimension goal = dimension_of_name(wanted);
    *turns = 0;
    if (wanted == QUANTITY_OTHER || a->kind != DIMENSION_KNOWN || (!a->unit && !a->has_name))
        return true;
    if (!find_turns(&goal, a, turns))
        return false;
    if (!a->unit)
        return !a->is_single || is_alike(&goal, a);
    if (a->is_single) {
        double si;
        return unit_convert(a->unit, wanted, 1, &si);
    }
    return is_alike(&goal, a) && !(wanted == QUANTITY_NUMBER && has_angle(a));
}

double dimension_angle_factor(const struct dimension *a, enum quantity wanted)
{
    const struct dimension goal = dimension_of_name(wanted);
    return a->kind == DIMENSION_KNOWN && is_alike(&goal, a) ? turns_between(&goal, a) : 0;
}

double dimension_turned(double x, int turns)
{
    if (turns == 0)
        return x;
    return turns > 0 ? x * (2 * PI) : x / (2 * PI);
}

/* Returns the power of a base as texts show it: 0 for angles that a factor of pi has changed,
 * because pi Hz is neither Hz nor rad/s. */
static double shown_power(const struct dimension *a, int base)
{
    const bool changed = !is_zero(angles_of(a).cycles - a->power[BASE_CYCLE]);
    return base == BASE_PI || (changed && base >= BASE_RADIAN) ? 0 : a->power[base];
}

/* Finds the quantity that has these powers; QUANTITY_OTHER if there is none. */
enum quantity dimension_quantity(const struct dimension *a)
{
    if (a->kind != DIMENSION_KNOWN)
        return QUANTITY_OTHER;
    for (int q = 0; q < QUANTITY_COUNT; q++) {
        bool same = q != QUANTITY_OTHER;
        for (int i = 0; i < DIMENSION_BASES && same; i++)
            same = is_zero(shown_power(a, i) - quantity_power[q][i]);
        if (same)
            return (enum quantity)q;
    }
    return QUANTITY_OTHER;
}

/* Appends the unit of the quantity, or powers of base units. */
void dimension_put_unit(const struct dimension *a, struct buffer *text)
{
    const enum quantity quantity = dimension_quantity(a);
    bool some = false;
    if (quantity != QUANTITY_OTHER) {
        buffer_put(text, text_of(quantity_unit(quantity)));
        return;
    }
    for (int i = 0; i < DIMENSION_BASES; i++) {
        const double power = shown_power(a, i);
        if (is_zero(power))
            continue;
        buffer_format(text, "%s%s", some ? " " : "", base_unit[i]);
        if (!is_zero(power - 1))
            buffer_format(text, "^%.3g", power);
        some = true;
    }
}

/* Appends a name for the dimension, for messages. */
void dimension_put(const struct dimension *a, struct buffer *text)
{
    const enum quantity quantity = dimension_quantity(a);
    if (quantity != QUANTITY_OTHER)
        buffer_put(text, text_of(quantity_name(quantity)));
    else if (a->kind == DIMENSION_KNOWN)
        dimension_put_unit(a, text);
    else
        buffer_put(text, a->kind == DIMENSION_MIXED ? TEXT("mixed dimensions") : TEXT("number"));
}
