/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes tables to files: CSV and TSV with "# key = value" lines and a header with units, JSON as
 * one object. The text is passed on in chunks, so that a large table needs no memory for itself. */
#include <hooke/base/file.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/result/outlet.h>

#include <math.h>
#include <string.h>

/* Passes the text on to the file, if there is one, once it is longer than `max` bytes. */
void outlet_pass(struct outlet *sink, size_t max)
{
    if (!sink->writer || sink->text->len <= max || sink->text->failed)
        return;
    writer_put(sink->writer, buffer_text(sink->text));
    buffer_clear(sink->text);
}

/* ---- CSV, TSV ---- */

/* Returns true if a spreadsheet would run the cell as a formula, also after leading apostrophes. */
bool cell_is_formula(struct text cell)
{
    size_t position = 0;
    while (position < cell.len && cell.data[position] == '\'')
        position++;
    return position < cell.len && memchr("=+-@\t\r", cell.data[position], 6);
}

/* Appends a cell, in quotes if asked for or if it contains the separator, quotes or line ends. */
void buffer_cell(struct buffer *output, struct text cell, char separator, bool quoted)
{
    for (size_t i = 0; i < cell.len && !quoted; i++)
        quoted = cell.data[i] == separator || strchr("\"\r\n", cell.data[i]);
    if (!quoted) {
        buffer_put(output, cell);
        return;
    }
    buffer_char(output, '"');
    for (size_t i = 0; i < cell.len; i++)
        buffer_put(output, cell.data[i] == '"' ? TEXT("\"\"") : (struct text){cell.data + i, 1});
    buffer_char(output, '"');
}

/* Appends a text cell. Texts that look like numbers are quoted, so that they are read back as
 * texts; formulas get an apostrophe in front, so that no spreadsheet runs them. */
static void put_text_cell(struct buffer *output, struct text cell, char separator)
{
    struct buffer guarded = {0};
    double number;
    const bool is_formula = cell_is_formula(cell),
               is_number = cell.len > 0 &&
                           (text_is(cell, "inf") || real_parse(cell, &number) != REAL_MALFORMED);
    if (is_formula)
        buffer_format(&guarded, "'%.*s", (int)cell.len, cell.data);
    buffer_cell(output, is_formula ? buffer_text(&guarded) : cell, separator,
                is_formula || is_number);
    output->failed |= guarded.failed;
    buffer_free(&guarded);
}

/* Appends the heading of a column, "NAME [UNIT]". */
static void put_column_heading(struct buffer *output, const struct table_column *column,
                               char separator)
{
    struct buffer name = {0};
    safe_text(&name, text_of(column->name), false);
    if (column->unit && column->unit[0]) {
        buffer_put(&name, TEXT(" ["));
        safe_text(&name, text_of(column->unit), false);
        buffer_char(&name, ']');
    }
    put_text_cell(output, buffer_text(&name), separator);
    output->failed |= name.failed;
    buffer_free(&name);
}

/* Writes a table as CSV or TSV: lines of keys, the header, the rows. An unknown number (NAN) is an
 * empty cell. */
static void put_separated(const struct table *table, char separator, struct outlet *sink)
{
    struct buffer *output = sink->text;
    for (int i = 0; i < table->keys; i++) {
        buffer_put(output, TEXT("# "));
        safe_text(output, text_of(table->key[i].key), false);
        buffer_put(output, TEXT(" = "));
        safe_text(output, text_of(table->key[i].value), false);
        buffer_char(output, '\n');
    }
    for (int i = 0; i < table->columns; i++) {
        if (i > 0)
            buffer_char(output, separator);
        put_column_heading(output, &table->column[i], separator);
    }
    buffer_char(output, '\n');
    for (size_t row = 0; row < table->rows && outlet_goes_on(sink, table, row); row++) {
        for (int i = 0; i < table->columns; i++) {
            const struct table_column *column = &table->column[i];
            if (i > 0)
                buffer_char(output, separator);
            if (!column->value)
                put_text_cell(output, text_of(column->text[row]), separator);
            else if (!isnan(column->value[row]))
                buffer_real(output, column->value[row]);
        }
        buffer_char(output, '\n');
        outlet_pass(sink, OUTLET_CHUNK);
    }
}

/* ---- JSON ---- */

/* Appends a text as a JSON string. Invisible and control characters are escaped. */
void buffer_json_text(struct buffer *output, struct text text)
{
    static const char escaped[] = "\"\\\b\f\n\r\t", letters[] = "\"\\bfnrt";
    buffer_char(output, '"');
    for (size_t used; text.len > 0; text.data += used, text.len -= used) {
        for (used = 0; used < text.len && text.data[used] >= ' ' && text.data[used] < 0x7F &&
                       text.data[used] != '"' && text.data[used] != '\\';)
            used++;
        if (used > 0) {
            buffer_put(output, (struct text){text.data, used});
            continue;
        }
        const uint32_t codepoint = text_codepoint(text, &used);
        const char *special =
            codepoint < 0x80 && codepoint > 0 ? strchr(escaped, (char)codepoint) : NULL;
        if (special)
            buffer_format(output, "\\%c", letters[special - escaped]);
        else if (codepoint > 0xFFFF && codepoint_hidden(codepoint)) /* a pair of surrogates */
            buffer_format(output, "\\u%04x\\u%04x", (unsigned)(0xD7C0 + (codepoint >> 10)),
                          (unsigned)(0xDC00 + (codepoint & 0x3FF)));
        else if (codepoint < 0x20 || codepoint == 0x7F || codepoint_hidden(codepoint))
            buffer_format(output, "\\u%04x", (unsigned)codepoint);
        else
            buffer_codepoint(output, codepoint);
    }
    buffer_char(output, '"');
}

void buffer_json_real(struct buffer *output, double value)
{
    if (isfinite(value))
        buffer_real(output, value);
    else
        buffer_put(output, TEXT("null"));
}

/* Writes a table as one JSON object with its keys and columns; an unknown number is null. */
void table_json(const struct table *table, struct outlet *sink)
{
    struct buffer *output = sink->text;
    buffer_put(output, TEXT("{\"keys\":{"));
    for (int i = 0; i < table->keys; i++) {
        buffer_put(output, i ? TEXT(",") : TEXT(""));
        buffer_json_text(output, text_of(table->key[i].key));
        buffer_char(output, ':');
        buffer_json_text(output, text_of(table->key[i].value));
    }
    buffer_put(output, TEXT("},\"columns\":["));
    for (int i = 0; i < table->columns; i++) {
        const struct table_column *column = &table->column[i];
        buffer_put(output, i ? TEXT(",\n{\"name\":") : TEXT("\n{\"name\":"));
        buffer_json_text(output, text_of(column->name));
        buffer_put(output, TEXT(",\"unit\":"));
        buffer_json_text(output, text_of(column->unit));
        buffer_put(output, TEXT(",\"values\":["));
        for (size_t row = 0; row < table->rows && outlet_goes_on(sink, table, row); row++) {
            if (row > 0)
                buffer_char(output, ',');
            if (column->value)
                buffer_json_real(output, column->value[row]);
            else
                buffer_json_text(output, text_of(column->text[row]));
            outlet_pass(sink, OUTLET_CHUNK);
        }
        buffer_put(output, TEXT("]}"));
    }
    buffer_put(output, TEXT("\n]}\n"));
}

void table_csv(const struct table *table, struct outlet *outlet)
{
    put_separated(table, ',', outlet);
}

void table_tsv(const struct table *table, struct outlet *outlet)
{
    put_separated(table, '\t', outlet);
}

const struct table_column *table_column_named(const struct table *table, const char *name)
{
    for (int c = 0; name && c < table->columns; c++)
        if (strcmp(table->column[c].name, name) == 0)
            return &table->column[c];
    return NULL;
}

void table_put(const struct table *table, table_format *format, struct buffer *output)
{
    format(table, &(struct outlet){output, NULL});
}

bool table_write(const struct table *table, table_format *format, const char *path,
                 struct write_policy policy, struct error *error)
{
    struct writer writer;
    return writer_open(&writer, path, policy, error) && table_send(table, format, &writer, error);
}

/* Writes a table to an open file and closes it. Returns false with an error, and leaves no file, if
 * out of memory, cancelled, or if writing fails. */
bool table_send(const struct table *table, table_format *format, struct writer *writer,
                struct error *error)
{
    struct buffer text = {0};
    struct outlet outlet = {&text, writer};
    format(table, &outlet);
    outlet_pass(&outlet, 0);
    const bool failed = text.failed;
    buffer_free(&text);
    if (failed) {
        writer_abandon(writer);
        return cancelled(table->cancel)
                   ? error_set(error, ERROR_CANCELLED, "stopped: the file was not written")
                   : error_memory(error);
    }
    return writer_commit(writer, error);
}
