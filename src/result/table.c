/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * Tables to files: CSV and TSV with "# key = value" lines and a header with units, JSON as one
 * object. The text goes out in chunks, so that a large table needs no
 * memory for itself.
 */
#include <hooke/base/file.h>
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/result/outlet.h>

#include <math.h>
#include <string.h>

void outlet_pass(struct outlet *sink, size_t max)
{
    if (!sink->writer || sink->text->len <= max || sink->text->failed)
        return;
    writer_put(sink->writer, buffer_text(sink->text));
    buffer_clear(sink->text);
}

/* ---- CSV, TSV ---- */

bool cell_is_formula(struct text cell)
{
    size_t at = 0;
    while (at < cell.len && cell.at[at] == '\'')
        at++;
    return at < cell.len && memchr("=+-@\t\r", cell.at[at], 6);
}

void buffer_cell(struct buffer *out, struct text cell, char separator, bool quoted)
{
    for (size_t i = 0; i < cell.len && !quoted; i++)
        quoted = cell.at[i] == separator || strchr("\"\r\n", cell.at[i]);
    if (!quoted) {
        buffer_put(out, cell);
        return;
    }
    buffer_char(out, '"');
    for (size_t i = 0; i < cell.len; i++)
        buffer_put(out, cell.at[i] == '"' ? TEXT("\"\"") : (struct text){cell.at + i, 1});
    buffer_char(out, '"');
}

/* Quotes what could be taken for a number; what a spreadsheet would run as a formula gets a ' in
 * front. */
static void put_text(struct buffer *out, struct text cell, char separator)
{
    struct buffer guarded = {0};
    double number;
    const bool is_formula = cell_is_formula(cell),
               is_number = cell.len > 0 &&
                           (text_is(cell, "inf") || real_parse(cell, &number) != REAL_MALFORMED);
    if (is_formula)
        buffer_format(&guarded, "'%.*s", (int)cell.len, cell.at);
    buffer_cell(out, is_formula ? buffer_text(&guarded) : cell, separator, is_formula || is_number);
    out->failed |= guarded.failed;
    buffer_free(&guarded);
}

static void put_name(struct buffer *out, const struct table_column *column, char separator)
{
    struct buffer name = {0};
    safe_text(&name, text_of(column->name), false);
    if (column->unit && column->unit[0]) {
        buffer_put(&name, TEXT(" ["));
        safe_text(&name, text_of(column->unit), false);
        buffer_char(&name, ']');
    }
    put_text(out, buffer_text(&name), separator);
    out->failed |= name.failed;
    buffer_free(&name);
}

static void put_separated(const struct table *table, char separator, struct outlet *sink)
{
    struct buffer *out = sink->text;
    for (int i = 0; i < table->keys; i++) {
        buffer_put(out, TEXT("# "));
        safe_text(out, text_of(table->key[i].key), false);
        buffer_put(out, TEXT(" = "));
        safe_text(out, text_of(table->key[i].value), false);
        buffer_char(out, '\n');
    }
    for (int i = 0; i < table->columns; i++) {
        if (i > 0)
            buffer_char(out, separator);
        put_name(out, &table->column[i], separator);
    }
    buffer_char(out, '\n');
    for (size_t row = 0; row < table->rows && outlet_goes_on(sink, table, row); row++) {
        for (int i = 0; i < table->columns; i++) {
            const struct table_column *column = &table->column[i];
            if (i > 0)
                buffer_char(out, separator);
            if (!column->value)
                put_text(out, text_of(column->text[row]), separator);
            else if (!isnan(column->value[row]))
                buffer_real(out, column->value[row]);
        }
        buffer_char(out, '\n');
        outlet_pass(sink, OUTLET_CHUNK);
    }
}

/* ---- JSON ---- */

void buffer_json_text(struct buffer *out, struct text text)
{
    static const char escaped[] = "\"\\\b\f\n\r\t", letters[] = "\"\\bfnrt";
    buffer_char(out, '"');
    for (size_t used; text.len > 0; text.at += used, text.len -= used) {
        for (used = 0; used < text.len && text.at[used] >= ' ' && text.at[used] < 0x7F &&
                       text.at[used] != '"' && text.at[used] != '\\';)
            used++;
        if (used > 0) {
            buffer_put(out, (struct text){text.at, used});
            continue;
        }
        const uint32_t codepoint = text_codepoint(text, &used);
        const char *special =
            codepoint < 0x80 && codepoint > 0 ? strchr(escaped, (char)codepoint) : NULL;
        if (special)
            buffer_format(out, "\\%c", letters[special - escaped]);
        else if (codepoint > 0xFFFF && codepoint_hidden(codepoint)) /* a pair of surrogates */
            buffer_format(out, "\\u%04x\\u%04x", (unsigned)(0xD7C0 + (codepoint >> 10)),
                          (unsigned)(0xDC00 + (codepoint & 0x3FF)));
        else if (codepoint < 0x20 || codepoint == 0x7F || codepoint_hidden(codepoint))
            buffer_format(out, "\\u%04x", (unsigned)codepoint);
        else
            buffer_codepoint(out, codepoint);
    }
    buffer_char(out, '"');
}

void buffer_json_real(struct buffer *out, double value)
{
    if (isfinite(value))
        buffer_real(out, value);
    else
        buffer_put(out, TEXT("null"));
}

void table_json(const struct table *table, struct outlet *sink)
{
    struct buffer *out = sink->text;
    buffer_put(out, TEXT("{\"keys\":{"));
    for (int i = 0; i < table->keys; i++) {
        buffer_put(out, i ? TEXT(",") : TEXT(""));
        buffer_json_text(out, text_of(table->key[i].key));
        buffer_char(out, ':');
        buffer_json_text(out, text_of(table->key[i].value));
    }
    buffer_put(out, TEXT("},\"columns\":["));
    for (int i = 0; i < table->columns; i++) {
        const struct table_column *column = &table->column[i];
        buffer_put(out, i ? TEXT(",\n{\"name\":") : TEXT("\n{\"name\":"));
        buffer_json_text(out, text_of(column->name));
        buffer_put(out, TEXT(",\"unit\":"));
        buffer_json_text(out, text_of(column->unit));
        buffer_put(out, TEXT(",\"values\":["));
        for (size_t row = 0; row < table->rows && outlet_goes_on(sink, table, row); row++) {
            if (row > 0)
                buffer_char(out, ',');
            if (column->value)
                buffer_json_real(out, column->value[row]);
            else
                buffer_json_text(out, text_of(column->text[row]));
            outlet_pass(sink, OUTLET_CHUNK);
        }
        buffer_put(out, TEXT("]}"));
    }
    buffer_put(out, TEXT("\n]}\n"));
}

void table_csv(const struct table *table, struct outlet *to)
{
    put_separated(table, ',', to);
}

void table_tsv(const struct table *table, struct outlet *to)
{
    put_separated(table, '\t', to);
}

void table_put(const struct table *table, table_format *format, struct buffer *out)
{
    format(table, &(struct outlet){out, NULL});
}

bool table_write(const struct table *table, table_format *format, const char *path,
                 struct write_policy policy, struct error *error)
{
    struct writer writer;
    return writer_open(&writer, path, policy, error) && table_send(table, format, &writer, error);
}

bool table_send(const struct table *table, table_format *format, struct writer *writer,
                struct error *error)
{
    struct buffer text = {0};
    struct outlet to = {&text, writer};
    format(table, &to);
    outlet_pass(&to, 0);
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
