/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Applies a calibration to the values of a recording: a straight line from readings to true
 * values. */
#include <hooke/base/unit.h>
#include "modules/recording/table/table.h"

#include <stdio.h>

/* Returns the quantity of a unit, which may be NULL. */
static enum quantity quantity_of(const struct unit *unit)
{
    return unit ? unit->quantity : QUANTITY_OTHER;
}

/* Converts the values of a recording to the calibration's unit, then to true values, once. Returns
 * false with the error if their quantity is not that of the calibration. */
bool recording_calibrate(struct recording *recording, const struct calibration *calibration,
                         struct error *error)
{
    struct column *column = &recording->column[recording->value];
    const struct unit *source_unit = unit_find(text_of(calibration->unit[0])),
                      *target_unit = unit_find(text_of(calibration->unit[1]));
    if (!calibration->known || recording->calibration.known)
        return true;
    if (quantity_of(source_unit) != column->quantity) {
        static const char no_unit[] = "numbers without a unit";
        const char *source = source_unit ? source_unit->row.name : no_unit;
        error_set(error, ERROR_COMMAND, "%s was calibrated in %s but is now in %s", column->name,
                  source, column->unit[0] ? column->unit : no_unit);
        return error_hint(error,
                          "set its unit with unit=, or use it uncalibrated with 'calibrate off'");
    }
    const double gain = calibration_gain(calibration),
                 factor = source_unit ? column->factor / source_unit->factor : 1;
    for (size_t i = 0; i < recording->rows; i++)
        column->value[i] =
            calibration->truth[0] + (column->value[i] * factor - calibration->read[0]) * gain;
    snprintf(column->unit, sizeof column->unit, "%s", calibration->unit[1]);
    column->quantity = quantity_of(target_unit);
    column->factor = target_unit ? target_unit->factor : 1;
    recording->calibration = *calibration;
    return true;
}
