/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The commands `order`, which measures the order of methods on the scene, and `selftest`, which
 * checks the claimed properties of all methods. */
#ifndef COMMAND_ROWS
#include <hooke/base/cancel.h>
#include <hooke/base/unit.h>
#include <hooke/plot/drawing.h>
#include <hooke/report.h>
#include "modules/comparison/comparison.h"
#include "modules/comparison/plots.h"

#include <math.h>

/* ---- order ---- */

/* Appends the result for one method: the fitted order beside the claimed one, the reason if they
 * differ, a table of step sizes and errors, and how they were measured. */
static void put_order(const struct session *session, const struct order *order, struct arena *arena,
                      struct buffer *output)
{
    const char *drag = contender_drag(&order->choice);
    struct text_table table = {.arena = arena, .gap = 3, .indent = 2};
    const char *verdict = catalog_row(&order_verdict_catalog, order->verdict)->name;
    buffer_put(output, text_of(order->choice.method->row.name));
    if (drag)
        buffer_format(output, " drag=%s", drag);
    if (order->fitted)
        buffer_format(output, ": order %.3f +- %.3f (* %d points, R^2 = %.8g), claimed %d: %s\n",
                      order->slope, order->guard, order->fitted, order->r2, order->claimed,
                      verdict);
    else if (order->verdict == ORDER_EXACT)
        buffer_put(output, TEXT(": exact: every step size gives the solution up to rounding\n"));
    else
        buffer_format(output, ": no order can be measured here (claimed %d)\n", order->claimed);
    if (order->words[0])
        buffer_format(output, "%s\n", order->words);
    columns_text(&order_point_columns, order->point, (size_t)order->points, true, &table);
    text_table_put(&table, output);
    int64_t turns = 0;
    for (int i = 0; i < order->points; i++)
        turns = order->point[i].turns > turns ? order->point[i].turns : turns;
    if (turns > 0)
        buffer_format(
            output,
            "steps end at %s (up to %lld extra steps per run); 'set turning off' steps across\n",
            order->switches ? "switches" : "turning points", (long long)turns);
    buffer_format(
        output,
        "each run is %s of the scene in fixed steps with compensated sums; its error is the "
        "root mean square of the whole state at four times, accurate to %s",
        SHOWN_QUANTITY(session->setup.settings.duration, QUANTITY_TIME, 4),
        SHOWN_SHORT(order->floor, 2));
    buffer_put(output, order->reference_stored
                           ? TEXT(", with the reference solution of an earlier study\n")
                           : TEXT("\n"));
}

/* Measures each method in turn, with steps from dt[0] to dt[1] [s] (NAN to choose them), into
 * orders [*count]. If there are several, those that do not apply are skipped and appended to
 * `absent` with the reason. Returns false with an error if nothing was measured or if cancelled;
 * results before that are kept. */
static bool measure_orders(struct session *session, const struct method_choice *choice, int choices,
                           const double dt[2], struct order *orders, int *count,
                           struct buffer *absent, struct error *error)
{
    struct order_request request = {.scene = &session->setup.scene,
                                    .dt = {dt[0], dt[1]},
                                    .duration = session->setup.settings.duration,
                                    .references = session_references(session),
                                    .cancel = session->front.cancel};
    for (int i = 0; i < choices; i++) {
        struct order *order = &orders[*count];
        request.choice = choice[i];
        const bool ok = study_order(&request, order, error);
        *count += ok || order->points > 0;
        if (!ok && (choices == 1 || error->code != ERROR_COMMAND))
            return false;
        if (!ok)
            buffer_format(absent, "left out: %s\n", error->text);
    }
    return *count > 0;
}

/* Stores the points of all sweeps as the result "order", and adds a record per method to the reply.
 * Returns false with an error if out of memory. */
static bool reply_orders(const struct session *session, const struct order *orders, int count,
                         struct arena *arena, struct reply *reply, struct error *error)
{
    struct order_row *rows = arena_array(arena, (size_t)count * ORDER_POINTS, sizeof *rows);
    size_t n = 0;
    if (!rows)
        return error_memory(error);
    for (int i = 0; i < count; i++)
        n += order_rows(&orders[i], rows + n);
    reply_result(session, reply, "order", &order_row_columns, rows, n,
                 count == 1 ? orders->choice.method->row.name : NULL, NULL);
    reply_records(reply, "order", &order_columns, orders, (size_t)count);
    return true;
}

/* Appends the result for several methods: a table with a line each, then their explanations and the
 * methods that were left out. */
static void put_orders(const struct session *session, const struct order *orders, int count,
                       const struct buffer *absent, struct arena *arena, struct buffer *text)
{
    int width, height;
    struct buffer lines = {0};
    session_size(session, &width, &height);
    struct text_table table = {.arena = arena, .gap = 2, .max = width};
    columns_text(&order_columns, orders, (size_t)count, true, &table);
    text_table_put(&table, text);
    buffer_put(&lines, buffer_text(absent));
    for (int i = 0; i < count; i++)
        if (orders[i].words[0])
            buffer_format(&lines, "%s: %s\n", orders[i].choice.method->row.name, orders[i].words);
    buffer_put(&lines, TEXT("'plot order' draws the errors; 'order METHOD' lists those of one\n"));
    put_folded_lines(&lines, width, text);
    buffer_free(&lines);
}

/* Measures the order of methods and draws it (`plot order`), unless the stored one can be drawn. */
bool order_study(struct session *session, const struct row *const *method, int methods,
                 struct reply *reply, struct error *error)
{
    if (methods == 0 && drawing_stored(session, "order"))
        return true;
    struct arena arena = {0};
    struct buffer absent = {0};
    struct method_choice *choice = methods_choice(session, method, &methods, &arena);
    struct order *orders = arena_array(&arena, (size_t)methods + 1, sizeof *orders);
    int count = 0;
    const bool ok = choice && orders
                        ? measure_orders(session, choice, methods, (double[]){NAN, NAN}, orders,
                                         &count, &absent, error) &&
                              reply_orders(session, orders, count, &arena, reply, error)
                        : error_memory(error);
    if (absent.len > 0)
        reply_note(reply, "%.*s", (int)absent.len - 1, buffer_view(&absent));
    buffer_free(&absent);
    arena_reset(&arena);
    return ok;
}

/* Executes `order`, for the named methods or the session's own. */
HANDLER(order)
{
    const struct argument_value *dt = argument_value(args, "dt");
    int wanted = 1, count = 0;
    double range[2] = {NAN, NAN};
    const size_t capacity = (size_t)argument_value(args, "METHOD")->count + 1;
    struct method_choice *choice = arena_array(args->arena, capacity, sizeof *choice);
    struct order *orders = arena_array(args->arena, capacity, sizeof *orders);
    struct buffer absent = {0};
    if (!choice || !orders)
        return error_memory(error);
    choice[0] = (struct method_choice){session->setup.method, session->setup.drag};
    if (!has_argument(args, "METHOD"))
        reply_unchosen(session, reply);
    if (!choose_methods(args, DRAG_DEFAULT, choice, &wanted, error))
        return false;
    for (int i = 0; i < 2 && dt->count; i++) {
        range[i] = dt->item->range[i];
        if (!(range[i] > 0))
            return error_at(error, dt->where, "a sweep needs two ends above 0, as in dt=1ms:100ms");
    }
    reply_assumed(session, false, true, reply);
    const bool ok = measure_orders(session, choice, wanted, range, orders, &count, &absent, error);
    if (count > 0 && reply_wants_text(reply) && wanted == 1)
        put_order(session, orders, args->arena, reply_buffer(reply));
    else if (count > 0 && reply_wants_text(reply))
        put_orders(session, orders, count, &absent, args->arena, reply_buffer(reply));
    buffer_free(&absent);
    return (count == 0 || reply_orders(session, orders, count, args->arena, reply, error)) && ok;
}

/* ---- selftest ---- */

/* Writes the result of one check: measured and wanted value, with an exclamation mark if it failed,
 * or "-" if the check does not apply. */
static void check_cell(struct text_table *table, const struct selftest_row *row,
                       enum selftest_check index)
{
    const struct selftest_result *check = &row->check[index];
    const char *mark = check->passed ? "" : " !";
    if (!check->applies)
        cell_text(table, "-");
    else if (index == SELFTEST_ORDER)
        cell_format(table, "%.2f of %g%s", check->value, check->wanted, mark);
    else if (index == SELFTEST_STABILITY)
        cell_format(table, "x %.6g of %.6g%s", check->value, check->wanted, mark);
    else
        cell_format(table, "%.0e%s", fabs(check->value), mark);
}

/* Adds the line of one method to the table. */
static void selftest_cells(const struct selftest_row *row, struct text_table *table)
{
    cell_text(table, row->method->row.name);
    for (enum selftest_check check = 0; check < SELFTEST_CHECKS; check++)
        check_cell(table, row, check);
    cell_text(table, row->passed ? "ok" : "FAILED");
}

/* One check of a row of selftest, as an object in its record. */
#define CHECK(name, index)                                                                         \
    {                                                                                              \
        name, .kind = COLUMN_OBJECT, .part = &check_columns,                                       \
              .offset = offsetof(struct selftest_row, check[index])                                \
    }
#define AT(member) .offset = offsetof(struct selftest_result, member)

static const struct result_column of_check[] = {
    {.name = "asked", .kind = COLUMN_BOOL, AT(applies)},
    {.name = "passed", .kind = COLUMN_BOOL, AT(passed)},
    {.name = "value", AT(value)},
    {.name = "wanted", AT(wanted)},
};
static const struct result_columns check_columns = RESULT_COLUMNS(of_check, struct selftest_result);

static const struct result_column of_selftest[] = {
    {.name = "method", .kind = COLUMN_ROW, .offset = offsetof(struct selftest_row, method)},
    {.name = "passed", .kind = COLUMN_BOOL, .offset = offsetof(struct selftest_row, passed)},
    CHECK("order", SELFTEST_ORDER),
    CHECK("area", SELFTEST_AREA),
    CHECK("reversal", SELFTEST_REVERSAL),
    CHECK("stability", SELFTEST_STABILITY),
};
static const struct result_columns selftest_columns =
    RESULT_COLUMNS(of_selftest, struct selftest_row);

/* Executes `selftest`: a line for each method that fails a check, or with --full for all. Fails
 * with ERROR_NUMERICAL if a method does. */
HANDLER(selftest)
{
    struct text_table table = {.arena = args->arena, .columns = SELFTEST_CHECKS + 2, .gap = 2};
    struct buffer text = {0}, failed = {0};
    const int64_t begin = clock_ns();
    const bool full = asks_full(args);
    int finished = 0, failures = 0;
    cell_text(&table, "method");
    for (size_t i = 0; i < SELFTEST_CHECKS; i++)
        cell_text(&table, catalog_row(&selftest_catalog, i)->name);
    cell_text(&table, "");
    for (size_t i = 0; i < method_catalog.count; i++) {
        const struct method *method = method_at(i);
        struct selftest_row row;
        if (method->flags & METHOD_EXTERNAL)
            continue;
        if (!selftest_method(method, session->front.cancel, &row))
            break;
        finished++;
        failures += !row.passed;
        if (!row.passed)
            buffer_format(&failed, "%s%s", failures > 1 ? ", " : "", method->row.name);
        if (full || !row.passed)
            selftest_cells(&row, &table);
        reply_records(reply, "selftest", &selftest_columns, &row, 1);
    }
    if (full || failures > 0)
        text_table_put(&table, &text);
    buffer_format(&text, "%d methods: %d passed, %d failed", finished, finished - failures,
                  failures);
    if (session->setup.settings.timing != TIMING_OFF)
        buffer_format(&text, "; %.1f s", clock_seconds(begin));
    buffer_put(&text, full ? TEXT("\n") : TEXT("; all measurements: --full\n"));
    for (size_t i = 0; i < SELFTEST_CHECKS; i++)
        buffer_format(&text, "%s: %s\n", catalog_row(&selftest_catalog, i)->name,
                      catalog_row(&selftest_catalog, i)->brief);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    bool ok = failures == 0;
    if (cancelled(session->front.cancel))
        ok = error_set(error, ERROR_CANCELLED, "stopped after %d methods", finished);
    else if (!ok)
        error_set(error, ERROR_NUMERICAL,
                  "%d of %d methods do not have their claimed properties: %.300s", failures,
                  finished, buffer_view(&failed));
    buffer_free(&failed);
    return ok;
}
#endif

COMMAND(order, .group = "STUDY", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("METHOD", TYPE_CHOICE, .flags = ARG_MANY, .choices = &method_catalog),
                  KEY("dt", TYPE_RANGE, .quantity = QUANTITY_TIME),
                  KEY("drag", TYPE_CHOICE, .choices = &drag_catalog), OPTION("full", TYPE_NONE)))

COMMAND(selftest, .group = "SESSION", .flags = COMMAND_TABLES, ARGUMENTS(OPTION("full", TYPE_NONE)))
