/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The commands export (tables of runs, recordings and results; scenes as programs; methods), print
 * and echo. */
#ifndef COMMAND_ROWS
#include <hooke/base/cancel.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/session/series_tools.h>
#include <hooke/report.h>
#include <hooke/scene/dimension.h>
#include <hooke/scene/formula.h>
#include <hooke/command/handler.h>
#include "command/redirect.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* [byte] Output that is written between two looks at Ctrl-C. */
#define SHOWN_CHUNK_BYTES 65536u

/* Chooses the format by --format or by the ending of the file; CSV if it has none. Returns false
 * with the error set for an unknown ending. */
static bool choose_format(const struct arguments *args, struct text path, table_format **format,
                          struct error *error)
{
    const struct argument_value *chosen = argument_value(args, "format");
    const struct text end = text_ending(path);
    const struct row *row = catalog_find(&table_format_catalog, end);
    row = chosen->count ? chosen->item->row : row;
    *format = row ? format_of_kind(row) : table_csv;
    return row || end.len == 0 || refuse_ending(path, error);
}

/* Fills export->table with what the arguments ask for: columns of runs or of a recording,
 * measurements, events, or a result. Returns false with the error set. */
static bool fill_table(struct session *session, const struct arguments *args, struct export *export,
                       struct error *error)
{
    const struct argument_value *runs = argument_value(args, "run"),
                                *band = argument_value(args, "band"),
                                *table_argument = argument_value(args, "of");
    static const char *const others[] = {"measurements", "events", "table", "data"};
    const struct series_tools *tools;
    for (size_t i = 0; i < COUNT_OF(others) && has_argument(args, "band"); i++)
        if (has_argument(args, others[i]))
            return error_at(error, band->where, "--band works only with columns of a run");
    if (table_argument->count && !has_argument(args, "table"))
        return error_at(error, table_argument->where,
                        "'of' must follow 'table': export FILE table of %s",
                        table_argument->item->row->name);
    if (has_argument(args, "measurements"))
        return export_result(session, catalog_find(&result_catalog, TEXT("measurements")), export,
                             error);
    if (has_argument(args, "events"))
        return export_event_records(session, export, error);
    if (has_argument(args, "table"))
        return table_argument->count
                   ? export_result(session, table_argument->item->row, export, error)
                   : export_latest(session, export, error);
    if (has_argument(args, "data"))
        return (tools = series_tools_for("data", argument_value(args, "data")->where, error)) &&
               tools->table(session, argument_value(args, "COLUMN"), argument_value(args, "every"),
                            export, error);
    return export_runs(session, runs, argument_value(args, "COLUMN"), argument_value(args, "every"),
                       export, error) &&
           (!has_argument(args, "band") ||
            ((tools = series_tools_for("--band", band->where, error)) &&
             tools->export_band(session, runs, band->where, export, error)));
}

/* Replies with the file, its number of rows and its columns: a line and a record. */
void reply_exported(struct reply *reply, struct text file, const struct table *table)
{
    struct buffer path = {0}, *text = reply_buffer(reply);
    safe_text(text, file, false);
    buffer_format(text, ": %zu row%s of ", table->rows, plural_s((int64_t)table->rows));
    for (int i = 0; i < table->columns; i++)
        buffer_format(text, "%s%s", i ? "," : "", table->column[i].name);
    buffer_put(&path, file);
    reply_begin(reply, "export");
    reply_string(reply, "file", buffer_view(&path));
    reply_int(reply, "rows", (int64_t)table->rows);
    reply_array(reply, "columns");
    for (int i = 0; i < table->columns; i++)
        reply_string(reply, NULL, table->column[i].name);
    reply_end(reply);
    buffer_free(&path);
}

/* Replies with each row of the table as a record. Returns false with the error set if it was
 * cancelled. */
static bool reply_rows(struct reply *reply, const struct table *table, struct error *error)
{
    struct table_store *const store = reply->store;
    reply->store = NULL; /* it is in the session already */
    const bool ok = reply_table_rows(reply, "row", table, 0, table->rows, true);
    reply->store = store;
    return ok || error_set(error, ERROR_CANCELLED, "stopped before all rows were written");
}

/* Writes the text in pieces, since a slow terminal takes long, so that Ctrl-C can end it. Returns
 * false with the error set if it was cancelled. */
static bool reply_in_pieces(const struct session *session, struct text text, struct reply *reply,
                            struct error *error)
{
    while (text.len > SHOWN_CHUNK_BYTES) {
        const char *end = memchr(text.data + SHOWN_CHUNK_BYTES, '\n', text.len - SHOWN_CHUNK_BYTES);
        const size_t size = end ? (size_t)(end + 1 - text.data) : text.len;
        if (cancelled(session->front.cancel))
            return error_set(error, ERROR_CANCELLED, "stopped: %zu bytes were left out", text.len);
        reply_data(reply, "export", (struct text){text.data, size});
        text = text_after(text, size);
    }
    reply_data(reply, "export", text);
    return true;
}

/* Writes the scene as a program in another language: the ending of FILE chooses the module and the
 * language. Existing files need --force. Reports file and language in the reply. Returns false with
 * the error set if no module knows the ending, the scene cannot be translated, or writing fails. */
static bool export_scene(struct session *session, const struct arguments *args, struct reply *reply,
                         struct error *error)
{
    const struct text file = argument_value(args, "FILE")->item->text;
    const struct scene_writer *writer = NULL;
    const struct row *kind = NULL;
    char endings[128] = "";
    for (size_t i = 0; module_list[i] && !kind; i++) {
        writer = &module_list[i]->writer;
        if (!writer->kinds)
            continue;
        kind = catalog_find(writer->kinds, text_ending(file));
        snprintf(endings + strlen(endings), sizeof endings - strlen(endings), "%s, and ",
                 writer->endings);
    }
    const char *path = arena_text(args->arena, file);
    struct buffer text = {0};
    if (!kind) {
        char what[32];
        snprintf(what, sizeof what, "export .%.*s", (int)text_ending(file).len,
                 text_ending(file).data);
        if (!module_is_in(what, file, error))
            return false;
        error_at(error, file, "a scene cannot be written as '%s'", what + strlen("export "));
        return error_hint(error, "possible are %s.hk with 'save'", endings);
    }
    const bool ok = (path || error_memory(error)) &&
                    writer->write(session, (size_t)catalog_index(writer->kinds, kind), args->arena,
                                  &text, error) &&
                    file_write(path, buffer_text(&text),
                               session_policy(session, has_argument(args, "force")), error);
    buffer_free(&text);
    if (!ok)
        return false;
    struct buffer *output = reply_buffer(reply);
    safe_text(output, file, false);
    buffer_format(output, ": %s, %s by %s", kind->brief, session->setup.scene.preset->row.name,
                  session->setup.method->row.name);
    reply_begin(reply, "export");
    reply_string(reply, "file", path);
    reply_string(reply, "program", kind->name);
    reply_end(reply);
    return true;
}

/* Writes the coefficients of a method to a file, or to the output if FILE is only the name of a
 * format. Returns false with the error set. */
static bool export_method(struct session *session, const struct arguments *args,
                          struct reply *reply, struct error *error)
{
    const struct text file = argument_value(args, "FILE")->item->text;
    const struct method *method = method_from(argument_value(args, "method")->item->row);
    const bool shown = text_ending(file).len == 0;
    const struct text end = shown ? file : text_ending(file);
    const struct row *format = catalog_find(&table_format_catalog, end);
    const char *path = arena_text(args->arena, file);
    struct export export = {.arena = args->arena};
    struct buffer text = {0};
    if (!text_is(end, "tex") && !format)
        return refuse_ending(file, error);
    if (!coefficients_table(method, args->arena, &export.table))
        return error_at(error, argument_value(args, "method")->where,
                        "%s has no table of coefficients: 'help %s' has its formula",
                        method->row.name, method->row.name);
    if (text_is(end, "tex"))
        coefficients_tex(method, &text);
    else
        table_put(&export.table, format_of_kind(format), &text);
    bool ok = (path && !text.failed) || error_memory(error);
    if (ok && shown)
        reply_data(reply, "export", buffer_text(&text));
    else if (ok)
        ok = file_write(path, buffer_text(&text),
                        session_policy(session, has_argument(args, "force")), error);
    if (ok && !shown)
        reply_exported(reply, file, &export.table);
    buffer_free(&text);
    return ok;
}

/* Writes a table to FILE, or to the output for '-'. */
HANDLER(export)
{
    const struct item *file = argument_value(args, "FILE")->item;
    char *path = arena_text(args->arena, file->text);
    struct export export = {.arena = args->arena};
    table_format *format;
    if (!path)
        return error_memory(error);
    if (has_argument(args, "scene"))
        return export_scene(session, args, reply, error);
    if (has_argument(args, "method"))
        return export_method(session, args, reply, error);
    if (catalog_find(&table_format_catalog, file->text)) {
        error_at(error, file->text, "'%s' is a format; export needs the name of a file", path);
        return error_hint(error, "export run.%s", path);
    }
    if (!choose_format(args, file->text, &format, error))
        return false;
    if (!fill_table(session, args, &export, error))
        return false;
    export.table.cancel = session->front.cancel;
    if (text_is(file->text, "-") && session->front.table)
        return session->front.table(session->front.context, &export.table) || error_memory(error);
    if (text_is(file->text, "-") && reply->format == FORMAT_JSON)
        return reply_rows(reply, &export.table, error);
    if (text_is(file->text, "-")) {
        struct buffer text = {0};
        table_put(&export.table, format, &text);
        bool ok = !text.failed || error_memory(error);
        if (text.len > 0 && text.data[text.len - 1] != '\n')
            buffer_char(&text, '\n');
        if (ok)
            ok = reply_in_pieces(session, buffer_text(&text), reply, error);
        buffer_free(&text);
        return ok;
    }
    const struct write_policy policy = session_policy(session, has_argument(args, "force"));
    if (!table_write(&export.table, format, path, policy, error)) {
        if (!error->where.data)
            error->where = file->text;
        return false;
    }
    reply_exported(reply, file->text, &export.table);
    return true;
}

/* Prints a string, or the value of an expression with its uncertainty and unit. */
HANDLER(print)
{
    UNUSED(error);
    struct item *item = argument_value(args, "EXPR")->item;
    struct named_value named = {.error_floor = 0};
    struct buffer text = {0}, unit = {0};
    if (!item->is_string && expr_dimension(item->expr)->unit)
        dimension_put_unit(expr_dimension(item->expr), &unit);
    /* A single name has an uncertainty, too. */
    if (!item->is_string && peek_name(item->text).len == item->text.len &&
        names_value(session, item->text, &named))
        item->value.uncertainty = named.uncertainty;
    if (item->is_string) {
        safe_text(&text, item->text, true);
    } else if (named.error_floor > 0) {
        buffer_format(&text, "no digit is certain: the error may be %s or more",
                      SHOWN_VALUE(named.error_floor, item->quantity, 2));
    } else {
        buffer_measured(&text, item->value, item->quantity, session->setup.settings.digits);
        if (unit.len > 0 && item->quantity == QUANTITY_OTHER)
            buffer_format(&text, " %s", buffer_view(&unit));
    }
    reply_text(reply, buffer_text(&text));
    reply_begin(reply, "print");
    reply_string(reply, "text", buffer_view(&text));
    reply_real(reply, "value", item->is_string || named.error_floor > 0 ? NAN : item->value.value);
    const char *shown;
    if (!item->is_string && item->quantity != QUANTITY_OTHER)
        shown = quantity_unit(item->quantity);
    else
        shown = unit.len > 0 ? buffer_view(&unit) : NULL;
    reply_string(reply, "unit", shown);
    reply_end(reply);
    buffer_free(&unit);
    buffer_free(&text);
    return true;
}

/* Prints the text; if it is one string, without quotes. */
HANDLER(echo)
{
    const struct argument_value *rest = argument_value(args, "TEXT");
    struct parser parser = {session, args->scope, args->arena,
                            rest->count ? rest->item->text : TEXT("")};
    struct item whole = {0};
    /* A text that is one string is shown without its quotes. */
    const bool quoted = parser.rest.len > 0 && strchr("'\"", parser.rest.data[0]);
    if (quoted && !parse_word(&parser, "", &whole, error))
        return false;
    struct buffer text = {0};
    struct text shown;
    if (quoted && parser.rest.len == 0)
        shown = whole.text;
    else
        shown = rest->count ? rest->item->text : TEXT("");
    safe_text(&text, shown, true);
    reply_text(reply, buffer_text(&text));
    buffer_free(&text);
    return true;
}
#endif

COMMAND(export, .group = "OUTPUT", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("FILE", TYPE_FILE, .flags = ARG_REQUIRED),
                  WORD("run", TYPE_RUN, .flags = ARG_MANY | ARG_ALL, .group = 1),
                  WORD("scene", TYPE_NONE, .group = 1),
                  WORD("method", TYPE_CHOICE, .choices = &method_catalog, .group = 1),
                  WORD("data", TYPE_NONE, .group = 1), WORD("measurements", TYPE_NONE, .group = 1),
                  WORD("table", TYPE_NONE, .group = 1), WORD("events", TYPE_NONE, .group = 1),
                  WORD("of", TYPE_CHOICE, .choices = &result_catalog),
                  PLACE("COLUMN", TYPE_COLUMN, .flags = ARG_MANY),
                  KEY("every", TYPE_VALUE, .quantity = QUANTITY_OTHER), OPTION("force", TYPE_NONE),
                  OPTION("band", TYPE_NONE),
                  OPTION("format", TYPE_CHOICE, .choices = &table_format_catalog)))

COMMAND(print, .group = "OUTPUT", .flags = COMMAND_ANYTIME,
        ARGUMENTS(PLACE("EXPR", TYPE_EXPR, .flags = ARG_REQUIRED)))

COMMAND(echo, .group = "OUTPUT", .flags = COMMAND_ANYTIME, ARGUMENTS(PLACE("TEXT", TYPE_REST)))
