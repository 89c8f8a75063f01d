/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Columns of the table of `compare`, for programs, files and people, and the functions that fill in
 * its rows. */
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include "modules/comparison/compute/compare.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* Fills in a row from a finished comparison. */
void compared_init(struct compared_row *row, const struct comparison *comparison)
{
    const struct run *run = comparison->run;
    *row = (struct compared_row){.comparison = *comparison,
                                 .method = run->method,
                                 .dt = NAN,
                                 .tol = NAN,
                                 .steps = run->steps,
                                 .cost = run->cost,
                                 .stop = run->stop,
                                 .number = run->number,
                                 .period = {NAN, NAN},
                                 .data_rms = NAN,
                                 .balanced = run->plan.ledger};
    if (run->plan.adaptive)
        row->tol = run->settings.tol;
    else
        row->dt = run->settings.dt;
    row->comparison.run = NULL;
}

/* Makes the row of a method that was not run because it would take `seconds` [s]. */
void compared_too_long(struct compared_row *row, const struct method_choice *choice, double dt,
                       double steps, double seconds)
{
    *row = (struct compared_row){
        .comparison = {.errors = {.end = NAN, .max = NAN, .phase = NAN},
                       .ledger = {.error_max = NAN},
                       .order = NAN,
                       .energy_factor = NAN,
                       .predicted_factor = NAN,
                       .time = {.minimum = NAN, .median = NAN, .spread = NAN}},
        .method = choice->method,
        .dt = dt,
        .tol = NAN,
        .steps = (int64_t)fmin(steps, 9e18),
        .period = {NAN, NAN},
        .data_rms = NAN,
        .too_long = true};
    snprintf(row->comparison.verdict, sizeof row->comparison.verdict,
             "not run: its %.3g steps would take about %.2g s; --force runs it anyway", steps,
             seconds);
}

/* Returns a row of the table as what it is. */
static const struct compared_row *compared(const void *row)
{
    return row;
}

/* ---- values ---- */

static double step_ns(const void *row)
{
    return timing_step_ns(&compared(row)->comparison.time, compared(row)->steps);
}

/* An error this large, in amplitudes, is not a lag of phase: the run has grown. */
static const double grown_error = 10;
/* A swing that shrinks is mostly gone at this error. */
static const double shrunk_error = 0.5;

/* Returns what became of the run in one word: "ok", the reason why it stopped, or how its motion is
 * wrong. */
static const char *comparison_status(const void *row_data)
{
    const struct compared_row *row = compared(row_data);
    if (row->too_long)
        return "too-long";
    if (row->stop != STOP_END)
        return stop_name(row->stop);
    if (row->comparison.grows || row->comparison.errors.max >= grown_error)
        return "unstable";
    if (row->comparison.shrinks && row->comparison.errors.max >= shrunk_error)
        return "damped";
    return row->comparison.errors.max >= 1 ? "lost" : stop_name(STOP_END);
}

static bool is_not_ok(const void *row)
{
    return strcmp(comparison_status(row), stop_name(STOP_END)) != 0;
}

static enum quantity data_quantity(const void *row)
{
    return compared(row)->data_quantity;
}

static bool has_data(const void *row)
{
    return compared(row)->data_heading[0] != '\0';
}

static bool comparison_is_timed(const void *row)
{
    return isfinite(compared(row)->comparison.time.minimum);
}

/* ---- for people ---- */

/* Writes the step or tolerance, as in "10 ms" or "tol 1e-06". */
void compared_setting(const struct compared_row *row, struct buffer *text)
{
    if (isfinite(row->tol))
        buffer_format(text, "tol %.3g", row->tol);
    else
        buffer_quantity(text, row->dt, QUANTITY_TIME, 4);
}

static void setting_cell(struct text_table *table, const void *row)
{
    struct buffer text = {0};
    compared_setting(row, &text);
    cell_take(table, &text);
}

static void energy_cell(struct text_table *table, const void *row)
{
    const double error = compared(row)->comparison.ledger.error_max;
    cell_quantity(table, stop_is_failure(compared(row)->stop) ? NAN : error, QUANTITY_NUMBER, 3);
}

/* Returns the heading: the energy balance is shown where drag or a drive changes the energy. */
static const char *energy_head(const void *first)
{
    return compared(first)->balanced ? "balance" : "|dE/E0|";
}

static const char *data_head(const void *first)
{
    return compared(first)->data_heading;
}

static void period_cell(struct text_table *table, const void *row)
{
    const struct measured period = compared(row)->period;
    cell_text(table, isfinite(period.value) ? SHOWN_MEASURED(period, QUANTITY_TIME, 6) : "-");
}

static void angle_cell(struct text_table *table, double radians)
{
    struct buffer text = {0};
    buffer_phase(&text, radians);
    cell_take(table, &text);
}

/* Writes the time per step, with (!) if the row ran general code and other rows specialised
 * code. */
static void step_time_cell(struct text_table *table, const void *row)
{
    const bool marked = compared(row)->mixed && compared(row)->comparison.path == KERNEL_GENERAL;
    const double ns = step_ns(row);
    const char *mark = marked ? " (!)" : "";
    if (isnan(ns))
        cell_text(table, "-");
    else
        cell_format(table, ns < 1000 ? "%.3g%s" : "%.0f%s", ns, mark);
}

/* ---- the columns ---- */

#define AT(member) .offset = offsetof(struct compared_row, member)

/* clang-format off */
static const struct result_column columns[] = {
    {.name = "method", .kind = COLUMN_ROW, AT(method), .index = 1, .heading = "method"},
    {.name = "dt", AT(dt), .quantity = QUANTITY_TIME,
     .index = 2, .heading = "dt", .cell = setting_cell},
    {.name = "tol", AT(tol)},
    {.name = "steps", .kind = COLUMN_COUNT, AT(steps), .index = 3, .heading = "steps"},
    {.name = "evals", .kind = COLUMN_COUNT, AT(cost.evals)},
    {.name = "turning_steps", .kind = COLUMN_COUNT, AT(cost.turns)},
    {.name = "error", AT(comparison.errors.max), .index = 5, .rank = 1, .heading = "max error"},
    {.name = "energy_error", AT(comparison.ledger.error_max), .index = 4, .head = energy_head,
     .cell = energy_cell, .flags = COLUMN_IF_ANY},
    {.name = "energy_factor", AT(comparison.energy_factor), .flags = COLUMN_DETAIL},
    {.name = "predicted_factor", AT(comparison.predicted_factor), .flags = COLUMN_DETAIL},
    {.name = "order", AT(comparison.order)},
    {.name = "phase_error", AT(comparison.errors.phase), .quantity = QUANTITY_ANGLE,
     .index = 9, .heading = "phase err", .look = angle_cell, .flags = COLUMN_IF_ANY},
    {.name = "period", AT(period.value), .quantity = QUANTITY_TIME, .index = 8,
     .rank = 3, .heading = "period T", .cell = period_cell, .flags = COLUMN_IF_ANY | COLUMN_NO_RECORD},
    {.name = "period_uncertainty", AT(period.uncertainty), .quantity = QUANTITY_TIME,
     .flags = COLUMN_NO_RECORD | COLUMN_DETAIL},
    {.name = "data_rms", AT(data_rms), .quantity_of = data_quantity, .index = 7,
     .head = data_head, .flags = COLUMN_IF_ANY | COLUMN_NO_RECORD, .any = has_data},
    {.name = "time_min", AT(comparison.time.minimum), .quantity = QUANTITY_TIME,
     .index = 10, .rank = 1, .heading = "time", .look = cell_seconds},
    {.name = "time_median", AT(comparison.time.median), .quantity = QUANTITY_TIME, .flags = COLUMN_DETAIL},
    {.name = "ns_per_step", .real = step_ns, .index = 11, .heading = "ns/step",
     .cell = step_time_cell, .flags = COLUMN_IF_ANY | COLUMN_WIDE | COLUMN_DETAIL, .any = comparison_is_timed},
    {.name = "path", .kind = COLUMN_CHOICE, AT(comparison.path), .choices = &kernel_catalog, .flags = COLUMN_DETAIL},
    {.name = "status", .kind = COLUMN_NAME, .text = comparison_status, .index = 6, .rank = 1,
     .heading = "status", .flags = COLUMN_IF_ANY, .any = is_not_ok},
    {.name = "reference_kept", .kind = COLUMN_BOOL, AT(comparison.reference_stored),
     .flags = COLUMN_NO_FILE},
    {.name = "verdict", .kind = COLUMN_CHARS, AT(comparison.verdict), .flags = COLUMN_NO_FILE},
    {.name = "run", .kind = COLUMN_INT, AT(number), .flags = COLUMN_DETAIL},
};
/* clang-format on */

const struct result_columns compared_columns = {columns, COUNT_OF(columns),
                                                sizeof(struct compared_row), .digits = 6};
