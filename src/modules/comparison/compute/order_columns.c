/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Columns of a measured order and of the points of its sweep, for programs and people. */
#include <hooke/base/catalog.h>
#include "modules/comparison/compute/compare.h"

#include <math.h>

const char *contender_drag(const struct method_choice *choice)
{
    return choice->drag == DRAG_DEFAULT
               ? NULL
               : catalog_row(&drag_catalog, (size_t)choice->drag - 1)->name;
}

/* ---- the whole ---- */

static void order_cell(struct text_table *table, double order)
{
    cell_format(table, isfinite(order) ? "%.3f" : "-", order);
}

#define AT(member) .offset = offsetof(struct order, member)

/* Returns the points of a struct order, for its column "sweep". */
static const void *list_points(const void *row, size_t *count)
{
    *count = (size_t)((const struct order *)row)->points;
    return ((const struct order *)row)->point;
}

static const struct result_column of_order[] = {
    {.name = "method", .kind = COLUMN_ROW, AT(choice.method), .index = 1, .heading = "method"},
    {.name = "drag",
     .kind = COLUMN_CHOICE,
     AT(choice.drag),
     .choices = &drag_catalog,
     .choice_first = DRAG_EXACT},
    {.name = "order_claimed", .kind = COLUMN_INT, AT(claimed), .index = 2, .heading = "claimed"},
    {.name = "order_measured", AT(slope), .index = 3, .heading = "measured", .look = order_cell},
    {.name = "guard", AT(guard), .index = 4, .heading = "+-", .digits = 2},
    {.name = "r2", AT(r2)},
    {.name = "points", .kind = COLUMN_INT, AT(fitted), .index = 5, .heading = "points"},
    {.name = "verdict",
     .kind = COLUMN_CHOICE,
     AT(verdict),
     .choices = &order_verdict_catalog,
     .index = 6,
     .heading = ""},
    {.name = "floor", AT(floor)},
    {.name = "reference_kept", .kind = COLUMN_BOOL, AT(reference_stored)},
    {.name = "note", .kind = COLUMN_CHARS, AT(words)},
    {.name = "sweep", .kind = COLUMN_LIST, .part = &order_point_columns, .list = list_points},
};

const struct result_columns order_columns = RESULT_COLUMNS(of_order, struct order);

/* ---- a point ---- */

/* Returns the word of the column "status": "refused" or why the solve ended. */
static const char *status_of(const void *row)
{
    const struct order_point *point = row;
    return point->refused ? "refused" : stop_name(point->stop);
}

/* Writes why a point has no error, or * if the line is fitted to it. */
static void state_cell(struct text_table *table, const void *row)
{
    const struct order_point *point = row;
    if (point->refused)
        cell_text(table, "refused");
    else if (point->stop == STOP_FULL)
        cell_text(table, "out of budget");
    else if (isnan(point->error))
        cell_text(table, stop_name(point->stop));
    else
        cell_text(table, point->fitted ? "*" : "");
}

#define IN(member) .offset = offsetof(struct order_point, member)

/* clang-format off */
#define POINT_COLUMNS \
    {.name = "dt", IN(dt), .quantity = QUANTITY_TIME, .index = 1, .heading = "dt", .digits = 4}, \
    {.name = "steps", .kind = COLUMN_COUNT, IN(steps), .index = 2, .heading = "steps"}, \
    {.name = "turning_steps", .kind = COLUMN_COUNT, IN(turns)}, \
    {.name = "error", IN(error), .index = 3, .heading = "error", .look = cell_error}, \
    {.name = "slope", IN(slope), .index = 4, .heading = "slope", .digits = 4}, \
    {.name = "fitted", .kind = COLUMN_BOOL, IN(fitted)}, \
    {.name = "status", .kind = COLUMN_NAME, .text = status_of, \
     .index = 5, .heading = "", .cell = state_cell}

static const struct result_column of_point[] = {POINT_COLUMNS};

#define ROW(member) .offset = offsetof(struct order_row, member)

static const struct result_column of_row[] = {
    {.name = "method", .kind = COLUMN_ROW, ROW(method)},
    POINT_COLUMNS,
    {.name = "order", ROW(order)},
    {.name = "line", ROW(line)},
};
/* clang-format on */

const struct result_columns order_point_columns = RESULT_COLUMNS(of_point, struct order_point);
const struct result_columns order_row_columns = RESULT_COLUMNS(of_row, struct order_row);

/* Fills in a row for each point and returns their number. */
size_t order_rows(const struct order *order, struct order_row *rows)
{
    double dt = 0, error = 0; /* means of the logarithms of what the line is fitted to */
    for (int i = 0; i < order->points; i++)
        if (order->point[i].fitted) {
            dt += log(order->point[i].dt) / order->fitted;
            error += log(order->point[i].error) / order->fitted;
        }
    for (int i = 0; i < order->points; i++) {
        const struct order_point *point = &order->point[i];
        rows[i] = (struct order_row){
            .point = *point,
            .method = order->choice.method,
            .order = order->slope,
            .line = point->fitted ? exp(error + order->slope * (log(point->dt) - dt)) : NAN};
    }
    return (size_t)order->points;
}
