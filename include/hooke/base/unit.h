/* SPDX-License-Identifier: GPL-3.0-or-later */
/* unit: the table of units, their conversion to SI, and quantities written with a unit. A unit
 * belongs to one quantity (mass, length …, <hooke/base/quantity.h>) and has a factor to SI. */
#pragma once

#include <hooke/base/catalog.h>
#include <hooke/base/quantity.h>

/* A row of unit_catalog. */
struct unit {
    struct row row; /* Name ("cm"); its unit is the SI unit ("m"). */
    /* Quantity that the unit measures. */
    enum quantity quantity;
    /* SI value = number * factor, up to rounding; unit_convert() rounds correctly for decimal
     * factors. */
    double factor;
    /* Use of the unit for display. */
    enum unit_use {
        UNIT_READ,  /* Read from input, never chosen for display. */
        UNIT_SHOWN, /* Chosen for display if the value has a suitable size. */
        UNIT_HOME   /* As UNIT_SHOWN, and chosen for the value zero. */
    } use;
};

/* All units. Those of one quantity that are displayed follow each other from the largest to the
 * smallest. */
extern const struct catalog unit_catalog;
/* Returns unit i of the catalog, 0 <= i < unit_catalog.count. */
const struct unit *unit_at(size_t i);
/* Returns the unit whose struct row this is; the row must be in unit_catalog. */
const struct unit *unit_from(const struct row *row);

const char *quantity_name(enum quantity quantity); /* Returns the English name, such as "mass". */
/* Returns how many times a position or an angle is differentiated by time to give this quantity: 0,
 * 1 or 2, or -1 for any other quantity. */
int quantity_order(enum quantity quantity);
/* Returns the article of the name: "a" (mass) or "an" (angle). */
const char *quantity_article(enum quantity quantity);
/* Returns the SI unit, such as "kg", or "" for a pure number and QUANTITY_OTHER. */
const char *quantity_unit(enum quantity quantity);
/* Appends the units that unit_convert() accepts for the quantity: "kg, g, mg". */
void quantity_units(enum quantity quantity, struct buffer *names);
/* Returns the longest unit at the start of the text that is not followed by a letter or digit, or
 * NULL. */
const struct unit *unit_match(struct text text);
/* Returns the unit with this name or alias, or NULL if there is none. */
const struct unit *unit_find(struct text name);
/* Converts a number in `unit` to SI units. Returns false, with *si unchanged, if the unit does not
 * measure the quantity `wanted`; Hz and rad/s are converted to each other with the factor 2 pi.
 * Decimal factors are exact: 5.7 cm gives the double nearest to 0.057. */
bool unit_convert(const struct unit *unit, enum quantity wanted, double number, double *si);
/* Returns the unit in which `value` [SI] has 1 to 999 before the decimal point if there is one,
 * such as g for 0.2 kg, else the nearest one. Returns NULL for a quantity without displayed units.
 */
const struct unit *unit_display(enum quantity quantity, double value);
/* Appends a value [SI] in the unit that unit_display() chooses, such as "200 g", with `digits`
 * significant digits. With 0 digits it appends as many as are needed to read the same double back.
 */
void buffer_quantity(struct buffer *buffer, double value, enum quantity quantity, int digits);
