/* SPDX-License-Identifier: GPL-3.0-or-later */
/*
 * The rows of a table into columns, in one pass over the file. What cannot be read is counted and said.
 */
#include "table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define BEFORE_LAST 8 /* rows kept in mind to see whether the last one is cut */

struct tally {
    size_t count, first; /* how many, and the line of the first */
    char example[SHORT_NAME];
};

struct reader {
    struct recording *recording;
    const struct table_layout *layout;
    struct tally ragged, extra, *words;  /* words: of each column */
    struct text recent[BEFORE_LAST + 1]; /* the last rows, newest first */
    bool ended;                          /* the newest row has a line end */
};

static void note(struct tally *tally, size_t line, struct text example)
{
    if (tally->count++ == 0) {
        tally->first = line;
        short_name(example, tally->example);
    }
}

/* The next field, parsed. Numbers that end at the separator need no look at the field as text. */
static bool next_cell(struct text *rest, const struct table_layout *layout, struct text *field, enum cell *cell,
                      double *value)
{
    size_t used = 0;
    if (rest->at == NULL)
        return false;
    enum real_status status = real_scan(*rest, layout->decimal, value, &used);
    if ((status == REAL_OK || status == REAL_UNDERFLOW) && (used == rest->len || rest->at[used] == layout->separator)) {
        *field = (struct text){rest->at, used};
        *rest = used < rest->len ? (struct text){rest->at + used + 1, rest->len - used - 1} : (struct text){NULL, 0};
        *cell = CELL_NUMBER;
        return true;
    }
    if (!table_field(rest, layout->separator, field))
        return false;
    *cell = table_cell(*field, layout->decimal, value);
    return true;
}

static void note_words(struct reader *reader, struct text line, size_t number)
{
    struct text field;
    double value;
    for (int i = 0; i < reader->recording->columns && table_field(&line, reader->layout->separator, &field); i++)
        if (table_cell(field, reader->layout->decimal, &value) == CELL_WORD)
            note(&reader->words[i], number, field);
}

/* Reads one line into row recording->rows; false: it is no row of this table. */
static bool read_row(struct reader *reader, struct text line, size_t number)
{
    struct recording *recording = reader->recording;
    struct text rest = line, field, beyond = {0};
    int fields = 0, numbers = 0;
    bool words = false;
    enum cell cell;
    double value;
    while (next_cell(&rest, reader->layout, &field, &cell, &value)) {
        if (fields < recording->columns) {
            recording->column[fields].value[recording->rows] = value;
            numbers += cell == CELL_NUMBER;
            words |= cell == CELL_WORD;
        } else if (cell == CELL_NUMBER) {
            return false;
        } else if (cell == CELL_WORD && beyond.len == 0) {
            beyond = field;
        }
        fields++;
    }
    if (fields < recording->columns || (numbers == 0 && (words || beyond.len > 0)))
        return false;
    if (beyond.len > 0)
        note(&reader->extra, number, beyond);
    if (words)
        note_words(reader, line, number);
    return true;
}

static struct text last_field(struct text row, char separator)
{
    struct text field = {0}, next;
    while (table_field(&row, separator, &next))
        field = next;
    return field;
}

static size_t decimals(struct text number, char decimal)
{
    const char *point = number.len ? memchr(number.at, decimal, number.len) : NULL;
    size_t count = 0;
    for (const char *at = point; point && ++at < number.at + number.len && *at >= '0' && *at <= '9';)
        count++;
    return count;
}

/*
 * Is the newest row, which has no line end, cut in mid-number? It is if it has fewer decimals than the rows before
 * agree on; or, where these do not agree or have none, if its last number is the beginning of the one above (-1 below
 * -120).
 */
static bool is_cut(const struct reader *reader)
{
    const struct table_layout *layout = reader->layout;
    struct text last = last_field(reader->recent[0], layout->separator);
    size_t agreed = 0;
    bool agree = true;
    for (size_t i = 1; i <= BEFORE_LAST && reader->recent[i].at; i++) {
        size_t here = decimals(last_field(reader->recent[i], layout->separator), layout->decimal);
        agree = agree && (i == 1 || here == agreed);
        agreed = here;
    }
    if (!reader->recent[1].at)
        return false;
    double value;
    enum cell cell = table_cell(last, layout->decimal, &value);
    struct text above = last_field(reader->recent[1], layout->separator);
    if (cell == CELL_WORD)
        return table_cell(above, layout->decimal, &value) != CELL_WORD;
    if (agree && agreed > 0)
        return decimals(last, layout->decimal) < agreed && (cell == CELL_NUMBER || last.len == 0);
    return last.len < above.len && text_starts(above, last);
}

static void name_columns(struct recording *recording)
{
    for (int i = 0; i < recording->columns; i++) {
        struct column *column = &recording->column[i];
        if (!column->name[0])
            snprintf(column->name, sizeof column->name, "column %d", i + 1);
    }
}

static void warn_rows(struct reader *reader)
{
    struct recording *recording = reader->recording;
    if (reader->layout->ambiguous)
        recording_warn(recording,
                       "commas are read as separators (%d columns of whole numbers); decimal=comma if they are "
                       "decimal marks",
                       recording->columns);
    if (reader->ragged.count > 0)
        recording_warn(recording, "%zu %s dropped that %s not %d numbers (first: line %zu, '%s')", reader->ragged.count,
                       reader->ragged.count == 1 ? "line" : "lines", reader->ragged.count == 1 ? "is" : "are",
                       recording->columns, reader->ragged.first, reader->ragged.example);
    for (int i = 0; i < recording->columns; i++) {
        const struct tally *words = &reader->words[i];
        if (words->count > 0 && words->count == recording->rows)
            recording_warn(recording, "%s holds words, not numbers ('%s')", recording->column[i].name, words->example);
        else if (words->count > 0)
            recording_warn(recording, "%s: %zu %s not a number and taken as missing (first: line %zu, '%s')",
                           recording->column[i].name, words->count, words->count == 1 ? "cell is" : "cells are",
                           words->first, words->example);
    }
    if (reader->extra.count > 0)
        recording_warn(recording, "%zu %s words behind the last column, not read (first: line %zu, '%s')",
                       reader->extra.count, reader->extra.count == 1 ? "row has" : "rows have", reader->extra.first,
                       reader->extra.example);
}

/* Room for every row there can be: a row takes a line, and a byte for each field. */
static bool allocate(struct reader *reader, struct text rest)
{
    struct recording *recording = reader->recording;
    size_t lines = 1, bytes = rest.len / (size_t)(recording->columns + 1) + 1;
    for (const char *at = rest.at, *end = rest.at + rest.len; at < end && lines < bytes; at++, lines++) {
        const char *next = memchr(at, '\n', (size_t)(end - at));
        if (!next)
            break;
        at = next;
    }
    if (memchr(rest.at, '\r', rest.len))
        lines = bytes; /* each could be a line end */
    for (int i = 0; i < recording->columns; i++)
        if (!(recording->column[i].value = arena_array(&recording->arena, lines, sizeof(double))))
            return false;
    recording->t = arena_array(&recording->arena, lines, sizeof(double));
    recording->line = arena_array(&recording->arena, lines, sizeof *recording->line);
    reader->words = arena_array(&recording->arena, (size_t)recording->columns, sizeof *reader->words);
    return recording->t && recording->line && reader->words;
}

bool table_rows(const struct table_text *text, const struct table_layout *layout, struct recording *recording,
                struct error *error)
{
    struct reader reader = {.recording = recording, .layout = layout};
    struct text rest = {layout->begin, (size_t)(text->text.at + text->text.len - layout->begin)}, line;
    if (!table_columns(layout, recording, error))
        return false;
    if (!allocate(&reader, rest))
        return error_memory(error);
    recording->separator = layout->separator;
    recording->decimal = layout->decimal;
    recording->header_lines = (int)(layout->line - 1);
    size_t number = layout->line, data = 0;
    for (; table_line(&rest, &line); number++) {
        if (table_skipped(line))
            continue;
        bool row = line.len <= LIMIT_LINE && read_row(&reader, line, number);
        reader.ended = line.at + line.len < text->text.at + text->text.len;
        if (!row && !reader.ended) {
            recording_warn(recording, "the last line (%zu) is cut short: dropped", number);
            recording->dropped++;
        } else if (!row) {
            note(&reader.ragged, number, line);
        } else {
            memmove(reader.recent + 1, reader.recent, BEFORE_LAST * sizeof *reader.recent);
            reader.recent[0] = line;
            recording->line[recording->rows] = (uint32_t)number;
            recording->t[recording->rows++] = (double)data;
        }
        data++;
    }
    if (recording->rows > 0 && !reader.ended && recording->line[recording->rows - 1] + 1 == number && is_cut(&reader)) {
        char shown[SHORT_NAME];
        recording_warn(recording, "the last line (%zu) seems cut in mid-number ('%s'): dropped", number - 1,
                       short_name(last_field(reader.recent[0], layout->separator), shown));
        recording->rows--;
        recording->dropped++;
    }
    recording->dropped += reader.ragged.count;
    name_columns(recording);
    warn_rows(&reader);
    return true;
}

bool table_read(const struct table_text *text, const struct load_options *options, struct recording *recording,
                struct error *error)
{
    (void)options;
    if (text->layout.columns == 0) {
        *error = text->problem;
        return false;
    }
    return table_rows(text, &text->layout, recording, error);
}
