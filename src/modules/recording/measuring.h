/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A measurement while it is made: what measure.c and the larger quantities share. */
#pragma once

#include <hooke/plot.h>
#include "modules/recording/known/known.h"

#include <hooke/command/handler.h>

struct measuring {
    struct session *session;
    const struct arguments *args;
    struct reply *reply;
    struct subject subject;
    const char *quantity; /* "period" */
    double period;        /* [s] NAN until it was read */
    struct error *error;
};

/* "name = 1.23 +- 0.01 s"; nothing where the value is not known. */
void put_measured(struct buffer *text, const char *name, struct measured value, enum quantity unit);
/* Opens a record of kind `measure`; the caller adds fields of its own and ends it. */
void measure_begin(struct measuring *m, const char *quantity, struct measured value,
                   enum quantity unit, double periods);

/* Adds to the list of measurements; measure_latest() is then its row. */
bool measure_keep(struct measuring *m, const char *name, struct measured value, enum quantity unit,
                  double periods);
struct measurement *measure_latest(const struct measuring *m);
/* Gives the text out and frees it. Returns true. */
bool measure_say(struct measuring *m, struct buffer *text);

/* The amplitude at the times at=, or in the middles of windows=. */
bool measure_amplitude(struct measuring *m);
/* gamma and 1/e time from readings of the amplitude, as on the sheet: the line through their
 * logarithms, and the time in which the first falls to 1/e. Nothing is said where they do not fall.
 */
void measure_fall(struct measuring *m, const struct reading *reading, int count,
                  struct buffer *text);
/* Measures the period in n windows, against the amplitude there. */
bool measure_periods(struct measuring *m, int windows, struct buffer *text);
/* T^2 against m over all recordings whose mass is known: k and the spring's effective mass; each k
 * and the first. */
bool measure_spring(struct measuring *m);

/* A quantity of several recordings, or of windows of one: mean, scatter, what to quote. */
bool measure_repeat(struct measuring *m);

/* The lines of spectra in words and as records (plot.c); with names where there are several
 * curves. */
void spectrum_report(const struct figure_peaks *peaks, int curves, struct reply *reply);
