/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Dimensions of expressions whose numbers carry units: powers of the base units. */
#pragma once

#include <hooke/base/quantity.h>
#include <hooke/base/text.h>

struct unit;

enum dimension_base {
    BASE_KILOGRAM,
    BASE_METRE,
    BASE_SECOND,
    BASE_VOLT,
    BASE_RADIAN, /* counts only beside numbers and cycles: arc lengths are metres all the same */
    BASE_CYCLE,  /* Hz is one a second, rad/s is 1/(2 pi) of it */
    BASE_PI,     /* pi as a factor: times cycles it is in radians, radians over it are cycles */
    DIMENSION_BASES
};

enum dimension_kind {
    DIMENSION_BARE,    /* numbers without a unit: beside a name they count in its SI unit */
    DIMENSION_UNKNOWN, /* names whose quantity is unknown fit everything */
    DIMENSION_MIXED,   /* sums of names that are not alike: nothing with a unit fits them */
    DIMENSION_KNOWN
};

struct dimension {
    enum dimension_kind kind;
    double power[DIMENSION_BASES];
    const struct unit *unit; /* the first that was typed; NULL if none was */
    bool has_name;
    bool is_single; /* a name, or a number or parenthesis with its unit: nothing was computed */
    /* result of a product or a power, whose cycles may have been made radians by hand */
    bool is_product;
};

/* Returns the dimension of a name of this quantity; QUANTITY_OTHER is unknown. */
struct dimension dimension_of_name(enum quantity quantity);
/* Returns the dimension of the number pi. */
struct dimension dimension_of_pi(void);
/* Returns the dimension of a number or a parenthesis with its unit. */
struct dimension dimension_of_unit(const struct unit *unit);
/* a b, or a / b. */
struct dimension dimension_product(const struct dimension *a, const struct dimension *b,
                                   bool divides);
struct dimension dimension_power(const struct dimension *a, double exponent);
/* Returns true if no power of kg, m, s and V is left. */
bool dimension_is_pure(const struct dimension *a);
/* Returns true if a unit was typed and cycles are left that pi did not make radians. */
bool dimension_counts_cycles(const struct dimension *a);
/*
 * Finds the dimension of a sum. Returns false if the two differ although a unit was typed in one of
 * them; numbers without a unit fit names, not numbers with one. *turns: b is to be multiplied by
 * (2 pi)^turns, -1, 0 or 1, as of Hz beside rad/s. Products are not converted, as 6.28*2 Hz could
 * be either, and a rate beside Hz could be in radians: these do not add.
 */
bool dimension_sum(const struct dimension *a, const struct dimension *b, struct dimension *sum,
                   int *turns);
/*
 * Returns true if such a value can be one of the wanted quantity, after a factor (2 pi)^turns.
 * Names are SI numbers, but one alone of another dimension does not fit, nor Hz for rad/s.
 */
bool dimension_fits(const struct dimension *a, enum quantity wanted, int *turns);
/* Returns the power of 2 pi by which such a value differs from one of the wanted quantity, or 0. */
double dimension_angle_factor(const struct dimension *a, enum quantity wanted);
/* x (2 pi)^turns */
double dimension_turned(double x, int turns);
/* QUANTITY_OTHER where it has no name. */
enum quantity dimension_quantity(const struct dimension *a);
/* Appends "length", "number", or "m^2 kg" where it has no name. */
void dimension_put(const struct dimension *a, struct buffer *text);
/* Appends its SI unit: "m/s", "m^2 kg"; nothing for a pure number. */
void dimension_put_unit(const struct dimension *a, struct buffer *text);
