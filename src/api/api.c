/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sessions inside other programs, by the functions of hooke/api.h. Each struct hooke owns a
 * session, and keeps output, messages and the last error of the latest call. */
#include <hooke/base/cancel.h>
#include <hooke/api.h>
#include <hooke/session/log.h>
#include <hooke/report.h>
#include <hooke/session/names.h>
#include <hooke/view.h>

#include <stdlib.h>
#include <string.h>

/* A column of an exported table, copied into the arena of the table. */
struct taken_column {
    char *name, *unit;
    double *value; /* [rows], or NULL if the column has texts */
    char **text;   /* [rows], or NULL if the column has values */
};

/* A table that hooke_table() returns; the arena owns its columns. */
struct hooke_table {
    struct arena arena;
    size_t rows, columns;
    struct taken_column *column;
};

/* A session with what the last call printed. */
struct hooke {
    struct session *session;
    struct cancel cancel;
    struct reply reply;
    struct buffer output, messages;
    bool has_error;
    struct hooke_error error;
    struct error last_error; /* message and position that the error points to */
    struct buffer file;      /* name of the file with the error; error.file points into it */
    /* Receives the table of `export -`; NULL if it goes to the output. */
    struct hooke_table *table;
};

/* Source name of lines that the program passes, to tell them from lines of files. */
static const char line_source[] = "hooke_run";

const char *hooke_version(void)
{
    return HOOKE_VERSION;
}

/* ---- output, messages and errors ---- */

/* Sink of the reply for output. Returns false if memory ran out. */
static bool take_output(void *context, struct text text)
{
    struct hooke *hooke = context;
    buffer_put(&hooke->output, text);
    return !hooke->output.failed;
}

/* Sink of the reply for messages. Returns false if memory ran out. */
static bool take_message(void *context, struct text text)
{
    struct hooke *hooke = context;
    buffer_put(&hooke->messages, text);
    return !hooke->messages.failed;
}

/* Stores an error of the reply for hooke_error(), with a copy of message, hint and file name, since
 * those of the caller do not last. `where` is the file and line of the statement, or NULL; lines
 * given to hooke_run() have line_source for a file and leave hooke->error.file NULL. `column`
 * counts from 1. */
static void take_error(void *context, const struct error *error, const struct source *where,
                       size_t column)
{
    struct hooke *hooke = context;
    hooke->has_error = true;
    hooke->last_error = *error;
    hooke->last_error.where = (struct text){NULL, 0};
    buffer_clear(&hooke->file);
    if (where && where->name && where->name != line_source)
        buffer_put(&hooke->file, text_of(where->name));
    hooke->error = (struct hooke_error){
        .status = (int)error->code,
        .code = error_name(error->code),
        .message = hooke->last_error.text,
        .hint = hooke->last_error.hint,
    };
    if (where) {
        hooke->error.line = where->line;
        hooke->error.column = (int)column;
    }
    if (hooke->file.len > 0)
        hooke->error.file = buffer_view(&hooke->file);
}

/* Clears output, messages, error, status and cancellation before the next call. */
static void clear_reply(struct hooke *hooke)
{
    buffer_clear(&hooke->output);
    buffer_clear(&hooke->messages);
    hooke->output.failed = hooke->messages.failed = hooke->reply.failed = false;
    hooke->has_error = false;
    hooke->session->execution.status = 0;
    hooke->session->execution.quit = false;
    atomic_store(&hooke->cancel.requested, 0);
}

const char *hooke_output(const struct hooke *hooke)
{
    return hooke ? buffer_view(&hooke->output) : "";
}

const char *hooke_messages(const struct hooke *hooke)
{
    return hooke ? buffer_view(&hooke->messages) : "";
}

/* Returns the error of the last call, or NULL; without a session, that memory ran out. */
const struct hooke_error *hooke_error(const struct hooke *hooke)
{
    static const struct hooke_error memory = {
        .status = ERROR_COMMAND, .code = "command", .message = "out of memory", .hint = ""};
    if (!hooke)
        return &memory;
    return hooke->has_error ? &hooke->error : NULL;
}

/* ---- tables ---- */

/* Copies the texts of a column; a missing text stays NULL. Returns false if out of memory. */
static bool copy_texts(struct hooke_table *table, const struct table_column *source,
                       struct taken_column *target)
{
    target->text = arena_array(&table->arena, table->rows + 1, sizeof *target->text);
    for (size_t i = 0; i < table->rows && target->text; i++)
        if (source->text[i] &&
            !(target->text[i] = arena_text(&table->arena, text_of(source->text[i]))))
            return false;
    return target->text != NULL;
}

/* Copies name, unit and values or texts of a column. Returns false if out of memory. */
static bool copy_column(struct hooke_table *table, const struct table_column *source,
                        struct taken_column *target)
{
    target->name = arena_text(&table->arena, text_of(source->name));
    target->unit = arena_text(&table->arena, text_of(source->unit ? source->unit : ""));
    if (!target->name || !target->unit || !source->value)
        return target->name && target->unit && copy_texts(table, source, target);
    target->value = arena_array(&table->arena, table->rows + 1, sizeof *target->value);
    if (target->value && table->rows > 0)
        memcpy(target->value, source->value, table->rows * sizeof *target->value);
    return target->value != NULL;
}

/* Receives the table of `export -` and copies it into hooke->table. Returns false if nobody asked
 * for a table or memory runs out. */
static bool take_table(void *context, const struct table *source)
{
    struct hooke_table *table = ((struct hooke *)context)->table;
    if (!table)
        return false;
    table->rows = source->rows;
    table->column = arena_array(&table->arena, (size_t)source->columns + 1, sizeof *table->column);
    for (int i = 0; i < source->columns && table->column; i++) {
        if (!copy_column(table, &source->column[i], &table->column[i]))
            return false;
        table->columns++;
    }
    return table->column != NULL;
}

void hooke_table_free(struct hooke_table *table)
{
    if (!table)
        return;
    arena_reset(&table->arena);
    free(table);
}

size_t hooke_rows(const struct hooke_table *table)
{
    return table ? table->rows : 0;
}

size_t hooke_columns(const struct hooke_table *table)
{
    return table ? table->columns : 0;
}

const char *hooke_column_name(const struct hooke_table *table, size_t index)
{
    return index < hooke_columns(table) ? table->column[index].name : NULL;
}

const char *hooke_column_unit(const struct hooke_table *table, size_t index)
{
    return index < hooke_columns(table) ? table->column[index].unit : NULL;
}

/* Returns the column of that name, or NULL. */
static const struct taken_column *taken_column_find(const struct hooke_table *table,
                                                    const char *name)
{
    for (size_t i = 0; i < hooke_columns(table) && name; i++)
        if (strcmp(table->column[i].name, name) == 0)
            return &table->column[i];
    return NULL;
}

const double *hooke_column(const struct hooke_table *table, const char *name)
{
    const struct taken_column *column = taken_column_find(table, name);
    return column ? column->value : NULL;
}

const char *hooke_text(const struct hooke_table *table, const char *name, size_t row)
{
    const struct taken_column *column = taken_column_find(table, name);
    return column && column->text && row < table->rows ? column->text[row] : NULL;
}

/* ---- sessions ---- */

/* Creates a session whose output, messages and errors are kept in the struct. Returns NULL if out
 * of memory. */
struct hooke *hooke_open(unsigned flags)
{
    struct hooke *hooke = calloc(1, sizeof *hooke);
    if (!hooke)
        return NULL;
    struct front front = {.cancel = &hooke->cancel, .context = hooke};
    screenshot_offer(&front);
    reply_init(&hooke->reply, (struct sink){take_output, take_message, hooke});
    hooke->reply.error = take_error;
    hooke->session = session_create(&front);
    if (!hooke->session) {
        hooke_close(hooke);
        return NULL;
    }
    hooke->session->options.safe = (flags & HOOKE_SAFE) != 0;
    return hooke;
}

void hooke_close(struct hooke *hooke)
{
    struct error ignored;
    if (!hooke)
        return;
    if (hooke->session)
        record_close(hooke->session, &ignored);
    session_destroy(hooke->session);
    reply_free(&hooke->reply);
    buffer_free(&hooke->output);
    buffer_free(&hooke->messages);
    buffer_free(&hooke->file);
    free(hooke);
}

/* Executes lines as a script. Returns the exit status, 0 if all succeeded. */
int hooke_run(struct hooke *hooke, const char *lines)
{
    struct text rest = text_of(lines ? lines : ""), line;
    struct script script;
    struct error error;
    if (!hooke)
        return ERROR_COMMAND;
    clear_reply(hooke);
    script_begin(&script, hooke->session, line_source, NULL);
    while (text_split(&rest, '\n', &line) &&
           script_feed(&script, hooke->session, line, &hooke->reply))
        ;
    script_end(&script, hooke->session, &hooke->reply);
    if (!hooke->has_error && (hooke->output.failed || hooke->messages.failed)) {
        error_memory(&error);
        take_error(hooke, &error, NULL, 0);
        hooke->session->execution.status = (int)error.code;
    }
    return hooke->session->execution.status;
}

void hooke_cancel(struct hooke *hooke)
{
    if (hooke)
        atomic_store(&hooke->cancel.requested, 1);
}

/* Sets value and uncertainty [SI] of a name of expressions. Returns 0 if it has no value at
 * present. */
int hooke_value(const struct hooke *hooke, const char *name, double *value, double *uncertainty)
{
    struct named_value named = {.error_floor = 0};
    if (!hooke || !name || !names_value(hooke->session, text_of(name), &named) ||
        isnan(named.value))
        return 0;
    if (value)
        *value = named.value;
    if (uncertainty)
        *uncertainty = named.uncertainty;
    return 1;
}

/* Returns the name of result number index among those that exist at present, or NULL. */
const char *hooke_result(const struct hooke *hooke, size_t index)
{
    for (size_t i = 0; i < result_catalog.count && hooke; i++) {
        const struct row *row = catalog_row(&result_catalog, i);
        if (result_is_kept(hooke->session, row) && index-- == 0)
            return row->name;
    }
    return NULL;
}

/* Returns the table that `export - WHAT` gives, which the caller frees, or NULL after an error.
 * Characters that would begin another statement are refused. */
struct hooke_table *hooke_table(struct hooke *hooke, const char *what)
{
    struct buffer line = {0};
    struct error error = {0};
    if (!hooke)
        return NULL;
    clear_reply(hooke);
    if (what && strpbrk(what, ";>\n\r#\\")) {
        error_set(&error, ERROR_USAGE,
                  "give the words that follow 'export FILE', such as: t y energy");
        take_error(hooke, &error, NULL, 0);
        return NULL;
    }
    buffer_format(&line, "export - %s", what ? what : "");
    hooke->table = calloc(1, sizeof *hooke->table);
    if (line.failed || !hooke->table) {
        error_memory(&error);
        take_error(hooke, &error, NULL, 0);
    } else {
        hooke->session->front.table = take_table;
        command_exec(hooke->session, buffer_text(&line), NULL, &hooke->reply);
        hooke->session->front.table = NULL;
    }
    struct hooke_table *table = hooke->table;
    hooke->table = NULL;
    buffer_free(&line);
    if (!hooke->has_error)
        return table;
    hooke_table_free(table);
    return NULL;
}
