/* SPDX-License-Identifier: GPL-3.0-or-later */
/* calibration: calibrations of sensors by two points: a straight line from readings to true values.
 */
#pragma once

#include <hooke/base/error.h>

struct unit;

/* Straight line through two pairs of a reading and its true value. It is compared and stored byte
 * by byte, so that unused members must be 0. */
struct calibration {
    /* Readings of the two points in unit[0], and their true values in unit[1]. */
    double read[2], truth[2];
    /* Unit of both readings, then unit of both true values; "" if they have none. */
    char unit[2][16];
    bool known;   /* There is a calibration; if false, values are used as the sensor sends them. */
    bool decided; /* The user has chosen a calibration, or has chosen to use none. */
};

/* Reads up to `max` numbers, each perhaps with a unit, from the beginning of *rest into value [max]
 * and unit [max], and removes them from *rest. unit[i] is NULL for a number without a unit. Returns
 * how many were read. */
int calibration_values(struct text *rest, double *value, const struct unit **unit, int max);
/* Makes a calibration of the values READ1, TRUE1, READ2, TRUE2 and their units. Returns false, with
 * `error` set, if units are of different kinds or if the two points are equal. */
bool calibration_make(const double value[4], const struct unit *const unit[4],
                      struct calibration *calibration, struct error *error);
/* Appends the calibration as text: "19.6 cm 20 cm 39.1 cm 40 cm", or "off". */
void calibration_put(const struct calibration *calibration, struct buffer *text);
/* Reads the text that calibration_put() wrote; any other text sets the calibration to off. */
void calibration_take_line(struct text line, struct calibration *calibration);
/* Returns the slope of the line, which is the change of the true value in unit[1] for a change of
 * the reading by one unit[0]. */
double calibration_gain(const struct calibration *calibration);
