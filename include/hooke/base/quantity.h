/* SPDX-License-Identifier: GPL-3.0-or-later */
/* quantity: kinds of numbers, as mass and length, and measured numbers. */
#pragma once

enum quantity {
    QUANTITY_NUMBER,
    QUANTITY_LENGTH,
    QUANTITY_MASS,
    QUANTITY_TIME,
    QUANTITY_FORCE,
    QUANTITY_STIFFNESS,
    QUANTITY_CUBIC_STIFFNESS,
    QUANTITY_RATE,
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
    QUANTITY_OTHER,
    QUANTITY_COUNT
};

/* A measured number. Its uncertainty is one standard uncertainty, >= 0, or NAN if unknown. */
struct measured {
    double value, uncertainty;
};
