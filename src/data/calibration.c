/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Calibrations of sensors: the straight line through two pairs of a reading and its true value. */
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/data.h>

#include <stdio.h>
#include <string.h>

/* Reads at most max numbers, each with a unit or none, off *rest. Returns how many. */
int calibration_values(struct text *rest, double *value, const struct unit **unit, int max)
{
    int n = 0;
    size_t used = 0;
    for (text_skip_blanks(rest);
         n < max && real_scan(*rest, '.', &value[n], &used) == REAL_OK && used > 0; n++) {
        *rest = (struct text){rest->data + used, rest->len - used};
        text_skip_blanks(rest);
        size_t len = 0;
        while (len < rest->len && rest->data[len] != ' ' && rest->data[len] != '\t')
            len++;
        unit[n] = unit_find((struct text){rest->data, len});
        *rest = unit[n] ? (struct text){rest->data + len, rest->len - len} : *rest;
        text_skip_blanks(rest);
    }
    return n;
}

/* Converts the second value to the unit of the first, whose name is written to name. A value
 * without a unit has that of the other. Returns false with the error set if the units are of
 * different quantities. */
static bool same_unit(const struct unit *const unit[2], double value[2], char name[16],
                      struct error *error)
{
    const struct unit *reference_unit = unit[0] ? unit[0] : unit[1];
    if (unit[0] && unit[1] && unit[0]->quantity != unit[1]->quantity)
        return error_set(error, ERROR_COMMAND, "%s and %s measure different quantities",
                         unit[0]->row.name, unit[1]->row.name);
    if (unit[1] && unit[1] != reference_unit)
        value[1] *= unit[1]->factor / reference_unit->factor;
    snprintf(name, sizeof((struct calibration *)0)->unit[0], "%s",
             reference_unit ? reference_unit->row.name : "");
    return true;
}

/* Makes the calibration of READ1 TRUE1 READ2 TRUE2. Returns false with the error set if units
 * differ in kind or both points are the same. */
bool calibration_make(const double value[4], const struct unit *const unit[4],
                      struct calibration *calibration, struct error *error)
{
    struct calibration made;
    memset(&made, 0, sizeof made); /* it is compared byte by byte */
    const struct unit *read[2] = {unit[0], unit[2]}, *truth[2] = {unit[1], unit[3]};
    made.decided = made.known = true;
    for (int i = 0; i < 2; i++) {
        made.read[i] = value[2 * i];
        made.truth[i] = value[2 * i + 1];
    }
    if (!same_unit(read, made.read, made.unit[0], error) ||
        !same_unit(truth, made.truth, made.unit[1], error))
        return false;
    if (made.read[0] == made.read[1] || made.truth[0] == made.truth[1])
        return error_set(error, ERROR_COMMAND,
                         "two different points are needed, but both are the same") ||
               error_hint(error, "calibrate y 19.6 cm 20 cm 39.1 cm 40 cm");
    *calibration = made;
    return true;
}

/* Appends READ1 TRUE1 READ2 TRUE2 with units, or off. */
void calibration_put(const struct calibration *calibration, struct buffer *text)
{
    if (!calibration->known) {
        buffer_put(text, TEXT("off"));
        return;
    }
    for (int i = 0; i < 4; i++) {
        const char *unit = calibration->unit[i % 2];
        buffer_put(text, i > 0 ? TEXT(" ") : TEXT(""));
        buffer_real(text, i % 2 ? calibration->truth[i / 2] : calibration->read[i / 2]);
        buffer_format(text, "%s%s", unit[0] ? " " : "", unit);
    }
}

/* Reads what calibration_put() wrote; other text clears the calibration. */
void calibration_take_line(struct text line, struct calibration *calibration)
{
    double value[4];
    const struct unit *unit[4];
    struct error ignored;
    if (calibration_values(&line, value, unit, 4) != 4 ||
        !calibration_make(value, unit, calibration, &ignored))
        memset(calibration, 0, sizeof *calibration);
}

double calibration_gain(const struct calibration *c)
{
    return (c->truth[1] - c->truth[0]) / (c->read[1] - c->read[0]);
}
