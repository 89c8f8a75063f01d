/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calibrations of sensors. */
#ifndef HOOKE_DATA_CALIBRATION_H
#define HOOKE_DATA_CALIBRATION_H

#include <hooke/base/error.h>

struct unit;

/* What a sensor reads, and what is true: the straight line through two points. Compared and kept
 * byte by byte: what is not used is 0. */
struct calibration {
    double read[2], truth[2]; /* numbers in these units: */
    char unit[2][16];         /* of both readings and of both truths; "": none */
    bool known;               /* else values are as they come */
    bool decided;             /* somebody has said so */
};

/* Numbers with or without a unit, NULL, at the beginning of *rest, which then begins behind them;
 * how many, `max` at most. */
int calibration_values(struct text *rest, double *value, const struct unit **unit, int max);
/* From READ1 TRUE1 READ2 TRUE2. Error: units of different kinds, no two points. */
bool calibration_make(const double value[4], const struct unit *const unit[4],
                      struct calibration *calibration, struct error *error);
/* "19.6 cm 20 cm 39.1 cm 40 cm", "off" */
void calibration_put(const struct calibration *calibration, struct buffer *text);
/* From what that wrote; anything else: off. */
void calibration_take_line(struct text line, struct calibration *calibration);
/* Truth for each reading, in their units. */
double calibration_gain(const struct calibration *calibration);

#endif
