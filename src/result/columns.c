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
static const void *row_at(const struct result_columns *columns, const void *rows, size_t i)
{
    return (const char *)rows + i * columns->size;
}

/* Returns the address of a column's value in a row, or in the struct that a pointer of the row
 * leads to. */
static const void *member(const struct result_column *column, const void *row)
{
    if (column->pointer_offset > 0)
        row = *(const void *const *)((const char *)row + column->pointer_offset - 1);
    return (const char *)row + column->offset;
}

static double real_of(const struct result_column *column, const void *row)
{
    return column->real ? column->real(row) : *(const double *)member(column, row);
}

static int64_t count_of(const struct result_column *column, const void *row)
{
    if (column->kind == COLUMN_INT)
        return *(const int *)member(column, row);
    return column->number ? column->number(row) : *(const int64_t *)member(column, row);
}

static bool bool_of(const struct result_column *column, const void *row)
{
    return *(const bool *)member(column, row);
}

/* Returns the text of a column of names, choices or characters in a row, or NULL if it has none. */
static const char *text_in(const struct result_column *column, const void *row)
{
    const void *value_address = member(column, row);
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

static enum quantity quantity_in(const struct result_column *column, const void *row)
{
    return column->quantity_of ? column->quantity_of(row) : column->quantity;
}

/* ---- records ---- */

/* Writes a list column as an array of objects. */
static void put_parts(struct reply *reply, const struct result_column *column, const void *row)
{
    size_t count = 0;
    const void *parts = column->list(row, &count);
    reply_array(reply, column->name);
    for (size_t i = 0; i < count; i++) {
        reply_object(reply, NULL);
        reply_columns(reply, column->part, row_at(column->part, parts, i));
        reply_close(reply);
    }
    reply_close(reply);
}

/* Adds the fields of a row to the record that is open, each by its column's kind; columns may write
 * themselves (record) or be undefined for a row (defined). */
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
            reply_quantity(reply, c->name, real_of(c, row), quantity_unit(quantity_in(c, row)));
            break;
        case COLUMN_INT:
        case COLUMN_COUNT:
            reply_int(reply, c->name, count_of(c, row));
            break;
        case COLUMN_BOOL:
            reply_bool(reply, c->name, bool_of(c, row));
            break;
        case COLUMN_MEASURED:
            reply_if_known(reply, c->name, *(const struct measured *)member(c, row),
                           quantity_in(c, row));
            break;
        case COLUMN_NAME:
        case COLUMN_CHARS:
        case COLUMN_ROW:
        case COLUMN_CHOICE:
            reply_string(reply, c->name, text_in(c, row));
            break;
        case COLUMN_OBJECT:
            reply_object(reply, c->name);
            reply_columns(reply, c->part, member(c, row));
            reply_close(reply);
            break;
        case COLUMN_LIST:
            put_parts(reply, c, row);
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
        reply_columns(reply, columns, row_at(columns, rows, i));
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
        const void *row = row_at(columns, rows, i);
        if (value)
            value[i] =
                column->kind == COLUMN_REAL ? real_of(column, row) : (double)count_of(column, row);
        else if (column->kind == COLUMN_BOOL)
            text[i] = bool_of(column, row) ? "true" : "false";
        else if (column->kind != COLUMN_CHARS)
            text[i] = text_in(column, row);
        else if (!(text[i] = arena_text(arena, text_of(member(column, row)))))
            return false;
        if (text && !text[i])
            text[i] = "";
    }
    table_column->name = column->name;
    table_column->unit =
        column->kind == COLUMN_REAL && count > 0 ? quantity_unit(quantity_in(column, rows)) : "";
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
        return isfinite(real_of(column, row));
    case COLUMN_INT:
    case COLUMN_COUNT:
        return count_of(column, row) != 0;
    case COLUMN_BOOL:
        return bool_of(column, row);
    default:
        return text_in(column, row) != NULL;
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
        any = has_value(column, row_at(columns, rows, i));
    return any && (wide || !(column->flags & COLUMN_WIDE));
}

/* Adds the cell of a row to a table for people, in the column's own form if it has one. */
static void column_cell_put(const struct result_column *column, const void *row,
                            struct text_table *table)
{
    if (column->cell)
        column->cell(table, row);
    else if (column->kind == COLUMN_REAL && column->look)
        column->look(table, real_of(column, row));
    else if (column->kind == COLUMN_REAL)
        cell_quantity(table, real_of(column, row), quantity_in(column, row),
                      column->digits ? column->digits : 3);
    else if (column->kind <= COLUMN_COUNT)
        cell_count(table, count_of(column, row));
    else if (column->kind == COLUMN_BOOL)
        cell_text(table, bool_of(column, row) ? "yes" : "no");
    else
        cell_text(table, text_in(column, row));
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
            column_cell_put(shown[c], row_at(columns, rows, i), table);
}
