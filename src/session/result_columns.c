/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the runs and the measurements of a session say: to programs and to files. */
#include <hooke/run.h>
#include <hooke/result.h>
#include <hooke/base/unit.h>
#include <hooke/session.h>

#include <math.h>

/* ---- measurements ---- */

static const char *unit_of(const void *row)
{
    return quantity_unit(((const struct measurement *)row)->unit);
}

#define AT(member) .at = offsetof(struct measurement, member)

/* The unit is a column: rows differ in it. */
static const struct result_column of_measurement[] = {
    {.name = "quantity", .kind = COLUMN_CHARS, AT(quantity)},
    {.name = "value", AT(value.value)},
    {.name = "uncertainty", AT(value.uncertainty)},
    {.name = "unit", .kind = COLUMN_NAME, .text = unit_of},
    {.name = "periods", AT(periods)},
    {.name = "of", .kind = COLUMN_CHARS, AT(of)},
};

const struct result_columns measurement_columns =
    RESULT_COLUMNS(of_measurement, struct measurement);

/* ---- runs ---- */

static const struct run *run_of(const void *row)
{
    return ((const struct run_row *)row)->slot->run;
}

static int64_t run_number(const void *row)
{
    return run_of(row)->number;
}

static const char *run_name(const void *row)
{
    return run_of(row)->name[0] ? run_of(row)->name : NULL;
}

static const char *run_scene(const void *row)
{
    return run_of(row)->scene.preset->row.name;
}

static const char *run_method(const void *row)
{
    return run_of(row)->method->row.name;
}

static double run_dt(const void *row)
{
    return run_of(row)->plan.adaptive ? NAN : run_of(row)->settings.dt;
}

static double run_tol(const void *row)
{
    return run_of(row)->plan.adaptive ? run_of(row)->settings.tol : NAN;
}

static int64_t run_steps(const void *row)
{
    return run_of(row)->steps;
}

static double run_t(const void *row)
{
    return run_of(row)->t;
}

static int64_t run_rows(const void *row)
{
    return (int64_t)trace_count(run_of(row)->trace);
}

static double run_energy_error(const void *row)
{
    struct ledger ledger;
    run_ledger(run_of(row), &ledger);
    return ledger.error_max;
}

static double run_error(const void *row)
{
    struct run_errors errors;
    run_errors(run_of(row), &errors);
    return errors.max;
}

static const char *run_status(const void *row)
{
    return stop_name(run_of(row)->stop);
}

static const char *run_note(const void *row)
{
    return ((const struct run_row *)row)->slot->note;
}

#define NUMBER(function) .kind = COLUMN_COUNT, .number = function
#define NAME(function) .kind = COLUMN_NAME, .text = function

/* Records have the method before the numbers, files after them. */
static const struct result_column of_run[] = {
    {.name = "run", NUMBER(run_number)},
    {.name = "name", NAME(run_name), .flags = COLUMN_NO_FILE},
    {.name = "scene", NAME(run_scene), .flags = COLUMN_NO_FILE},
    {.name = "method", NAME(run_method), .flags = COLUMN_NO_FILE},
    {.name = "dt", .real = run_dt, .quantity = QUANTITY_TIME},
    {.name = "tol", .real = run_tol},
    {.name = "steps", NUMBER(run_steps)},
    {.name = "t", .real = run_t, .quantity = QUANTITY_TIME},
    {.name = "energy_error", .real = run_energy_error, .flags = COLUMN_NO_RECORD},
    {.name = "error", .real = run_error, .flags = COLUMN_NO_RECORD},
    {.name = "method", NAME(run_method), .flags = COLUMN_NO_RECORD},
    {.name = "rows", NUMBER(run_rows), .flags = COLUMN_NO_FILE},
    {.name = "status", NAME(run_status)},
    {.name = "current",
     .kind = COLUMN_BOOL,
     .at = offsetof(struct run_row, current),
     .flags = COLUMN_NO_FILE},
    {.name = "note", NAME(run_note), .flags = COLUMN_NO_FILE},
};

const struct result_columns run_columns = RESULT_COLUMNS(of_run, struct run_row);
