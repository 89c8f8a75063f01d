/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Writes results by the description of their columns: as records, as a table for a file, and as a
 * table for people. A result is an array of structs (rows); a struct result_column tells where in
 * the struct a value is and what it is. */
#include <hooke/base/catalog.h>
#include <hooke/base/unit.h>
#include <hooke/result.h>

#include <math.h>

/* ---- values of a row ---- */

/* Returns row i of an array of the columns' structs. */
static const void *nth_row(const struct result_columns *columns, const void *rows, size_t i)
{
    return (const char *)rows + i * columns->size;
}

/* Returns the address of a column's value in a row, or in the struct that a pointer of the row
 * leads to. */
static const void *column_address(const struct result_column *column, const void *row)
{
    if (column->pointer_offset > 0)
        row = *(const void *const *)((const char *)row + column->pointer_offset - 1);
    return (const char *)row + column->offset;
}

static double column_real(const struct result_column *column, const void *row)
{
    return column->real ? column->real(row) : *(const double *)column_address(column, row);
}

static int64_t column_integer(const struct result_column *column, const void *row)
{
    if (column->kind == COLUMN_INT)
        return *(const int *)column_address(column, row);
    return column->number ? column->number(row) : *(const int64_t *)column_address(column, row);
}

static bool column_bool(const struct result_column *column, const void *row)
{
    return *(const bool *)column_address(column, row);
}

/* Returns the text of a column of names, choices or characters in a row, or NULL if it has none. */
static const char *column_text(const struct result_column *column, const void *row)
{
    const void *value_address = column_address(column, row);
    switch (column->kind) {
    case COLUMN_NAME:
        return column->text ? column->text(row) : *(const char *const *)value_address;
    case COLUMN_ROW: {
        const struct row *named = *(const struct row *const *)value_address;
        return named ? named->name : NULL;
    }
    case COLUMN_CHOICE: {
        const int index = *(const int *)value_address - column->choice_first;
        return index >= 0 ? catalog_row(column->choices, (size_t)index)->name : NULL;
    }
    default:
        return *(const char *)value_address ? value_address : NULL;
    }
}

static enum quantity value_quantity(const struct result_column *column, const void *row)
{
    return column->quantity_of ? column->quantity_of(row) : column->quantity;
}

/* ---- records ---- */

/* Writes a list column as an array of objects. */
static void reply_list_column(struct reply *reply, const struct result_column *column,
                              const void *row)
{
    size_t count = 0;
    const void *parts = column->list(row, &count);
    reply_array(reply, column->name);
    for (size_t i = 0; i < count; i++) {
        reply_object(reply, NULL);
        reply_columns(reply, column->part, nth_row(column->part, parts, i));
        reply_close(reply);
    }
    reply_close(reply);
}

/* Adds the fields of `row`, an object that the columns describe, to the open record of the reply. A
 * column is skipped if it has COLUMN_NO_RECORD or is not defined for this row; one with a function
 * `record` writes its field itself. */
void reply_columns(struct reply *reply, const struct result_columns *columns, const void *row)
{
    for (const struct result_column *c = columns->column; c < columns->column + columns->count;
         c++) {
        if (c->flags & COLUMN_NO_RECORD || (c->defined && !c->defined(row)))
            continue;
        if (c->record) {
            c->record(reply, c->name, row);
            continue;
        }
        switch (c->kind) {
        case COLUMN_REAL:
            reply_quantity(reply, c->name, column_real(c, row),
                           quantity_unit(value_quantity(c, row)));
            break;
        case COLUMN_INT:
        case COLUMN_COUNT:
            reply_int(reply, c->name, column_integer(c, row));
            break;
        case COLUMN_BOOL:
            reply_bool(reply, c->name, column_bool(c, row));
            break;
        case COLUMN_MEASURED:
            reply_if_known(reply, c->name, *(const struct measured *)column_address(c, row),
                           value_quantity(c, row));
            break;
        case COLUMN_NAME:
        case COLUMN_CHARS:
        case COLUMN_ROW:
        case COLUMN_CHOICE:
            reply_string(reply, c->name, column_text(c, row));
            break;
        case COLUMN_OBJECT:
            reply_object(reply, c->name);
            reply_columns(reply, c->part, column_address(c, row));
            reply_close(reply);
            break;
        case COLUMN_LIST:
            reply_list_column(reply, c, row);
            break;
        }
    }
}

/* Writes each row as a record of the kind, if somebody reads or stores records. */
void reply_records(struct reply *reply, const char *kind, const struct result_columns *columns,
                   const void *rows, size_t count)
{
    for (size_t i = 0; i < count && (reply_wants_records(reply) || reply->store); i++) {
        reply_begin(reply, kind);
        reply_columns(reply, columns, nth_row(columns, rows, i));
        reply_end(reply);
    }
}

/* ---- a table to a file ---- */

/* Fills a column of a table with the values of all rows, numbers or texts, allocated from the
 * arena. Returns false if out of memory. */
static bool fill_values(const struct result_columns *columns, const struct result_column *column,
                        const void *rows, size_t count, struct arena *arena,
                        struct table_column *table_column)
{
    const bool numbers = column->kind <= COLUMN_COUNT;
    double *value = numbers ? arena_array(arena, count + 1, sizeof *value) : NULL;
    const char **text = numbers ? NULL : arena_array(arena, count + 1, sizeof *text);
    if (!value && !text)
        return false;
    for (size_t i = 0; i < count; i++) {
        const void *row = nth_row(columns, rows, i);
        if (value)
            value[i] = column->kind == COLUMN_REAL ? column_real(column, row)
                                                   : (double)column_integer(column, row);
        else if (column->kind == COLUMN_BOOL)
            text[i] = column_bool(column, row) ? "true" : "false";
        else if (column->kind != COLUMN_CHARS)
            text[i] = column_text(column, row);
        else if (!(text[i] = arena_text(arena, text_of(column_address(column, row)))))
            return false;
        if (text && !text[i])
            text[i] = "";
    }
    table_column->name = column->name;
    table_column->unit =
        column->kind == COLUMN_REAL && count > 0 ? quantity_unit(value_quantity(column, rows)) : "";
    table_column->value = value;
    table_column->text = text;
    table_column->detail = column->flags & COLUMN_DETAIL;
    return true;
}

/* Returns true for kinds of columns that have no single value, so that only records can hold them.
 */
static bool is_only_recorded(enum column_kind kind)
{
    return kind == COLUMN_MEASURED || kind == COLUMN_OBJECT || kind == COLUMN_LIST;
}

/* Makes a table for a file of all columns that have a single value. Returns false if out of memory.
 */
bool columns_table(const struct result_columns *columns, const void *rows, size_t count,
                   struct arena *arena, struct table *table)
{
    struct table_column *table_column =
        arena_array(arena, (size_t)columns->count, sizeof *table_column);
    int used = 0;
    for (int i = 0; table_column && i < columns->count; i++) {
        const struct result_column *column = &columns->column[i];
        if (column->flags & COLUMN_NO_FILE || column->record || is_only_recorded(column->kind))
            continue;
        if (!fill_values(columns, column, rows, count, arena, &table_column[used++]))
            return false;
    }
    *table = (struct table){
        .column = table_column, .columns = used, .rows = count, .digits = columns->digits};
    return table_column != NULL;
}

/* ---- a table for people ---- */

/* Returns true if a row has something to show in a column: a finite number, a count that is not 0,
 * true, or a text. */
static bool has_value(const struct result_column *column, const void *row)
{
    if (column->any)
        return column->any(row);
    switch (column->kind) {
    case COLUMN_REAL:
        return isfinite(column_real(column, row));
    case COLUMN_INT:
    case COLUMN_COUNT:
        return column_integer(column, row) != 0;
    case COLUMN_BOOL:
        return column_bool(column, row);
    default:
        return column_text(column, row) != NULL;
    }
}

/* Returns true if a table for people has the column: some row has a value in it, and wide columns
 * are wanted if it is one. */
static bool column_is_shown(const struct result_columns *columns,
                            const struct result_column *column, const void *rows, size_t count,
                            bool wide)
{
    bool any = !(column->flags & COLUMN_IF_ANY);
    for (size_t i = 0; i < count && !any; i++)
        any = has_value(column, nth_row(columns, rows, i));
    return any && (wide || !(column->flags & COLUMN_WIDE));
}

/* Adds the cell of a row to a table for people, in the column's own form if it has one. */
static void column_cell_put(const struct result_column *column, const void *row,
                            struct text_table *table)
{
    if (column->cell)
        column->cell(table, row);
    else if (column->kind == COLUMN_REAL && column->look)
        column->look(table, column_real(column, row));
    else if (column->kind == COLUMN_REAL)
        cell_quantity(table, column_real(column, row), value_quantity(column, row),
                      column->digits ? column->digits : 3);
    else if (column->kind <= COLUMN_COUNT)
        cell_count(table, column_integer(column, row));
    else if (column->kind == COLUMN_BOOL)
        cell_text(table, column_bool(column, row) ? "yes" : "no");
    else
        cell_text(table, column_text(column, row));
}

/* Collects the columns that a table for people shows, ordered by their index (1 first; 0 is not
 * shown). Returns their number. */
static int columns_shown(const struct result_columns *columns, const void *rows, size_t count,
                         bool wide, const struct result_column *shown[TABLE_COLUMNS_MAX])
{
    int used = 0;
    for (int index = 1; index <= TABLE_COLUMNS_MAX; index++)
        for (const struct result_column *c = columns->column; c < columns->column + columns->count;
             c++)
            if (c->index == index && used < TABLE_COLUMNS_MAX &&
                column_is_shown(columns, c, rows, count, wide))
                shown[used++] = c;
    return used;
}

/* Returns how readily a column is left out for want of room, larger first. */
static int column_rank(const struct result_column *column)
{
    const int usual = column->flags & COLUMN_WIDE ? TABLE_RANK_WIDE : 2;
    return column->rank ? column->rank : usual;
}

/* Adds the headings and cells of a table for people; `wide` adds the wide columns. */
void columns_text(const struct result_columns *columns, const void *rows, size_t count, bool wide,
                  struct text_table *table)
{
    const struct result_column *shown[TABLE_COLUMNS_MAX];
    table->columns = columns_shown(columns, rows, count, wide, shown);
    for (int c = 0; c < table->columns; c++)
        table->rank[c] = column_rank(shown[c]);
    for (int c = 0; c < table->columns; c++)
        cell_text(table, shown[c]->head && count > 0 ? shown[c]->head(rows) : shown[c]->heading);
    for (size_t i = 0; i < count; i++)
        for (int c = 0; c < table->columns; c++)
            column_cell_put(shown[c], nth_row(columns, rows, i), table);
}
