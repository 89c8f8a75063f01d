/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Reads the rows of a table into columns, in one pass over the file. Unreadable rows are counted
 * and reported. */
#include <hooke/base/cancel.h>
#include <hooke/base/number.h>
#include <hooke/result.h>
#include "modules/recording/table/plain_number.h"
#include "modules/recording/table/stamp.h"
#include "modules/recording/table/table.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Rows compared with the last one to detect that it is cut, and lines that estimate the number of
 * rows. */
#define BEFORE_LAST 8
#define ESTIMATE_LINES 64
#define ROWS_KEPT 16 /* rows kept for that: a power of two above BEFORE_LAST */

struct row_problem {
    size_t count, first; /* number of such rows, and line of the first */
    char example[SHORT_NAME];
};

struct row_reader {
    struct recording *recording;
    const struct table_layout *layout;
    /* Lines that are no rows, words after the last column, [columns] cells that are no numbers. */
    struct row_problem ragged, extra, *words;
    /* Rows of another width that are used: shorter ones, and those with more numbers. */
    struct row_problem shorter, wider;
    size_t other_line;           /* line of the newest row of another width, 0 before the first */
    int other_fields;            /* number of its fields */
    int frequent_fields;         /* number of fields of many lines, or 0 as long as it is unknown */
    int long_looks;              /* number of searches for it */
    struct stamp_column *stamps; /* stamps of each column */
    struct text recent[ROWS_KEPT]; /* row i is recent[i % ROWS_KEPT] if it is a late one */
    size_t capacity;               /* rows for which there is memory */
    bool ended;                    /* the newest row has its line end */
};

/* ---- memory ---- */

static bool array_resize(void *array, size_t count, size_t size)
{
    void *old, *fresh;
    memcpy(&old, array, sizeof old);
    fresh = realloc(old, count * size);
    if (fresh)
        memcpy(array, &fresh, sizeof fresh);
    return fresh != NULL;
}

/* Allocates space for `rows` rows, up to the limit; unused memory costs nothing. */
static bool reserve_rows(struct row_reader *reader, size_t rows, struct error *error)
{
    struct recording *recording = reader->recording;
    const size_t each = ((size_t)recording->columns + 2) * sizeof(double) + sizeof(uint32_t),
                 max = TABLE_BYTES / each;
    rows = rows < max ? rows : max;
    if (rows <= reader->capacity) {
        error_set(error, ERROR_IO,
                  "the table has more than %zu rows of %d columns, beyond the limit of %u MiB", max,
                  recording->columns, TABLE_BYTES >> 20);
        return error_hint(error, "export a part of it, or fewer columns");
    }
    bool done = array_resize(&recording->t, rows, sizeof *recording->t) &&
                array_resize(&recording->line, rows, sizeof *recording->line);
    for (int i = 0; i < recording->columns && done; i++)
        done = array_resize(&recording->column[i].value, rows, sizeof(double));
    reader->capacity = rows;
    return done || error_memory(error);
}

/* ---- one row ---- */

static void row_problem_note(struct row_problem *tally, size_t line, struct text example)
{
    if (tally->count++ == 0) {
        tally->first = line;
        short_name(example, tally->example);
    }
}

/* Reads a row of nothing but plain numbers that ends in LF or CRLF, as nearly all of an
 * instrument's rows. Returns the start of the next line, or NULL if read_row() has to read it. */
static const char *plain_row(struct row_reader *reader, const char *cursor, const char *end)
{
    const struct recording *recording = reader->recording;
    const char separator = reader->layout->separator, decimal = reader->layout->decimal;
    const size_t row = recording->rows;
    const char *begin = cursor;
    if (separator == decimal || reader->layout->unpadded)
        return NULL;
    for (int i = 0; i < recording->columns; i++) {
        if (i > 0 && (cursor == end || *cursor++ != separator))
            return NULL;
        cursor = plain_number(cursor, end, decimal, &recording->column[i].value[row]);
        if (!cursor)
            return NULL;
    }
    reader->recent[row % ROWS_KEPT] = (struct text){begin, (size_t)(cursor - begin)};
    cursor += cursor < end && *cursor == separator && separator != ' ' && separator != '\n';
    cursor += cursor < end && *cursor == '\r';
    return cursor < end && *cursor == '\n' ? cursor + 1 : NULL;
}

static enum cell_kind cell_of(struct text field, const struct table_layout *layout, double *value)
{
    const enum cell_kind cell = table_cell(field, layout->decimal, value);
    return cell == CELL_WORD && layout->grouped && table_grouped(field, layout->decimal, value)
               ? CELL_NUMBER
               : cell;
}

/* Cuts off and reads the next field. Numbers that end at the separator take a shortcut. */
static bool next_cell(struct text *rest, const struct table_layout *layout, struct text *field,
                      enum cell_kind *cell, double *value)
{
    size_t used = 0;
    if (rest->data == NULL)
        return false;
    /* A comma that is both ends a number only behind its quotes. */
    const enum real_status status = layout->decimal == layout->separator
                                        ? REAL_MALFORMED
                                        : real_scan(*rest, layout->decimal, value, &used);
    if ((status == REAL_OK || status == REAL_UNDERFLOW) &&
        (used == rest->len || rest->data[used] == layout->separator)) {
        *field = (struct text){rest->data, used};
        *rest = used < rest->len ? (struct text){rest->data + used + 1, rest->len - used - 1}
                                 : (struct text){NULL, 0};
        *cell = CELL_NUMBER;
        return true;
    }
    if (!table_field(rest, layout->separator, field))
        return false;
    *cell = cell_of(*field, layout, value);
    return true;
}

static void note_words(struct row_reader *reader, struct text line, size_t number)
{
    struct text field;
    double value;
    for (int i = 0;
         i < reader->recording->columns && table_field(&line, reader->layout->separator, &field);
         i++)
        if (cell_of(field, reader->layout, &value) == CELL_WORD)
            row_problem_note(&reader->words[i], number, field);
}

/* Returns the number of fields of a row that holds two numbers or more and no words; 0 for any
 * other line. */
static int number_fields(const struct table_layout *layout, struct text line)
{
    struct text field;
    enum cell_kind cell;
    double value;
    int fields = 0, numbers = 0;
    while (next_cell(&line, layout, &field, &cell, &value)) {
        if (cell == CELL_WORD)
            return 0;
        numbers += cell == CELL_NUMBER || cell == CELL_STAMP;
        fields++;
    }
    return numbers >= 2 ? fields : 0;
}

/* Returns true if the fields of a row of another width belong to the first columns: between blanks
 * any could be missing, unless the line above has as many, and decimal commas look like
 * separators. */
static bool fields_are_aligned(const struct table_layout *layout, struct text line, int fields)
{
    if (layout->separator == ',')
        return fields < layout->columns || memchr(line.data, '.', line.len);
    if (layout->separator != ' ')
        return layout->separator != '\n';
    return layout->fields_above == (fields < layout->columns ? fields : layout->columns);
}

/* Returns true if a row of another width belongs to the table, because a formula was typed beside
 * some rows. A single such line may be garbled; WIDTH_RUN lines of the same width in a row, or
 * every fourth line, are rows. `ahead` is the text after the line. */
static bool is_other_width(struct row_reader *reader, struct text line, struct text ahead,
                           size_t number)
{
    enum { WIDTH_RUN = 3, LINES_AHEAD = 64, FREQUENT = LINES_AHEAD / 4, LONG_LOOKS = 64 };
    const int fields = number_fields(reader->layout, line);
    if (fields == 0 || !fields_are_aligned(reader->layout, line, fields))
        return false;
    const bool follows = reader->other_fields == fields && reader->other_line + 1 == number;
    /* The first rows may be the ones without the formula: a run of others like them comes later. */
    const bool first = reader->recording->rows < WIDTH_RUN;
    const int lines = reader->long_looks < LONG_LOOKS ? LINES_AHEAD : WIDTH_RUN - 1;
    struct text next;
    bool found = follows || fields == reader->frequent_fields;
    reader->long_looks += !found;
    for (int i = 0, run = 0, same = 0; i < lines && !found && table_line(&ahead, &next); i++) {
        const bool is_same =
            next.len <= LIMIT_LINE && number_fields(reader->layout, next) == fields;
        run = is_same ? run + 1 : 0;
        same += is_same;
        found = run == WIDTH_RUN - 1 && (first || i == WIDTH_RUN - 2);
        if (same == FREQUENT) {
            reader->frequent_fields = fields;
            found = true;
        }
    }
    if (!found)
        return false;
    reader->other_line = number;
    reader->other_fields = fields;
    return true;
}

/* Sets the column's unit from that after a number. Returns false if the column has another unit. */
static bool take_unit(struct column *column, const struct table_layout *layout, struct text field)
{
    double value;
    struct text unit;
    if (!number_with_unit(field, layout->decimal, &value, &unit))
        return true;
    if (column->unit[0] == '\0')
        column_unit(column, unit);
    return text_is(unit, column->unit);
}

/* Reads line `number`, followed by the text `ahead`, into row recording->rows. Returns false if it
 * is not a row. */
static bool read_row(struct row_reader *reader, struct text line, struct text ahead, size_t number)
{
    struct recording *recording = reader->recording;
    struct text rest = line, field, stray_word = {0};
    int fields = 0, numbers = 0;
    bool words = false, wider = false;
    enum cell_kind cell;
    double value;
    while (next_cell(&rest, reader->layout, &field, &cell, &value)) {
        if (fields < recording->columns) {
            if (cell == CELL_STAMP)
                value = stamp_seconds(&reader->stamps[fields], field);
            else if (cell == CELL_NUMBER && fields + 1 == reader->layout->unpadded)
                value = unpadded_value(field, reader->layout);
            if (cell == CELL_NUMBER &&
                !take_unit(&recording->column[fields], reader->layout, field)) {
                value = NAN;
                cell = CELL_WORD;
                row_problem_note(&reader->words[fields], number, field);
            }
            recording->column[fields].value[recording->rows] = value;
            numbers += cell == CELL_NUMBER || cell == CELL_STAMP;
            words |= cell == CELL_WORD;
        } else if (cell == CELL_NUMBER) {
            wider = true;
        } else if (cell == CELL_WORD && stray_word.len == 0) {
            stray_word = field;
        }
        fields++;
    }
    const bool shorter = fields < recording->columns;
    if ((shorter || wider) && !is_other_width(reader, line, ahead, number))
        return false;
    if (numbers == 0 && (words || stray_word.len > 0))
        return false;
    for (int i = fields; i < recording->columns; i++)
        recording->column[i].value[recording->rows] = NAN;
    if (shorter || wider)
        row_problem_note(shorter ? &reader->shorter : &reader->wider, number, line);
    if (stray_word.len > 0)
        row_problem_note(&reader->extra, number, stray_word);
    if (words)
        note_words(reader, line, number);
    return true;
}

/* Returns the last field that is read; what follows may be a separator that ends the row. */
static struct text last_field(const struct row_reader *reader, struct text row)
{
    struct text field = {0}, next;
    for (int i = 0;
         i < reader->recording->columns && table_field(&row, reader->layout->separator, &next); i++)
        field = next;
    return field;
}

static size_t decimals(struct text number, char decimal)
{
    const char *point = number.len ? memchr(number.data, decimal, number.len) : NULL;
    size_t count = 0;
    for (const char *cursor = point;
         point && ++cursor < number.data + number.len && *cursor >= '0' && *cursor <= '9';)
        count++;
    return count;
}

/* Returns true if the newest row, which has no line end, is cut within a number: it has fewer
 * decimals than earlier rows or, if these differ, its last number begins the one above. */
static bool is_cut(const struct row_reader *reader)
{
    const struct table_layout *layout = reader->layout;
    const size_t row = reader->recording->rows - 1;
    struct text last = last_field(reader, reader->recent[row % ROWS_KEPT]);
    size_t agreed = 0;
    bool agree = true;
    if (row == 0)
        return false;
    for (size_t i = 1; i <= BEFORE_LAST && i <= row; i++) {
        size_t here =
            decimals(last_field(reader, reader->recent[(row - i) % ROWS_KEPT]), layout->decimal);
        agree = agree && (i == 1 || here == agreed);
        agreed = here;
    }
    double value;
    enum cell_kind cell = table_cell(last, layout->decimal, &value);
    struct text previous = last_field(reader, reader->recent[(row - 1) % ROWS_KEPT]);
    if (cell == CELL_WORD || text_is(last, "-"))
        return table_cell(previous, layout->decimal, &value) != CELL_WORD;
    if (agree && agreed > 0)
        return decimals(last, layout->decimal) < agreed && (cell == CELL_NUMBER || last.len == 0);
    return last.len < previous.len && text_starts(previous, last);
}

static void name_columns(struct recording *recording, const struct table_layout *layout)
{
    char stem[SHORT_NAME] = "column";
    if (layout->stem.len > 0)
        short_name(layout->stem, stem);
    for (int i = 0; i < recording->columns; i++) {
        struct column *column = &recording->column[i];
        if (!column->name[0])
            snprintf(column->name, sizeof column->name, "%s %d", stem, i + 1);
    }
}

/* Adds warnings about marks, dropped lines and unreadable cells to the recording. */
static void warn_rows(struct row_reader *reader)
{
    struct recording *recording = reader->recording;
    const struct row_problem *ragged = &reader->ragged;
    const char mark = reader->layout->decimal == '.' ? ',' : '.';
    if (reader->layout->ambiguous)
        recording_warn(recording,
                       "commas are read as separators (%d columns of whole numbers); give "
                       "decimal=comma if they are decimal marks",
                       recording->columns);
    if (reader->layout->grouped)
        recording_warn(recording,
                       "'%c' is read as a separator of thousands, because the numbers continue "
                       "from 999 with it; give decimal=%s if it is not",
                       mark, mark == ',' ? "comma" : "point");
    if (reader->layout->unpadded)
        recording_warn(recording,
                       "%s: the fractions seem to lack leading zeros (values fall where a digit is "
                       "added), so 0%c20 is read as 0%c%0*d",
                       recording->column[reader->layout->unpadded - 1].name,
                       reader->layout->decimal, reader->layout->decimal,
                       (int)nearbyint(log10(reader->layout->unpadded_parts)), 20);
    if (ragged->count > 0)
        recording_warn(
            recording, "%zu line%s dropped that %s not %d numbers (first: line %zu, '%s')",
            ragged->count, plural_s((int64_t)ragged->count), ragged->count == 1 ? "is" : "are",
            recording->columns, ragged->first, ragged->example);
    if (reader->shorter.count > 0)
        recording_warn(recording,
                       "%zu rows have fewer than %d columns; their last values are missing (first: "
                       "line %zu, '%s')",
                       reader->shorter.count, recording->columns, reader->shorter.first,
                       reader->shorter.example);
    if (reader->wider.count > 0)
        recording_warn(recording,
                       "%zu rows have more than %d columns; the additional ones are not read "
                       "(first: line %zu, '%s')",
                       reader->wider.count, recording->columns, reader->wider.first,
                       reader->wider.example);
    for (int i = 0; i < recording->columns; i++) {
        const struct row_problem *words = &reader->words[i];
        if (words->count > 0 && words->count == recording->rows)
            recording_warn(recording, "%s contains words, not numbers ('%s')",
                           recording->column[i].name, words->example);
        else if (words->count > 0)
            recording_warn(
                recording, "%s: %zu %s not a number and taken as missing (first: line %zu, '%s')",
                recording->column[i].name, words->count,
                words->count == 1 ? "cell is" : "cells are", words->first, words->example);
    }
    if (reader->extra.count > 0)
        recording_warn(
            recording,
            "%zu %s words after the last column, which are not read (first: line %zu, '%s')",
            reader->extra.count, reader->extra.count == 1 ? "row has" : "rows have",
            reader->extra.first, reader->extra.example);
}

static bool is_full(struct row_reader *reader, struct error *error)
{
    const size_t capacity = reader->capacity;
    return reader->recording->rows == capacity &&
           !reserve_rows(reader, capacity + capacity / 2 + 64, error);
}

/* Reads the next line, whatever it is; *data counts the lines of the table. Returns false at the
 * end. */
static bool read_line(struct row_reader *reader, struct text *rest, size_t number, size_t *data)
{
    struct recording *recording = reader->recording;
    struct text line;
    if (!table_line(rest, &line))
        return false;
    if (table_skipped(line))
        return true;
    const bool row = line.len <= LIMIT_LINE && read_row(reader, line, *rest, number);
    reader->ended = rest->len > 0 || rest->data > line.data + line.len;
    if (!row && !reader->ended) {
        recording_warn(recording, "the last line (%zu) is incomplete and was dropped", number);
        recording->dropped++;
    } else if (!row) {
        row_problem_note(&reader->ragged, number, line);
    } else {
        reader->recent[recording->rows % ROWS_KEPT] = line;
        recording->line[recording->rows] = (uint32_t)number;
        recording->t[recording->rows++] = (double)*data;
    }
    ++*data;
    return true;
}

/* Reads all rows in one pass: plain ones by plain_row(), others by read_line(). */
bool table_rows(const struct table_text *text, const struct table_layout *layout,
                struct recording *recording, struct error *error)
{
    struct row_reader reader = {.recording = recording, .layout = layout};
    if (layout->columns == 0 || !layout->begin) { /* a format that was sure without a table */
        *error = text->problem;
        if (*error->text == '\0')
            error_set(error, ERROR_IO, "%s: there is no table of numbers", text->name);
        return false;
    }
    const char *end = text->text.data + text->text.len, *next;
    struct text rest = {layout->begin, (size_t)(end - layout->begin)}, line = rest, first;
    if (!table_columns(layout, recording, error))
        return false;
    reader.words = arena_array(&recording->arena, (size_t)recording->columns, sizeof *reader.words);
    reader.stamps =
        arena_array(&recording->arena, (size_t)recording->columns, sizeof *reader.stamps);
    if (!reader.words || !reader.stamps)
        return error_memory(error);
    /* Estimates the number of rows from the length of the first ones. */
    size_t lines = 0;
    while (lines < ESTIMATE_LINES && table_line(&line, &first))
        lines++;
    const size_t bytes = rest.len - line.len;
    if (!reserve_rows(&reader,
                      (size_t)(1.1 * (double)rest.len * (double)lines / (double)(bytes + 1)) + 64,
                      error))
        return false;
    recording->separator = layout->separator;
    recording->decimal = layout->decimal;
    recording->header_lines = (int)(layout->line - text->header);
    size_t number = layout->line, data = 0;
    for (bool more = true; more && rest.len > 0; number++) {
        if (number % LOOK_EACH_ROWS == 0 && cancelled(recording->cancel))
            return error_set(error, ERROR_CANCELLED, "reading was stopped");
        if (is_full(&reader, error))
            return false;
        next = plain_row(&reader, rest.data, end);
        if (next) {
            recording->line[recording->rows] = (uint32_t)number;
            recording->t[recording->rows++] = (double)data++;
            rest = (struct text){next, (size_t)(end - next)};
            reader.ended = true;
        } else {
            more = read_line(&reader, &rest, number, &data);
        }
    }
    if (recording->rows > 0 && !reader.ended &&
        recording->line[recording->rows - 1] + 1 == number && is_cut(&reader)) {
        char shown[SHORT_NAME];
        recording_warn(
            recording, "the last line (%zu) seems to end inside a number ('%s') and was dropped",
            number - 1,
            short_name(last_field(&reader, reader.recent[(recording->rows - 1) % ROWS_KEPT]),
                       shown));
        recording->rows--;
        recording->dropped++;
    }
    recording->dropped += reader.ragged.count;
    name_columns(recording, layout);
    warn_rows(&reader);
    stamp_columns(recording, reader.stamps);
    return true;
}

bool table_read(const struct table_text *text, const struct load_options *options,
                struct recording *recording, struct error *error)
{
    (void)options;
    return table_rows(text, &text->layout, recording, error);
}
