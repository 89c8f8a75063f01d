/* SPDX-License-Identifier: GPL-3.0-or-later */
/* order, selftest */
#ifndef COMMAND_ROWS
#include <hooke/report.h>
#include <hooke/command/handler.h>

#include <math.h>

/* ---- order ---- */

static void put_order(const struct session *session, const struct order *order, struct arena *arena,
                      struct buffer *out)
{
    const char *drag = contender_drag(&order->by);
    struct text_table table = {.arena = arena, .gap = 3, .indent = 2};
    buffer_format(out, "%s%s%s, ", order->by.method->row.name, drag ? " drag=" : "",
                  drag ? drag : "");
    buffer_quantity(out, session->setup.settings.duration, QUANTITY_TIME, 4);
    buffer_put(out, TEXT(" of the scene in fixed steps with compensated sums; root mean "
                         "square error of the whole state at four times, good to "));
    buffer_short(out, order->floor, 2);
    buffer_put(out, order->reference_stored ? TEXT(", by a solution found before\n") : TEXT("\n"));
    columns_text(&order_point_columns, order->point, (size_t)order->points, true, &table);
    text_table_put(&table, out);
    int64_t turns = 0;
    for (int i = 0; i < order->points; i++)
        turns = order->point[i].turns > turns ? order->point[i].turns : turns;
    if (turns > 0)
        buffer_format(
            out, "steps end at %s, in up to %lld extra ones a run; 'set turning off' goes across\n",
            order->switches ? "switches" : "turning points", (long long)turns);
    const char *verdict = catalog_row(&order_verdict_catalog, order->verdict)->name;
    if (order->fitted)
        buffer_format(out, "order %.3f +- %.3f (* %d points, R^2 = %.8g), claimed %d: %s\n",
                      order->slope, order->guard, order->fitted, order->r2, order->claimed,
                      verdict);
    else if (order->verdict == ORDER_EXACT)
        buffer_put(out, TEXT("exact: every step size gives the solution to rounding\n"));
    else
        buffer_format(out, "no order can be measured here (claimed %d)\n", order->claimed);
    if (order->words[0])
        buffer_format(out, "%s\n", order->words);
}

static void reply_order(const struct order *order, struct reply *reply)
{
    reply_begin(reply, "order");
    reply_columns(reply, &order_columns, order);
    reply_array(reply, "sweep");
    for (int i = 0; i < order->points; i++) {
        reply_object(reply, NULL);
        reply_columns(reply, &order_point_columns, &order->point[i]);
        reply_close(reply);
    }
    reply_close(reply);
    reply_end(reply);
}

HANDLER(order)
{
    const struct argument_value *method = argument_value(args, "METHOD"),
                                *dt = argument_value(args, "dt"),
                                *drag = argument_value(args, "drag");
    struct order_request request = {.scene = &session->setup.scene,
                                    .by = {session->setup.method, session->setup.drag},
                                    .dt = {NAN, NAN},
                                    .duration = session->setup.settings.duration,
                                    .references = &session->references,
                                    .cancel = session->front.cancel};
    if (method->count)
        request.by = (struct method_choice){(const struct method *)(const void *)method->item->row,
                                            DRAG_DEFAULT};
    else
        reply_unchosen(session, reply);
    if (drag->count)
        request.by.drag = (enum drag)(drag->item->index + 1);
    for (int i = 0; i < 2 && dt->count; i++) {
        request.dt[i] = dt->item->range[i];
        if (!(request.dt[i] > 0))
            return error_at(error, dt->where, "a sweep needs two ends above 0, as in dt=1ms:100ms");
    }
    struct order order;
    reply_assumed(session, false, true, reply);
    const bool ok = study_order(&request, &order, error);
    if (ok || order.points > 0) {
        struct buffer text = {0};
        put_order(session, &order, args->arena, &text);
        reply_text(reply, buffer_text(&text));
        buffer_free(&text);
        reply_result(session, reply, "order", &order_point_columns, order.point,
                     (size_t)order.points, order.by.method->row.name, NULL);
        reply_order(&order, reply);
    }
    return ok;
}

/* ---- selftest ---- */

static void check_cell(struct text_table *table, const struct selftest_row *row,
                       enum selftest_check check)
{
    struct buffer text = {0};
    if (!row->check[check].applies)
        buffer_char(&text, '-');
    else if (check == SELFTEST_ORDER)
        buffer_format(&text, "%.2f of %g", row->check[check].value, row->check[check].wanted);
    else if (check == SELFTEST_STABILITY)
        buffer_format(&text, "x %.6g of %.6g", row->check[check].value, row->check[check].wanted);
    else
        buffer_format(&text, "%.0e", fabs(row->check[check].value));
    if (row->check[check].applies && !row->check[check].passed)
        buffer_put(&text, TEXT(" !"));
    cell_take(table, &text);
}

static void selftest_cells(const struct selftest_row *row, struct text_table *table)
{
    cell_text(table, row->method->row.name);
    for (enum selftest_check check = 0; check < SELFTEST_CHECKS; check++)
        check_cell(table, row, check);
    cell_text(table, row->passed ? "ok" : "FAILED");
}

static void reply_selftest(const struct selftest_row *row, struct reply *reply)
{
    reply_begin(reply, "selftest");
    reply_string(reply, "method", row->method->row.name);
    reply_bool(reply, "passed", row->passed);
    for (enum selftest_check i = 0; i < SELFTEST_CHECKS; i++) {
        reply_object(reply, catalog_row(&selftest_catalog, i)->name);
        reply_bool(reply, "asked", row->check[i].applies);
        reply_bool(reply, "passed", row->check[i].passed);
        reply_real(reply, "value", row->check[i].applies ? row->check[i].value : NAN);
        reply_real(reply, "wanted", row->check[i].applies ? row->check[i].wanted : NAN);
        reply_close(reply);
    }
    reply_end(reply);
}

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
        const struct method *method =
            (const struct method *)(const void *)catalog_row(&method_catalog, i);
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
        reply_selftest(&row, reply);
    }
    if (full || failures > 0)
        text_table_put(&table, &text);
    buffer_format(&text, "%d methods: %d passed, %d failed", finished, finished - failures,
                  failures);
    if (session->setup.settings.timing != TIMING_OFF)
        buffer_format(&text, "; %.1f s", clock_seconds(begin));
    buffer_put(&text, full ? TEXT("\n") : TEXT("; what was measured: --full\n"));
    for (size_t i = 0; i < SELFTEST_CHECKS; i++)
        buffer_format(&text, "%s: %s\n", catalog_row(&selftest_catalog, i)->name,
                      catalog_row(&selftest_catalog, i)->brief);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    bool ok = failures == 0;
    if (cancelled(session->front.cancel))
        ok = error_set(error, ERROR_CANCELLED, "stopped after %d methods", finished);
    else if (!ok)
        error_set(error, ERROR_NUMERICAL, "%d of %d methods are not what their rows claim: %.300s",
                  failures, finished, buffer_view(&failed));
    buffer_free(&failed);
    return ok;
}
#endif

COMMAND(order,
        .row = {"order", "", "measured order of a method on this scene, with guard bands", "",
                NULL},
        .group = "STUDY",
        .text = "Fixed steps from coarse to fine with compensated sums. The order is the slope of "
                "the error (of the "
                "whole state at\n"
                "the end of 'duration') over the step, fitted where it means something: below the "
                "steps that are too "
                "coarse, above\n"
                "rounding. Without METHOD the present one. Where the scene spoils the order (drag "
                "that is not smooth, stiffness, "
                "drag=explicit), it "
                "says so.",
        .examples = "order\nduration = 2 s; order rk4 dt=1ms:100ms",
        .see = "precision compare stability", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("METHOD", TYPE_CHOICE, .choices = &method_catalog),
                  KEY("dt", TYPE_RANGE, .quantity = QUANTITY_TIME),
                  KEY("drag", TYPE_CHOICE, .choices = &drag_catalog), OPTION("full", TYPE_NONE)))

COMMAND(
    selftest,
    .row = {"selftest", "", "what every method claims, measured on this machine", "", NULL},
    .group = "SESSION",
    .text = "Order on a Kepler orbit, areas kept by symplectic methods, the way back of "
            "symmetric ones, and runs on "
            "both sides of\n"
            "the stability limit, for every method: those that fail, or with --full all. The exit "
            "status is 3 if one fails.",
    .examples = "selftest\nset format json; selftest; set format text",
    .see = "order stability stress", .flags = COMMAND_TABLES, ARGUMENTS(OPTION("full", TYPE_NONE)))
