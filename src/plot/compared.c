/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Compares a recording with a run: which derivative of the run the recording holds, and how far
 * they differ. */
#include <hooke/run.h>
#include <hooke/data.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/plot/curves.h>

#include <hooke/plot.h>
#include <hooke/session/series_tools.h>

#include <math.h>

/* An offset below this fraction of the recording's unit is rounding. */
#define OFFSET_ROUNDING 1e-9

bool quantity_is_scaled(enum quantity quantity)
{
    return quantity == QUANTITY_VOLTAGE || quantity == QUANTITY_FORCE;
}

bool recorded_bare(const struct recording *recording)
{
    return recording->column[recording->value].quantity == QUANTITY_OTHER;
}

/* Appends that a recording has no unit, or an unknown one. */
void put_bare(const struct recording *recording, struct buffer *text)
{
    const struct column *value = &recording->column[recording->value];
    char unit[SAFE_NAME_SIZE];
    if (value->unit[0])
        buffer_format(text, "has the unknown unit '%s'", safe_name(text_of(value->unit), unit));
    else
        buffer_put(text, TEXT("has no unit"));
}

/* Returns the derivative of the position that a recording holds (0, 1, 2), by its quantity, or -1
 * if it cannot be compared with the run. Without a run (NULL) only the quantity decides. */
int recorded_derivative(const struct recording *recording, const struct run *run)
{
    const enum quantity quantity = recording->column[recording->value].quantity;
    if (!run)
        return quantity_order(quantity) > 0 ? quantity_order(quantity) : 0;
    const struct system *system = &run->system;
    if (quantity == system_variable(system, 0).quantity || recorded_bare(recording))
        return 0;
    if (system->order != 2)
        return -1;
    if (quantity_is_scaled(quantity))
        return 0;
    if (quantity == system_variable(system, system->n / 2).quantity)
        return 1;
    return quantity == model_quantity(system->model, observable_named("a")) ? 2 : -1;
}

/* Returns the name and the quantity of a derivative of a run's first coordinate. */
struct variable run_derivative(const struct run *run, int derivative)
{
    if (derivative < 2)
        return system_variable(&run->system, derivative * run->system.n / 2);
    return (struct variable){.name = "a",
                             .quantity = model_quantity(run->system.model, observable_named("a"))};
}

struct data_distance run_data_distance(const struct run *run, struct recording *recording)
{
    struct data_distance distance = {.rms = NAN, .gain = 1, .offset = NAN};
    if (recording)
        series_tools()->distance(run, recording, &distance);
    return distance;
}

/* Appends how a voltage or force corresponds to the run: "1 V = 2.31 cm, 0 V at y = 1.2 cm". */
void put_scale(const struct data_distance *data, const struct run *run, struct buffer *text)
{
    const struct variable first = system_variable(&run->system, 0);
    const char *unit = quantity_unit(data->quantity);
    buffer_format(text, "1 %s = ", unit);
    buffer_quantity(text, data->gain, first.quantity, 4);
    buffer_format(text, ", 0 %s at %s = ", unit, first.name);
    const bool rounding = fabs(data->at_zero) < OFFSET_ROUNDING * fabs(data->gain);
    buffer_quantity(text, rounding ? 0 : data->at_zero, first.quantity, 4);
}
