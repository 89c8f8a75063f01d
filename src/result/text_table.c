/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables for people: cells are added row by row, the headings first, then text_table_put() writes
 * them in columns that fit the screen. */
#include <hooke/base/number.h>
#include <hooke/base/safe_text.h>
#include <hooke/base/unit.h>
#include <hooke/result.h>

#include <math.h>
#include <string.h>

/* Adds a copy of the text as the next cell; NULL makes it empty. Sets table->failed if out of
 * memory. */
void cell_text(struct text_table *table, const char *text)
{
    if (table->cells == table->capacity) {
        const int capacity = table->capacity ? 2 * table->capacity : 64;
        const char **grown = arena_array(table->arena, (size_t)capacity, sizeof *grown);
        if (!grown) {
            table->failed = true;
            return;
        }
        if (table->cells)
            memcpy(grown, table->cell, (size_t)table->cells * sizeof *grown);
        table->cell = grown;
        table->capacity = capacity;
    }
    const char *copy = arena_text(table->arena, text_of(text));
    table->failed |= !copy;
    table->cell[table->cells++] = copy ? copy : "";
}

void cell_take(struct text_table *table, struct buffer *text)
{
    cell_text(table, buffer_view(text));
    buffer_free(text);
}

/* Adds a formatted text as the next cell. */
void cell_format(struct text_table *table, const char *format, ...)
{
    struct buffer text = {0};
    va_list args;
    va_start(args, format);
    buffer_vformat(&text, format, args);
    va_end(args);
    cell_take(table, &text);
}

void cell_quantity(struct text_table *table, double value, enum quantity quantity, int digits)
{
    cell_text(table, isfinite(value) ? SHOWN_QUANTITY(value, quantity, digits) : "-");
}

void cell_error(struct text_table *table, double value)
{
    if (isfinite(value))
        cell_format(table, value == 0 ? "0" : "%.1e", value);
    else
        cell_text(table, "-");
}

void cell_count(struct text_table *table, int64_t value)
{
    cell_format(table, "%lld", (long long)value);
}

void cell_seconds(struct text_table *table, double seconds)
{
    if (seconds < 1e-3)
        cell_format(table, "%.3g us", seconds * 1e6);
    else
        cell_quantity(table, seconds, QUANTITY_TIME, 3);
}

/* Adds the first `rows` rows of a table, with its headings, for as many columns as the text table
 * has. */
void table_cells(const struct table *source, size_t rows, struct text_table *table)
{
    for (int c = 0; c < table->columns; c++) {
        const struct table_column *column = &source->column[c];
        struct buffer heading = {0};
        safe_text(&heading, text_of(column->name), false);
        if (column->unit[0])
            buffer_format(&heading, " [%s]", column->unit);
        cell_take(table, &heading);
    }
    for (size_t i = 0; i < rows && i < source->rows; i++)
        for (int c = 0; c < table->columns; c++) {
            const struct table_column *column = &source->column[c];
            struct buffer cell = {0};
            if (!column->value)
                safe_text(&cell, text_of(column->text[i]), false);
            else if (!isnan(column->value[i]))
                buffer_short(&cell, column->value[i], 6);
            cell_take(table, &cell);
        }
}

/* Returns the width of the table with this gap between columns; columns of negative width are
 * hidden. */
static int table_width(const struct text_table *table, const int *width, int gap)
{
    int wide = table->indent;
    for (int column = 0; column < table->columns; column++)
        if (width[column] >= 0)
            wide += width[column] + (column > 0 ? gap : 0);
    return wide;
}

/* Returns true if a column has the same cell in all rows, of which there must be at least two. */
static bool is_same_in_all_rows(const struct text_table *table, int column)
{
    const int rows = table->cells / table->columns;
    for (int row = 2; row < rows; row++)
        if (strcmp(table->cell[row * table->columns + column],
                   table->cell[table->columns + column]) != 0)
            return false;
    return rows > 2;
}

/* Hides columns with the same value in all rows, except the first column, which names the rows,
 * until the table fits: sets their width to -1 and appends their values to a sentence for below the
 * table. */
static void fold_columns(const struct text_table *table, int *width, struct buffer *told)
{
    for (int column = 1; column < table->columns; column++) {
        if (table_width(table, width, 1) <= table->max)
            return;
        if (!is_same_in_all_rows(table, column))
            continue;
        width[column] = -1;
        const char *heading = table->cell[column];
        buffer_put(told, told->len > 0 ? TEXT(", ") : TEXT("in each row: "));
        buffer_format(told, *heading ? "%s %s" : "%s%s", heading,
                      table->cell[table->columns + column]);
    }
}

/* Hides columns until the table fits, those of the largest rank first and from the right within a
 * rank: sets their width to -1 and appends their headings to a sentence for below the table. */
static void drop_columns(const struct text_table *table, int *width, struct buffer *told)
{
    while (table_width(table, width, 1) > table->max) {
        int least = 0;
        for (int column = 1; column < table->columns; column++)
            if (width[column] >= 0 && table->rank[column] > 0 &&
                (least == 0 || table->rank[column] >= table->rank[least]))
                least = column;
        if (least == 0)
            return;
        width[least] = -1;
        if (table->rank[least] >= TABLE_RANK_WIDE)
            continue;
        buffer_put(told, told->len > 0 ? TEXT(", ") : TEXT("left out because of the width: "));
        buffer_put(told, *table->cell[least] ? text_of(table->cell[least]) : TEXT("remarks"));
    }
}

/* Appends a sentence below the table, folded to its width, and frees it. */
static void put_sentence_below(const struct text_table *table, struct buffer *told,
                               struct buffer *output)
{
    struct buffer folded = {0};
    buffer_folded(&folded, buffer_text(told), table->max);
    if (told->len > 0)
        buffer_format(output, "%s\n", buffer_view(&folded));
    buffer_free(&folded);
    buffer_free(told);
}

static void put_blanks(struct buffer *output, int count)
{
    for (int i = 0; i < count; i++)
        buffer_char(output, ' ');
}

/* Writes the table, its columns aligned and within table->max cells: gaps become narrower, equal
 * columns are summed up below the table, then columns are left out. Sentences below tell which. */
void text_table_put(const struct text_table *table, struct buffer *output)
{
    int width[TABLE_COLUMNS_MAX] = {0};
    for (int i = 0; i < table->cells; i++) {
        const int w = text_width(text_of(table->cell[i]));
        int *column = &width[i % table->columns];
        *column = w > *column ? w : *column;
    }
    /* Narrower gaps come first, then hidden columns. */
    int gap = table->gap;
    while (table->max > 0 && gap > 1 && table_width(table, width, gap) > table->max)
        gap--;
    struct buffer folded = {0}, dropped = {0};
    if (table->max > 0) {
        fold_columns(table, width, &folded);
        drop_columns(table, width, &dropped);
    }
    for (int i = 0; i < table->cells; i++) {
        const int column = i % table->columns;
        const bool last = column == table->columns - 1;
        put_blanks(output, column == 0 ? table->indent : 0);
        if (width[column] >= 0) {
            buffer_put(output, text_of(table->cell[i]));
            put_blanks(output,
                       last ? 0 : width[column] + gap - text_width(text_of(table->cell[i])));
        }
        /* No blanks at the end of a line. */
        while (last && output->len > 0 && !output->failed && output->data[output->len - 1] == ' ')
            output->data[--output->len] = '\0';
        if (last)
            buffer_char(output, '\n');
    }
    put_sentence_below(table, &folded, output);
    put_sentence_below(table, &dropped, output);
}
