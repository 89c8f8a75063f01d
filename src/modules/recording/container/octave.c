/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Text files of Octave (save -text) that store columns as vectors, one after the other: vectors of
 * equal length become a table. A single matrix is a table already and is read as ordinary text. */
#include "modules/recording/container/container.h"

#include <hooke/base/number.h>
#include <hooke/base/numeric.h>

#include "modules/recording/table/table.h"

#include <math.h>
#include <string.h>

/* Largest number of variables that are read from a file. */
enum { VARIABLES_MAX = 256 };

/* A variable of the file; its texts point into the file's text. */
struct octave_variable {
    struct text name, body; /* the body has its numbers, separated by white space */
    double rows, columns;   /* 0 unless it is an array of real numbers */
    bool is_range;          /* the body is base, limit, increment */
    double base, increment;
};

struct octave_file {
    struct octave_variable variable[VARIABLES_MAX];
    size_t variables;
};

static const char *const blanks = " \t\r\n";

/* Takes the next number or word off the text. Returns an empty text at its end. */
static struct text next_word(struct text *rest)
{
    const size_t gap = rest->len > 0 ? strspn(rest->data, blanks) : 0;
    const size_t skipped = gap < rest->len ? gap : rest->len;
    *rest = (struct text){rest->data + skipped, rest->len - skipped};
    const size_t used = rest->len > 0 ? strcspn(rest->data, blanks) : 0;
    const struct text word = {rest->data, used < rest->len ? used : rest->len};
    *rest = (struct text){rest->data + word.len, rest->len - word.len};
    return word;
}

/* Returns true if the line begins with the label; sets *value to the text after it. */
static bool has_label(struct text line, const char *label, struct text *value)
{
    if (!text_starts(line, text_of(label)))
        return false;
    *value = text_trim(text_after(line, strlen(label)));
    return true;
}

/* Reads a range (base:increment:limit) as a vector; a faulty one stays empty. */
static void read_range(struct octave_variable *v)
{
    struct text rest = v->body;
    double limit;
    if (real_parse(next_word(&rest), &v->base) == REAL_OK &&
        real_parse(next_word(&rest), &limit) == REAL_OK &&
        real_parse(next_word(&rest), &v->increment) == REAL_OK && v->increment != 0) {
        v->rows = floor((limit - v->base) / v->increment * (1 + 1e-12) + 1e-9) + 1;
        v->columns = 1;
    }
}

/* Collects the variables of the file, up to VARIABLES_MAX. */
static void read_variables(struct text text, struct octave_file *file)
{
    struct text line, value;
    struct octave_variable *v = NULL;
    bool is_matrix = false;
    while (table_line(&text, &line)) {
        if (has_label(line, "# name:", &value)) {
            if (v && v->is_range)
                read_range(v);
            if (file->variables == VARIABLES_MAX)
                return;
            v = &file->variable[file->variables++];
            *v = (struct octave_variable){.name = value};
            is_matrix = false;
        } else if (v && has_label(line, "# type:", &value)) {
            is_matrix = text_is(value, "matrix");
            v->is_range = text_is(value, "range") || text_is(value, "double_range");
        } else if (is_matrix && has_label(line, "# rows:", &value)) {
            v->rows = real_parse(value, &v->rows) == REAL_OK ? v->rows : 0;
        } else if (is_matrix && has_label(line, "# columns:", &value)) {
            v->columns = real_parse(value, &v->columns) == REAL_OK ? v->columns : 0;
        } else if (v && line.len > 0 && line.data[0] != '#') {
            if (v->body.len == 0)
                v->body.data = line.data;
            v->body.len = (size_t)(line.data + line.len - v->body.data);
        }
    }
    if (v && v->is_range)
        read_range(v);
}

/* Returns the number of values of a vector, or 0 for anything else and for a vector that claims
 * more values than its text can hold. */
static double vector_length(const struct octave_variable *v)
{
    static const double range_max = 1e7;
    const double length = v->rows * v->columns,
                 max = v->is_range ? range_max : 0.5 * (double)(v->body.len + 1);
    return (v->rows == 1 || v->columns == 1) && length >= 2 && length <= max ? length : 0;
}

/* Returns the length of the longest vectors shorter than `limit`, or 0 if there are none. */
static double longest_vectors(const struct octave_file *file, double limit)
{
    double longest = 0;
    for (size_t i = 0; i < file->variables; i++) {
        const double length = vector_length(&file->variable[i]);
        longest = length < limit ? fmax(longest, length) : longest;
    }
    return longest;
}

/* Adds a part with all vectors of `length` elements side by side as columns. Adds none, and returns
 * true, if fewer than two vectors have that length or contents has PARTS_MAX parts. Returns false
 * with the error set if out of memory or cancelled. */
static bool add_table(struct octave_file *file, double length, struct contents *contents,
                      struct error *error)
{
    struct octave_variable *column[VARIABLES_MAX];
    size_t count = 0;
    for (size_t i = 0; i < file->variables; i++)
        if (vector_length(&file->variable[i]) == length)
            column[count++] = &file->variable[i];
    struct container_part *part = count > 1 ? contents_add(contents, column[0]->name) : NULL;
    if (!part)
        return count < 2 || contents->parts == PARTS_MAX || error_memory(error);
    for (size_t i = 0; i < count; i++) {
        buffer_put(&part->text, i > 0 ? TEXT("\t") : TEXT(""));
        put_cell(&part->text, column[i]->name);
    }
    for (double row = 0; row < length && !part->text.failed; row++) {
        if (fmod(row, LOOK_EACH_ROWS) == 0 && !unpacking_goes_on(contents->cancel, error))
            return false;
        buffer_char(&part->text, '\n');
        for (size_t i = 0; i < count; i++) {
            buffer_put(&part->text, i > 0 ? TEXT("\t") : TEXT(""));
            if (column[i]->is_range)
                buffer_format(&part->text, "%.17g", column[i]->base + row * column[i]->increment);
            else
                buffer_put(&part->text, next_word(&column[i]->body));
        }
    }
    buffer_char(&part->text, '\n');
    return !part->text.failed || error_memory(error);
}

/* Returns true if a variable has several rows and several columns. */
static bool has_matrix(const struct octave_file *file)
{
    for (size_t i = 0; i < file->variables; i++)
        if (file->variable[i].rows > 1 && file->variable[i].columns > 1)
            return true;
    return false;
}

/* Returns false with the error if there are two vectors, which then differ in length. */
static bool refuse_lengths(const struct octave_file *file, const char *shown, struct error *error)
{
    const struct octave_variable *a = NULL, *b = NULL;
    for (size_t i = 0; i < file->variables; i++)
        if (vector_length(&file->variable[i]) > 0) {
            b = a && !b ? &file->variable[i] : b;
            a = a ? a : &file->variable[i];
        }
    if (!b)
        return true;
    error_set(error, ERROR_IO,
              "%s contains vectors of different length, %.*s (%.0f values) and %.*s (%.0f values), "
              "which cannot form a table",
              shown, (int)text_fitting(a->name, SHORT_NAME - 1), a->name.data, vector_length(a),
              (int)text_fitting(b->name, SHORT_NAME - 1), b->name.data, vector_length(b));
    return error_hint(error, "save one matrix: M = [t(:) y(:)]; save -text FILE M");
}

/* Makes a part of the vectors of each length in a text file of Octave, from the longest down. Adds
 * none if the file has a matrix instead. Returns false with the error if vectors of different
 * lengths form no table. */
bool octave_tables(struct text text, const char *shown, struct contents *contents,
                   struct error *error)
{
    struct octave_file file = {.variables = 0};
    read_variables(text, &file);
    double length = longest_vectors(&file, HUGE_VAL);
    while (length > 0) {
        if (!add_table(&file, length, contents, error))
            return false;
        length = longest_vectors(&file, length);
    }
    if (contents->parts > 0)
        contents->container = "Octave";
    return contents->parts > 0 || has_matrix(&file) || refuse_lengths(&file, shown, error);
}
