/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Finds the meaning of marks in numbers that a single number does not tell: decimal marks or
 * separators of thousands, and decimals that are not padded. */
#include "modules/recording/table/table.h"

#include <math.h>
#include <string.h>

enum { COLUMNS_LOOKED_AT = 8 };

/* ---- between thousands ---- */

/* Reads digits that may have the mark before every three. Sets *group to the number if it has marks
 * between thousands, else to 0, and *value to the number if the (first) mark is a decimal one.
 * Returns false if a mark is elsewhere, so that it cannot separate thousands. */
static bool read_group(struct text field, char mark, double *value, double *group)
{
    const char other = mark == '.' ? ',' : '.';
    size_t i = field.len > 0 && field.data[0] == '-', digits = 0, marks = 0;
    double number = 0;
    *value = *group = 0;
    for (; i < field.len; i++) {
        const char c = field.data[i];
        if (c == mark) {
            if (digits == 0 || digits > 3 || (marks > 0 && digits != 3))
                return false;
            *value = marks == 0 ? number : *value;
            marks++;
            digits = 0;
        } else if (c >= '0' && c <= '9') {
            number = 10 * number + (c - '0');
            digits++;
        } else { /* decimals after thousands are clear */
            *value = *group = 0;
            return marks == 0 ? !memchr(field.data, mark, field.len) : c == other && digits == 3;
        }
    }
    if (marks > 0 && digits != 3)
        return false;
    if (marks > 0) {
        const double whole = *value;
        *group = number;
        *value = marks == 1 ? number / 1000 : whole;
    } else {
        *value = number;
    }
    return true;
}

/* Returns true if the mark separates thousands: a column continues from whole numbers of three
 * digits (960, 980) to numbers with three digits after the mark (1.000, 1.020) without a jump, and
 * no number has another count of digits after the mark. */
bool is_grouped(const struct table_text *text, const struct table_layout *layout, char mark)
{
    double previous[COLUMNS_LOOKED_AT] = {0}, value, group;
    int votes = 0;
    struct text field;
    for (size_t i = 0; i < text->heads; i++) {
        struct text line = text->head[i].text;
        if (text->head[i].number < layout->line || table_skipped(line))
            continue;
        for (int c = 0; c < COLUMNS_LOOKED_AT && table_field(&line, layout->separator, &field);
             c++) {
            if (!read_group(field, mark, &value, &group))
                return false;
            if (group > 0 && previous[c] >= 500) {
                if (fabs(group - previous[c]) >= fabs(value - previous[c]))
                    return false;
                votes++;
            }
            previous[c] = group > 0 ? 0 : value;
        }
    }
    return votes > 0;
}

/* ---- decimals that are not padded ---- */

enum { MILLI_DIGITS = 3, MICRO_DIGITS = 6 };

/* Evidence that a column's decimals are not padded. */
struct unpadded_column {
    /* Digits before and after the mark in the previous row, and the number. */
    double whole, part, number;
    /* Range of the steps of the digits after the mark, among rows with the same digits before
     * it. */
    double step_min, step_max;
    /* Number of rows, and of those at which the number, if padded, would fall. */
    size_t rows, back;
    int digits_max;
    bool excluded; /* the decimals are padded, or it is not such a column */
};

/* Reads digits, the mark and digits into *whole, *part and the number of digits after the mark;
 * without a mark *part and *digits are 0. Returns false for anything else, and if the digits after
 * the mark begin with a padding 0. */
static bool read_parts(struct text field, char mark, double *whole, double *part, int *digits)
{
    bool is_fraction = false;
    *whole = *part = 0;
    *digits = 0;
    field = text_trim(field);
    for (size_t i = 0; i < field.len; i++) {
        const char c = field.data[i];
        if (c == mark && i > 0 && !is_fraction) {
            is_fraction = true;
            continue;
        }
        if (c < '0' || c > '9')
            return false;
        double *number = is_fraction ? part : whole;
        *number = 10 * *number + (c - '0');
        *digits += is_fraction;
    }
    const bool padded = *digits > 1 && field.data[field.len - (size_t)*digits] == '0';
    return field.len > 0 && !padded && *digits <= MICRO_DIGITS;
}

/* Adds a field of the next row to the evidence that the digits after the mark are a whole number
 * without padding; excludes the column if the field contradicts that. */
static void unpadded_column_update(struct unpadded_column *column, struct text field, char mark)
{
    double whole, part;
    int digits;
    if (!read_parts(field, mark, &whole, &part, &digits)) {
        column->excluded = true;
        return;
    }
    const double number = whole + part / pow(10, digits);
    if (column->rows++ == 0) {
        column->step_min = HUGE_VAL;
    } else {
        column->excluded |=
            whole < column->whole || (whole == column->whole && part < column->part);
        column->back += number < column->number;
        if (whole == column->whole) {
            column->step_min = fmin(column->step_min, part - column->part);
            column->step_max = fmax(column->step_max, part - column->part);
        }
    }
    column->whole = whole;
    column->part = part;
    column->number = number;
    column->digits_max = digits > column->digits_max ? digits : column->digits_max;
}

/* Finds columns of a program that prints seconds, a point and then milliseconds as a whole number:
 * 0.80, 0.100, 0.120. The numbers fall, but the digits after the point rise. There are at most
 * three digits (six for microseconds), and none begins with a padding 0. */
void find_unpadded(const struct table_text *text, struct table_layout *layout)
{
    struct unpadded_column column[COLUMNS_LOOKED_AT] = {0};
    struct text field;
    for (size_t i = 0; i < text->heads; i++) {
        struct text line = text->head[i].text;
        if (text->head[i].number < layout->line || table_skipped(line))
            continue;
        for (int c = 0; c < COLUMNS_LOOKED_AT && table_field(&line, layout->separator, &field); c++)
            if (!column[c].excluded)
                unpadded_column_update(&column[c], field, layout->decimal);
    }
    for (int c = COLUMNS_LOOKED_AT; c-- > 0;) {
        const int digits = column[c].digits_max;
        const bool even = column[c].rows >= 8 && column[c].step_max < 2 * column[c].step_min;
        if (column[c].excluded || column[c].back < 1 || (column[c].back < 2 && !even) ||
            (digits != MILLI_DIGITS && digits != MICRO_DIGITS))
            continue;
        layout->unpadded = c + 1;
        layout->unpadded_parts = pow(10, digits);
    }
}

/* The digits after the mark count parts, so that 0.20 is 20 of unpadded_parts. */
double unpadded_value(struct text field, const struct table_layout *layout)
{
    double whole, part;
    int digits;
    if (!read_parts(field, layout->decimal, &whole, &part, &digits) ||
        part >= layout->unpadded_parts)
        return NAN;
    return (whole * layout->unpadded_parts + part) / layout->unpadded_parts;
}
