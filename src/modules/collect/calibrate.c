/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Commands calibrate and zero: a linear calibration of the value that a sensor sends, from two
 * points whose true values are known, or from its mean at rest. */
#ifndef COMMAND_ROWS
#include "modules/collect/collecting.h"
#include <hooke/base/cancel.h>
#include <hooke/data.h>
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

/* [s] time at the end of the data over which a reading is averaged */
#define READING_SECONDS 1.0
#define READING_SAMPLES_MIN 3 /* Smallest number of samples in a reading. */
/* Two readings have to differ by this many standard deviations of their means. */
#define READING_SEPARATION_SIGMAS 5
/* A warning is given if a reading scatters by more than this fraction of the distance between both.
 */
#define READING_SCATTER_MAX 0.05

/* A reading of the sensor, in the unit of its column or, under a calibration, of the uncalibrated
 * value. */
struct raw {
    /* scatter is the standard deviation of one sample */
    double mean, scatter;
    size_t n;
    const struct unit *unit; /* unit of the readings, or NULL */
};

/* Averages the uncalibrated samples of a recording from t_begin to t_end [s] into *raw (mean,
 * scatter, number, unit); values of a calibrated recording are converted back to readings. Returns
 * false with an error if there are too few or if cancelled. */
static bool take_reading(const struct session *session, const struct recording *recording,
                         double t_begin, double t_end, struct raw *raw, struct error *error)
{
    const struct calibration *c = &recording->calibration;
    const struct column *column = &recording->column[recording->value];
    double mean = 0, squares = 0;
    *raw = (struct raw){.unit = unit_find(text_of(c->known ? c->unit[0] : column->unit))};
    for (size_t i = 0; i < recording->rows; i++) {
        double value = column->value[i];
        if (cancelled_at(session->front.cancel, i))
            return error_set(error, ERROR_CANCELLED, "stopped; nothing was calibrated");
        if (!(recording->t[i] >= t_begin && recording->t[i] <= t_end) || !isfinite(value))
            continue;
        if (c->known)
            value = c->read[0] + (value - c->truth[0]) / calibration_gain(c);
        const double apart = value - mean; /* Welford 1962 */
        mean += apart / (double)++raw->n;
        squares += apart * (value - mean);
    }
    raw->mean = mean;
    raw->scatter = raw->n > 1 ? sqrt(squares / (double)(raw->n - 1)) : 0;
    return raw->n >= READING_SAMPLES_MIN ||
           error_set(error, ERROR_COMMAND,
                     "%s has only %zu samples from %.6g to %.6g s, which is too few",
                     recording->name, raw->n, t_begin, t_end);
}

/* Returns the mean of a reading rounded to one digit beyond its standard error. */
static double rounded_mean(const struct raw *raw)
{
    const double error = raw->scatter / sqrt((double)raw->n), decimals = 1 - floor(log10(error));
    char text[64];
    double value = raw->mean;
    if (error > 0 && decimals >= 0 && decimals < 15 && fabs(value) < 1e15) {
        snprintf(text, sizeof text, "%.*f", (int)decimals, value);
        real_parse(text_of(text), &value);
    }
    return value;
}

/* A number with its unit, to be shown. */
struct shown_value {
    char text[64];
};

/* Returns "VALUE UNIT" for a message. */
static struct shown_value with_unit_name(double value, const char *unit)
{
    struct shown_value made;
    snprintf(made.text, sizeof made.text, "%.6g%s%.32s", value, unit[0] ? " " : "", unit);
    return made;
}

static struct shown_value with_unit(double value, const struct unit *unit)
{
    return with_unit_name(value, unit ? unit->row.name : "");
}

/* Reports a calibration as a line and as a record. */
static void calibration_reply(const struct calibration *c, struct reply *reply)
{
    struct buffer text = {0};
    calibration_put(c, &text);
    if (!c->known)
        reply_line(reply, "values are used without calibration");
    else
        reply_line(reply, "y: a reading of %s means %s, and %s means %s; %s for each %s",
                   with_unit_name(c->read[0], c->unit[0]).text,
                   with_unit_name(c->truth[0], c->unit[1]).text,
                   with_unit_name(c->read[1], c->unit[0]).text,
                   with_unit_name(c->truth[1], c->unit[1]).text,
                   with_unit_name(calibration_gain(c), c->unit[1]).text,
                   c->unit[0][0] ? c->unit[0] : "unit of the reading");
    reply_begin(reply, "calibration");
    reply_string(reply, "points", c->known ? buffer_view(&text) : NULL);
    reply_real(reply, "gain", c->known ? calibration_gain(c) : NAN);
    reply_string(reply, "read_unit", c->known ? c->unit[0] : NULL);
    reply_string(reply, "unit", c->known ? c->unit[1] : NULL);
    reply_end(reply);
    buffer_free(&text);
}

/* Stores the calibration for the data that is being collected and for later collections. */
static void calibration_keep(struct session *session, const struct calibration *c,
                             struct reply *reply)
{
    session->setup.calibration = *c;
    session_changed(session);
    calibration_reply(c, reply);
}

/* Makes and stores the calibration of two readings whose true values are known, truth[i] in
 * unit[i]. Returns false with an error if the readings are too close to each other compared with
 * their noise. */
static bool calibrate_from_readings(struct session *session, const struct raw raw[2],
                                    const double truth[2], const struct unit *const unit[2],
                                    struct reply *reply, struct error *error)
{
    const double apart = fabs(raw[1].mean - raw[0].mean),
                 noise = hypot(raw[0].scatter / sqrt((double)raw[0].n),
                               raw[1].scatter / sqrt((double)raw[1].n));
    const double value[4] = {rounded_mean(&raw[0]), truth[0], rounded_mean(&raw[1]), truth[1]};
    const struct unit *const units[4] = {raw[0].unit, unit[0], raw[1].unit, unit[1]};
    struct calibration c;
    if (!(apart > READING_SEPARATION_SIGMAS * noise)) {
        error_set(error, ERROR_COMMAND, "the device read %s both times, so there is only one point",
                  with_unit(raw[0].mean, raw[0].unit).text);
        return error_hint(error, "check that the body was moved and that the column is right");
    }
    for (int i = 0; i < 2; i++) {
        const char *const name = raw[i].unit ? raw[i].unit->row.name : "";
        if (raw[i].scatter > READING_SCATTER_MAX * apart)
            reply_warning(reply, "the body was not at rest: the readings at %s scatter by %.2g%s%s",
                          with_unit(truth[i], unit[i]).text, raw[i].scatter, *name ? " " : "",
                          name);
    }
    if (!calibration_make(value, units, &c, error))
        return false;
    calibration_keep(session, &c, reply);
    return true;
}

/* Returns the recording that is being collected, or NULL. */
static struct recording *growing_recording(const struct session *session)
{
    for (int i = 0; session_collecting(session) && i < session->recordings; i++)
        if (session->recording[i]->growing)
            return session->recording[i]->recording;
    return NULL;
}

/* Takes the reading at the next of the two points (`calibrate take`); after the second the
 * calibration is made. Returns false with an error if no point is expected or there is too little
 * data. */
static bool take_next_point(struct session *session, struct reply *reply, struct error *error)
{
    struct collecting *now = session_collecting(session);
    struct recording *recording = growing_recording(session);
    struct raw raw[2];
    if (!now || !now->aim.waits) {
        error_set(error, ERROR_COMMAND, "no calibration is waiting for a point");
        return error_hint(error, "while collecting, type: calibrate y 20 cm 40 cm");
    }
    if (!recording)
        return error_set(error, ERROR_COMMAND, "no data have arrived yet");
    const double end = recording->t[recording->rows - 1];
    const int i = now->aim.taken;
    if (!take_reading(session, recording, end - READING_SECONDS, end, &raw[i], error))
        return false;
    reply_line(reply, "%s reads %s, scatter %.2g in %zu samples",
               with_unit(now->aim.truth[i], now->aim.truth_unit[i]).text,
               with_unit(raw[i].mean, raw[i].unit).text, raw[i].scatter, raw[i].n);
    if (i == 0) {
        now->aim.taken = 1;
        now->aim.read[0] = raw[0].mean;
        now->aim.scatter[0] = raw[0].scatter;
        now->aim.samples = raw[0].n;
        now->aim.read_unit = raw[0].unit;
        reply_line(reply, "hold it at %s, then type: calibrate take",
                   with_unit(now->aim.truth[1], now->aim.truth_unit[1]).text);
        return true;
    }
    now->aim.waits = false;
    raw[0] =
        (struct raw){now->aim.read[0], now->aim.scatter[0], now->aim.samples, now->aim.read_unit};
    return calibrate_from_readings(session, raw, now->aim.truth, now->aim.truth_unit, reply, error);
}

/* Takes both readings from the current recording, in two windows of time such as "0:2,5:7" [s]
 * (`remaining`), and makes the calibration; the true values are truth [i] in unit [i]. Returns
 * false with an error if the windows are malformed or too short. */
static bool calibrate_from_windows(struct session *session, struct text remaining,
                                   const double truth[2], const struct unit *const unit[2],
                                   struct reply *reply, struct error *error)
{
    const struct recording *recording = session_recording(session);
    struct raw raw[2];
    const struct text all = remaining;
    for (int i = 0; i < 2; i++) {
        double edge[2];
        for (int k = 0; k < 2; k++) {
            size_t used = 0;
            char delimiter;
            if (i == 1 && k == 1)
                delimiter = '\0';
            else
                delimiter = k ? ',' : ':';
            if (real_scan(remaining, '.', &edge[k], &used) != REAL_OK || used == 0 ||
                (delimiter ? used >= remaining.len || remaining.data[used] != delimiter
                           : used != remaining.len))
                return error_at(error, all, "at= needs two windows [s], as in at=0:2,5:7");
            used += delimiter != '\0';
            remaining = text_after(remaining, used);
        }
        if (!recording)
            return error_at(error, all, "there is no recording to calibrate from");
        if (!take_reading(session, recording, edge[0], edge[1], &raw[i], error))
            return false;
    }
    return calibrate_from_readings(session, raw, truth, unit, reply, error);
}

/* Begins a calibration from two true values, truth [i] in unit [i]: from windows of a recording if
 * `rest` is at=..., else by asking the user to hold the sensor's object at the first point. Returns
 * false with an error, such as if both values are the same or nothing is being collected. */
static bool begin_calibration(struct session *session, struct text rest, const double truth[2],
                              const struct unit *const unit[2], struct reply *reply,
                              struct error *error)
{
    struct collecting *now = session_collecting(session);
    const struct text key = TEXT("at=");
    if (truth[0] == truth[1])
        return error_set(error, ERROR_COMMAND,
                         "two different points are needed, but both are the same");
    if (text_starts(rest, key))
        return calibrate_from_windows(session, text_trim(text_after(rest, key.len)), truth, unit,
                                      reply, error);
    if (!now) {
        error_set(error, ERROR_COMMAND, "nothing is being collected");
        return error_hint(error, "give the times of both positions in the current recording, "
                                 "at=0:2,5:7; or READ1 TRUE1 READ2 TRUE2");
    }
    now->aim.waits = true;
    now->aim.taken = 0;
    for (int i = 0; i < 2; i++) {
        now->aim.truth[i] = truth[i];
        now->aim.truth_unit[i] = unit[i];
    }
    reply_line(reply, "hold it at %s, then type: calibrate take",
               with_unit(truth[0], unit[0]).text);
    return true;
}

/* Calibrates the value (from two or four numbers), takes the next point, removes the calibration,
 * or shows it. */
HANDLER(calibrate)
{
    const struct argument_value *name = argument_value(args, "NAME"),
                                *points = argument_value(args, "POINTS");
    const struct unit *unit[4];
    double value[4];
    if (has_argument(args, "off")) {
        struct calibration none;
        memset(&none, 0, sizeof none);
        none.decided = true;
        calibration_keep(session, &none, reply);
        return true;
    }
    if (has_argument(args, "take"))
        return take_next_point(session, reply, error);
    if (!name->count) {
        calibration_reply(&session->setup.calibration, reply);
        return true;
    }
    const struct recording *recording = session_recording(session);
    if (!text_is(name->item->text, "y") &&
        !(recording && text_is(name->item->text, recording->column[recording->value].name)))
        return error_at(error, name->where,
                        "only the value can be calibrated: calibrate y 20 cm 40 cm");
    struct text rest = points->count ? points->item->text : TEXT("");
    const int n = calibration_values(&rest, value, unit, 4);
    if (n == 2)
        return begin_calibration(session, rest, value, unit, reply, error);
    if (n != 4 || rest.len > 0) {
        error_at(error, points->count ? points->where : name->where,
                 "'calibrate' needs two true values, or READ1 TRUE1 READ2 TRUE2");
        return error_hint(error, "calibrate y 20 cm 40 cm; calibrate y 19.6 cm 20 cm 39.1 cm 40 "
                                 "cm");
    }
    struct calibration c;
    if (!calibration_make(value, unit, &c, error))
        return false;
    calibration_keep(session, &c, reply);
    return true;
}

/* Makes the mean of the last second (whole periods if the period is known) the zero of the value.
 */
HANDLER(zero)
{
    UNUSED(args);
    const struct recording *recording =
        session_collecting(session) ? growing_recording(session) : session_recording(session);
    struct raw raw;
    if (!recording) {
        error_set(error, ERROR_COMMAND, "there are no data for a zero");
        return error_hint(error, "collect SOURCE for=2s; zero; collect again");
    }
    const double end = recording->t[recording->rows - 1],
                 period = session_collecting(session) ? session_collecting(session)->period : NAN;
    const double last =
        period > 0 ? fmax(1, floor(READING_SECONDS / period)) * period : READING_SECONDS;
    if (!take_reading(session, recording, end - last, end, &raw, error))
        return false;
    struct calibration c =
        session->setup.calibration.known ? session->setup.calibration : recording->calibration;
    const double mean = rounded_mean(&raw);
    if (!c.known) {
        const double value[4] = {mean, 0, mean + 1, 1};
        const struct unit *const unit[4] = {raw.unit, raw.unit, raw.unit, raw.unit};
        if (!calibration_make(value, unit, &c, error))
            return false;
    } else {
        const double truth = c.truth[0] + (mean - c.read[0]) * calibration_gain(&c);
        c.truth[0] -= truth;
        c.truth[1] -= truth;
    }
    c.decided = true;
    reply_line(reply, "the zero is now at the reading %s (mean of the last %.3g s, scatter %.2g)",
               with_unit(mean, raw.unit).text, last, raw.scatter);
    calibration_keep(session, &c, reply);
    return true;
}
#endif

COMMAND(calibrate, .group = "DATA", .flags = COMMAND_CHANGES | COMMAND_BESIDE,
        ARGUMENTS(WORD("off", TYPE_NONE, .group = 1), WORD("take", TYPE_NONE, .group = 1),
                  PLACE("NAME", TYPE_TEXT, .group = 1), PLACE("POINTS", TYPE_REST)))

COMMAND(zero, .group = "DATA", .flags = COMMAND_CHANGES | COMMAND_BESIDE)
