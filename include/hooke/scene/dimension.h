/* SPDX-License-Identifier: GPL-3.0-or-later */
/* dimension: dimensional analysis of expressions whose numbers carry units (y0 + 1 cm): a dimension
 * is a product of powers of base units. The compiler of expressions computes the dimension of each
 * operation, and refuses sums of different dimensions. Cycles (Hz) and radians (rad/s) are
 * different base units, between which values are converted by factors of 2 pi; `turns` is the
 * exponent of such a factor. */
#pragma once

#include <hooke/base/quantity.h>
#include <hooke/base/text.h>

struct unit;

/* Base units; their powers are real numbers, because of square roots. */
enum dimension_base {
    BASE_KILOGRAM,
    BASE_METRE,
    BASE_SECOND,
    BASE_VOLT,
    /* Angle. Distinguished only from pure numbers and from cycles: a length divided by a length may
     * be an angle, since arc lengths are in metres. */
    BASE_RADIAN,
    BASE_CYCLE, /* Cycle: Hz is 1 cycle per second, and 1 cycle is 2 pi radians. */
    /* The number pi as a factor, whose power is counted because it converts: cycles times pi are
     * radians, radians divided by pi are cycles. */
    BASE_PI,
    DIMENSION_BASES
};

/* Knowledge about the dimension of an expression. */
enum dimension_kind {
    /* Numbers without a unit; added to a name, they are in the SI unit of that name. */
    DIMENSION_BARE,
    /* It contains a name whose quantity is unknown, and can be combined with everything. */
    DIMENSION_UNKNOWN,
    /* Sum of names of different dimensions; it cannot be combined with anything that has a unit. */
    DIMENSION_MIXED,
    /* The member `power` has the dimension. */
    DIMENSION_KNOWN
};

/* Dimension of an expression, a plain value. */
struct dimension {
    enum dimension_kind kind;
    /* Powers of the base units. */
    double power[DIMENSION_BASES];
    /* First unit in the expression, or NULL if it has none; a row of unit_catalog. */
    const struct unit *unit;
    /* It contains a name. */
    bool has_name;
    /* It is a single name, or a number or parenthesis with its unit: nothing was computed. */
    bool is_single;
    /* It is a product or a power, in which the user may have converted cycles to radians (6.28*2
     * Hz). */
    bool is_product;
};

/* Returns the dimension of a name of this quantity; QUANTITY_OTHER gives DIMENSION_UNKNOWN. */
struct dimension dimension_of_name(enum quantity quantity);
/* Returns the dimension of the number pi. */
struct dimension dimension_of_pi(void);
/* Returns the dimension of a number or a parenthesis with its unit. */
struct dimension dimension_of_unit(const struct unit *unit);
/* Returns the dimension of the product a b, or of the quotient a / b. */
struct dimension dimension_product(const struct dimension *a, const struct dimension *b,
                                   bool divides);
/* Returns the dimension of a to the power of `exponent`. */
struct dimension dimension_power(const struct dimension *a, double exponent);
/* Returns true if the powers of kg, m, s and V are 0. */
bool dimension_is_pure(const struct dimension *a);
/* Returns true if the expression contains a unit and a positive power of cycles that no factor pi
 * has converted to radians. */
bool dimension_counts_cycles(const struct dimension *a);
/* Computes the dimension of a + b. Sets *turns to -1, 0 or 1: b has to be multiplied by
 * (2 pi)^turns before the addition, as for Hz added to rad/s. Returns false if the dimensions
 * differ and one of them contains a unit; numbers without a unit can be added to names, but not to
 * numbers with a unit. Returns false, too, if the factor is ambiguous: for products (6.28*2 Hz),
 * and for rates without an angle added to Hz. */
bool dimension_sum(const struct dimension *a, const struct dimension *b, struct dimension *sum,
                   int *turns);
/* Returns true if a value of dimension a can be used as the quantity `wanted`, and sets *turns to
 * -1, 0 or 1: the value has to be multiplied by (2 pi)^turns. Expressions of names without units
 * fit every quantity, because they are numbers in SI, except a single name of another dimension,
 * and a product in Hz where rad/s is wanted or the reverse: its numbers may contain 2 pi already.
 */
bool dimension_fits(const struct dimension *a, enum quantity wanted, int *turns);
/* Returns the power p such that a value of dimension a, multiplied by (2 pi)^p, counts angles in
 * the unit of the quantity `wanted`. Returns 0 if both have the same unit of angles, or if the
 * dimensions differ in more than angles. */
double dimension_angle_factor(const struct dimension *a, enum quantity wanted);
/* Returns x (2 pi)^turns; `turns` is -1, 0 or 1. */
double dimension_turned(double x, int turns);
/* Returns the quantity of this dimension, or QUANTITY_OTHER if no enum quantity has it. */
enum quantity dimension_quantity(const struct dimension *a);
/* Appends the name of the quantity, such as "length", or its unit, such as "m^2 kg", if the
 * quantity has no name. */
void dimension_put(const struct dimension *a, struct buffer *text);
/* Appends the SI unit: "m/s", "m^2 kg"; nothing for a pure number. */
void dimension_put_unit(const struct dimension *a, struct buffer *text);
