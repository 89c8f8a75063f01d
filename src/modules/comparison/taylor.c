/* SPDX-License-Identifier: GPL-3.0-or-later */
/* taylor: the error of a single step, as a term of the Taylor expansion. */
#ifndef COMMAND_ROWS
#include <hooke/base/number.h>
#include <hooke/base/unit.h>
#include <hooke/report.h>
#include "modules/comparison/comparison.h"
#include "modules/comparison/compute/local_error.h"

#include <math.h>
#include <string.h>

/* ---- the terms ---- */

/* Appends y'', y''' or y^(4). */
static void put_derivative(const char *name, int order, struct buffer *text)
{
    if (order < 4)
        buffer_format(text, "%s%.*s", name, order, "'''");
    else
        buffer_format(text, "%s^(%d)", name, order);
}

/* Appends the unit of a derivative of the variable: "m/s^3" for the second one of a velocity. */
static void put_rate_unit(const struct variable *variable, int order, struct buffer *text)
{
    const struct text unit = text_of(quantity_unit(variable->quantity));
    if (unit.len > 2 && memcmp(unit.data + unit.len - 2, "/s", 2) == 0)
        buffer_format(text, "%.*s/s^%d", (int)unit.len - 2, unit.data, order + 1);
    else if (order == 1)
        buffer_format(text, "%s/s", unit.len > 0 ? unit.data : "1");
    else
        buffer_format(text, "%s/s^%d", unit.len > 0 ? unit.data : "1", order);
}

/* Appends the leading error of a variable as a term: "-1/2 dt^2 y''". */
static void put_term(const struct variable *variable, const struct leading_error *leading,
                     struct buffer *text)
{
    if (leading->exponent == 0)
        buffer_put(text, TEXT("0 (rounding only)"));
    else if (leading->exponent < 0)
        buffer_put(text, TEXT("no clear power of dt"));
    else if (leading->denominator > 0) {
        if (leading->denominator > 1)
            buffer_format(text, "%d/%d ", leading->numerator, leading->denominator);
        else
            buffer_format(text, "%d ", leading->numerator);
        buffer_format(text, "dt^%d ", leading->exponent);
        put_derivative(variable->name, leading->exponent, text);
    } else {
        buffer_short(text, leading->coefficient, 5);
        buffer_put(text, TEXT(" "));
        put_rate_unit(variable, leading->exponent, text);
        buffer_format(text, " dt^%d", leading->exponent);
    }
}

/* Writes a line for each variable: the term, and the value of the derivative in it. */
static void put_terms(const struct local_error *result, struct arena *arena, struct buffer *output)
{
    struct text_table table = {.arena = arena, .columns = 2, .gap = 3, .indent = 2};
    for (int i = 0; i < result->n; i++) {
        const struct variable *variable = &result->variable[i];
        const struct leading_error *leading = &result->leading[i];
        struct buffer term = {0}, value = {0};
        buffer_format(&term, "error of %s = ", variable->name);
        put_term(variable, leading, &term);
        if (leading->exponent > 0)
            buffer_put(&term, TEXT(" + ..."));
        if (leading->exponent > 0 && leading->denominator > 0) {
            put_derivative(variable->name, leading->exponent, &value);
            buffer_put(&value, TEXT(" = "));
            buffer_short(&value, leading->derivative, 5);
            buffer_put(&value, TEXT(" "));
            put_rate_unit(variable, leading->exponent, &value);
        }
        cell_take(&table, &term);
        cell_take(&table, &value);
    }
    text_table_put(&table, output);
}

/* Writes the scene's law: "with v' = -k/m*y-gamma*v". Typed equations are known to whoever typed
 * them. */
static void put_law(const struct session *session, struct buffer *output)
{
    struct system system;
    struct error ignored;
    struct buffer law = {0};
    if (!scene_bind(&session->setup.scene, &system, &ignored) || system.n != 2 || system.order != 2)
        return;
    for (int i = 0; i < system.terms; i++) {
        const char *equation = system.term[i].row->equation[0];
        if (!equation) {
            buffer_free(&law);
            return;
        }
        buffer_format(&law, "%s%s", law.len > 0 && equation[0] != '-' ? "+" : "", equation);
    }
    if (law.len > 0)
        buffer_format(output, "with %s'' = %s\n", system_variable(&system, 0).name,
                      buffer_view(&law));
    buffer_free(&law);
}

/* ---- the measured errors ---- */

/* Writes the errors of the first variables (a position and its velocity) beside their slopes. */
static void put_errors(const struct local_error *result, struct arena *arena, struct buffer *output)
{
    enum { SHOWN_MAX = 2 };
    const int half = result->n / 2, last = result->n - 1;
    const int shown[SHOWN_MAX] = {0, half > 0 ? half : last};
    const int variables = result->n < SHOWN_MAX ? result->n : SHOWN_MAX;
    struct text_table table = {.arena = arena, .columns = 1 + 2 * variables, .gap = 3, .indent = 2};
    cell_text(&table, "dt");
    for (int i = 0; i < variables; i++) {
        cell_format(&table, "error of %s", result->variable[shown[i]].name);
        cell_text(&table, "slope");
    }
    for (int k = 0; k < result->points; k++) {
        cell_text(&table, SHOWN_QUANTITY(result->dt[k], QUANTITY_TIME, 4));
        for (int i = 0; i < variables; i++) {
            const int v = shown[i];
            const double error = result->error[k][v],
                         slope = k > 0 ? log(fabs(error / result->error[k - 1][v])) /
                                             log(result->dt[k] / result->dt[k - 1])
                                       : NAN;
            cell_text(&table, SHOWN_QUANTITY(error, result->variable[v].quantity, 3));
            cell_format(&table, isfinite(slope) ? "%.3f" : "-", slope);
        }
    }
    text_table_put(&table, output);
}

/* Writes how the local error leads to the global one. */
static void put_summary(const struct local_error *result, struct buffer *output)
{
    const struct method *method = result->choice.method;
    int least = 0;
    for (int i = 0; i < result->n; i++)
        if (result->leading[i].exponent > 0 && (least == 0 || result->leading[i].exponent < least))
            least = result->leading[i].exponent;
    if (least == 0)
        return;
    buffer_format(output, "one step: dt^%d; a run takes 1/dt of them, so its error falls as dt^%d",
                  least, least - 1);
    if (method->order == least - 1)
        buffer_format(output, ": order %d, as claimed", method->order);
    buffer_format(output, " ('order %s' measures it)\n", method->row.name);
}

/* Writes the expansion of the solution up to the term in which the method differs from it. */
static void put_expansion(const struct local_error *result, struct buffer *output)
{
    const char *name = result->variable[0].name;
    const int last = result->leading[0].exponent;
    if (last < 1 || last > 4)
        return;
    buffer_format(output, "the solution: %s(t+dt) = %s", name, name);
    for (int order = 1, factorial = 1; order <= last; factorial *= ++order) {
        buffer_put(output, TEXT(" + "));
        if (factorial > 1)
            buffer_format(output, "1/%d ", factorial);
        buffer_format(output, order > 1 ? "dt^%d " : "dt ", order);
        put_derivative(name, order, output);
    }
    buffer_put(output, TEXT(" + ...\n"));
}

/* Writes all lines on the local error of one method: state, terms, table and summary. */
static void put_local_error(const struct session *session, const struct local_error *result,
                            bool is_full, struct arena *arena, struct buffer *output)
{
    struct buffer lines = {0};
    int width, height;
    session_size(session, &width, &height);
    buffer_format(&lines, "%s, one step from t = %s", result->choice.method->row.name,
                  SHOWN_QUANTITY(result->t, QUANTITY_TIME, 4));
    for (int i = 0; i < result->n && i < 4; i++)
        buffer_format(&lines, ", %s = %s", result->variable[i].name,
                      SHOWN_QUANTITY(result->state[i], result->variable[i].quantity, 4));
    buffer_put(&lines, TEXT(":\n"));
    put_folded_lines(&lines, width, output);
    put_terms(result, arena, output);
    if (is_full) {
        put_expansion(result, &lines);
        put_law(session, &lines);
        put_folded_lines(&lines, width, output);
        put_errors(result, arena, output);
    }
    put_summary(result, &lines);
    put_folded_lines(&lines, width, output);
    buffer_free(&lines);
}

/* Measures the local error of each method and replies with lines, a result and records. */
HANDLER(taylor)
{
    const struct argument_value *at = argument_value(args, "at");
    const size_t capacity = (size_t)argument_value(args, "METHOD")->count + 1;
    struct method_choice *choice = arena_array(args->arena, capacity, sizeof *choice);
    struct local_error *result = arena_array(args->arena, 1, sizeof *result);
    int count = 1;
    if (!choice || !result)
        return error_memory(error);
    choice[0] = (struct method_choice){session->setup.method, session->setup.drag};
    if (!has_argument(args, "METHOD"))
        reply_unchosen(session, reply);
    if (!choose_methods(args, DRAG_DEFAULT, choice, &count, error))
        return false;
    reply_assumed(session, false, false, reply);
    size_t rows = 0;
    struct local_error_row *row = arena_array(
        args->arena, capacity * LOCAL_ERROR_POINTS * (size_t)session->setup.scene.model->n,
        sizeof *row);
    if (!row)
        return error_memory(error);
    for (int i = 0; i < count; i++) {
        const struct local_error_request request = {&session->setup.scene, choice[i],
                                                    at->count ? at->item->value.value : NAN,
                                                    session->front.cancel};
        if (!study_local_error(&request, result, error))
            return false;
        rows += local_error_rows(result, row + rows);
        if (reply_wants_text(reply))
            put_local_error(session, result, count == 1 || asks_full(args), args->arena,
                            reply_buffer(reply));
    }
    reply_result(session, reply, "taylor", &local_error_columns, row, rows,
                 count == 1 ? choice->method->row.name : NULL, NULL);
    reply_records(reply, "taylor", &local_error_columns, row, rows);
    return true;
}
#endif

COMMAND(taylor, .group = "STUDY", .flags = COMMAND_TABLES,
        ARGUMENTS(PLACE("METHOD", TYPE_CHOICE, .flags = ARG_MANY, .choices = &method_catalog),
                  KEY("drag", TYPE_CHOICE, .choices = &drag_catalog),
                  KEY("at", TYPE_VALUE, .flags = ARG_NEGATIVE, .quantity = QUANTITY_TIME),
                  OPTION("full", TYPE_NONE)))
