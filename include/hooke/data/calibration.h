/* SPDX-License-Identifier: GPL-3.0-or-later */
/* calibration: calibrations of sensors by two points: a straight line from readings to true values.
 */
#pragma once

#include <hooke/base/error.h>

struct unit;

/* Straight line through two pairs of a reading and its true value. It is compared and stored byte
 * by byte, so that unused members must be 0. */
struct calibration {
    /* Readings and true values of the two points, in their units. */
    double read[2], truth[2];
    char unit[2][16]; /* Unit of both readings, and of both true values; "" if they have none. */
    bool known;       /* False if values are used as the sensor sends them. */
    bool decided;     /* The user has chosen, be it a calibration or none. */
};

/* Reads at most `max` numbers from the beginning of *rest and removes them from it. unit[i] becomes
 * NULL for a number without a unit. Returns the number read. */
int calibration_values(struct text *rest, double *value, const struct unit **unit, int max);
/* Makes a calibration of READ1 TRUE1 READ2 TRUE2. Returns false, with `error` set, if units are of
 * different kinds or if the two points are equal. */
bool calibration_make(const double value[4], const struct unit *const unit[4],
                      struct calibration *calibration, struct error *error);
/* Appends the calibration as text: "19.6 cm 20 cm 39.1 cm 40 cm", or "off". */
void calibration_put(const struct calibration *calibration, struct buffer *text);
/* Reads the text that calibration_put() wrote; any other text sets the calibration to off. */
void calibration_take_line(struct text line, struct calibration *calibration);
/* Returns the slope of the line: change of the true value per change of the reading, in their
 * units. */
double calibration_gain(const struct calibration *calibration);
