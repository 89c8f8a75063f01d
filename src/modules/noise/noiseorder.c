/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command noiseorder: strong and weak orders of the methods for the scene, measured. */
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include "modules/noise/setup.h" /* for the rows, too */

#ifndef COMMAND_ROWS
#include "modules/noise/compute/orders.h"

enum { ORDER_LEVELS = 5, ORDER_PATHS = 1000, ORDER_METHODS = 3 };

/* A row of the table: a method with one step. */
struct order_row {
    const char *method;
    double dt, strong, strong_error, weak, weak_error;
    double strong_order, strong_order_error, weak_order, weak_order_error; /* of the method */
};

#define REAL_AT(member) .quantity = QUANTITY_NUMBER, .at = offsetof(struct order_row, member)
static const struct result_column of_order[] = {
    {.name = "method", .kind = COLUMN_NAME, .at = offsetof(struct order_row, method)},
    {.name = "dt", .quantity = QUANTITY_TIME, .at = offsetof(struct order_row, dt)},
    {.name = "strong", REAL_AT(strong)},
    {.name = "strong_error", REAL_AT(strong_error)},
    {.name = "weak", REAL_AT(weak)},
    {.name = "weak_error", REAL_AT(weak_error)},
    {.name = "strong_order", REAL_AT(strong_order)},
    {.name = "strong_order_error", REAL_AT(strong_order_error)},
    {.name = "weak_order", REAL_AT(weak_order)},
    {.name = "weak_order_error", REAL_AT(weak_order_error)},
};
static const struct result_columns noiseorder_columns = RESULT_COLUMNS(of_order, struct order_row);

/* The methods that were named, else all that the scene can have. Returns how many. */
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

static void put_order(struct buffer *text, struct measured order)
{
    if (isnan(order.value))
        buffer_format(text, "not known");
    else
        buffer_uncertain(text, order.value, order.uncertainty);
}

/* A line for each method, then its errors with the largest and the smallest step. */
static void say_orders(const struct noise_setup *setup, const struct orders_request *request,
                       const struct method_orders *orders, int methods, struct arena *arena,
                       struct reply *reply)
{
    struct text_table table = {.arena = arena, .columns = 6, .gap = 3};
    static const char *const heading[] = {"method",          "strong order",  "weak order",
                                          "strong at first", "weak at first", "weak at last"};
    struct buffer text = {0};
    bool unknown = false;
    buffer_format(&text,
                  "a step beside half of it on the same path, %lld paths and their mirror "
                  "images to t = ",
                  (long long)request->paths);
    buffer_quantity(&text, setup->forcing.system.t0 + request->span, QUANTITY_TIME, 4);
    buffer_format(&text, ",\ndt from ");
    buffer_quantity(&text, orders[0].level[0].dt, QUANTITY_TIME, 4);
    buffer_format(&text, " down to ");
    buffer_quantity(&text, orders[0].level[request->levels - 1].dt, QUANTITY_TIME, 4);
    buffer_format(&text, "; ");
    noise_setup_put(setup, &text);
    buffer_format(&text, "\n");
    for (size_t i = 0; i < COUNT_OF(heading); i++)
        cell_text(&table, heading[i]);
    for (int i = 0; i < methods; i++) {
        const struct order_level *first = &orders[i].level[0], *last = first + request->levels - 1;
        const struct measured order[2] = {orders[i].strong, orders[i].weak};
        cell_text(&table, orders[i].method->row.name);
        for (int k = 0; k < 2; k++) {
            struct buffer cell = {0};
            put_order(&cell, order[k]);
            unknown = unknown || isnan(order[k].value);
            cell_take(&table, &cell);
        }
        cell_error(&table, first->strong.value);
        cell_error(&table, first->weak.value);
        cell_error(&table, last->weak.value);
    }
    text_table_put(&table, &text);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    if (unknown)
        reply_line(
            reply,
            "not known: chance or rounding hides the differences, or their sign changes: more "
            "paths=N, or another dt");
}

static void reply_orders(const struct noise_setup *setup, const struct method_orders *orders,
                         int methods, struct arena *arena, struct reply *reply)
{
    const int levels = orders[0].levels;
    struct order_row *row = arena_array(arena, (size_t)(methods * levels), sizeof *row);
    for (int i = 0; row && i < methods * levels; i++) {
        const struct method_orders *of = &orders[i / levels];
        const struct order_level *level = &of->level[i % levels];
        row[i] = (struct order_row){.method = of->method->row.name,
                                    .dt = level->dt,
                                    .strong = level->strong.value,
                                    .strong_error = level->strong.uncertainty,
                                    .weak = level->weak.value,
                                    .weak_error = level->weak.uncertainty,
                                    .strong_order = of->strong.value,
                                    .strong_order_error = of->strong.uncertainty,
                                    .weak_order = of->weak.value,
                                    .weak_order_error = of->weak.uncertainty};
    }
    struct arena kept = {0};
    struct table table;
    if (!row)
        return;
    reply_records(reply, "noiseorder", &noiseorder_columns, row, (size_t)(methods * levels));
    if (columns_table(&noiseorder_columns, row, (size_t)(methods * levels), &kept, &table))
        noise_keep_table(setup, 0, "noiseorder", NULL, &kept, &table, reply);
}

/* Reads how many paths and steps; refuses what cannot be. */
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
        return error_at(error, argument_value(args, "levels")->where, "levels=N is 3 to %d",
                        ORDER_LEVELS_MAX);
    if (request->paths < 10 || request->paths >= UINT32_MAX)
        return error_at(error, argument_value(args, "paths")->where, "paths=N is from 10 on");
    return true;
}

HANDLER(noiseorder)
{
    const struct noise_setup *setup = noise_setup_read(session, args, error);
    struct orders_request request;
    const struct noise_method *method[ORDER_METHODS];
    if (!setup || !read_request(args, setup, &request, error))
        return false;
    const int methods = choose_methods(args, setup, method);
    if (methods == 0)
        return error_set(error, ERROR_COMMAND, "baoab needs velocities, and the scene has none");
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
    say_orders(setup, &request, orders, methods, args->arena, reply);
    reply_orders(setup, orders, methods, args->arena, reply);
    return true;
}
#endif

COMMAND(noiseorder, .group = "NOISE", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("DURATION", TYPE_VALUE, .quantity = QUANTITY_TIME), NOISE_ARGUMENTS,
                  KEY("method", TYPE_CHOICE, .choices = &noise_method_catalog, .flags = ARG_MANY),
                  KEY("paths", TYPE_INTEGER), KEY("levels", TYPE_INTEGER),
                  OPTION("threads", TYPE_INTEGER)))
