/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a measured order says, and each point of its sweep: to programs, to people. */
#include <hooke/study.h>

#include <math.h>

const char *contender_drag(const struct method_choice *by)
{
    return by->drag == DRAG_DEFAULT ? NULL : catalog_row(&drag_catalog, (size_t)by->drag - 1)->name;
}

/* ---- the whole ---- */

static const char *method_of(const void *row)
{
    return ((const struct order *)row)->by.method->row.name;
}

static const char *drag_of(const void *row)
{
    return contender_drag(&((const struct order *)row)->by);
}

static const char *verdict_of(const void *row)
{
    return catalog_row(&order_verdict_catalog, ((const struct order *)row)->verdict)->name;
}

#define AT(member) .at = offsetof(struct order, member)

static const struct result_column of_order[] = {
    {.name = "method", .kind = COLUMN_NAME, .text = method_of},
    {.name = "drag", .kind = COLUMN_NAME, .text = drag_of},
    {.name = "order_claimed", .kind = COLUMN_INT, AT(claimed)},
    {.name = "order_measured", AT(slope)},
    {.name = "guard", AT(guard)},
    {.name = "r2", AT(r2)},
    {.name = "points", .kind = COLUMN_INT, AT(fitted)},
    {.name = "verdict", .kind = COLUMN_NAME, .text = verdict_of},
    {.name = "floor", AT(floor)},
    {.name = "reference_kept", .kind = COLUMN_BOOL, AT(reference_stored)},
    {.name = "note", .kind = COLUMN_CHARS, AT(words)},
};

const struct result_columns order_columns = RESULT_COLUMNS(of_order, struct order);

/* ---- a point ---- */

static const char *status_of(const void *row)
{
    const struct order_point *point = row;
    return point->refused ? "refused" : stop_name(point->stop);
}

static void state_cell(struct text_table *table, const void *row)
{
    const struct order_point *point = row;
    cell_text(table, point->refused             ? "refused"
                     : point->stop == STOP_FULL ? "out of budget"
                     : isnan(point->error)      ? stop_name(point->stop)
                     : point->fitted            ? "*"
                                                : "");
}

#define IN(member) .at = offsetof(struct order_point, member)

/* clang-format off */
static const struct result_column of_point[] = {
    {.name = "dt", IN(dt), .quantity = QUANTITY_TIME, .index = 1, .heading = "dt", .digits = 4},
    {.name = "steps", .kind = COLUMN_COUNT, IN(steps), .index = 2, .heading = "steps"},
    {.name = "turning_steps", .kind = COLUMN_COUNT, IN(turns)},
    {.name = "error", IN(error), .index = 3, .heading = "error", .look = cell_error},
    {.name = "slope", IN(slope), .index = 4, .heading = "slope", .digits = 4},
    {.name = "fitted", .kind = COLUMN_BOOL, IN(fitted)},
    {.name = "status", .kind = COLUMN_NAME, .text = status_of,
     .index = 5, .heading = "", .cell = state_cell},
};
/* clang-format on */

const struct result_columns order_point_columns = RESULT_COLUMNS(of_point, struct order_point);
