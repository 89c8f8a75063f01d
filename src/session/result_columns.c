/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Columns of runs and measurements: their names are the headings of tables and the keys in JSON. */
#include <hooke/run.h>
#include <hooke/result.h>
#include <hooke/base/unit.h>
#include <hooke/session.h>

#include <math.h>

/* ---- measurements ---- */

static const char *measurement_unit(const void *row)
{
    return quantity_unit(((const struct measurement *)row)->unit);
}

#define AT(member) .offset = offsetof(struct measurement, member)

/* The unit is a column of its own, because it differs between rows. */
static const struct result_column of_measurement[] = {
    {.name = "quantity", .kind = COLUMN_CHARS, AT(quantity)},
    {.name = "value", AT(value.value)},
    {.name = "uncertainty", AT(value.uncertainty)},
    {.name = "unit", .kind = COLUMN_NAME, .text = measurement_unit},
    {.name = "periods", AT(periods)},
    {.name = "of", .kind = COLUMN_CHARS, AT(source)},
};

const struct result_columns measurement_columns =
    RESULT_COLUMNS(of_measurement, struct measurement);

/* ---- runs ---- */

static const struct run *run_of(const void *row)
{
    return ((const struct run_row *)row)->run;
}

/* Returns the step of a run with fixed steps, else NAN. */
static double run_dt(const void *row)
{
    return run_of(row)->plan.adaptive ? NAN : run_of(row)->settings.dt;
}

/* Returns the tolerance of an adaptive run, else NAN. */
static double run_tol(const void *row)
{
    return run_of(row)->plan.adaptive ? run_of(row)->settings.tol : NAN;
}

static int64_t run_rows(const void *row)
{
    return (int64_t)trace_count(run_of(row)->trace);
}

/* Returns the largest energy error of the run, relative to E0. */
static double run_energy_error(const void *row)
{
    struct ledger ledger;
    run_ledger(run_of(row), &ledger);
    return ledger.error_max;
}

/* Returns the largest error of the run against its exact solution. */
static double run_error(const void *row)
{
    struct run_errors errors;
    run_errors(run_of(row), &errors);
    return errors.max;
}

static const char *row_status(const void *row)
{
    return run_status(run_of(row));
}

#define IN_RUN(member)                                                                             \
    .pointer_offset = COLUMN_IN(struct run_row, run), .offset = offsetof(struct run, member)

/* Records have the method before the numbers, files after them. */
static const struct result_column of_run[] = {
    {.name = "run", .kind = COLUMN_INT, IN_RUN(number)},
    {.name = "name", .kind = COLUMN_CHARS, IN_RUN(name), .flags = COLUMN_NO_FILE},
    {.name = "scene", .kind = COLUMN_ROW, IN_RUN(scene.preset), .flags = COLUMN_NO_FILE},
    {.name = "method", .kind = COLUMN_ROW, IN_RUN(method), .flags = COLUMN_NO_FILE},
    {.name = "dt", .real = run_dt, .quantity = QUANTITY_TIME},
    {.name = "tol", .real = run_tol},
    {.name = "steps", .kind = COLUMN_COUNT, IN_RUN(steps)},
    {.name = "t", IN_RUN(t), .quantity = QUANTITY_TIME},
    {.name = "energy_error", .real = run_energy_error, .flags = COLUMN_NO_RECORD},
    {.name = "error", .real = run_error, .flags = COLUMN_NO_RECORD},
    {.name = "method", .kind = COLUMN_ROW, IN_RUN(method), .flags = COLUMN_NO_RECORD},
    {.name = "rows", .kind = COLUMN_COUNT, .number = run_rows, .flags = COLUMN_NO_FILE},
    {.name = "status", .kind = COLUMN_NAME, .text = row_status},
    {.name = "current",
     .kind = COLUMN_BOOL,
     .offset = offsetof(struct run_row, current),
     .flags = COLUMN_NO_FILE},
    {.name = "note",
     .kind = COLUMN_NAME,
     .pointer_offset = COLUMN_IN(struct run_row, slot),
     .offset = offsetof(struct run_slot, note),
     .flags = COLUMN_NO_FILE},
};

const struct result_columns run_columns = RESULT_COLUMNS(of_run, struct run_row);
