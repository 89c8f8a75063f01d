/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes tables as Markdown, HTML and LaTeX: one walk over keys, heading and rows, with the texts
 * of a struct markup between them. Cells are escaped, so that none is read as markup. */
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include "modules/documents/document.h"
#include <hooke/result/outlet.h>

#include <math.h>

/* Texts around the parts of a table in one markup; NULL for none. */
struct markup {
    const char *begin;
    const char *keys, *key, *key_between, *key_end, *keys_end;
    bool bare_keys; /* keys are in a comment and not escaped */
    /* beginning of a table, before the alignment of columns where that comes first */
    const char *table;
    const char *head, *unit, *unit_end, *head_end, *cell_separator, *heading_end;
    const char *aligned[3]; /* alignment of texts, of numbers, and the text after all of them */
    const char *row, *text, *number, *cell_end, *row_end;
    const char *end;
    void (*escape)(struct buffer *output, struct text text);
    void (*real)(struct buffer *output, double value);
};

/* Appends a number as S columns of siunitx read it. */
static void latex_real(struct buffer *output, double value)
{
    char z[REAL_TEXT_SIZE];
    real_format(value, z);
    buffer_format(output, isinf(value) ? "{%s}" : "%s", z);
}

static const struct markup markdown = {.key = "- ",
                                       .key_between = ": ",
                                       .key_end = "\n",
                                       .keys_end = "\n",
                                       .head = " ",
                                       .unit = " (",
                                       .unit_end = ")",
                                       .head_end = " |",
                                       .heading_end = "\n|",
                                       .aligned = {" --- |", " ---: |", "\n"},
                                       .row = "|",
                                       .text = " ",
                                       .number = " ",
                                       .cell_end = " |",
                                       .row_end = "\n",
                                       .escape = buffer_markdown,
                                       .real = buffer_real};

static const struct markup html = {.begin = document_table,
                                   .keys = "<ul>\n",
                                   .key = "<li>",
                                   .key_between = ": ",
                                   .key_end = "</li>\n",
                                   .keys_end = "</ul>\n",
                                   .table = "<table>\n<thead>\n",
                                   .head = "<th>",
                                   .unit = " (",
                                   .unit_end = ")",
                                   .head_end = "</th>",
                                   .heading_end = "</tr>\n</thead>\n<tbody>\n",
                                   .row = "<tr>",
                                   .text = "<td>",
                                   .number = "<td class=\"number\">",
                                   .cell_end = "</td>",
                                   .row_end = "</tr>\n",
                                   .end = "</tbody>\n</table>\n</body>\n</html>\n",
                                   .escape = buffer_html,
                                   .real = buffer_real};

static const struct markup latex = {.begin = "% \\usepackage{siunitx}\n",
                                    .key = "% ",
                                    .key_between = " = ",
                                    .key_end = "\n",
                                    .bare_keys = true,
                                    .table = "\\begin{tabular}{",
                                    .head = "{",
                                    .unit = " [",
                                    .unit_end = "]",
                                    .head_end = "}",
                                    .cell_separator = " & ",
                                    .heading_end = " \\\\\n\\hline\n",
                                    .aligned = {"l", "S", "}\n\\hline\n"},
                                    .row_end = " \\\\\n",
                                    .end = "\\hline\n\\end{tabular}\n",
                                    .escape = buffer_latex,
                                    .real = latex_real};

/* ---- the walk ---- */

/* Appends a text, or nothing for NULL. */
static void words_put(struct buffer *output, const char *words)
{
    buffer_put(output, text_of(words));
}

/* Appends a text, with control characters visible and escaped for the markup. */
static void put_escaped(struct buffer *output, const struct markup *as, const char *text)
{
    struct buffer safe = {0};
    safe_text(&safe, text_of(text), false);
    as->escape(output, buffer_text(&safe));
    output->failed |= safe.failed;
    buffer_free(&safe);
}

/* Appends a key and its value. */
static void put_key(struct buffer *output, const struct markup *as, const struct table_key *key)
{
    const char *const cell_text[] = {key->key, key->value};
    words_put(output, as->key);
    for (int i = 0; i < 2; i++) {
        if (as->bare_keys)
            safe_text(output, text_of(cell_text[i]), false);
        else
            put_escaped(output, as, cell_text[i]);
        words_put(output, i ? as->key_end : as->key_between);
    }
}

/* Appends the alignment of the columns: texts left, numbers right. */
static void put_alignment(struct buffer *output, const struct markup *as, const struct table *table)
{
    for (int i = 0; i < table->columns; i++)
        words_put(output, as->aligned[table->column[i].value != NULL]);
    words_put(output, as->aligned[2]);
}

/* Appends the names and units of the columns, with the alignment before them if the markup has
 * words that open a table (as->table), else behind. */
static void markup_heading_put(struct buffer *output, const struct markup *as,
                               const struct table *table)
{
    words_put(output, as->table);
    if (as->table)
        put_alignment(output, as, table);
    words_put(output, as->row);
    for (int i = 0; i < table->columns; i++) {
        const struct table_column *column = &table->column[i];
        words_put(output, i ? as->cell_separator : NULL);
        words_put(output, as->head);
        put_escaped(output, as, column->name);
        if (column->unit && column->unit[0]) {
            words_put(output, as->unit);
            put_escaped(output, as, column->unit);
            words_put(output, as->unit_end);
        }
        words_put(output, as->head_end);
    }
    words_put(output, as->heading_end);
    if (!as->table)
        put_alignment(output, as, table);
}

/* Appends a number, rounded to `digits` unless it is whole (a count) or digits is 0. */
static void put_number(struct buffer *output, const struct markup *as, double value, int digits)
{
    if (digits > 0 && isfinite(value) && value != nearbyint(value))
        buffer_short(output, value, digits);
    else
        as->real(output, value);
}

/* Appends row number `row` of the table, columns of numbers and of texts each in their words; an
 * unknown number (NAN) is an empty cell. */
static void markup_row_put(struct buffer *output, const struct markup *as,
                           const struct table *table, size_t row)
{
    words_put(output, as->row);
    for (int i = 0; i < table->columns; i++) {
        const struct table_column *column = &table->column[i];
        words_put(output, i ? as->cell_separator : NULL);
        words_put(output, column->value ? as->number : as->text);
        if (!column->value)
            put_escaped(output, as, column->text[row]);
        else if (!isnan(column->value[row]))
            put_number(output, as, column->value[row], table->digits);
        words_put(output, as->cell_end);
    }
    words_put(output, as->row_end);
}

/* Returns true if a row has something in the column: a number other than 0, or a text. */
static bool column_has_values(const struct table *table, const struct table_column *column)
{
    for (size_t i = 0; i < table->rows; i++)
        if (column->value ? !isnan(column->value[i]) && column->value[i] != 0 : *column->text[i])
            return true;
    return table->rows == 0;
}

/* Sets *chosen to the table with only the columns that people read. A table of a study (`digits` is
 * not 0) loses details and columns that are empty or 0; other tables have all columns. Returns
 * false if out of memory. */
static bool choose_columns(const struct table *table, struct arena *arena, struct table *chosen)
{
    struct table_column *column = arena_array(arena, (size_t)table->columns + 1, sizeof *column);
    *chosen = *table;
    chosen->columns = 0;
    chosen->column = column;
    for (int i = 0; column && i < table->columns; i++)
        if (table->digits == 0 ||
            (!table->column[i].detail && column_has_values(table, &table->column[i])))
            column[chosen->columns++] = table->column[i];
    return column != NULL;
}

/* Writes the chosen columns of a table in one markup, after its keys, and passes the text on in
 * pieces, so that long tables need little memory. Sets output->failed if out of memory or
 * cancelled. */
static void markup_table_put(const struct table *all, const struct markup *as, struct outlet *sink)
{
    struct buffer *output = sink->text;
    struct arena arena = {0};
    struct table chosen;
    const struct table *table = &chosen;
    if (!choose_columns(all, &arena, &chosen)) {
        output->failed = true;
        return;
    }
    words_put(output, as->begin);
    words_put(output, table->keys ? as->keys : NULL);
    for (int i = 0; i < table->keys; i++)
        put_key(output, as, &table->key[i]);
    words_put(output, table->keys ? as->keys_end : NULL);
    markup_heading_put(output, as, table);
    for (size_t row = 0; row < table->rows && outlet_goes_on(sink, all, row); row++) {
        markup_row_put(output, as, table, row);
        outlet_pass(sink, OUTLET_CHUNK);
    }
    words_put(output, as->end);
    arena_reset(&arena);
}

void documents_markdown(const struct table *table, struct outlet *outlet)
{
    markup_table_put(table, &markdown, outlet);
}

void documents_html(const struct table *table, struct outlet *outlet)
{
    markup_table_put(table, &html, outlet);
}

void documents_latex(const struct table *table, struct outlet *outlet)
{
    markup_table_put(table, &latex, outlet);
}
