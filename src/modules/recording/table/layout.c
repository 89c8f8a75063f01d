/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the table in a file and the way its rows are written. For each separator and decimal mark,
 * searches the first consecutive lines that split into the same number of numbers; the pair that
 * reads most of the following lines is chosen. */
#include <hooke/base/unit.h>
#include "modules/recording/table/table.h"

#include <math.h>
#include <string.h>

/* Consecutive rows that make a table, if the file has that many. */
#define TABLE_ROWS_MIN 3
/* Lines that are counted to compare two pairs. */
#define SCORED_LINES_MAX 200

/* Pairs in the order of preference if two read the same number of lines. '\n' separates nothing: it
 * stands for a single column. */
static const struct separator_pair {
    char separator, decimal;
    bool grouped; /* the other mark may be between thousands */
} readings[] = {
    {'\t', '.', false}, {'\t', ',', false}, {';', '.', false}, {';', ',', false},
    {',', '.', false},  {' ', '.', false},  {' ', ',', false}, {'\n', '.', false},
    {'\n', ',', false}, {',', ',', false}, /* decimals in quotes */
};

/* Numbers of fields, of numbers and of words in a line, and signs of a wrong decimal mark. */
struct shape {
    int fields, numbers, words;
    bool last_empty; /* the row ends in a separator */
    bool fraction;   /* some number has a decimal point */
    /* A whole number other than 0 starts with 0, which happens if a decimal comma was taken as a
     * separator. */
    bool led_by_zero;
};

/* Splits a line by the separator and decimal mark of `reading` and counts the kinds of fields. */
static struct shape shape_of(struct text line, struct separator_pair reading)
{
    struct shape shape = {0};
    struct text field;
    double value;
    while (shape.fields <= (int)LIMIT_COLUMNS && table_field(&line, reading.separator, &field)) {
        enum cell_kind cell = table_cell(field, reading.decimal, &value);
        shape.fields++;
        if (cell == CELL_WORD && reading.grouped && field.data[0] != '0' &&
            table_grouped(field, reading.decimal, &value)) {
            shape.numbers++;
            continue;
        }
        shape.numbers += cell == CELL_NUMBER || cell == CELL_STAMP;
        shape.words += cell == CELL_WORD;
        shape.last_empty = field.len == 0;
        if (cell != CELL_NUMBER)
            continue;
        bool whole = !memchr(field.data, reading.decimal, field.len);
        shape.fraction |= !whole;
        shape.led_by_zero |= whole && field.len > 1 && field.data[0] == '0';
    }
    return shape;
}

/* Returns true if a line of that shape may be a row with at least `min` fields. With `words`, some
 * fields may be words. Blanks also separate the words of sentences, and commas their parts, so more
 * numbers than words are required there, or as many. */
static bool is_row(struct shape shape, char separator, int min, bool words)
{
    int more = -shape.fields; /* required excess of numbers over words */
    if (separator == ' ')
        more = 1;
    else if (separator == ',')
        more = 0;
    return shape.fields >= min && shape.fields <= (int)LIMIT_COLUMNS && shape.numbers > 0 &&
           (shape.words == 0 ||
            (words && shape.numbers >= 2 && shape.numbers >= shape.words + more));
}

/* The table that one pair of separator and decimal mark finds. */
struct found {
    struct separator_pair reading;
    size_t first;      /* head[first] is the first row */
    int fields, score; /* width, and number of rows among the lines counted */
    bool trailing;     /* every counted row ends in a separator */
    bool fraction, led_by_zero;
};

/* Finds `run` consecutive rows of at least `min` fields in the first lines of a text; if `words`,
 * some fields may be words. Sets *found to the first row and the score, the number of rows. Returns
 * false if there are none. */
static bool find_rows(const struct table_text *text, size_t first_line,
                      struct separator_pair reading, int min, bool words, int run,
                      struct found *found)
{
    int same = 0;
    *found = (struct found){.reading = reading, .trailing = true};
    for (size_t i = first_line, counted = 0; i < text->heads && counted < SCORED_LINES_MAX; i++) {
        if (table_skipped(text->head[i].text))
            continue;
        /* A line without the separator is not a row if two fields are required; most pairs end
         * here. */
        const bool single =
            min > 1 && reading.separator != ' ' &&
            !memchr(text->head[i].text.data, reading.separator, text->head[i].text.len);
        struct shape shape =
            single ? (struct shape){.fields = 1} : shape_of(text->head[i].text, reading);
        bool row = is_row(shape, reading.separator, min, words) &&
                   (same == 0 || shape.fields == found->fields);
        if (same < run && !row) { /* a row of another width may be the first of the table */
            same = 0;
            counted = 0;
            *found = (struct found){.reading = reading, .trailing = true};
            row = is_row(shape, reading.separator, min, words);
        }
        if (row && same++ == 0) {
            found->first = i;
            found->fields = shape.fields;
        }
        counted += same > 0;
        found->score += row;
        found->trailing &= !row || shape.last_empty;
        found->fraction |= row && shape.fraction;
        found->led_by_zero |= row && shape.led_by_zero;
    }
    return same >= run;
}

/* Returns the first row, including rows of another width directly above, which would otherwise be
 * taken for the header. */
static size_t first_row(const struct table_text *text, const struct found *found, size_t first_line)
{
    size_t first = found->first;
    for (size_t i = found->first; i-- > first_line;) {
        struct text line = text->head[i].text, field;
        double value;
        if (table_skipped(line))
            continue;
        if (!table_field(&line, found->reading.separator, &field))
            break;
        const enum cell_kind cell = table_cell(field, found->reading.decimal, &value);
        if (cell != CELL_NUMBER && cell != CELL_STAMP)
            break;
        first = i;
    }
    return first;
}

/* Returns the number of fields in a line, without empty ones at its end. */
static int field_count(struct text line, char separator)
{
    struct text field;
    int fields = 0, used = 0; /* number of fields, and the same without empty ones at the end */
    while (fields <= (int)LIMIT_COLUMNS && header_field(&line, separator, &field)) {
        fields++;
        used = field.len > 0 ? fields : used;
    }
    return used;
}

/* Returns true if all fields of a line are units or are in brackets. */
static bool all_units(struct text line, char separator)
{
    struct text field;
    int units = 0;
    while (table_field(&line, separator, &field)) {
        bool bracketed =
            field.len > 2 && strchr("([", field.data[0]) && strchr(")]", field.data[field.len - 1]);
        if (field.len > 0 && !bracketed && !unit_find(field))
            return false;
        units += field.len > 0;
    }
    return units > 0;
}

/* Returns the separator with which the line names all columns or, unless `exact`, the separator of
 * the numbers if it is not a blank and gives at least two fields; else 0. */
static char names_separator(struct text line, const struct table_layout *layout, bool exact)
{
    const char separators[] = {layout->separator, '\t', ';', ','};
    for (size_t i = 0; i < COUNT_OF(separators); i++)
        if (field_count(line, separators[i]) == layout->columns)
            return separators[i];
    return !exact && layout->separator != ' ' && field_count(line, layout->separator) >= 2
               ? layout->separator
               : 0;
}

/* Returns true for a comment of the form "# rows: 300" (key, colon, content). Sets *line to the
 * names of the columns if the comment lists them, else to an empty text. A single name of a table
 * with several columns ("# name: data", as Octave saves a matrix) becomes the stem of their
 * names. */
static bool keyed_comment(struct text *line, struct table_layout *layout)
{
    struct text rest = text_trim(*line), key, first;
    double value;
    if (rest.len == 0 || rest.data[rest.len - 1] == ':' || !text_split(&rest, ':', &key) ||
        memchr(key.data, ' ', key.len) || !rest.data)
        return false;
    *line = (struct text){0};
    const bool name = text_is(key, "name");
    if (!name && !text_is(key, "columns") && !text_is(key, "fields") && !text_is(key, "names"))
        return true;
    rest = text_trim(rest);
    struct text fields = rest;
    if (!table_field(&fields, layout->separator, &first) ||
        table_cell(first, layout->decimal, &value) != CELL_WORD)
        return true;
    if (names_separator(rest, layout, true))
        *line = rest;
    else if (name)
        layout->stem = rest;
    return true;
}

/* Finds the header lines above the first row (names, or names and then units) and sets them in the
 * layout. Sets *fields_above to the number of fields in the line directly above, or 0. */
static void find_names(const struct table_text *text, size_t first, size_t first_line,
                       struct table_layout *layout, int *fields_above)
{
    struct text candidate[2] = {{0}};
    char separator[2] = {0};
    size_t candidates = 0;
    *fields_above = 0;
    for (size_t i = first; i-- > first_line && candidates < 2 && layout->stem.len == 0;) {
        struct text line = text_trim(text->head[i].text);
        const bool comment = table_comment(line);
        if (line.len == 0 ||
            (comment ? memchr(line.data, '=', line.len) != NULL : table_skipped(line)))
            continue;
        /* Names may follow a # or %, as in "# t y". */
        line = comment ? text_after(line, 1) : text->head[i].text;
        if (comment && keyed_comment(&line, layout) && line.len == 0)
            continue;
        if (!comment && *fields_above == 0)
            *fields_above = field_count(line, layout->separator);
        separator[candidates] = names_separator(line, layout, comment);
        if (!separator[candidates])
            break;
        candidate[candidates++] = line;
    }
    const bool units = candidates == 2 && all_units(candidate[0], separator[0]);
    layout->units = units ? candidate[0] : (struct text){0};
    layout->names = candidate[units];
    layout->name_separator = separator[units];
}

/* Returns true if the user's options permit the pair. */
static bool is_allowed(struct separator_pair reading, const struct load_options *options)
{
    return (!options->separator || options->separator == reading.separator ||
            reading.separator == '\n') &&
           (!options->decimal || options->decimal == reading.decimal);
}

/* Role of the commas between whole numbers: separators, perhaps decimal marks, too unclear to
 * guess, decimal marks. */
enum commas { COMMAS_SEPARATE, COMMAS_PERHAPS, COMMAS_UNCLEAR, COMMAS_DECIMAL };

/* Judges the commas from the number of fields in the line above and from leading zeros. */
static enum commas commas_of(const struct found *found, int fields_above)
{
    if (found->reading.separator != ',' || found->fraction || fields_above == found->fields)
        return COMMAS_SEPARATE;
    if (found->fields == 2)
        return fields_above == 1 || found->led_by_zero ? COMMAS_DECIMAL : COMMAS_PERHAPS;
    return fields_above >= 2 || found->led_by_zero ? COMMAS_UNCLEAR : COMMAS_PERHAPS;
}

/* Sets *layout to the layout of the table that was found: its separator, decimal mark, names, and
 * first row at or after first_line. Returns false if the commas of the table must be decimal marks,
 * so that this separator is wrong. */
static bool layout_fill(const struct table_text *text, size_t first_line,
                        const struct load_options *options, const struct found *found,
                        struct table_layout *layout)
{
    size_t first = first_row(text, found, first_line);
    int fields_above;
    *layout = (struct table_layout){.separator = found->reading.separator,
                                    .decimal = found->reading.decimal,
                                    .columns = found->fields,
                                    .begin = text->head[first].text.data,
                                    .line = text->head[first].number};
    find_names(text, first, first_line, layout, &fields_above);
    layout->fields_above = fields_above;
    if (found->trailing && field_count(layout->names, layout->name_separator) < found->fields)
        layout->columns--;
    enum commas commas =
        options->separator || options->decimal ? COMMAS_SEPARATE : commas_of(found, fields_above);
    layout->ambiguous = commas == COMMAS_PERHAPS;
    layout->unclear = commas == COMMAS_UNCLEAR;
    return commas != COMMAS_DECIMAL;
}

/* Decides the decimal mark by the whole file if the first lines have only whole numbers, as a
 * record that begins at rest. */
static void settle_decimal(const struct table_text *text, const struct found *found,
                           const struct load_options *options, struct table_layout *layout)
{
    if (options->decimal || found->fraction || layout->separator == ',')
        return;
    size_t len = (size_t)(text->text.data + text->text.len - layout->begin);
    if (memchr(layout->begin, ',', len) && !memchr(layout->begin, '.', len))
        layout->decimal = ',';
}

/* Finds the best pair of separator and decimal mark, from strict passes to lenient ones, and sets
 * the layout. Returns false if there is no table, or if either mark could separate thousands. */
static bool find_best(const struct table_text *text, size_t first_line,
                      const struct load_options *options, struct table_layout *layout)
{
    static const struct {
        int min, run;
        bool words, grouped;
    } passes[] = {{2, TABLE_ROWS_MIN, false, false},
                  {2, TABLE_ROWS_MIN, true, false},
                  {2, TABLE_ROWS_MIN, false, true},
                  {1, TABLE_ROWS_MIN, false, false},
                  {2, 2, false, false},
                  {2, 1, false, false}};
    for (size_t pass = 0; pass < COUNT_OF(passes); pass++) {

        struct found best = {0};
        bool tied = false; /* either mark could stand between thousands */
        const bool grouped = passes[pass].grouped;
        for (size_t i = 0; i < COUNT_OF(readings) && (grouped || best.score < SCORED_LINES_MAX);
             i++) { /* more than all is not read */
            struct found found;
            struct table_layout trial;
            struct separator_pair reading = readings[i];
            reading.grouped = grouped;
            if ((readings[i].separator == '\n') != (passes[pass].min == 1) ||
                !is_allowed(readings[i], options) ||
                !find_rows(text, first_line, reading, passes[pass].min, passes[pass].words,
                           passes[pass].run, &found) ||
                (grouped && !found.fraction) || found.score < best.score)
                continue;
            tied |= grouped && best.score > 0 && found.score == best.score &&
                    found.reading.decimal != best.reading.decimal;
            if (found.score == best.score ||
                (readings[i].separator == readings[i].decimal && !found.fraction) ||
                !layout_fill(text, first_line, options, &found, &trial))
                continue;
            best = found;
            *layout = trial;
            tied = false;
        }
        if (tied) {
            *layout = (struct table_layout){0};
            return false;
        }
        if (best.score > 0) {
            settle_decimal(text, &best, options, layout);
            const char other = layout->decimal == '.' ? ',' : '.';
            if (!options->decimal && best.fraction && is_grouped(text, layout, layout->decimal)) {
                layout->decimal = other;
                layout->grouped = true;
            } else if (best.fraction && is_grouped(text, layout, other)) {
                layout->grouped = true;
            }
            layout->grouped |= grouped;
            find_unpadded(text, layout);
            return true;
        }
    }
    return false;
}

/* Returns a line of the head with more fields than a table may have, with whatever separator, or
 * NULL. */
static const struct table_line *wide_line(const struct table_text *text, size_t first_line)
{
    for (size_t i = first_line; i < text->heads; i++)
        for (size_t r = 0; r < COUNT_OF(readings) && text->head[i].text.len > LIMIT_COLUMNS; r++)
            if (shape_of(text->head[i].text, readings[r]).fields > (int)LIMIT_COLUMNS)
                return &text->head[i];
    return NULL;
}

/* Sets the error that tells why there is no table. Returns false. */
static bool no_table(const struct table_text *text, size_t first_line, struct error *error)
{
    const struct table_line *line = wide_line(text, first_line);
    if (line) {
        error_set(error, ERROR_IO, "line %zu of %s has more than %d columns", line->number,
                  text->name, (int)LIMIT_COLUMNS);
        return error_hint(error, "export fewer columns");
    }
    for (size_t i = first_line; i < text->heads; i++)
        if (text->head[i].text.len >= HEAD_BYTES)
            return error_set(error, ERROR_IO,
                             "line %zu of %s has more than %u bytes, so no table starts there",
                             text->head[i].number, text->name, HEAD_BYTES);
    error_set(error, ERROR_IO, "no table of numbers found in %s", text->name);
    return error_hint(error, "a table has rows of numbers separated by tabs, semicolons, commas or "
                             "blanks; sep= and decimal= describe others");
}

/* Finds the best layout of a table in the first lines of the text, from first_line on. Returns
 * false with the error if there is none, or if its commas are unclear. */
bool table_find(const struct table_text *text, size_t first_line,
                const struct load_options *options, struct table_layout *layout,
                struct error *error)
{
    *layout = (struct table_layout){0};
    if (options->separator == ',' && options->decimal == ',')
        return error_set(error, ERROR_COMMAND,
                         "the comma cannot be both the separator and the decimal mark");
    if (!find_best(text, first_line, options, layout))
        return no_table(text, first_line, error);
    if (layout->unclear) {
        error_set(error, ERROR_IO,
                  "the commas in line %zu of %s could be separators or decimal marks", layout->line,
                  text->name);
        layout->columns = 0;
        return error_hint(error, "export it with semicolons or tabs; decimal=point sep=comma takes "
                                 "every comma as a separator");
    }
    return true;
}
