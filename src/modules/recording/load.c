/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command load: recordings, tables of export, scenes; and recordings in replies. */
#ifndef COMMAND_ROWS
#include "modules/recording/recording_text.h"
#include "modules/recording/known/handed_in.h"
#include <hooke/base/file.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/statement.h>
#include <hooke/base/unit.h>
#include <hooke/command/handler.h>

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

/* Sends the description line by line; warnings follow as warnings, not as lines of text. */
void reply_description(const struct recording *recording, struct reply *reply)
{
    struct buffer text = {0};
    recording_describe(recording, &text);
    struct text rest = buffer_text(&text), line;
    while (text_split(&rest, '\n', &line))
        if (line.len > 0 && !text_starts(line, TEXT("warning: ")))
            reply_text(reply, line);
    buffer_free(&text);
    for (int i = 0; i < recording->warnings; i++) {
        struct buffer safe = {0};
        safe_text(&safe, text_of(recording->warning[i]), false);
        reply_warning(reply, "%s", buffer_view(&safe));
        buffer_free(&safe);
    }
}

/* Returns the name of the catalog's row whose letter this is, or NULL. */
static const char *word_of(const struct catalog *catalog, const char *letters, char letter)
{
    const char *cursor = strchr(letters, letter);
    return cursor && letter ? catalog_row(catalog, (size_t)(cursor - letters))->name : NULL;
}

/* Adds name, file, rows, columns, options and warnings as a record. */
void reply_recording(const struct recording *recording, struct reply *reply)
{
    reply_begin(reply, "recording");
    reply_string(reply, "name", recording->name);
    reply_string(reply, "file", recording->path);
    reply_string(reply, "format", recording->format);
    reply_int(reply, "rows", (int64_t)recording->rows);
    reply_int(reply, "dropped", (int64_t)recording->dropped);
    reply_real(reply, "t_start", recording->t[0]);
    reply_real(reply, "t_end", recording->t[recording->rows - 1]);
    reply_real(reply, "dt", recording->dt);
    reply_array(reply, "columns");
    for (int i = 0; i < recording->columns; i++) {
        reply_object(reply, NULL);
        reply_string(reply, "name", recording->column[i].name);
        reply_string(reply, "unit", recording->column[i].unit);
        reply_close(reply);
    }
    reply_close(reply);
    reply_string(reply, "time",
                 recording->time >= 0 ? recording->column[recording->time].name : NULL);
    reply_string(reply, "value", recording->column[recording->value].name);
    reply_int(reply, "header_lines", recording->header_lines);
    reply_string(reply, "separator",
                 word_of(&separator_catalog, separator_letters, recording->separator));
    reply_string(reply, "decimal", word_of(&decimal_catalog, decimal_letters, recording->decimal));
    reply_reals(reply, "window", recording->window, 2, "");
    reply_real(reply, "zero", recording->zero);
    reply_bool(reply, "cleaned", recording->cleaned);
    reply_int(reply, "masked", recording->cleaned ? (int64_t)recording->findings->masked : 0);
    reply_measured(reply, "mass",
                   recording->mass.value > 0 ? recording->mass : (struct measured){NAN, NAN},
                   QUANTITY_MASS);
    reply_string(reply, "velocity", recording->velocity[0] ? recording->velocity : NULL);
    reply_array(reply, "warnings");
    for (int i = 0; i < recording->warnings; i++)
        reply_string(reply, NULL, recording->warning[i]);
    reply_close(reply);
    reply_end(reply);
}

/* Appends the options of `load` with which the file is loaded again in the same way, for a saved
 * session. */
static void put_options(const struct arguments *args, struct buffer *output)
{
    static const char *const keys[] = {"t",    "y",       "run", "unit", "tunit",
                                       "rate", "decimal", "sep", "as"};
    for (size_t i = 0; i < COUNT_OF(keys); i++) {
        const struct argument_value *key = argument_value(args, keys[i]);
        if (key->count == 0)
            continue;
        buffer_format(output, " %s=", keys[i]);
        if (strcmp(keys[i], "rate") == 0)
            buffer_real(output, key->item->value.value);
        else
            buffer_word(output, key->item->text);
    }
}

static const struct unit *unit_of_argument(const struct arguments *args, const char *name)
{
    return has_argument(args, name) ? argument_value(args, name)->item->unit : NULL;
}

static char letter_of_argument(const struct arguments *args, const char *name, const char *letters)
{
    return has_argument(args, name) ? letters[argument_value(args, name)->item->index] : 0;
}

/* Rows of a preview. */
#define PREVIEW_ROWS 5

/* Shows the first rows as they were understood; nothing is kept. */
static void reply_preview(const struct recording *recording, struct arena *arena,
                          struct reply *reply)
{
    const struct column *value = &recording->column[recording->value];
    struct text_table table = {.arena = arena, .columns = 3, .gap = 2, .indent = 2};
    const char *brief = catalog_find(&format_catalog, text_of(recording->format))->brief;
    if (recording->container)
        reply_line(reply, "format %s, from %s: %s", recording->format, recording->container, brief);
    else
        reply_line(reply, "format %s: %s", recording->format, brief);
    cell_text(&table, "line");
    cell_text(&table, "t [s]");
    cell_format(&table, "%s [%s]", value->name,
                value->quantity == QUANTITY_OTHER ? "as in the file"
                                                  : quantity_unit(value->quantity));
    for (size_t i = 0; i < recording->rows && i < PREVIEW_ROWS; i++) {
        cell_count(&table, recording->line[i]);
        cell_text(&table, SHOWN_SHORT(recording->t[i], 9));
        cell_text(&table, SHOWN_SHORT(recording->y[i], 9));
    }
    text_table_put(&table, reply_buffer(reply));
    reply_line(reply, "nothing was loaded; the same command without --preview loads it");
}

/* ---- tables ---- */

#define SHOWN_ROWS 10 /* rows and columns that are shown of a table */
#define SHOWN_COLUMNS 8

/* Returns true if the command has arguments besides the file. */
static bool any_option(const struct arguments *args)
{
    for (int i = 0; i < args->command->arguments; i++)
        if (args->value[i].count > 0 && args->command->argument[i].form != FORM_PLACE)
            return true;
    return false;
}

/* Stops the reading of a file that does not begin as a table of export (the look of a
 * read_watch). */
static bool look_for_table(void *context, struct text content, size_t offset, uintmax_t size,
                           struct error *error)
{
    (void)size;
    bool *is_table = context;
    if (offset == 0)
        *is_table = table_recognise(content);
    return *is_table || error_set(error, ERROR_IO, "no table");
}

/* Returns true if one of the first two columns is t, as in a recording. */
static bool has_times(const struct table *table)
{
    for (int c = 0; c < table->columns && c < 2; c++)
        if (table->column[c].value && text_is(text_of(table->column[c].name), "t"))
            return true;
    return false;
}

/* Reads the file as a table that `export` wrote, and sets *found if it is one; a recording, in
 * which times come first, is not. Returns false with the error if the table is malformed. */
static bool read_table(const char *path, const struct cancel *cancel, struct arena *arena,
                       struct table *table, bool *found, struct error *error)
{
    struct buffer text = {0};
    struct error ignored;
    struct read_watch watch = {.context = found, .look = look_for_table};
    *found = false;
    bool ok = true;
    if (file_read_watched(path, LIMIT_FILE, &watch, &text, &ignored))
        ok = table_parse(buffer_text(&text), cancel, arena, table, error);
    else
        *found = false;
    buffer_free(&text);
    *found = *found && (!ok || !has_times(table));
    return ok;
}

/* Shows the first rows of a loaded table and adds its record. */
static void reply_loaded(const struct table *table, struct text file, struct arena *arena,
                         struct reply *reply)
{
    struct buffer shown = {0};
    struct text_table cells = {.arena = arena, .columns = table->columns, .gap = 2, .indent = 2};
    cells.columns = cells.columns > SHOWN_COLUMNS ? SHOWN_COLUMNS : cells.columns;
    safe_text(&shown, file, false);
    reply_line(
        reply,
        "%s: a table of %zu row%s; 'plot COLUMN against COLUMN of loaded' draws two of its columns",
        buffer_view(&shown), table->rows, table->rows == 1 ? "" : "s");
    table_cells(table, SHOWN_ROWS, &cells);
    text_table_put(&cells, reply_buffer(reply));
    reply_begin(reply, "table");
    reply_string(reply, "file", buffer_view(&shown));
    reply_int(reply, "rows", (int64_t)table->rows);
    reply_array(reply, "columns");
    for (int c = 0; c < table->columns; c++) {
        reply_object(reply, NULL);
        reply_string(reply, "name", table->column[c].name);
        reply_string(reply, "unit", table->column[c].unit);
        reply_close(reply);
    }
    reply_end(reply);
    buffer_free(&shown);
}

/* Loads a table for `plot` and expressions. Sets *found if the file is a table and not a recording.
 * Returns false with the error. */
static bool load_table(const char *path, const struct cancel *cancel, const struct arguments *args,
                       bool *found, struct reply *reply, struct error *error)
{
    struct arena arena = {0};
    struct table table;
    const bool ok = read_table(path, cancel, &arena, &table, found, error);
    if (ok && *found && reply->store) {
        table_store_put(reply->store, "loaded", &arena, &table);
        reply_loaded(&table, argument_value(args, "FILE")->item->text, args->arena, reply);
    }
    arena_reset(&arena);
    return ok;
}

/* Reads the checksum of sum=. Returns false with the error. */
static bool read_sum(struct text text, uint64_t *sum, struct error *error)
{
    *sum = 0;
    for (size_t i = 0; i < text.len; i++) {
        const char *digit = memchr("0123456789abcdef", text.data[i], 16);
        if (!digit || text.len != 16)
            return error_at(error, text, "sum= needs the 16 digits written by 'save'");
        *sum = *sum << 4 | (uint64_t)(digit - "0123456789abcdef");
    }
    return true;
}

/* Finds a recording that has moved, by its checksum `sum` under the same name, beside the command
 * file or in the current folder. Returns it with a note, or NULL with the earlier error and a
 * hint. */
static struct recording *load_moved(const struct arguments *args, const char *path, uint64_t sum,
                                    const struct load_options *options, struct reply *reply,
                                    struct error *error)
{
    const struct text name = text_last_component(text_of(path));
    const char *here = arena_text(args->arena, name),
               *found = here ? script_path(args->where, text_of(here), args->arena) : NULL;
    struct error ignored;
    struct recording *recording = found ? recording_load(found, options, &ignored) : NULL;
    if (recording && recording->sum == sum) {
        reply_note(reply, "%s was not found; the same recording was found as %s", path, found);
        return recording;
    }
    recording_destroy(recording);
    error_hint(error,
               "put the file back there, next to the command file, or in the current folder");
    return NULL;
}

/* Returns true for a file that can be read twice. Pipes cannot, and are read as recordings. */
static bool file_is_regular(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0 && S_ISREG(st.st_mode) && st.st_size > 0 &&
           strcmp(path, STANDARD_INPUT) != 0;
}

bool check_input(const struct session *session, struct text where, struct error *error)
{
    if (session->front.input)
        return true;
    error_at(error, where, "standard input already provides the commands");
    return error_hint(
        error,
        "use -c or a command file, so that standard input is free for data; a file named - is ./-");
}

/* Sets the error of a missing file. Returns false. */
static bool needs_file(const struct arguments *args, struct error *error)
{
    error_at(error, args->word, "load needs a FILE, or 'scene' and a FILE");
    return error_hint(error, "'load disk.txt' reads a recording, 'load scene lorenz.ode' a scene");
}

/* Loads a scene from a file of another program, by the module that reads files with its ending.
 * Returns false with the error. */
static bool load_scene(struct session *session, const struct arguments *args, struct reply *reply,
                       struct error *error)
{
    const struct text file = argument_value(args, "scene")->item->text;
    const struct text ending = text_ending(file);
    const struct scene_reader *other = NULL; /* that would read another ending */
    char what[32];
    for (size_t i = 0; module_list[i]; i++) {
        const struct scene_reader *reader = &module_list[i]->reader;
        if (!reader->ending)
            continue;
        if (text_is(ending, reader->ending))
            return reader->load(session, args, file, argument_text(args, "set"), reply, error);
        other = reader;
    }
    snprintf(what, sizeof what, "load .%.*s", (int)ending.len, ending.data);
    if (!module_is_in(what, file, error))
        return false;
    if (!other)
        return error_at(error, file,
                        "this program was built without a module that reads scenes from files");
    return error_at(error, file, "scenes are read from %s, which end in .%s", other->kind,
                    other->ending);
}

bool recording_list_formats(struct session *session, struct arena *arena, struct reply *reply)
{
    UNUSED(session);
    UNUSED(arena);
    for (size_t i = 0; i < format_catalog.count; i++)
        reply_listed(&format_catalog, catalog_row(&format_catalog, i), reply);
    return true;
}

/* Loads a scene, a table or a recording, or previews a recording. */
HANDLER(load)
{
    const struct argument_value *file = argument_value(args, "FILE"),
                                *scene = argument_value(args, "scene");
    if (scene->count)
        return load_scene(session, args, reply, error);
    if (file->count == 0)
        return needs_file(args, error);
    const struct load_options options = {
        .time = argument_text(args, "t"),
        .value = argument_text(args, "y"),
        .run = argument_text(args, "run"),
        .unit = unit_of_argument(args, "unit"),
        .time_unit = unit_of_argument(args, "tunit"),
        .rate = has_argument(args, "rate") ? argument_value(args, "rate")->item->value.value : 0,
        .decimal = letter_of_argument(args, "decimal", decimal_letters),
        .separator = letter_of_argument(args, "sep", separator_letters),
        .name = argument_text(args, "as"),
        .cancel = session->front.cancel};
    if (options.name.len > 0 &&
        (options.name.len > LIMIT_NAME || peek_name(options.name).len != options.name.len))
        return error_at(
            error, options.name,
            "a name begins with a letter, followed by at most %d letters, digits, _ and -",
            LIMIT_NAME);
    const bool input = text_is(file->item->text, "-");
    if (input && !check_input(session, file->item->text, error))
        return false;
    char *path = input ? arena_text(args->arena, TEXT(STANDARD_INPUT))
                       : script_path(args->where, file->item->text, args->arena);
    bool found = false;
    if (path && !any_option(args) && file_is_regular(path)) {
        const bool ok = load_table(path, options.cancel, args, &found, reply, error);
        if (!ok)
            error->where = file->item->text;
        if (!ok || found)
            return ok;
    }
    uint64_t sum = 0;
    if (has_argument(args, "sum") && !read_sum(argument_text(args, "sum"), &sum, error))
        return false;
    struct recording *recording = path ? recording_load(path, &options, error) : NULL;
    if (!recording && path && sum != 0 && error->code == ERROR_IO)
        recording = load_moved(args, path, sum, &options, reply, error);
    if (path && session->options.checking && (recording || error->code == ERROR_IO))
        recording = recording_checked(session->options.checking, path, &options, recording);
    if (!recording) {
        if (!path)
            return error_memory(error);
        if (!error->where.data)
            error->where = file->item->text;
        return false;
    }
    if (has_argument(args, "preview")) {
        reply_description(recording, reply);
        reply_preview(recording, args->arena, reply);
        reply_recording(recording, reply);
        recording_destroy(recording);
        return true;
    }
    struct buffer saved = {0};
    put_options(args, &saved);
    const int same = session_find_recording(session, text_of(recording->name));
    if (same >= 0)
        session_drop_recording(session, same);
    const bool ok = session_add_recording(session, recording, buffer_view(&saved), error);
    buffer_free(&saved);
    if (!ok)
        return false;
    reply_description(recording, reply);
    if (sum != 0 && sum != recording->sum)
        reply_warning(reply, "%s has changed since the session was saved", recording->name);
    reply_recording(recording, reply);
    return true;
}
#endif

COMMAND(load, .group = "DATA", .flags = COMMAND_CHANGES,
        ARGUMENTS(PLACE("FILE", TYPE_FILE, .group = 1), WORD("scene", TYPE_SCENE_FILE, .group = 1),
                  KEY("set", TYPE_TEXT), KEY("t", TYPE_TEXT), KEY("y", TYPE_TEXT),
                  KEY("run", TYPE_TEXT), KEY("unit", TYPE_UNIT),
                  KEY("tunit", TYPE_UNIT, .quantity = QUANTITY_TIME),
                  KEY("rate", TYPE_VALUE, .quantity = QUANTITY_FREQUENCY),
                  KEY("decimal", TYPE_CHOICE, .choices = &decimal_catalog),
                  KEY("sep", TYPE_CHOICE, .choices = &separator_catalog), KEY("as", TYPE_TEXT),
                  KEY("sum", TYPE_TEXT), OPTION("preview", TYPE_NONE)))
