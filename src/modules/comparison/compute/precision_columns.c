/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Columns of the table of a precision study, one row per point, for programs, files and people. */
#include <hooke/base/unit.h>
#include "modules/comparison/compute/compare.h"

#include <math.h>

/* Makes a row for each point, in the arena. */
const struct precision_row *precision_rows(const struct precision *precision, struct arena *arena)
{
    struct precision_row *row = arena_array(arena, (size_t)precision->points + 1, sizeof *row);
    for (int i = 0; row && i < precision->points; i++) {
        const struct precision_point *point = &precision->point[i];
        row[i] = (struct precision_row){.point = *point,
                                        .curve = precision->curve[point->curve],
                                        .accuracy = precision->reference.accuracy,
                                        .stored = precision->reference.stored,
                                        .resolved = !precision->reference.dissenting_method[0],
                                        .precision = precision};
    }
    return row;
}

/* Returns the point of a row. */
static const struct precision_point *point_of(const void *row)
{
    return &((const struct precision_row *)row)->point;
}

/* ---- values ---- */

/* Returns the step of a row [s], or NAN for an adaptive solve. */
static double dt_of(const void *row)
{
    return point_of(row)->tol > 0 ? NAN : point_of(row)->dt;
}

/* Returns the tolerance of a row, or NAN for fixed steps. */
static double tol_of(const void *row)
{
    return point_of(row)->tol > 0 ? point_of(row)->tol : NAN;
}

static double step_ns(const void *row)
{
    return timing_step_ns(&point_of(row)->time, point_of(row)->steps);
}

/* Returns why a point has no meaningful error, or "" if it has one. */
const char *precision_failure(const struct precision *precision,
                              const struct precision_point *point)
{
    if (point->refused)
        return "refused";
    if (point->stop == STOP_FULL)
        return "too long";
    if (point->stop != STOP_END)
        return stop_name(point->stop);
    if (precision_meaningful(point))
        return "";
    return precision->reference.dissenting_method[0] ? "apart" : "lost";
}

/* Returns why the point has no meaningful error, or "". */
static const char *failure_of(const void *row)
{
    return precision_failure(((const struct precision_row *)row)->precision, point_of(row));
}

/* Returns the word of the column "status": the failure, spelled without a blank, or "ok". */
static const char *status_of(const void *row)
{
    if (point_of(row)->stop == STOP_FULL && !point_of(row)->refused)
        return "too-long";
    return *failure_of(row) ? failure_of(row) : stop_name(STOP_END);
}

/* Returns the number of evaluations predicted for the point's error, or NAN for adaptive or failed
 * points and for scenes without a prediction. */
static double predicted_of(const void *row)
{
    const struct precision_point *point = point_of(row);
    const bool fixed = point->tol == 0 && precision_meaningful(point);
    return fixed ? precision_predict(((const struct precision_row *)row)->precision, point->curve,
                                     point->errors.max)
                 : NAN;
}

static bool has_phase(const void *row)
{
    return isfinite(point_of(row)->errors.phase);
}

static bool point_is_timed(const void *row)
{
    return isfinite(point_of(row)->time.minimum);
}

/* ---- for people ---- */

/* Returns the heading of the column of steps or tolerances. */
static const char *setting_head(const void *first)
{
    return ((const struct precision_row *)first)->curve.adaptive ? "tol" : "dt";
}

static const char *order_head(const void *first)
{
    return ((const struct precision_row *)first)->curve.adaptive ? "slope" : "order";
}

/* Writes the tolerance, or the step with its unit. */
static void setting_cell(struct text_table *table, const void *row)
{
    const struct precision_point *point = point_of(row);
    if (point->tol > 0)
        cell_format(table, "%.3g", point->tol);
    else
        cell_seconds(table, point->dt);
}

static void order_cell(struct text_table *table, double order)
{
    cell_format(table, isfinite(order) ? "%.2f" : "-", order);
}

static void predicted_cell(struct text_table *table, double evals)
{
    cell_format(table, isfinite(evals) ? "%.0f" : "-", evals);
}

static void step_time_cell(struct text_table *table, double ns)
{
    if (isnan(ns))
        cell_text(table, "-");
    else
        cell_format(table, ns < 1000 ? "%.3g" : "%.0f", ns);
}

/* Returns the mark if it applies, otherwise no text. */
static const char *mark_if(bool applies, const char *mark)
{
    return applies ? mark : "";
}

/* Writes the failure and the marks that put_marks() in precision.c explains below the tables. */
static void marks_cell(struct text_table *table, const void *row)
{
    const struct precision_point *point = point_of(row);
    const bool is_noisy = point->time.spread > TIMING_SPREAD || point->time.others > TIMING_OTHERS;
    cell_format(table, "%s%s%s%s%s%s%s", failure_of(row), mark_if(point->asymptotic, "*"),
                mark_if(point->is_below_reference, "<"), mark_if(is_noisy, "~"),
                mark_if(point->time.few, "!"), mark_if(point->timed_steps > 0, "+"),
                mark_if(point->probed, " probe"));
}

/* ---- the columns ---- */

#define AT(member) .offset = offsetof(struct precision_row, member)
#define COUNTED(member) .kind = COLUMN_COUNT, AT(point.cost.member)

/* clang-format off */
static const struct result_column columns[] = {
    {.name = "method", .kind = COLUMN_ROW, AT(curve.choice.method)},
    {.name = "dt", .real = dt_of, .quantity = QUANTITY_TIME,
     .index = 1, .head = setting_head, .cell = setting_cell},
    {.name = "tol", .real = tol_of},
    {.name = "steps", .kind = COLUMN_COUNT, AT(point.steps), .index = 2, .heading = "steps"},
    {.name = "evals", COUNTED(evals), .index = 3, .heading = "evals"},
    {.name = "jacobians", COUNTED(jacobians), .index = 4, .heading = "jac", .flags = COLUMN_IF_ANY},
    {.name = "solves", COUNTED(solves), .index = 5, .heading = "solves", .flags = COLUMN_IF_ANY},
    {.name = "rejected", COUNTED(rejected), .index = 6, .heading = "rej", .flags = COLUMN_IF_ANY},
    {.name = "error", AT(point.errors.max), .index = 7, .heading = "error", .look = cell_error},
    {.name = "error_end", AT(point.errors.end), .index = 8, .heading = "at end", .look = cell_error,
     .flags = COLUMN_WIDE | COLUMN_DETAIL},
    {.name = "energy_error", AT(point.errors.energy), .index = 9, .heading = "energy",
     .look = cell_error, .flags = COLUMN_IF_ANY | COLUMN_DETAIL},
    {.name = "phase_error", AT(point.errors.phase), .quantity = QUANTITY_ANGLE,
     .index = 10, .heading = "phase", .look = cell_error, .flags = COLUMN_IF_ANY | COLUMN_WIDE | COLUMN_DETAIL},
    {.name = "amplitude_error", AT(point.errors.amplitude), .index = 11, .heading = "ampl.",
     .look = cell_error, .flags = COLUMN_IF_ANY | COLUMN_WIDE | COLUMN_DETAIL, .any = has_phase},
    {.name = "order", AT(point.order), .index = 12, .head = order_head, .look = order_cell},
    {.name = "time_min", AT(point.time.minimum), .quantity = QUANTITY_TIME,
     .index = 13, .heading = "time", .look = cell_seconds, .flags = COLUMN_IF_ANY},
    {.name = "time_median", AT(point.time.median), .quantity = QUANTITY_TIME,
     .index = 14, .heading = "median", .look = cell_seconds, .flags = COLUMN_IF_ANY | COLUMN_WIDE | COLUMN_DETAIL,
     .any = point_is_timed},
    {.name = "ns_per_step", .real = step_ns, .index = 15, .heading = "ns/step",
     .look = step_time_cell, .flags = COLUMN_IF_ANY, .any = point_is_timed},
    {.name = "path", .kind = COLUMN_CHOICE, AT(point.path), .choices = &kernel_catalog,
     .flags = COLUMN_DETAIL},
    {.name = "time_spread", AT(point.time.spread), .flags = COLUMN_NO_FILE},
    {.name = "samples", .kind = COLUMN_INT, AT(point.time.samples), .flags = COLUMN_NO_FILE},
    {.name = "time_recording", AT(point.recording), .index = 16, .heading = "recorded",
     .look = cell_seconds, .flags = COLUMN_IF_ANY | COLUMN_NO_FILE},
    {.name = "status", .kind = COLUMN_NAME, .text = status_of},
    {.name = "below_reference", .kind = COLUMN_BOOL, AT(point.is_below_reference), .flags = COLUMN_NO_FILE},
    {.name = "asymptotic", .kind = COLUMN_BOOL, AT(point.asymptotic), .flags = COLUMN_NO_FILE},
    {.name = "reference_accuracy", AT(accuracy), .flags = COLUMN_NO_FILE},
    {.name = "reference_kept", .kind = COLUMN_BOOL, AT(stored), .flags = COLUMN_NO_FILE},
    {.name = "reference_resolved", .kind = COLUMN_BOOL, AT(resolved), .flags = COLUMN_NO_FILE},
    {.name = "slope", AT(curve.slope), .flags = COLUMN_NO_FILE},
    {.name = "slope_expected", AT(curve.expected), .flags = COLUMN_NO_FILE},
    {.name = "slope_differs", .kind = COLUMN_BOOL, AT(curve.differs), .flags = COLUMN_NO_FILE},
    {.name = "evals_predicted", .real = predicted_of, .index = 17, .heading = "predicted",
     .look = predicted_cell, .flags = COLUMN_NO_FILE | COLUMN_IF_ANY},
    {.name = "marks", .kind = COLUMN_NAME, .text = status_of, .index = 18, .heading = "",
     .cell = marks_cell, .flags = COLUMN_NO_FILE | COLUMN_NO_RECORD},
};
/* clang-format on */

const struct result_columns precision_columns = {columns, COUNT_OF(columns),
                                                 sizeof(struct precision_row), .digits = 4};
