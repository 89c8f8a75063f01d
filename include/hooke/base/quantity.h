/* SPDX-License-Identifier: GPL-3.0-or-later */
/* quantity: physical quantities as an enum, and numbers with uncertainties. Units and names of
 * quantities are in <hooke/base/unit.h>. */
#pragma once

/* Physical quantity of a number. */
enum quantity {
    /* A pure number without a unit. */
    QUANTITY_NUMBER,
    QUANTITY_LENGTH,
    QUANTITY_MASS,
    QUANTITY_TIME,
    QUANTITY_FORCE,
    QUANTITY_STIFFNESS,
    QUANTITY_CUBIC_STIFFNESS,
    /* Damping per mass, growth rates: 1/s. */
    QUANTITY_RATE,
    /* Coefficient of linear drag: kg/s. */
    QUANTITY_MASS_RATE,
    QUANTITY_VELOCITY,
    QUANTITY_ACCELERATION,
    QUANTITY_AREA,
    QUANTITY_DENSITY,
    QUANTITY_VISCOSITY,
    QUANTITY_ANGLE,
    QUANTITY_ANGULAR_FREQUENCY,
    QUANTITY_ANGULAR_ACCELERATION,
    QUANTITY_FREQUENCY,
    QUANTITY_ENERGY,
    QUANTITY_POWER,
    QUANTITY_VOLTAGE,
    /* Any other quantity: its unit is unknown, so that nothing is converted. */
    QUANTITY_OTHER,
    QUANTITY_COUNT
};

/* A value in SI units with its standard uncertainty, which is >= 0, or NAN if unknown. */
struct measured {
    double value, uncertainty;
};
