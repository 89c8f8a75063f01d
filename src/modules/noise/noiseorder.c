/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command noiseorder: measures strong and weak orders of the methods for the scene. */
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include "modules/noise/setup.h" /* also needed for the rows */

#ifndef COMMAND_ROWS
#include "modules/noise/compute/orders.h"

enum { ORDER_LEVELS = 5, ORDER_PATHS = 1000, ORDER_METHODS = 3 };

/* A row of the table: a method with one step. */
struct order_row {
    struct method_orders orders;
    struct order_level level;
};

/* Adds a cell with an order and its uncertainty. */
static void put_order(struct text_table *table, struct measured order)
{
    struct buffer text = {0};
    if (isnan(order.value))
        buffer_put(&text, TEXT("not known"));
    else
        buffer_uncertain(&text, order.value, order.uncertainty);
    cell_take(table, &text);
}

static void strong_cell(struct text_table *table, const void *row)
{
    put_order(table, ((const struct order_row *)row)->orders.strong);
}

static void weak_cell(struct text_table *table, const void *row)
{
    put_order(table, ((const struct order_row *)row)->orders.weak);
}

static double weak_at_last(const void *row)
{
    const struct method_orders *orders = &((const struct order_row *)row)->orders;
    return orders->level[orders->levels - 1].weak.value;
}

#define AT(member) .offset = offsetof(struct order_row, member)

/* clang-format off */
static const struct result_column of_order[] = {
    {.name = "method", .kind = COLUMN_ROW, AT(orders.method), .index = 1, .heading = "method"},
    {.name = "dt", .quantity = QUANTITY_TIME, AT(level.dt)},
    {.name = "strong", AT(level.strong.value), .index = 4, .heading = "strong at first", .look = cell_error},
    {.name = "strong_error", AT(level.strong.uncertainty)},
    {.name = "weak", AT(level.weak.value), .index = 5, .heading = "weak at first", .look = cell_error},
    {.name = "weak_error", AT(level.weak.uncertainty)},
    {.name = "strong_order", AT(orders.strong.value), .index = 2, .heading = "strong order", .cell = strong_cell},
    {.name = "strong_order_error", AT(orders.strong.uncertainty)},
    {.name = "weak_order", AT(orders.weak.value), .index = 3, .heading = "weak order", .cell = weak_cell},
    {.name = "weak_order_error", AT(orders.weak.uncertainty)},
    {.real = weak_at_last, .flags = COLUMN_NO_RECORD | COLUMN_NO_FILE,
     .index = 6, .heading = "weak at last", .look = cell_error},
};
/* clang-format on */

static const struct result_columns noiseorder_columns = RESULT_COLUMNS(of_order, struct order_row);

/* Sets method[] to the methods named by method=, or to all if none is named, without those that
 * need a velocity in scenes of first order. Returns their number, at most ORDER_METHODS. */
static int choose_methods(const struct arguments *args, const struct noise_setup *setup,
                          const struct noise_method *method[ORDER_METHODS])
{
    const struct argument_value *given = argument_value(args, "method");
    int count = 0;
    for (size_t i = 0; i < noise_method_catalog.count && count < ORDER_METHODS; i++) {
        bool wanted = given->count == 0;
        for (int k = 0; k < given->count; k++)
            wanted = wanted || given->item[k].index == (int)i;
        if (wanted && (setup->forcing.system.order == 2 || !noise_method_at(i)->needs_velocity))
            method[count++] = noise_method_at(i);
    }
    return count;
}

/* Replies with a line for each method, then a record for each of its step sizes, and stores the
 * table. */
static void reply_orders(const struct noise_setup *setup, const struct orders_request *request,
                         const struct method_orders *orders, int methods, struct arena *arena,
                         struct reply *reply)
{
    const int levels = request->levels;
    const size_t rows = (size_t)(methods * levels);
    struct order_row *row = arena_array(arena, rows, sizeof *row);
    struct text_table table = {.arena = arena, .gap = 3};
    /* columns of the first table of each method */
    struct result_columns first = noiseorder_columns;
    struct arena table_arena = {0};
    struct table file;
    bool unknown = false;
    if (!row)
        return;
    for (int i = 0; i < methods * levels; i++)
        row[i] = (struct order_row){orders[i / levels], orders[i / levels].level[i % levels]};
    struct buffer *text = reply_buffer(reply);
    buffer_format(text,
                  "each step compared with half of it on the same path; %lld paths and their "
                  "mirror images to t = %s,\ndt from %s down to %s; ",
                  (long long)request->paths,
                  SHOWN_QUANTITY(setup->forcing.system.t0 + request->span, QUANTITY_TIME, 4),
                  SHOWN_QUANTITY(row[0].level.dt, QUANTITY_TIME, 4),
                  SHOWN_QUANTITY(row[levels - 1].level.dt, QUANTITY_TIME, 4));
    noise_setup_put(setup, text);
    buffer_char(text, '\n');
    first.size *= (size_t)levels;
    columns_text(&first, row, (size_t)methods, true, &table);
    text_table_put(&table, text);
    for (int i = 0; i < methods; i++)
        unknown = unknown || isnan(orders[i].strong.value) || isnan(orders[i].weak.value);
    if (unknown)
        reply_line(reply,
                   "an order is not known if chance or rounding hides the differences, or if "
                   "their sign changes; increase paths=N, or choose another dt");
    reply_records(reply, "noiseorder", &noiseorder_columns, row, rows);
    if (columns_table(&noiseorder_columns, row, rows, &table_arena, &file))
        noise_keep_table(setup, 0, "noiseorder", NULL, &table_arena, &file, reply);
}

/* Reads the numbers of paths and levels. Returns false with *error if they are out of range. */
static bool read_request(const struct arguments *args, const struct noise_setup *setup,
                         struct orders_request *request, struct error *error)
{
    *request = (struct orders_request){.forcing = &setup->forcing,
                                       .span = setup->span,
                                       .dt = setup->dt,
                                       .levels = (int)noise_integer(args, "levels", ORDER_LEVELS),
                                       .paths = noise_integer(args, "paths", ORDER_PATHS),
                                       .seed = setup->seed};
    if (request->levels < 3 || request->levels > ORDER_LEVELS_MAX)
        return error_at(error, argument_value(args, "levels")->where, "levels=N must be 3 to %d",
                        ORDER_LEVELS_MAX);
    if (request->paths < 10 || request->paths >= UINT32_MAX)
        return error_at(error, argument_value(args, "paths")->where, "paths=N must be at least 10");
    return true;
}

/* Measures each method in turn, after its steps and its cost have been checked. */
HANDLER(noiseorder)
{
    const struct noise_setup *setup = noise_setup_read(session, args, error);
    struct orders_request request;
    const struct noise_method *method[ORDER_METHODS];
    if (!setup || !read_request(args, setup, &request, error))
        return false;
    const int methods = choose_methods(args, setup, method);
    if (methods == 0)
        return error_set(error, ERROR_COMMAND, "baoab needs velocities, but the scene has none");
    struct path_grid grid;
    for (int i = 0; i < methods; i++)
        if (!noise_path_grid_make(&setup->forcing, method[i], setup->span, setup->dt, 1, &grid,
                                  error))
            return false;
    const struct parallel parallel = noise_parallel(session, args);
    const int threads = parallel_threads(&parallel, request.paths);
    if (!noise_check_cost(session, args, setup, noise_orders_bytes(&request, threads),
                          methods * noise_orders_steps(&request) / threads, error))
        return false;
    struct method_orders *orders = arena_array(args->arena, (size_t)methods, sizeof *orders);
    if (!orders)
        return error_memory(error);
    for (int i = 0; i < methods; i++)
        if (!noise_orders_measure(&request, method[i], parallel, &orders[i], error))
            return false;
    session_changed(session);
    reply_orders(setup, &request, orders, methods, args->arena, reply);
    return true;
}
#endif

COMMAND(noiseorder, .group = "NOISE", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("DURATION", TYPE_VALUE, .quantity = QUANTITY_TIME), NOISE_ARGUMENTS,
                  KEY("method", TYPE_CHOICE, .choices = &noise_method_catalog, .flags = ARG_MANY),
                  KEY("paths", TYPE_INTEGER), KEY("levels", TYPE_INTEGER),
                  OPTION("threads", TYPE_INTEGER)))
