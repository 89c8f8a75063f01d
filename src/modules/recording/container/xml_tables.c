/* SPDX-License-Identifier: GPL-3.0-or-later */
/* XML documents of instruments as tables of text: Logger Pro's .cmbl (DataSet with DataColumns that
 * have a name, a unit and a block of numbers, one a line, Z for a missing one) and CASSY Lab 2's
 * .labx (channels with quantity, symbol, unit and a list of values). Each set of columns becomes a
 * part. */
#include "modules/recording/container/container.h"

#include "modules/recording/table/table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    /* Columns of a data set at most. */
    COLUMNS_MAX = 256,
    /* Elements before the first one of a table; an instrument has a few hundred. */
    STRANGE_MAX = 20000
};

/* A column that is being read. */
struct xml_column {
    struct buffer name, unit, cells; /* cells has one cell a line */
};

/* A document that is being read, the context of the handlers. */
struct tables {
    struct contents *contents;
    struct error *error;
    const char *shown;
    bool known;            /* the document is of one of the two programs */
    bool cassy;            /* it is CASSY Lab's */
    int strange;           /* elements so far that belong to neither */
    struct buffer *target; /* receives the text of the current element, or NULL */
    struct buffer set;     /* name of the current data set */
    struct xml_column *column;
    size_t columns;
    int sets; /* data sets so far, for their names */
};

/* Returns true if the name is one of the blank-separated names. */
static bool is_one_of(const char *name, const char *names)
{
    struct text rest = text_of(names), one;
    while (text_split(&rest, ' ', &one))
        if (strlen(name) == one.len && memcmp(name, one.data, one.len) == 0)
            return true;
    return false;
}

/* Empties the current data set. */
static void clear_columns(struct tables *tables)
{
    for (size_t i = 0; i < tables->columns; i++) {
        buffer_free(&tables->column[i].name);
        buffer_free(&tables->column[i].unit);
        buffer_free(&tables->column[i].cells);
    }
    tables->columns = 0;
    buffer_clear(&tables->set);
}

/* Returns the column that is being read, or NULL. */
static struct xml_column *newest_column(struct tables *tables)
{
    return tables->columns > 0 ? &tables->column[tables->columns - 1] : NULL;
}

/* Returns the buffer for the text within an element of that name, or NULL if the element is not
 * used. Names differ between CASSY Lab and Logger Pro. */
static struct buffer *target_of(struct tables *tables, const char *name)
{
    struct xml_column *column = newest_column(tables);
    if (strcmp(name, "DataSetName") == 0)
        return &tables->set;
    if (!column)
        return NULL;
    if (is_one_of(name, tables->cassy ? "quantity" : "DataObjectName"))
        return &column->name;
    if (is_one_of(name, tables->cassy ? "unit" : "ColumnUnits"))
        return &column->unit;
    if (is_one_of(name, tables->cassy ? "value" : "ColumnCells"))
        return &column->cells;
    return NULL;
}

/* Sets the error of a document of neither program. Returns false. */
static bool refuse_strange(const struct tables *tables)
{
    error_set(tables->error, ERROR_IO,
              "%s is an XML document, but neither Logger Pro's (.cmbl) nor CASSY Lab's (.labx)",
              tables->shown);
    return error_hint(tables->error, "open it in the program that made it and export it as CSV");
}

/* Handles the start of an element: begins a data set or a column, and directs the text that follows
 * to its buffer. `context` is the struct tables. Returns false with the error for documents of
 * other programs. */
static bool element_start(void *context, const char *name, const char **attributes)
{
    struct tables *tables = context;
    (void)attributes;
    tables->cassy |= strcmp(name, "cassylab") == 0;
    tables->known |= is_one_of(name, "cassylab DataSet");
    if (!tables->known && ++tables->strange > STRANGE_MAX)
        return refuse_strange(tables);
    if (is_one_of(name, tables->cassy ? "channels" : "DataSet"))
        clear_columns(tables);
    if (is_one_of(name, tables->cassy ? "channel" : "DataColumn")) {
        if (tables->columns == COLUMNS_MAX)
            return error_set(tables->error, ERROR_IO, "%s has more than %d columns in a data set",
                             tables->shown, COLUMNS_MAX);
        tables->column[tables->columns++] = (struct xml_column){0};
    }
    struct buffer *target = target_of(tables, name);
    tables->target = target ? target : tables->target;
    return true;
}

/* Appends the columns side by side, up to the length of the longest. Returns false with the
 * error. */
static bool write_rows(struct tables *tables, struct buffer *output)
{
    struct text rest[COLUMNS_MAX], cell;
    bool more = true;
    for (size_t i = 0; i < tables->columns; i++)
        rest[i] = buffer_text(&tables->column[i].cells);
    for (size_t row = 1; more && !output->failed; row++) {
        if (row % LOOK_EACH_ROWS == 0 &&
            !unpacking_goes_on(tables->contents->cancel, tables->error))
            return false;
        const size_t old_len = output->len;
        more = false;
        for (size_t i = 0; i < tables->columns; i++) {
            buffer_put(output, i > 0 ? TEXT("\t") : TEXT(""));
            bool found = false;
            while (!found && text_split(&rest[i], '\n', &cell))
                found = text_trim(cell).len > 0;
            more |= found;
            if (found && !text_is(text_trim(cell), "Z"))
                put_cell(output, cell);
        }
        buffer_char(output, '\n');
        if (!more && !output->failed) {
            output->len = old_len;
            output->data[old_len] = '\0';
        }
    }
    return !output->failed || error_memory(tables->error);
}

/* Adds the current data set as a part, with a line of names and units, unless it is empty. Returns
 * false with the error. */
static bool finish_set(struct tables *tables)
{
    char name[32];
    size_t filled = 0;
    for (size_t i = 0; i < tables->columns; i++)
        filled += tables->column[i].cells.len > 0;
    if (filled == 0)
        return true;
    snprintf(name, sizeof name, "set %d", ++tables->sets);
    struct text set_name = text_trim(buffer_text(&tables->set));
    struct container_part *part =
        contents_add(tables->contents, set_name.len > 0 ? set_name : text_of(name));
    if (!part)
        return tables->contents->parts == PARTS_MAX || error_memory(tables->error);
    for (size_t i = 0; i < tables->columns; i++) {
        const struct text unit = text_trim(buffer_text(&tables->column[i].unit));
        buffer_put(&part->text, i > 0 ? TEXT("\t") : TEXT(""));
        put_cell(&part->text, buffer_text(&tables->column[i].name));
        if (unit.len > 0) {
            buffer_put(&part->text, TEXT(" ("));
            put_cell(&part->text, unit);
            buffer_char(&part->text, ')');
        }
    }
    buffer_char(&part->text, '\n');
    return write_rows(tables, &part->text);
}

/* Handles the end of an element; each <value> of CASSY becomes a line. */
static bool element_end(void *context, const char *name)
{
    struct tables *tables = context;
    if (tables->target && strcmp(name, "value") == 0)
        buffer_char(tables->target, '\n');
    tables->target = NULL;
    return !is_one_of(name, tables->cassy ? "channels" : "DataSet") || finish_set(tables);
}

/* Handles text: appends it to the current target. */
static bool element_text(void *context, struct text text)
{
    struct tables *tables = context;
    if (tables->target)
        buffer_put(tables->target, text);
    return !tables->target || !tables->target->failed || error_memory(tables->error);
}

/* Parses an XML document of CASSY Lab or Logger Pro and adds its data sets as parts; refuses
 * documents of other programs. Returns false with the error. */
bool xml_tables(struct text document, const char *shown, struct contents *contents,
                struct error *error)
{
    struct tables tables = {.contents = contents, .error = error, .shown = shown};
    const struct xml_reader reader = {&tables, contents->cancel, element_start, element_end,
                                      element_text};
    tables.column = calloc(COLUMNS_MAX, sizeof *tables.column);
    bool done = tables.column ? xml_read(document, shown, &reader, error) : error_memory(error);
    contents->container = tables.cassy ? "labx" : "cmbl";
    if (done && !tables.known) {
        done = refuse_strange(&tables);
    } else if (done && contents->parts == 0) {
        done = error_set(error, ERROR_IO, "%s has no columns of numbers", shown);
    }
    clear_columns(&tables);
    buffer_free(&tables.set);
    free(tables.column);
    return done;
}
