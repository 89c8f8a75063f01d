/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads tables that table.c wrote as CSV, TSV or JSON: the same doubles bit for bit, and the same
 * texts. */
#include <hooke/base/number.h>
#include <hooke/base/statement.h>
#include <hooke/result/outlet.h>

#include <assert.h>
#include <math.h>
#include <string.h>

/* Beginnings by which such files are recognised. */
#define FIRST_KEY "# hooke = "
#define FIRST_JSON "{\"keys\":{"

bool table_recognise(struct text text)
{
    return text_starts(text, TEXT(FIRST_KEY)) || text_starts(text, TEXT(FIRST_JSON));
}

/* Progress of reading a table. */
struct table_reading {
    /* memory of the table */
    struct arena *arena;
    /* text that has not been read yet */
    struct text rest;
    struct error *error;
    const struct cancel *cancel;
};

/* Sets the error that the file is damaged and how. Returns false. */
static bool report_damage(struct table_reading *r, const char *what)
{
    return error_set(r->error, ERROR_IO, "not a table written by export: %s", what);
}

/* Returns false with an error if the user has cancelled; looks only every LOOK_EACH_ROWS rows. */
static bool row_continues(struct table_reading *r, size_t row)
{
    return row % LOOK_EACH_ROWS != LOOK_EACH_ROWS - 1 || !cancelled(r->cancel) ||
           error_set(r->error, ERROR_CANCELLED, "stopped while reading");
}

/* Returns the array with room for one more element: a copy of twice the size whenever its count is
 * a power of two from `least` on. Returns NULL if out of memory. */
static void *grow_array(struct arena *arena, void *array, size_t count, size_t size, size_t least)
{
    if (count > 0 && (count < least || (count & (count - 1))))
        return array;
    void *more = arena_array(arena, count ? 2 * count : least, size);
    if (more && array)
        memcpy(more, array, count * size);
    return more;
}

/* Copies a buffer's text into the arena. Returns NULL with an error if out of memory. */
static const char *buffer_text_copy(struct table_reading *r, const struct buffer *text)
{
    const char *made = text->failed ? NULL : arena_text(r->arena, buffer_text(text));
    if (!made)
        error_memory(r->error);
    return made;
}

/* Returns true if a number was read; one too small for a double counts as read (0). */
static bool is_number_status(enum real_status status)
{
    return status == REAL_OK || status == REAL_UNDERFLOW;
}

/* ---- CSV, TSV ---- */

/* One cell of a file of separated values. */
struct parsed_cell {
    const char *text;
    bool quoted;
};

/* Reads a cell up to the separator or the end of the line; sets *last if the line ends there.
 * Returns false with an error if a quotation mark is not closed. */
static bool read_cell(struct table_reading *r, char separator, struct parsed_cell *cell, bool *last)
{
    struct buffer text = {0};
    struct text rest = r->rest;
    cell->quoted = rest.len > 0 && rest.data[0] == '"';
    size_t i = cell->quoted;
    for (; i < rest.len; i++) {
        if (cell->quoted && rest.data[i] == '"') {
            if (i + 1 >= rest.len || rest.data[i + 1] != '"')
                break;
            i++;
        } else if (!cell->quoted && (rest.data[i] == separator || rest.data[i] == '\n')) {
            break;
        }
        buffer_char(&text, rest.data[i]);
    }
    i += cell->quoted;
    const bool ends = i >= rest.len || rest.data[i] == '\n';
    const bool ok = i <= rest.len && (ends || rest.data[i] == separator);
    const size_t used = i < rest.len ? i + 1 : rest.len;
    r->rest = text_after(rest, used);
    *last = ends;
    const char *own = ok ? buffer_text_copy(r, &text) : NULL;
    /* The apostrophe before a formula was added by table.c. */
    cell->text =
        own && cell->quoted && cell_is_formula(text_of(own)) && own[0] == '\'' ? own + 1 : own;
    buffer_free(&text);
    return ok ? cell->text != NULL : report_damage(r, "a quotation mark is not closed");
}

/* Reads the lines "# KEY = VALUE" at the beginning. Returns false with an error if one is
 * malformed. */
static bool read_keys(struct table_reading *r, struct table *table)
{
    struct table_key *key = NULL;
    struct text line;
    while (text_starts(r->rest, TEXT("# ")) && text_split(&r->rest, '\n', &line)) {
        const char *sign = NULL;
        for (size_t i = 2; i + 3 <= line.len && !sign; i++)
            sign = memcmp(line.data + i, " = ", 3) == 0 ? line.data + i : NULL;
        key = grow_array(r->arena, key, (size_t)table->keys, sizeof *key, 16);
        if (!sign || !key)
            return key ? report_damage(r, "a line that begins with # has no ' = '")
                       : error_memory(r->error);
        const size_t name = (size_t)(sign - line.data);
        key[table->keys] =
            (struct table_key){arena_text(r->arena, (struct text){line.data + 2, name - 2}),
                               arena_text(r->arena, (struct text){sign + 3, line.len - name - 3})};
        if (!key[table->keys].key || !key[table->keys].value)
            return error_memory(r->error);
        table->keys++;
    }
    table->key = key;
    return true;
}

/* Splits a heading such as "dt [s]" into the name and the unit of a column. */
static bool split_heading(struct table_reading *r, const char *heading, struct table_column *column)
{
    const struct text all = text_of(heading);
    const char *open = NULL;
    for (const char *cursor = heading; (cursor = strstr(cursor, " [")); cursor++)
        open = cursor;
    const bool has_unit = open && all.len > 0 && heading[all.len - 1] == ']';
    const size_t name = has_unit ? (size_t)(open - heading) : all.len;
    *column = (struct table_column){
        .name = arena_text(r->arena, (struct text){heading, name}),
        .unit = has_unit ? arena_text(r->arena, (struct text){open + 2, all.len - name - 3}) : ""};
    return (column->name && column->unit) || error_memory(r->error);
}

/* Fills a column from the cells of a file, cell[i * columns] for row i: with numbers if every cell
 * is an unquoted number or empty, else with texts. */
static bool fill_column(struct table_reading *r, const struct parsed_cell *cell, int columns,
                        size_t rows, struct table_column *column)
{
    double *value = arena_array(r->arena, rows + 1, sizeof *value);
    const char **text = arena_array(r->arena, rows + 1, sizeof *text);
    bool numbers = true;
    assert(cell || rows == 0);
    if (!value || !text)
        return error_memory(r->error);
    for (size_t i = 0; i < rows; i++) {
        if (!row_continues(r, i))
            return false;
        const struct parsed_cell *one = &cell[i * (size_t)columns];
        const struct text as = text_of(one->text);
        text[i] = one->text;
        value[i] = NAN;
        if (text_is(as, "inf") || text_is(as, "-inf"))
            value[i] = as.data[0] == '-' ? -HUGE_VAL : HUGE_VAL;
        else if (as.len > 0)
            numbers &= is_number_status(real_parse(as, &value[i]));
        numbers &= !one->quoted;
    }
    if (numbers)
        column->value = value;
    else
        column->text = text;
    return true;
}

/* Reads a table in CSV or TSV: keys, a header, and rows of equal length. A tab in the header means
 * TSV. The columns are in r->arena. Returns false with r->error if the text is damaged, if out of
 * memory, or if row_continues() stops it. */
static bool read_separated(struct table_reading *r, struct table *table)
{
    struct table_column *column = NULL;
    struct parsed_cell *cell = NULL, one;
    size_t cells = 0;
    if (!read_keys(r, table))
        return false;
    const char *line = r->rest.len ? memchr(r->rest.data, '\n', r->rest.len) : NULL;
    const char separator =
        line && memchr(r->rest.data, '\t', (size_t)(line - r->rest.data)) ? '\t' : ',';
    for (bool last = false; !last; table->columns++) {
        column = grow_array(r->arena, column, (size_t)table->columns, sizeof *column, 16);
        if (!column)
            return error_memory(r->error);
        if (!read_cell(r, separator, &one, &last) ||
            !split_heading(r, one.text, &column[table->columns]))
            return false;
    }
    while (r->rest.len > 0) {
        bool last = false;
        if (!row_continues(r, table->rows))
            return false;
        for (int c = 0; c < table->columns; c++) {
            if (last)
                return report_damage(r, "rows differ in length");
            cell = grow_array(r->arena, cell, cells, sizeof *cell, 64);
            if (!cell)
                return error_memory(r->error);
            if (!read_cell(r, separator, &cell[cells++], &last))
                return false;
        }
        if (!last)
            return report_damage(r, "rows differ in length");
        table->rows++;
    }
    for (int c = 0; c < table->columns; c++)
        if (!fill_column(r, cell + c, table->columns, table->rows, &column[c]))
            return false;
    table->column = column;
    return true;
}

/* ---- JSON, of the one form that is written ---- */

/* Skips blanks and line ends, then `what` if it follows; returns false if it does not. */
static bool table_text_take(struct table_reading *r, const char *what)
{
    text_skip_blanks(&r->rest);
    while (r->rest.len > 0 && r->rest.data[0] == '\n')
        r->rest = text_after(r->rest, 1);
    const struct text wanted = text_of(what);
    if (!text_starts(r->rest, wanted))
        return false;
    r->rest = text_after(r->rest, wanted.len);
    return true;
}

/* Reads the four hexadecimal digits of \\uXXXX. */
static bool read_code(struct table_reading *r, uint32_t *code)
{
    *code = 0;
    for (int i = 0; i < 4; i++) {
        const char *digits = "0123456789abcdef";
        const char *cursor =
            r->rest.len > 0 && r->rest.data[0] ? strchr(digits, r->rest.data[0]) : NULL;
        if (!cursor)
            return false;
        *code = *code * 16 + (uint32_t)(cursor - digits);
        r->rest = text_after(r->rest, 1);
    }
    return true;
}

/* Reads a JSON escape sequence behind its backslash and appends the character to `output`; a pair
 * of surrogates makes one character. Returns false with r->error if it is malformed. */
static bool read_escape(struct table_reading *r, struct buffer *output)
{
    static const char letters[] = "\"\\bfnrt/", meant[] = "\"\\\b\f\n\r\t/";
    const char letter = r->rest.len > 0 ? r->rest.data[0] : 0;
    const char *known = letter ? strchr(letters, letter) : NULL;
    uint32_t code, low;
    r->rest = (struct text){r->rest.data + 1, r->rest.len - (r->rest.len > 0)};
    if (known) {
        buffer_char(output, meant[known - letters]);
        return true;
    }
    if (letter != 'u' || !read_code(r, &code))
        return false;
    if (code >= 0xD800 && code < 0xDC00) {
        if (!table_text_take(r, "\\u") || !read_code(r, &low))
            return false;
        code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
    }
    buffer_codepoint(output, code);
    return true;
}

/* Reads a JSON string into the arena. Returns NULL with an error if it is not closed. */
static const char *read_string(struct table_reading *r)
{
    struct buffer text = {0};
    bool ok = table_text_take(r, "\"");
    while (ok && r->rest.len > 0 && r->rest.data[0] != '"') {
        const char c = r->rest.data[0];
        r->rest = text_after(r->rest, 1);
        if (c == '\\')
            ok = read_escape(r, &text);
        else
            buffer_char(&text, c);
    }
    ok = ok && table_text_take(r, "\"");
    const char *made = ok ? buffer_text_copy(r, &text) : NULL;
    if (!ok)
        report_damage(r, "a text has no closing quotation mark");
    buffer_free(&text);
    return made;
}

/* Reads the object of keys, behind its opening brace. */
static bool read_json_keys(struct table_reading *r, struct table *table)
{
    struct table_key *key = NULL;
    for (bool more = !table_text_take(r, "}"); more; more = table_text_take(r, ",")) {
        key = grow_array(r->arena, key, (size_t)table->keys, sizeof *key, 16);
        if (!key)
            return error_memory(r->error);
        key[table->keys].key = read_string(r);
        if (!key[table->keys].key || !table_text_take(r, ":") ||
            !(key[table->keys].value = read_string(r)))
            return report_damage(r, "a key has no text");
        table->keys++;
    }
    table->key = key;
    return table->keys == 0 || table_text_take(r, "}") ||
           report_damage(r, "the list of keys is not closed");
}

/* Reads the array of a column's values, behind its opening bracket: numbers and null, or texts.
 * Sets *rows to their number. Returns false with an error if both are mixed or something is
 * malformed. */
static bool read_values(struct table_reading *r, struct table_column *column, size_t *rows)
{
    double *value = NULL;
    const char **text = NULL;
    *rows = 0;
    for (bool more = !table_text_take(r, "]"), any = more; any && more;
         more = table_text_take(r, ",")) {
        table_text_take(r, "");
        size_t used = 0;
        if (!row_continues(r, *rows))
            return false;
        if (r->rest.len > 0 && r->rest.data[0] == '"') {
            text = grow_array(r->arena, text, *rows, sizeof *text, 16);
            if (!text || value)
                return text ? report_damage(r, "a column mixes numbers and texts")
                            : error_memory(r->error);
            if (!(text[*rows] = read_string(r)))
                return false;
        } else {
            value = grow_array(r->arena, value, *rows, sizeof *value, 16);
            if (!value || text)
                return value ? report_damage(r, "a column mixes texts and numbers")
                             : error_memory(r->error);
            value[*rows] = NAN;
            if (!table_text_take(r, "null") &&
                !is_number_status(real_scan(r->rest, '.', &value[*rows], &used)))
                return report_damage(r, "a value is not a number");
            r->rest = text_after(r->rest, used);
        }
        ++*rows;
    }
    if (*rows == 0)
        /* An empty column counts as one of numbers. */
        value = arena_array(r->arena, 1, sizeof *value);
    column->value = value;
    column->text = text;
    return *rows == 0 || table_text_take(r, "]") ||
           report_damage(r, "the list of values is not closed");
}

/* Reads a table in JSON, in exactly the form that table_json() writes. */
static bool read_json(struct table_reading *r, struct table *table)
{
    struct table_column *column = NULL;
    table_text_take(r, FIRST_JSON);
    if (!read_json_keys(r, table) || !table_text_take(r, ",\"columns\":["))
        return report_damage(r, "the columns are missing");
    do {
        size_t rows;
        column = grow_array(r->arena, column, (size_t)table->columns, sizeof *column, 16);
        if (!column)
            return error_memory(r->error);
        struct table_column *one = &column[table->columns++];
        *one = (struct table_column){.name = NULL};
        if (!table_text_take(r, "{\"name\":") || !(one->name = read_string(r)) ||
            !table_text_take(r, ",\"unit\":") || !(one->unit = read_string(r)) ||
            !table_text_take(r, ",\"values\":["))
            return report_damage(r, "a column has no name, unit or values");
        if (!read_values(r, one, &rows))
            return false;
        if (!table_text_take(r, "}"))
            return report_damage(r, "a column is not closed");
        if (table->columns > 1 && rows != table->rows)
            return report_damage(r, "columns differ in length");
        table->rows = rows;
    } while (table_text_take(r, ","));
    table->column = column;
    return table_text_take(r, "]}") || table_text_take(r, "]") ||
           report_damage(r, "the list of columns is not closed");
}

/* Reads a table in either form. Returns false with an error if it is damaged or reading was
 * cancelled. */
bool table_parse(struct text text, const struct cancel *cancel, struct arena *arena,
                 struct table *table, struct error *error)
{
    struct table_reading reading = {arena, text, error, cancel};
    *table = (struct table){.cancel = cancel};
    return text_starts(text, TEXT(FIRST_JSON)) ? read_json(&reading, table)
                                               : read_separated(&reading, table);
}
