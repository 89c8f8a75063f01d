/* SPDX-License-Identifier: GPL-3.0-or-later */
/* State of a measurement, and the functions that measure.c shares with the larger quantities. A
 * measurement is kept with measure_keep(), its record begun with measure_begin(), its text sent
 * with measure_say(). */
#pragma once

#include <hooke/plot.h>
#include "modules/recording/known/known.h"

#include <hooke/command/handler.h>

/* A measurement that is being made. */
struct measuring {
    struct session *session;
    const struct arguments *args;
    struct reply *reply;
    struct subject subject;
    const char *quantity; /* name of the quantity, such as "period" */
    double period;        /* [s] period of the subject, NAN until it is read */
    struct error *error;
};

/* Appends "name = 1.23 +- 0.01 s", or nothing if the value is NAN. */
void put_measured(struct buffer *text, const char *name, struct measured value, enum quantity unit);
/* Begins a record of kind `measure`; the caller adds its own fields and ends it. */
void measure_begin(struct measuring *m, const char *quantity, struct measured value,
                   enum quantity unit, double periods);

/* Adds the value to the session's measurements. Returns false with the error if out of memory. */
bool measure_keep(struct measuring *m, const char *name, struct measured value, enum quantity unit,
                  double periods);
/* Returns the measurement that was added last. */
struct measurement *measure_latest(const struct measuring *m);
/* Adds the text to the reply and frees it. Returns true. */
bool measure_say(struct measuring *m, struct buffer *text);

/* Measures the amplitude at the times at=, or in the middles of windows=. Returns false with the
 * error. */
bool measure_amplitude(struct measuring *m);
/* Reports gamma and the 1/e time from readings of the amplitude, as lab sheets ask for: from the
 * line through their logarithms, and from the time in which the first one falls to 1/e. Appends
 * nothing if the readings do not fall. */
void measure_fall(struct measuring *m, const struct reading *reading, int count,
                  struct buffer *text);
/* Measures the period in that number of windows, against the amplitude there. Returns false with
 * the error. */
bool measure_periods(struct measuring *m, int windows, struct buffer *text);
/* Fits T^2 against m over all recordings with a known mass: reports k and the spring's effective
 * mass, and each k against the first. Returns false with the error. */
bool measure_spring(struct measuring *m);

/* Measures a quantity of several recordings, or in windows of one: reports mean, scatter and the
 * value to quote. Returns false with the error. */
bool measure_repeat(struct measuring *m);

/* Adds the lines of spectra to the reply, in words and as records, with labels if there are several
 * curves (figure/spectrum.c). */
void spectrum_report(const struct figure_peaks *peaks, int curves, struct reply *reply);
