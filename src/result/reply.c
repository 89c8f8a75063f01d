/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes replies of commands in three forms: lines of text, JSON objects, CSV rows. */
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/result/outlet.h>

#include <math.h>
#include <stdio.h>
#include <string.h>

bool sink_nothing(void *context, struct text text)
{
    (void)context;
    (void)text;
    return true;
}

void reply_init(struct reply *reply, struct sink sink)
{
    *reply = (struct reply){.sink = sink};
}

void reply_free(struct reply *reply)
{
    struct buffer *const buffers[] = {&reply->json, &reply->header, &reply->row, &reply->lines,
                                      &reply->last_header};
    for (size_t i = 0; i < COUNT_OF(buffers); i++)
        buffer_free(buffers[i]);
}

/* Writes text to the results unless the reply is muted; notes if that fails. */
static void write_out(struct reply *reply, struct text text)
{
    if (!reply->failed && !reply->muted && text.len > 0 &&
        !reply->sink.output(reply->sink.context, text))
        reply->failed = true;
}

/* Writes a buffer to the results and empties it. If it ran out of memory the reply has failed. */
static void flush_out(struct reply *reply, struct buffer *buffer)
{
    if (buffer->failed)
        reply->failed = true;
    else
        write_out(reply, buffer_text(buffer));
    buffer_clear(buffer);
}

void reply_flush(struct reply *reply)
{
    struct buffer *lines = &reply->lines;
    if (lines->len > 0 && lines->data[lines->len - 1] != '\n')
        buffer_char(lines, '\n');
    if (reply->format == FORMAT_TEXT && !reply->quiet)
        flush_out(reply, lines);
}

struct buffer *reply_buffer(struct reply *reply)
{
    reply_flush(reply);
    return &reply->lines;
}

void reply_text(struct reply *reply, struct text text)
{
    buffer_put(reply_buffer(reply), text);
    if (text.len == 0)
        buffer_char(&reply->lines, '\n');
    reply_flush(reply);
}

void reply_paragraph(struct reply *reply, struct text text, int width)
{
    struct buffer lines = {0};
    buffer_folded(&lines, text, width);
    reply_text(reply, buffer_text(&lines));
    buffer_free(&lines);
}

/* Begins another table in CSV: after a separator, or in a file of its own. */
static void begin_csv_table(struct reply *reply, const char *kind)
{
    struct buffer separator = {0};
    if (reply->part) {
        reply->part(reply->sink.context, kind);
    } else if (reply->begun) {
        buffer_format(&separator, "\n# %s\n", kind);
        flush_out(reply, &separator);
    }
    reply->begun = true;
    buffer_free(&separator);
}

void reply_data(struct reply *reply, const char *kind, struct text text)
{
    reply_flush(reply);
    reply->recorded = true; /* not written again at the command's end */
    if (reply->format == FORMAT_CSV) {
        buffer_clear(&reply->last_header);
        begin_csv_table(reply, kind);
    }
    write_out(reply, text);
}

/* ---- records ---- */

/* Appends the heading of the field's CSV column, with the keys around it: "fit.halves.gamma". */
static void put_csv_heading(struct reply *reply, const char *key)
{
    if (reply->header.len > 0)
        buffer_char(&reply->header, ',');
    for (int i = 1; i < reply->depth; i++)
        if (reply->level[i].key)
            buffer_format(&reply->header, "%s.", reply->level[i].key);
    buffer_put(&reply->header, text_of(key));
}

/* Appends the field's column in a stored table: "halves.gamma.1", "parameters.k.value". */
static void put_store_column(struct reply *reply, const char *key, struct buffer *name)
{
    for (int i = 1; i <= reply->depth; i++) {
        const bool last = i == reply->depth, array = reply->level[i - 1].array;
        const char *own = last ? key : reply->level[i].key;
        const char *word = array && !last && reply->level[i].name[0] ? reply->level[i].name : own;
        buffer_put(name, name->len ? TEXT(".") : TEXT(""));
        if (array && (last || !reply->level[i].name[0]))
            buffer_format(name, "%d", reply->level[i - 1].element);
        else
            buffer_put(name, text_of(word));
    }
}

/* Adds the field to the row that is being stored, if any: a number, a text, or an empty cell. */
static void record_value_append(struct reply *reply, const char *key, const double *value,
                                const char *unit, const char *text)
{
    if (!reply->store || !reply->store->row)
        return;
    struct buffer name = {0};
    put_store_column(reply, key, &name);
    if (!name.failed && value)
        store_cell_real(reply->store, buffer_view(&name), unit, *value);
    else if (!name.failed && text)
        store_cell_text(reply->store, buffer_view(&name), text);
    else if (!name.failed)
        store_cell_none(reply->store, buffer_view(&name));
    buffer_free(&name);
}

static bool inside_array(const struct reply *reply)
{
    for (int i = 0; i < reply->depth; i++)
        if (reply->level[i].array)
            return true;
    return false;
}

static bool is_special(char c)
{
    return c == ',' || c == '"' || c == '\n' || c == '\r';
}

/* Appends a CSV cell with control characters visible, quoted if it could be a formula. */
static void put_csv_text(struct buffer *row, const char *text)
{
    struct buffer safe = {0};
    safe_text(&safe, text_of(text), true);
    const char *second = text[0] ? text + 1 : text;
    buffer_cell(row, buffer_text(&safe), ',',
                text[0] && strchr("=+-@", text[0]) && !(*second && strchr("0123456789.", *second)));
    row->failed |= safe.failed;
    buffer_free(&safe);
}

/* Adds a cell to the CSV row; inside arrays the values of all elements share the array's cell. */
static void put_csv_cell(struct reply *reply, const char *key, struct text value, bool is_text)
{
    struct buffer *row = &reply->row;
    if (reply->format != FORMAT_CSV)
        return;
    if (inside_array(reply)) {
        if (row->len > 0 && row->data[row->len - 1] != ',')
            buffer_char(row, ' ');
        struct buffer safe = {0};
        safe_text(&safe, value, true);
        for (size_t i = 0; i < safe.len; i++)
            buffer_char(row, is_special(safe.data[i]) ? ';' : safe.data[i]);
        row->failed |= safe.failed;
        buffer_free(&safe);
        return;
    }
    if (reply->header.len > 0)
        buffer_char(row, ',');
    put_csv_heading(reply, key);
    if (is_text)
        put_csv_text(row, value.data);
    else
        buffer_put(row, value);
}

/* Writes the comma and the key before a JSON value, and counts the elements of arrays. */
static void put_key(struct reply *reply, const char *key)
{
    if (reply->depth > 0) {
        if (reply->format == FORMAT_JSON && !reply->level[reply->depth - 1].empty)
            buffer_char(&reply->json, ',');
        reply->level[reply->depth - 1].empty = false;
        reply->level[reply->depth - 1].element++;
    }
    if (reply->format == FORMAT_JSON && key &&
        !(reply->depth > 0 && reply->level[reply->depth - 1].array)) {
        buffer_json_text(&reply->json, text_of(key));
        buffer_char(&reply->json, ':');
    }
}

static void put_literal(struct reply *reply, const char *key, struct text json, struct text cell)
{
    put_key(reply, key);
    if (reply->format == FORMAT_JSON)
        buffer_put(&reply->json, json);
    put_csv_cell(reply, key, cell, false);
}

/* Opens an object or an array in the record. */
static void open_level(struct reply *reply, const char *key, bool array)
{
    put_key(reply, key);
    buffer_char(&reply->json, array ? '[' : '{');
    if (reply->format == FORMAT_CSV && array && !inside_array(reply)) {
        if (reply->header.len > 0)
            buffer_char(&reply->row, ',');
        put_csv_heading(reply, key);
    }
    if (reply->depth < REPLY_DEPTH) {
        reply->level[reply->depth].key = key;
        reply->level[reply->depth].array = array;
        reply->level[reply->depth].empty = true;
        reply->level[reply->depth].element = 0;
        reply->level[reply->depth].name[0] = 0;
        reply->depth++;
    }
}

void reply_begin(struct reply *reply, const char *kind)
{
    buffer_clear(&reply->json);
    buffer_clear(&reply->header);
    buffer_clear(&reply->row);
    reply->depth = 0;
    reply->kind = kind;
    open_level(reply, NULL, false);
    reply_string(reply, "kind", kind);
    if (reply->store)
        store_row_begin(reply->store, kind);
}

bool reply_wants_records(const struct reply *reply)
{
    return reply->format != FORMAT_TEXT || reply->muted;
}

bool reply_wants_text(const struct reply *reply)
{
    return reply->format == FORMAT_TEXT && !reply->quiet && !reply->muted;
}

/* Returns true for the `name` that an object in an array begins with; it names its columns. */
static bool takes_object_name(struct reply *reply, const char *key, const char *value)
{
    const int d = reply->depth - 1;
    if (d < 1 || !reply->level[d - 1].array || !reply->level[d].empty || strcmp(key, "name") != 0)
        return false;
    snprintf(reply->level[d].name, sizeof reply->level[d].name, "%s", value);
    return true;
}

void reply_string(struct reply *reply, const char *key, const char *value)
{
    if (!value) {
        reply_null(reply, key);
        return;
    }
    const bool names = takes_object_name(reply, key, value);
    put_key(reply, key);
    if (!names)
        record_value_append(reply, key, NULL, "", value);
    if (reply->format == FORMAT_JSON)
        buffer_json_text(&reply->json, text_of(value));
    put_csv_cell(reply, key, text_of(value), true);
}

void reply_quantity(struct reply *reply, const char *key, double value, const char *unit)
{
    char z[REAL_TEXT_SIZE];
    const bool known = isfinite(value);
    const struct text text = {z, known ? real_format(value, z) : 0};
    put_literal(reply, key, known ? text : TEXT("null"), text);
    record_value_append(reply, key, &value, unit, NULL);
}

void reply_real(struct reply *reply, const char *key, double value)
{
    reply_quantity(reply, key, value, "");
}

void reply_int(struct reply *reply, const char *key, int64_t value)
{
    char z[24];
    const double real = (double)value;
    snprintf(z, sizeof z, "%lld", (long long)value);
    put_literal(reply, key, text_of(z), text_of(z));
    record_value_append(reply, key, &real, "", NULL);
}

void reply_bool(struct reply *reply, const char *key, bool value)
{
    const struct text text = value ? TEXT("true") : TEXT("false");
    put_literal(reply, key, text, text);
    record_value_append(reply, key, NULL, "", text.data);
}

void reply_null(struct reply *reply, const char *key)
{
    put_literal(reply, key, TEXT("null"), TEXT(""));
    record_value_append(reply, key, NULL, "", NULL);
}

/* A stored table gets two columns with the unit, NAME and NAME_uncertainty. */
void reply_in_unit(struct reply *reply, const char *key, struct measured value, const char *unit)
{
    struct table_store *store = reply->store;
    char uncertainty[64];
    snprintf(uncertainty, sizeof uncertainty, "%s_uncertainty", key ? key : "");
    reply->store = NULL;
    reply_object(reply, key);
    reply_real(reply, "value", value.value);
    reply_real(reply, "uncertainty", value.uncertainty);
    reply_string(reply, "unit", unit);
    reply_close(reply);
    reply->store = store;
    record_value_append(reply, key, &value.value, unit, NULL);
    if (key)
        record_value_append(reply, uncertainty, &value.uncertainty, unit, NULL);
}

void reply_measured(struct reply *reply, const char *key, struct measured value,
                    enum quantity quantity)
{
    reply_in_unit(reply, key, value, quantity_unit(quantity));
}

void reply_if_known(struct reply *reply, const char *key, struct measured value,
                    enum quantity quantity)
{
    if (isfinite(value.value))
        reply_measured(reply, key, value, quantity);
    else
        reply_null(reply, key);
}

void reply_object(struct reply *reply, const char *key)
{
    open_level(reply, key, false);
}

void reply_array(struct reply *reply, const char *key)
{
    open_level(reply, key, true);
}

void reply_reals(struct reply *reply, const char *key, const double *value, int count,
                 const char *unit)
{
    reply_array(reply, key);
    for (int i = 0; i < count; i++)
        reply_quantity(reply, NULL, value[i], unit);
    reply_close(reply);
}

void reply_close(struct reply *reply)
{
    if (reply->depth > 0)
        buffer_char(&reply->json, reply->level[--reply->depth].array ? ']' : '}');
}

void reply_end(struct reply *reply)
{
    while (reply->depth > 0)
        reply_close(reply);
    reply->recorded = true;
    if (reply->store)
        store_row_end(reply->store);
    if (reply->format == FORMAT_JSON) {
        buffer_char(&reply->json, '\n');
        flush_out(reply, &reply->json);
    } else if (reply->format == FORMAT_CSV) {
        buffer_char(&reply->header, '\n');
        buffer_char(&reply->row, '\n');
        if (!text_equal(buffer_text(&reply->header), buffer_text(&reply->last_header))) {
            buffer_clear(&reply->last_header);
            buffer_put(&reply->last_header, buffer_text(&reply->header));
            begin_csv_table(reply, reply->kind);
            flush_out(reply, &reply->header);
        }
        flush_out(reply, &reply->row);
    }
}

static void put_table_row(struct reply *reply, const char *kind, const struct table *table,
                          size_t row)
{
    reply_begin(reply, kind);
    for (const struct table_column *c = table->column; c < table->column + table->columns; c++)
        if (c->value)
            reply_quantity(reply, c->name, c->value[row], c->unit);
        else
            reply_string(reply, c->name, c->text[row]);
}

/* Appends a row of a table as CSV without its header. */
static void put_csv_row(struct buffer *output, const char *kind, const struct table *table,
                        size_t row)
{
    buffer_put(output, text_of(kind));
    for (const struct table_column *c = table->column; c < table->column + table->columns; c++) {
        buffer_char(output, ',');
        if (!c->value)
            put_csv_text(output, c->text[row]);
        else if (isfinite(c->value[row]))
            buffer_real(output, c->value[row]);
    }
    buffer_char(output, '\n');
}

bool reply_table_rows(struct reply *reply, const char *kind, const struct table *table,
                      size_t first, size_t count, bool headed)
{
    const size_t chunk = (size_t)1 << 20; /* [byte] text is written in chunks of this size */
    for (size_t i = 0; i < count && !reply->failed; i++) {
        if (i % OUTLET_ROWS == OUTLET_ROWS - 1 && cancelled(table->cancel)) {
            flush_out(reply, &reply->row);
            return false;
        }
        if (i > 0 && reply->format == FORMAT_CSV) {
            put_csv_row(&reply->row, kind, table, first + i);
            if (reply->row.len >= chunk || reply->row.failed || i == count - 1)
                flush_out(reply, &reply->row);
            continue;
        }
        put_table_row(reply, kind, table, first + i);
        if (i == 0 && !headed) {
            buffer_clear(&reply->last_header);
            buffer_put(&reply->last_header, buffer_text(&reply->header));
            buffer_char(&reply->last_header, '\n');
        }
        reply_end(reply);
    }
    return true;
}

/* ---- one statement ---- */

void reply_command_begin(struct reply *reply, enum output_format format)
{
    reply_flush(reply);
    reply->format = format;
    reply->recorded = false;
    buffer_clear(&reply->lines);
    buffer_clear(&reply->json); /* drops a record that was not written */
}

/* Ends the reply of a command; in JSON and CSV lines without a record are written, too. */
void reply_command_end(struct reply *reply, const char *kind)
{
    reply_flush(reply);
    struct buffer *lines = &reply->lines;
    reply->failed |= lines->failed;
    if (lines->len > 0 && !reply->recorded && !reply->quiet && reply->format == FORMAT_JSON) {
        struct table_store *store = reply->store;
        lines->data[--lines->len] = '\0';
        reply->store = NULL; /* the store keeps only records */
        reply_begin(reply, kind);
        reply_string(reply, "text", lines->data);
        reply_end(reply);
        reply->store = store;
    } else if (!reply->recorded && !reply->quiet && reply->format == FORMAT_CSV) {
        struct buffer output = {0};
        struct text rest = buffer_text(lines), line;
        while (text_split(&rest, '\n', &line))
            if (line.len > 0)
                buffer_format(&output, "# %.*s\n", (int)line.len, line.data);
        flush_out(reply, &output);
        buffer_free(&output);
    }
    buffer_clear(lines);
}
