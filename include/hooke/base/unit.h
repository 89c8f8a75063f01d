/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * unit: quantities and their units.
 *
 * A closed table. A quantity is a kind of number (mass, length …); a unit belongs to one quantity
 * and has a factor to SI.
 */
#pragma once

#include <hooke/base/catalog.h>
#include <hooke/base/quantity.h>

struct unit {
    struct row row; /* name ("cm") and, as its unit, the SI name ("m") */
    enum quantity quantity;
    double factor; /* value in SI = number * factor, up to rounding: convert with unit_convert */
    enum unit_use {
        UNIT_READ,  /* understood, never chosen for display */
        UNIT_SHOWN, /* chosen for display by size */
        UNIT_HOME   /* chosen by size, and for zero */
    } use;
};

extern const struct catalog unit_catalog;
const struct unit *unit_at(size_t i);
const struct unit *unit_from(const struct row *row); /* row has to be one of the catalog's */

const char *quantity_name(enum quantity quantity); /* returns "mass" */
/* Returns how often a position or an angle is differentiated to give this quantity: 0, 1 or 2; -1
 * if it is not of a motion. */
int quantity_order(enum quantity quantity);
const char *quantity_article(enum quantity quantity); /* "a" mass, "an" angle */
const char *quantity_unit(enum quantity quantity);    /* SI unit "kg", "" for a pure number */
void quantity_units(enum quantity quantity, struct buffer *names); /* "kg, g, mg" */
/* Returns the longest unit at the start of the text that no letter follows, or NULL. */
const struct unit *unit_match(struct text text);
const struct unit *unit_find(struct text name); /* returns NULL if no unit has this name */
/*
 * Converts a number in `unit` to SI. Returns false if the unit does not fit the quantity: units of
 * the same quantity do, and Hz for rad/s or back, by 2 pi. Decimal factors are exact: 5.7 cm gives
 * the double nearest to 0.057.
 */
bool unit_convert(const struct unit *unit, enum quantity wanted, double number, double *si);
/* Returns the unit that shows `value` [SI] with 1 to 999 before the point, if there is one: g for
 * 0.2 kg, cm for 0.05 m. */
const struct unit *unit_display(enum quantity quantity, double value);
/* Appends the value [SI] with a unit that suits it, such as "200 g", to `digits` significant
 * digits. With 0 digits it writes as many as are needed to read the same value back. */
void buffer_quantity(struct buffer *buffer, double value, enum quantity quantity, int digits);
