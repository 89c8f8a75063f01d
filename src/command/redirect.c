/* SPDX-License-Identifier: GPL-3.0-or-later */
/* STATEMENT > FILE: reads the file name off the end of a statement, and writes the statement's
 * result to it. */
#include <hooke/base/file.h>
#include <hooke/base/statement.h>
#include <hooke/module.h>
#include <hooke/plot.h>
#include <hooke/report.h>
#include "command/redirect.h"

#include <stdio.h>
#include <string.h>

/* Returns the text behind the last > outside of quotes, or {NULL, 0} if there is none. */
static struct text text_behind_greater(struct text statement)
{
    struct text found = {NULL, 0};
    char quote = 0;
    for (size_t i = 0; i < statement.len; i++) {
        const char c = statement.data[i];
        if (quote)
            quote = c == quote ? 0 : quote;
        else if (c == '\'' || c == '"')
            quote = c;
        else if (c == '>')
            found = text_after(statement, i + 1);
    }
    return found;
}

/* Sets an error with the possible endings of tables, or the module that is missing. Returns
 * false. */
bool refuse_ending(struct text file, struct error *error)
{
    struct buffer list = {0};
    char what[32];
    snprintf(what, sizeof what, "export .%.*s", (int)text_ending(file).len, text_ending(file).data);
    if (!module_is_in(what, file, error))
        return false;
    for (size_t i = 0; i < table_format_catalog.count; i++)
        buffer_format(&list, "%s.%s", i ? " " : "", catalog_row(&table_format_catalog, i)->name);
    error_at(error, file, "a table goes to a file that ends in one of %s", buffer_view(&list));
    buffer_free(&list);
    return false;
}

/* Returns the row of the catalog that the ending of the file names, or NULL. */
static const struct row *ending_row(const struct catalog *catalog, struct text file)
{
    size_t dot = file.len;
    while (dot > 0 && file.data[dot - 1] != '.' && file.data[dot - 1] != '/')
        dot--;
    if (dot < 2 || file.data[dot - 1] != '.')
        return NULL;
    return catalog_find(catalog, text_after(file, dot));
}

/* Returns the name of the plot that shows the result of the command, or NULL if there is none. */
static const char *plot_of_command(const struct command *command)
{
    for (size_t i = 0; i < plot_catalog.count; i++) {
        const struct plot_row *row = plot_row((enum plot_kind)i);
        if (strcmp(row->command ? row->command : row->row.name, command->row.name) == 0)
            return row->row.name;
    }
    return NULL;
}

/* Chooses a table format or a plot by the ending of the file. Returns false for other endings. */
static bool choose_content(const struct command *command, struct redirect *redirect)
{
    const struct row *format = ending_row(&table_format_catalog, redirect->file);
    const struct picture_writer *writer = module_pictures();
    if (format)
        redirect->format = format_of_kind(format);
    else if (writer && ending_row(writer->kinds, redirect->file))
        redirect->plot = plot_of_command(command);
    return format || redirect->plot;
}

/* Parses `rest`, the text behind the sign >, into redirect->file (a word, or anything in quotes)
 * and redirect->force. Nothing is opened. Returns false unless it is a name and at most --force. */
static bool parse_file(struct text rest, struct redirect *redirect)
{
    rest = text_trim(rest);
    struct text file = peek_word(rest, "");
    const char quote = rest.len > 1 && strchr("'\"", rest.data[0]) ? rest.data[0] : 0;
    const char *end = quote ? memchr(rest.data + 1, quote, rest.len - 1) : NULL;
    if (end)
        file = (struct text){rest.data, (size_t)(end - rest.data) + 1};
    const struct text left = text_trim((struct text){file.data + file.len, rest.len - file.len});
    redirect->force = text_is(left, "--force");
    redirect->file = end ? (struct text){file.data + 1, file.len - 2} : file;
    return redirect->file.len > 0 && (left.len == 0 || redirect->force);
}

/* Shortens the statement by "> FILE" if the ending of the file names a table format or a picture;
 * otherwise leaves it unchanged and redirect->file empty. */
void redirect_take(const struct command *command, struct text *statement, struct redirect *redirect)
{
    const struct text rest = text_behind_greater(*statement);
    *redirect = (struct redirect){.file = {NULL, 0}};
    if (!(command->flags & COMMAND_TABLES) || !rest.data || !parse_file(rest, redirect)) {
        redirect->file = (struct text){NULL, 0};
        return;
    }
    if (!choose_content(command, redirect)) {
        redirect->file = (struct text){NULL, 0};
        return;
    }
    statement->len = (size_t)(rest.data - 1 - statement->data);
}

/* Replaces the error by one that lists the possible endings of files, if it is at or behind a sign
 * > whose file has another ending: redirect_take() leaves such a file in the statement, which then
 * cannot be read. */
void redirect_explain(const struct command *command, struct text statement, struct error *error)
{
    const struct text rest = text_behind_greater(statement);
    struct redirect redirect;
    if (!(command->flags & COMMAND_TABLES) || !rest.data || !parse_file(rest, &redirect) ||
        !(error->where.data >= rest.data - 1 &&
          error->where.data <= statement.data + statement.len))
        return;
    *error = (struct error){.code = ERROR_NONE};
    refuse_ending(redirect.file, error);
    if (plot_of_command(command) && module_pictures())
        error_hint(error, "%s .. > FILE.csv; a picture of it goes to %s", command->row.name,
                   module_pictures()->files);
    else
        error_hint(error, "%s .. > FILE.csv; 'plot COLUMN against COLUMN of %s' draws its columns",
                   command->row.name, command->row.name);
}

/* Opens the file before anything is computed. Returns false with the error set. */
bool redirect_open(const struct session *session, struct redirect *redirect, struct arena *arena,
                   struct error *error)
{
    const char *path = arena_text(arena, redirect->file);
    if (!path)
        return error_memory(error);
    if (writer_open(&redirect->writer, path, session_policy(session, redirect->force), error))
        return true;
    error->where = redirect->file;
    return false;
}

void redirect_put_plot(const struct redirect *redirect, struct buffer *statement)
{
    const char *quote = memchr(redirect->file.data, '\'', redirect->file.len) ? "\"" : "'";
    buffer_format(statement, "plot %s > %s%.*s%s%s", redirect->plot, quote, (int)redirect->file.len,
                  redirect->file.data, quote, redirect->force ? " --force" : "");
}

/* Writes the result as a table, or abandons the file. Returns false with the error set. */
bool redirect_finish(struct session *session, struct redirect *redirect,
                     const struct row *table_row, struct reply *reply, struct error *error)
{
    struct arena arena = {0};
    struct export export = {.arena = &arena};
    bool ok = table_row ? export_result(session, table_row, &export, error)
                        : error_at(error, redirect->file, "this command produced no table");
    export.table.cancel = session->front.cancel;
    if (ok)
        ok = table_send(&export.table, redirect->format, &redirect->writer, error);
    else
        writer_abandon(&redirect->writer);
    if (ok)
        reply_exported(reply, redirect->file, &export.table);
    else if (!error->where.data)
        error->where = redirect->file;
    arena_reset(&arena);
    return ok;
}
