/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes the coefficients of a method (Butcher tableau, or weights of a splitting) as text for
 * people, as LaTeX and as a table for files. Numbers that are fractions are written as fractions.
 */
#include <hooke/base/number.h>
#include <hooke/method/coefficients.h>
#include <hooke/report.h>

#include <float.h>
#include <math.h>
#include <string.h>

/* Error allowed between a coefficient and a fraction, in units of its last place, because
 * coefficients were computed. */
static const double fraction_rounding = 2;
/* Largest denominator tried. A number that is not a fraction is within rounding of one with such a
 * denominator in one case of ten thousand. */
static const double denominator_max = 4e5;

/* Finds the fraction *numerator / *denominator that equals a positive number within rounding, by
 * its continued fraction. Returns false, with both unchanged, if there is none with a denominator
 * up to denominator_max. */
static bool find_fraction(double value, double *numerator, double *denominator)
{
    double p[2] = {1, floor(value)}, q[2] = {0, 1}, rest = value - floor(value);
    while (fabs(p[1] / q[1] - value) > fraction_rounding * DBL_EPSILON * fabs(value)) {
        if (!(rest > 0))
            return false;
        const double whole = floor(1 / rest);
        rest = 1 / rest - whole;
        for (int k = 0; k < 2; k++) {
            double *term = k ? q : p;
            const double next = whole * term[1] + term[0];
            term[0] = term[1];
            term[1] = next;
        }
        if (q[1] > denominator_max)
            return false;
    }
    *numerator = p[1];
    *denominator = q[1];
    return true;
}

/* Appends a coefficient as a fraction, or else as a decimal number: exact in LaTeX, six digits for
 * people. */
static void put_coefficient(double value, bool tex, struct buffer *output)
{
    double p, q;
    if (!find_fraction(fabs(value), &p, &q)) {
        if (tex)
            buffer_real(output, value);
        else
            buffer_format(output, "%.6g", value);
        return;
    }
    const char *sign = value < 0 ? "-" : "";
    if (q == 1)
        buffer_format(output, "%s%.0f", sign, p);
    else
        buffer_format(output, tex ? "%s\\frac{%.0f}{%.0f}" : "%s%.0f/%.0f", sign, p, q);
}

/* ---- for people ---- */

/* [cell] blanks between columns, and before each line */
enum { GAP_WIDE = 2, GAP_NARROW = 1, INDENT = 2 };

/* Returns the width [cell] of a coefficient for people. */
static int coefficient_width(double value)
{
    struct buffer text = {0};
    put_coefficient(value, false, &text);
    const int width = (int)text.len;
    buffer_free(&text);
    return width;
}

/* Finds the widths [cell] of the labels, width[0], and of the columns, width[1...]. Returns the
 * number of columns. */
static int measure_columns(const struct method *method, int width[1 + COEFFICIENTS_MAX])
{
    struct coefficient_row row;
    int columns = 0;
    memset(width, 0, (1 + COEFFICIENTS_MAX) * sizeof *width);
    for (int i = 0; method_coefficients(method, i, &row); i++) {
        const int label = isnan(row.time) ? (int)strlen(row.label) : coefficient_width(row.time);
        width[0] = label > width[0] ? label : width[0];
        for (int k = 0; k < row.count; k++) {
            const int cell = coefficient_width(row.value[k]);
            width[k + 1] = cell > width[k + 1] ? cell : width[k + 1];
        }
        columns = row.count > columns ? row.count : columns;
    }
    return columns;
}

/* Appends a coefficient, padded with blanks to `width`. */
static void put_coefficient_cell(double value, int width, struct buffer *output)
{
    const size_t begun = output->len;
    put_coefficient(value, false, output);
    buffer_format(output, "%*s", width - (int)(output->len - begun), "");
}

/* Appends a line "label | coefficients": the time of a stage, or the name of a kind of weights. */
static void put_coefficient_row(const struct coefficient_row *row, const int *width, int gap,
                                struct buffer *output)
{
    if (isnan(row->time))
        buffer_format(output, "  %-*s |", width[0], row->label);
    else {
        buffer_put(output, TEXT("  "));
        put_coefficient_cell(row->time, width[0], output);
        buffer_put(output, TEXT(" |"));
    }
    for (int k = 0; k < row->count; k++) {
        buffer_format(output, "%*s", k ? gap : 1, "");
        put_coefficient_cell(row->value[k], width[k + 1], output);
    }
    while (output->len > 0 && !output->failed && output->data[output->len - 1] == ' ')
        output->data[--output->len] = '\0';
    buffer_char(output, '\n');
}

/* Appends the coefficients as lines of at most `max` cells, stages above a rule, weights below.
 * Returns false if they do not fit or if the method has none. */
bool coefficients_text(const struct method *method, int max, struct buffer *output)
{
    int width[1 + COEFFICIENTS_MAX];
    struct coefficient_row row;
    bool staged = false;
    const int columns = measure_columns(method, width);
    int all = width[0] + GAP_WIDE, gap = GAP_WIDE;
    for (int k = 0; k < columns; k++)
        all += width[k + 1] + GAP_WIDE;
    if (all + INDENT > max) {
        gap = GAP_NARROW;
        all -= columns;
    }
    if (columns == 0 || all + INDENT > max)
        return false;
    for (int i = 0; method_coefficients(method, i, &row); i++) {
        if (staged && isnan(row.time)) {
            buffer_format(output, "  ");
            for (int k = 0; k < all; k++)
                buffer_char(output, k == width[0] + 1 ? '+' : '-');
            buffer_char(output, '\n');
        }
        staged = !isnan(row.time);
        put_coefficient_row(&row, width, gap, output);
    }
    return true;
}

/* ---- LaTeX ---- */

/* Appends the label of weights in LaTeX; "b^" is b with a hat, longer names are upright. */
static void put_tex_label(const char *label, struct buffer *output)
{
    const size_t len = strlen(label);
    if (len == 2 && label[1] == '^')
        buffer_format(output, "\\hat{%c}", *label);
    else
        buffer_format(output, len > 1 ? "\\mathrm{%s}" : "%s", label);
}

/* Appends the coefficients as a displayed array. Returns false if the method has none. */
bool coefficients_tex(const struct method *method, struct buffer *output)
{
    struct coefficient_row row;
    int columns = 0;
    bool staged = false;
    for (int i = 0; method_coefficients(method, i, &row); i++)
        columns = row.count > columns ? row.count : columns;
    if (columns == 0)
        return false;
    buffer_format(output, "%% %s: %s\n\\[\n\\renewcommand{\\arraystretch}{1.3}\n\\begin{array}{c|",
                  method->row.name, method->row.citation);
    for (int k = 0; k < columns; k++)
        buffer_char(output, 'c');
    buffer_put(output, TEXT("}\n"));
    for (int i = 0; method_coefficients(method, i, &row); i++) {
        if (staged && isnan(row.time))
            buffer_put(output, TEXT("\\hline\n"));
        staged = !isnan(row.time);
        if (staged)
            put_coefficient(row.time, true, output);
        else
            put_tex_label(row.label, output);
        for (int k = 0; k < columns; k++) {
            buffer_put(output, TEXT(" & "));
            if (k < row.count)
                put_coefficient(row.value[k], true, output);
        }
        buffer_put(output, TEXT(" \\\\\n"));
    }
    buffer_put(output, TEXT("\\end{array}\n\\]\n"));
    return true;
}

/* ---- a table ---- */

/* Makes a table, in the arena, of a method's coefficients with a row for each stage and each kind
 * of weights: columns row (its label), c (time), k1, k2, ... Missing coefficients are NAN. Returns
 * false if out of memory or if the method has none. */
bool coefficients_table(const struct method *method, struct arena *arena, struct table *table)
{
    struct coefficient_row row;
    int columns = 0;
    size_t rows = 0;
    for (; method_coefficients(method, (int)rows, &row); rows++)
        columns = row.count > columns ? row.count : columns;
    struct table_column *column = arena_array(arena, (size_t)columns + 2, sizeof *column);
    double *value = arena_array(arena, rows * ((size_t)columns + 1) + 1, sizeof *value);
    const char **label = arena_array(arena, rows + 1, sizeof *label);
    if (!column || !value || !label)
        return false;
    column[0] = (struct table_column){.name = "row", .unit = "", .text = label};
    for (int k = 0; k <= columns; k++) {
        struct buffer text = {0};
        if (k)
            buffer_format(&text, "k%d", k);
        else
            buffer_char(&text, 'c');
        const char *kept = text.failed ? NULL : arena_text(arena, buffer_text(&text));
        buffer_free(&text);
        if (!kept)
            return false;
        column[k + 1] =
            (struct table_column){.name = kept, .unit = "", .value = value + (size_t)k * rows};
    }
    for (size_t i = 0; method_coefficients(method, (int)i, &row); i++) {
        label[i] = row.label[0] ? row.label : "a";
        value[i] = row.time;
        for (int k = 0; k < columns; k++)
            value[(size_t)(k + 1) * rows + i] = k < row.count ? row.value[k] : NAN;
    }
    *table = (struct table){.column = column, .columns = columns + 2, .rows = rows};
    return rows > 0;
}
