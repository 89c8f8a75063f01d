/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Compares the tables of a hand-in with those that its session gives: values.csv by value and
 * uncertainty, data files number by number. */
#include "modules/report/check.h"

#include <math.h>
#include <string.h>

#define SAME_DIGITS 1e-6      /* relative tolerance for values without uncertainty */
#define SAME_UNCERTAINTY 0.05 /* uncertainties have two digits */

/* Largest difference of two numbers of a data file that counts as none, relative to the largest
 * number of the column. A recording that is read back from recording-N.csv may differ in its last
 * bits from the file that it was loaded from, and so may every run that starts from its fit. */
static const double data_tolerance_relative = 1e-9;

/* The same for numbers without a unit, which are often errors relative to something of size 1. */
static const double data_tolerance_of_one = 1e-13;

/* ---- values ---- */

/* Columns of values.csv; each is NULL if the table has none of that name and type. */
struct values {
    const char *const *name, *const *subject, *const *source;
    const double *value, *uncertainty, *t;
    size_t rows;
};

/* Finds the columns of values.csv. Returns false if a necessary one is missing; t is not
 * necessary. */
static bool find_values(const struct table *table, struct values *values)
{
    *values = (struct values){.rows = table->rows};
    for (int i = 0; i < table->columns; i++) {
        const struct table_column *column = &table->column[i];
        const struct {
            const char *name;
            const char *const **text;
            const double **number;
        } wanted[] = {
            {"name", &values->name, NULL},
            {"of", &values->subject, NULL},
            {"source", &values->source, NULL},
            {"value", NULL, &values->value},
            {"uncertainty", NULL, &values->uncertainty},
            {"t", NULL, &values->t},
        };
        for (size_t k = 0; k < COUNT_OF(wanted); k++) {
            if (strcmp(column->name, wanted[k].name) != 0)
                continue;
            if (wanted[k].text)
                *wanted[k].text = column->text;
            else
                *wanted[k].number = column->value;
        }
    }
    return values->name && values->subject && values->source && values->value &&
           values->uncertainty;
}

/* Returns the time of a value, or -infinity if it has none, so that those compare equal. */
static double checked_time(const struct values *values, size_t row)
{
    return values->t && isfinite(values->t[row]) ? values->t[row] : -HUGE_VAL;
}

/* Returns true if two rows are of the same quantity: name, subject, source and time. */
static bool same_key(const struct values *a, size_t i, const struct values *b, size_t j)
{
    return strcmp(a->name[i], b->name[j]) == 0 && strcmp(a->subject[i], b->subject[j]) == 0 &&
           strcmp(a->source[i], b->source[j]) == 0 && !(checked_time(a, i) < checked_time(b, j)) &&
           !(checked_time(a, i) > checked_time(b, j));
}

/* Returns the row of `b` that corresponds to row i of `a`. Rows with the same name are counted:
 * the second one in `a` corresponds to the second one in `b`. */
static size_t find_row(const struct values *a, size_t i, const struct values *b)
{
    size_t duplicates = 0;
    for (size_t k = 0; k < i; k++)
        duplicates += same_key(a, k, a, i);
    for (size_t j = 0; j < b->rows; j++)
        if (same_key(a, i, b, j) && duplicates-- == 0)
            return j;
    return b->rows;
}

/* Returns true if the values differ by no more than the computed uncertainty (or by SAME_DIGITS if
 * there is none) and the uncertainties are the same within SAME_UNCERTAINTY. */
static bool values_agree(struct measured stated, struct measured computed)
{
    const double u = isfinite(computed.uncertainty) ? fabs(computed.uncertainty) : 0;
    const double v = isfinite(stated.uncertainty) ? fabs(stated.uncertainty) : 0;
    return fabs(stated.value - computed.value) <= fmax(u, SAME_DIGITS * fabs(computed.value)) &&
           fabs(v - u) <= SAME_UNCERTAINTY * u;
}

/* Compares row i of the folder's values with row j of the session's, and reports a difference. */
static void compare_value(struct check *check, const struct values *handed, size_t i,
                          const struct values *repeated, size_t j)
{
    const struct measured stated = {handed->value[i], handed->uncertainty[i]};
    const struct measured computed = {repeated->value[j], repeated->uncertainty[j]};
    check->values++;
    if (values_agree(stated, computed))
        return;
    struct buffer detail = {0};
    buffer_format(&detail,
                  "%s of %s (%s): the folder has %.9g +- %.2g, the session gives %.9g +- %.2g",
                  handed->name[i], handed->subject[i], handed->source[i], stated.value,
                  stated.uncertainty, computed.value, computed.uncertainty);
    check_differs(check, "values.csv", "a value", buffer_text(&detail));
    buffer_free(&detail);
}

/* Reports a row that only one of the tables has; `what` says which. */
static void report_unmatched(struct check *check, const struct values *values, size_t i,
                             const char *what)
{
    struct buffer detail = {0};
    buffer_format(&detail, "%s of %s (%s) = %.9g", values->name[i], values->subject[i],
                  values->source[i], values->value[i]);
    check->values++;
    check_differs(check, "values.csv", what, buffer_text(&detail));
    buffer_free(&detail);
}

/* Compares values.csv of a hand-in, handed_text, with that of the repeated session: adds a
 * difference to *check for each row that differs or is only in one of them, and for a table that
 * cannot be read. */
void check_values(struct check *check, struct text handed_text, struct text repeated_text)
{
    struct table handed_table = {0}, repeated_table = {0};
    struct values handed, repeated;
    struct error error = {0};
    if (!table_parse(handed_text, NULL, &check->arena, &handed_table, &error) ||
        !find_values(&handed_table, &handed)) {
        if (!text_equal(handed_text, repeated_text)) /* else it has a heading alone */
            check_differs(check, "values.csv", "it is not a table of values", text_of(error.text));
        return;
    }
    if (!table_parse(repeated_text, NULL, &check->arena, &repeated_table, &error) ||
        !find_values(&repeated_table, &repeated))
        return;
    for (size_t i = 0; i < handed.rows; i++) {
        const size_t j = find_row(&handed, i, &repeated);
        if (j < repeated.rows)
            compare_value(check, &handed, i, &repeated, j);
        else
            report_unmatched(check, &handed, i, "the session does not give");
    }
    for (size_t j = 0; j < repeated.rows; j++)
        if (find_row(&repeated, j, &handed) == handed.rows)
            report_unmatched(check, &repeated, j, "it lacks");
}

/* ---- data ---- */

/* Difference between two tables of the same shape. */
struct data_difference {
    size_t count, row; /* cells that differ, and the row of the largest difference */
    int column;
    double relative; /* largest difference, relative to the largest number of its column */
};

/* Returns the largest magnitude of the finite numbers of a column. */
static double column_max(const struct table_column *column, size_t rows)
{
    double max = 0;
    for (size_t i = 0; i < rows; i++)
        if (isfinite(column->value[i]))
            max = fmax(max, fabs(column->value[i]));
    return max;
}

/* Returns the difference of two numbers relative to `scale`; infinity if only one is a finite
 * number. */
static double number_difference(double a, double b, double scale)
{
    if (!isfinite(a) || !isfinite(b))
        return (isnan(a) && isnan(b)) || (!isnan(a) && !isnan(b) && a == b) ? 0 : HUGE_VAL;
    return scale > 0 ? fabs(a - b) / scale : 0;
}

/* Returns the unit of a column, or "" if it has none. */
static const char *unit_of_column(const struct table_column *column)
{
    return column->unit ? column->unit : "";
}

/* Compares column c of two tables of the same shape and adds its differences to *found. Texts must
 * be equal. */
static void compare_column(const struct table *handed, const struct table *repeated, int c,
                           struct data_difference *found)
{
    const struct table_column *a = &handed->column[c], *b = &repeated->column[c];
    const double scale =
        a->value ? fmax(column_max(a, handed->rows), column_max(b, repeated->rows)) : 0;
    const bool has_unit = *unit_of_column(a);
    const double tolerance =
        data_tolerance_relative + (has_unit || !(scale > 0) ? 0 : data_tolerance_of_one / scale);
    for (size_t i = 0; i < handed->rows; i++) {
        double relative;
        if (a->value)
            relative = number_difference(a->value[i], b->value[i], scale);
        else
            relative = strcmp(a->text[i], b->text[i]) != 0 ? HUGE_VAL : 0;
        if (relative <= tolerance)
            continue;
        found->count++;
        if (relative > found->relative) {
            found->relative = relative;
            found->row = i;
            found->column = c;
        }
    }
}

/* Returns true if both columns have the same name, unit and type. */
static bool same_column(const struct table_column *a, const struct table_column *b)
{
    return strcmp(a->name, b->name) == 0 && strcmp(unit_of_column(a), unit_of_column(b)) == 0 &&
           !a->value == !b->value;
}

/* Appends the text or number of a cell. */
static void checked_cell_put(const struct table_column *column, size_t row, struct buffer *text)
{
    if (column->value)
        buffer_format(text, "%.9g", column->value[row]);
    else
        buffer_put(text, text_of(column->text[row]));
}

/* Reports the cell with the largest relative difference, which is in *found, and the number of
 * cells that differ. */
static void report_data_difference(struct check *check, const char *file,
                                   const struct table *handed, const struct table *repeated,
                                   const struct data_difference *found)
{
    const struct table_column *column = &handed->column[found->column];
    struct buffer detail = {0};
    buffer_format(&detail, "%s of row %zu is ", column->name, found->row + 1);
    checked_cell_put(column, found->row, &detail);
    buffer_put(&detail, TEXT(", the session gives "));
    checked_cell_put(&repeated->column[found->column], found->row, &detail);
    if (found->count > 1)
        buffer_format(&detail, "; %zu numbers differ, this one the most", found->count);
    check_differs(check, file, "the session gives different data", buffer_text(&detail));
    buffer_free(&detail);
}

/* Compares a table of the folder with that of the session. Tables of different shape are reported
 * as a whole, others by their largest difference beyond the tolerance. */
void check_data(struct check *check, const char *file, struct text handed_text,
                struct text repeated_text)
{
    struct table handed = {0}, repeated = {0};
    struct data_difference found = {0};
    struct error error = {0};
    struct buffer detail = {0};
    if (!table_parse(repeated_text, NULL, &check->arena, &repeated, &error))
        return;
    bool same = table_parse(handed_text, NULL, &check->arena, &handed, &error);
    if (!same)
        buffer_put(&detail, text_of(error.text));
    else if (handed.rows != repeated.rows)
        buffer_format(&detail, "it has %zu rows, the session gives %zu", handed.rows,
                      repeated.rows);
    same = same && handed.rows == repeated.rows;
    if (same && handed.columns == repeated.columns)
        for (int c = 0; c < handed.columns && same; c++)
            same = same_column(&handed.column[c], &repeated.column[c]);
    else
        same = false;
    if (!same) {
        if (detail.len == 0)
            buffer_put(&detail, TEXT("it has different columns"));
        check_differs(check, file, "the session gives different data", buffer_text(&detail));
    } else {
        for (int c = 0; c < handed.columns; c++)
            compare_column(&handed, &repeated, c, &found);
        if (found.count > 0)
            report_data_difference(check, file, &handed, &repeated, &found);
    }
    buffer_free(&detail);
}
